//! Failing machines: every failure ends with a message, without a panic, a leak or a hang.

mod draw_calls;
mod lacking;
mod representative;
mod shadows;

use std::time::Duration;

use ash::vk;
use cull::{CostTable, Strategy};
use gpu::{Adapter, Device, DeviceOptions, Instance, PredicationMode, Readback};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scene::Scene;
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::fault_injection::{
    CALLS_THAT_MAKE, CALLS_THAT_RUN, CALLS_THAT_SAVE, Fault, FaultInjection, calls,
};
use tests::{Driver, instance_with};

#[test]
fn a_driver_that_does_not_give_its_pipelines_away_leaves_the_file_as_it_is() {
    let folder = std::env::temp_dir().join(format!("antumbra-kept-{}", std::process::id()));
    let file = folder.join("pipelines.bin");
    let instance = instance_with(FaultInjection::default().entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let options = DeviceOptions { pipeline_cache: Some(file.clone()), ..Default::default() };
    drop(Device::new(&instance, &adapter, &options).unwrap());
    let stored = std::fs::read(&file).unwrap();
    for &call in CALLS_THAT_SAVE {
        // Some calls return the size and then fail to return the data.
        for number in 0..calls(call) {
            let code = vk::Result::ERROR_OUT_OF_HOST_MEMORY;
            let fault = Fault { call, fails: number..usize::MAX, code };
            FaultInjection { faults: vec![fault], ..FaultInjection::default() }.install();
            drop(Device::new(&instance, &adapter, &options).unwrap());
            assert!(calls(call) > number, "{call:?} is never called");
            assert!(std::fs::read(&file).unwrap() == stored, "the file has changed");
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(instance.validation_log().drain(), []);
}

/// The parts that the walks below need, created once.
struct Stage {
    instance: Instance,
    adapter: Adapter,
    scene: Scene,
    path: CameraPath,
}

const FRAMES: u32 = 5;

impl Stage {
    fn new() -> Self {
        let instance = instance_with(FaultInjection::default().entry());
        let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
        let GeneratedScene { scene, routes } = city(1000, 1).unwrap();
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        Self { instance, adapter, scene, path }
    }

    /// Runs a user's whole program, from the device to its end.
    /// Returns the number of queries.
    fn walk(&self, options: &RendererOptions, goes: Goes) -> Result<u32, render::Error> {
        let wait_bound = Duration::from_secs(2);
        let device_options = DeviceOptions { wait_bound, ..Default::default() };
        let device = Device::new(&self.instance, &self.adapter, &device_options)?;
        let mut renderer = Renderer::new(&device, &self.scene, options)?;
        renderer.time_passes()?;
        let mut histories = [renderer.new_view()?, renderer.new_view()?];
        let image = || Readback::new(&device, renderer.size());
        let images = [image()?, image()?];
        let request = |strategy, frame, image| FrameRequest {
            image: Some(image),
            ..FrameRequest::new(strategy, self.path.camera(frame))
        };
        let mut failed = Ok(());
        let mut queries = 0;
        for frame in 0..FRAMES {
            let strategies = [Strategy::ANTUMBRA, methods::HZB];
            for ((history, image), strategy) in histories.iter_mut().zip(&images).zip(strategies) {
                match renderer.render(history, request(strategy, frame, image)) {
                    Err(error) if goes == Goes::On && failed.is_ok() => failed = Err(error),
                    result => queries += result?.queries,
                }
            }
        }
        let [history, other] = &mut histories;
        renderer.wait_idle(history)?;
        renderer.wait_idle(other)?;
        let last = images[0].rgba8()?.to_vec();
        assert!(last == *images[1].rgba8()?, "two images of one frame");
        renderer.render(history, request(Strategy::FRUSTUM, FRAMES - 1, &images[0]))?;
        renderer.wait_idle(history)?;
        assert!(last == *images[0].rgba8()?, "a wrong image");
        failed.map(|()| queries)
    }

    /// Walks on a machine with one fault; returns the message of the error, if any.
    fn walk_with(&self, fault: Fault, options: &RendererOptions, goes: Goes) -> Option<String> {
        let place = format!("{fault:?}");
        FaultInjection { faults: vec![fault], ..FaultInjection::default() }.install();
        let sentence = self.walk(options, goes).err().map(|error| error.to_string());
        assert_eq!(self.instance.validation_log().drain(), [], "with {place}");
        if let Some(sentence) = &sentence {
            assert!(sentence.len() > 30 && !sentence.contains('\n'), "with {place}: {sentence}");
        }
        sentence
    }

    /// Drops the instance, and checks that the layers report nothing, including leaked objects.
    fn finish(self) {
        let log = self.instance.validation_log().clone();
        drop(self.instance);
        assert_eq!(log.drain(), []);
    }
}

/// The behaviour of a program after a frame that failed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Goes {
    On,
    Home,
}

fn options(predication: PredicationMode) -> RendererOptions {
    // Failures in a measurement are ignored, and the number of its calls depends on the clock.
    let cost_model = CostModel::Table(CostTable::default());
    RendererOptions {
        methods: methods::all(),
        size: [64, 64],
        predication: Some(predication),
        cost_model,
        ..Default::default()
    }
}

/// Returns the numbers of calls of each of `names` in a walk without a fault.
fn clean_calls(
    stage: &Stage,
    options: &RendererOptions,
    names: &[&'static std::ffi::CStr],
) -> Vec<usize> {
    FaultInjection::default().install();
    let queries = stage.walk(options, Goes::Home).unwrap();
    assert!(queries > 0, "a walk that asks nothing proves little");
    names.iter().map(|name| calls(name)).collect()
}

#[test]
fn out_of_memory_is_an_error_with_advice() {
    exhaust(8);
}

#[test]
#[ignore = "long walk"]
fn out_of_memory_is_an_error_wherever_it_happens() {
    exhaust(usize::MAX);
}

/// Takes the memory away from up to `most` calls of each kind on.
fn exhaust(most: usize) {
    let stage = Stage::new();
    let options = options(PredicationMode::Conditional);
    let code = vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
    let memory = [c"vkAllocateMemory", c"vkBindBufferMemory", c"vkBindImageMemory"];
    let counts = clean_calls(&stage, &options, &memory);
    // The allocator takes large blocks, so it calls the driver less often than memory is needed.
    assert!(counts[0] > 0 && counts[1] > 12 && counts[2] == 2, "{counts:?}");
    for (call, count) in memory.into_iter().zip(counts) {
        for first in (0..count).step_by(count.div_ceil(most)).chain([count, count + 9]) {
            // From this call on no memory is left, of any kind.
            let fault = Fault { call, fails: first..usize::MAX, code };
            let sentence = stage.walk_with(fault, &options, Goes::Home);
            // Frames without memory for their tests are drawn without them.
            let is_forgiven = call == memory[0] && first > 0;
            assert!(sentence.is_none() || first < count, "{call:?}, {first}: {sentence:?}");
            assert!(sentence.is_some() || first >= count || is_forgiven, "{call:?}, {first}");
            if let Some(sentence) = sentence {
                assert!(sentence.contains("memory"), "{sentence}");
                assert!(sentence.contains("use fewer or smaller objects and images"), "{sentence}");
            }
        }
    }
    stage.finish();
}

#[test]
fn any_call_that_makes_something_may_fail() {
    let stage = Stage::new();
    let options = options(PredicationMode::Instances);
    let counts = clean_calls(&stage, &options, CALLS_THAT_MAKE);
    let code = vk::Result::ERROR_OUT_OF_HOST_MEMORY;
    for (&call, &count) in CALLS_THAT_MAKE.iter().zip(&counts) {
        assert!(count > 0, "{call:?} is never called: it need not be in the list");
        // The first calls, and some of the many others.
        for number in (0..count.min(3)).chain((3..count).step_by(count.div_ceil(4).max(1))) {
            let fault = Fault { call, fails: number..number + 1, code };
            let sentence = stage.walk_with(fault, &options, Goes::Home);
            // Memory is taken from another block.
            let forgiven = [c"vkAllocateMemory", c"vkMapMemory", c"vkCreatePipelineCache"];
            let forgiven = forgiven.contains(&call);
            assert!(sentence.is_some() || forgiven, "call {number} of {call:?} failed unnoticed");
        }
    }
    stage.finish();
}

#[test]
fn a_full_descriptor_pool_is_followed_by_another() {
    let stage = Stage::new();
    let options = options(PredicationMode::Instances);
    let call = c"vkAllocateDescriptorSets";
    let count = clean_calls(&stage, &options, &[call])[0];
    let code = vk::Result::ERROR_OUT_OF_POOL_MEMORY;
    let mut followed = 0;
    for number in count - 12..count {
        let fault = Fault { call, fails: number..number + 1, code };
        match stage.walk_with(fault, &options, Goes::Home) {
            None => followed += 1,
            // A pool without room for its first set.
            Some(sentence) => assert!(sentence.contains("vkAllocateDescriptorSets"), "{sentence}"),
        }
    }
    assert!(followed > 6, "{followed} of 12");
    let fault = Fault { call, fails: count - 2..count, code };
    let sentence = stage.walk_with(fault, &options, Goes::Home);
    assert!(sentence.is_some(), "a new pool without room is an error");
    stage.finish();
}

#[test]
fn a_lost_device_is_an_error_with_the_call_and_the_code() {
    lose_device(6);
}

#[test]
#[ignore = "long walk"]
fn a_lost_device_is_an_error_at_every_call() {
    lose_device(usize::MAX);
}

/// Loses the device at up to `most` calls of each kind, and at the last one.
fn lose_device(most: usize) {
    let stage = Stage::new();
    let options = options(PredicationMode::Conditional);
    let counts = clean_calls(&stage, &options, CALLS_THAT_RUN);
    let code = vk::Result::ERROR_DEVICE_LOST;
    for (&call, &count) in CALLS_THAT_RUN.iter().zip(&counts) {
        assert!(count > 0, "{call:?} is never called");
        let at_close = call == c"vkDeviceWaitIdle";
        for number in (0..count - 1).step_by(count.div_ceil(most)).chain([count - 1]) {
            let fault = Fault { call, fails: number..usize::MAX, code };
            let sentence = stage.walk_with(fault, &options, Goes::Home);
            // Closing a device cannot report an error.
            let told = sentence.as_deref().unwrap_or("");
            let last_wait = call == c"vkWaitSemaphores" && number + 1 == count;
            if !at_close && !last_wait {
                assert!(told.contains(call.to_str().unwrap()), "{number}: {told}");
                assert!(told.contains("ERROR_DEVICE_LOST"), "{told}");
                assert!(told.contains("update the driver"), "{told}");
            }
        }
    }
    stage.finish();
}

#[test]
fn a_frame_that_is_never_over_is_an_error_and_closing_does_not_hang() {
    let stage = Stage::new();
    let options = options(PredicationMode::Conditional);
    let call = c"vkWaitSemaphores";
    let [waits] = clean_calls(&stage, &options, &[call])[..] else { unreachable!() };
    // The last wait belongs to closing the device, which cannot report an error.
    for number in 0..waits - 1 {
        for fails in [number..number + 1, number..usize::MAX] {
            let fault = Fault { call, fails, code: vk::Result::TIMEOUT };
            let sentence = stage.walk_with(fault, &options, Goes::Home).expect("an error");
            assert!(sentence.contains("(vkWaitSemaphores: TIMEOUT)"), "{sentence}");
        }
    }
    stage.finish();
}

#[test]
fn after_a_frame_that_failed_the_next_ones_are_drawn() {
    let stage = Stage::new();
    let options = options(PredicationMode::Conditional);
    let counts = clean_calls(&stage, &options, &[c"vkQueueSubmit2", c"vkEndCommandBuffer"]);
    let code = vk::Result::ERROR_OUT_OF_HOST_MEMORY;
    for (call, count) in [c"vkQueueSubmit2", c"vkEndCommandBuffer"].into_iter().zip(counts) {
        // All frames except the last three, whose images are compared.
        for number in count - 1 - 2 * FRAMES as usize..count - 3 {
            let fault = Fault { call, fails: number..number + 1, code };
            let sentence = stage.walk_with(fault, &options, Goes::On).expect("an error");
            assert!(sentence.contains(call.to_str().unwrap()), "{sentence}");
        }
    }
    stage.finish();
}

/// Checks that no renderer is made on a device that reports a loss once, while costs are measured.
#[test]
fn a_loss_while_costs_are_measured_refuses_the_renderer() {
    let stage = Stage::new();
    let told = options(PredicationMode::Conditional);
    let measured = RendererOptions { cost_model: CostModel::Measured, ..told.clone() };
    let submits = |options: &RendererOptions| {
        FaultInjection::default().install();
        let device = Device::new(&stage.instance, &stage.adapter, &DeviceOptions::default())?;
        Renderer::new(&device, &stage.scene, options)?;
        Ok::<_, render::Error>(calls(c"vkQueueSubmit2"))
    };
    let number = submits(&told).unwrap().midpoint(submits(&measured).unwrap());
    let code = vk::Result::ERROR_DEVICE_LOST;
    let fault = Fault { call: c"vkQueueSubmit2", fails: number..number + 1, code };
    let sentence = stage.walk_with(fault, &measured, Goes::Home).expect("an error");
    assert!(sentence.contains("vkQueueSubmit2"), "{sentence}");
    stage.finish();
}

/// Checks that a failed measurement of costs does not fail the program. Each call fails once, or
/// permanently from some point of the measurement on.
#[test]
#[ignore = "long walk"]
fn costs_that_cannot_be_measured_are_no_reason_to_fail() {
    let stage = Stage::new();
    let told = options(PredicationMode::Conditional);
    let measured = RendererOptions { cost_model: CostModel::Measured, ..told.clone() };
    let made = |options: &RendererOptions| {
        let device = Device::new(&stage.instance, &stage.adapter, &DeviceOptions::default())?;
        let renderer = Renderer::new(&device, &stage.scene, options)?;
        Ok::<_, render::Error>(renderer.costs())
    };
    let all: Vec<_> = CALLS_THAT_MAKE.iter().chain(CALLS_THAT_RUN).copied().collect();
    let counts = |options: &RendererOptions| -> Vec<usize> {
        FaultInjection::default().install();
        assert!(made(options).unwrap().is_some());
        all.iter().map(|name| calls(name)).collect()
    };
    let without = counts(&told);
    let with = counts(&measured);
    let mut forgiven = 0;
    for (call, (without, with)) in all.iter().zip(without.into_iter().zip(with)) {
        // A handful of calls follow the measurement, so the first half of the additional calls
        // surely belongs to it.
        let own = with.saturating_sub(without) / 2;
        for number in (without..without + own).step_by(own.div_ceil(3).max(1)) {
            let code = vk::Result::ERROR_OUT_OF_HOST_MEMORY;
            let once = Fault { call, fails: number..number + 1, code };
            let place = format!("{once:?}");
            let sentence = stage.walk_with(once.clone(), &measured, Goes::Home);
            assert_eq!(sentence, None, "with {place}");
            FaultInjection { faults: vec![once], ..FaultInjection::default() }.install();
            forgiven += usize::from(made(&measured).unwrap() == Some(CostTable::default()));
            let lost =
                Fault { call, fails: number..usize::MAX, code: vk::Result::ERROR_DEVICE_LOST };
            let sentence = stage.walk_with(lost, &measured, Goes::Home);
            assert!(sentence.is_some(), "a device that is lost for good, with {place}");
        }
    }
    assert!(forgiven > 10, "{forgiven}");
    stage.finish();
}
