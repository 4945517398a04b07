//! Shadow maps on failing machines. A frame that is lost between its plan and its submit leaves the
//! maps right, and without memory for more maps, lights get smaller ones.

use cull::{Aabb, ObjectId, Strategy};
use glam::{Affine3A, vec3};
use gpu::{Device, DeviceOptions, Readback};
use render::{CostModel, FrameRequest, RenderView, Renderer, RendererOptions, SpareCapacity};
use scene::{LightId, ObjectChange, SceneUpdate};
use shadows::{ShadowBias, ShadowCaching, ShadowMethod, ShadowOptions, ShadowStats};
use tests::fault_injection::{Fault, FaultInjection, calls};
use tests::{Driver, instance_with, shadow_scene};

use super::vk;

const FRAMES: u32 = 8;

fn renderer(device: &Device, bias: ShadowBias) -> Renderer {
    let [sun, ..] = shadow_scene::lights();
    let options = RendererOptions {
        size: [64, 48],
        cost_model: CostModel::Off,
        spare: SpareCapacity { lights: 4, ..SpareCapacity::default() },
        shadows: ShadowOptions {
            method: ShadowMethod::Maps,
            bias,
            sun_side: 256,
            spot_side: 256,
            point_side: 128,
            layers_max: 16,
            ..ShadowOptions::default()
        },
        ..RendererOptions::default()
    };
    Renderer::new(device, &shadow_scene::scene(&shadow_scene::boxes(), &[sun]), &options).unwrap()
}

/// Changes the scene of a frame: two boxes move twice, and lights are added, one of which moves.
fn change(renderer: &mut Renderer, frame: u32) {
    let [_, spot, point] = shadow_scene::lights();
    if frame == 2 {
        renderer.add_lights(&[spot, point]).unwrap();
    }
    if frame > 2 {
        let position = point.position + vec3(0.1, 0.0, 0.0) * frame as f32;
        renderer.set_light(LightId(2), scene::PunctualLight { position, ..point }).unwrap();
    }
    let moved = |object: u32| {
        let low = vec3(object as f32, 0.5 + frame as f32 * 0.1, 0.0);
        let transform: Affine3A = shadow_scene::transform_of(&Aabb::new(low, low + 0.8));
        ObjectChange::Move { object: ObjectId(object), transform }
    };
    let objects = if frame % 4 == 3 { vec![] } else { vec![moved(4), moved(5)] };
    renderer.apply(&SceneUpdate { objects, ..SceneUpdate::default() }).unwrap();
}

/// Draws a frame; `None` if it fails.
fn draw(renderer: &mut Renderer, view: &mut RenderView, image: &Readback) -> Option<Vec<u8>> {
    let request = FrameRequest {
        image: Some(image),
        ..FrameRequest::new(Strategy::ANTUMBRA, shadow_scene::camera())
    };
    renderer.render(view, request).ok()?;
    renderer.wait_idle(view).ok()?;
    Some(image.rgba8().unwrap().to_vec())
}

/// Draws all frames with a fault, and the last one again without it. Returns the images, and the
/// counts of the last frame.
fn walk(
    device: &Device,
    bias: ShadowBias,
    fault: Option<Fault>,
) -> (Vec<Option<Vec<u8>>>, ShadowStats) {
    FaultInjection::default().install();
    let mut renderer = renderer(device, bias);
    let mut view = renderer.new_view().unwrap();
    let image = Readback::new(device, renderer.size()).unwrap();
    let has_fault = fault.is_some();
    FaultInjection { faults: fault.into_iter().collect(), ..FaultInjection::default() }.install();
    let frames = (0..FRAMES).map(|frame| {
        change(&mut renderer, frame);
        draw(&mut renderer, &mut view, &image)
    });
    let mut images: Vec<_> = frames.collect();
    if has_fault {
        FaultInjection::default().install();
    }
    images.push(draw(&mut renderer, &mut view, &image));
    (images, renderer.shadow_stats())
}

#[test]
fn lost_frames_and_missing_memory_leave_maps_right() {
    lose(ShadowBias::Plane, 2);
}

#[test]
fn lost_frames_and_missing_memory_leave_midpoints_right() {
    lose(ShadowBias::Midpoint, 2);
}

#[test]
#[ignore = "long walk"]
fn more_lost_frames_and_missing_memory_leave_maps_right() {
    [ShadowBias::Plane, ShadowBias::Midpoint].into_iter().for_each(|bias| lose(bias, 1));
}

/// Walks with a fault at up to ten calls of each kind, or at every `stride`th of these.
fn lose(bias: ShadowBias, stride: usize) {
    let instance = instance_with(FaultInjection::default().entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let loses = [
        c"vkQueueSubmit2",
        c"vkGetSemaphoreCounterValue",
        c"vkCreateBuffer",
        c"vkBindBufferMemory",
    ];
    let grows = [c"vkCreateImage", c"vkBindImageMemory", c"vkCreateImageView"];
    let (expected, whole) = walk(&device, bias, None);
    let counts: Vec<usize> = loses.iter().chain(&grows).map(|call| calls(call)).collect();
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
    let mut lost = 0;
    let mut smaller = 0;
    for (&call, count) in loses.iter().chain(&grows).zip(counts) {
        for number in (0..count).step_by(stride * count.div_ceil(10)) {
            let code = vk::Result::ERROR_OUT_OF_HOST_MEMORY;
            let fault = Fault { call, fails: number..number + 1, code };
            let (images, stats) = walk(&device, bias, Some(fault.clone()));
            let has_grown = !grows.contains(&call);
            for (frame, (found, expected)) in images.iter().zip(&expected).enumerate() {
                lost += u32::from(found.is_none());
                let is_right = found.is_none() || !has_grown || found == expected;
                assert!(is_right, "frame {frame} with {fault:?}");
            }
            assert_eq!(stats.lights + stats.unshadowed_lights, whole.lights, "{fault:?}");
            smaller += u32::from(images.last() != expected.last());
            assert!(images.last().is_some_and(Option::is_some), "{fault:?}");
        }
    }
    assert!(lost > 8 && smaller > 0, "{lost} frames lost, {smaller} walks with smaller maps");
    drop(device);
    let log = instance.validation_log().clone();
    drop(instance);
    assert_eq!(log.drain(), []);
}

#[test]
fn casters_that_there_was_no_memory_for_are_there_in_the_next_frame() {
    let instance = instance_with(FaultInjection::default().entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let [sun, ..] = shadow_scene::lights();
    let posts = (0..900).map(|post| {
        let [x, z] = [post % 30, post / 30].map(|place| place as f32 * 0.8 - 12.0);
        Aabb::new(vec3(x, 0.0, z), vec3(x + 0.2, 1.0, z + 0.2))
    });
    let boxes: Vec<Aabb> = std::iter::once(shadow_scene::GROUND).chain(posts).collect();
    let scene = shadow_scene::scene(&boxes, &[sun]);
    let options = RendererOptions {
        size: [64, 48],
        cost_model: CostModel::Off,
        shadows: ShadowOptions {
            method: ShadowMethod::Maps,
            caching: ShadowCaching::Uncached,
            sun_side: 256,
            ..ShadowOptions::default()
        },
        ..RendererOptions::default()
    };
    {
        FaultInjection::default().install();
        let mut renderer = Renderer::new(&device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let request = FrameRequest::new(Strategy::ANTUMBRA, shadow_scene::camera());
        let before = device.wait_counts().other;
        renderer.render(&mut view, request).unwrap();
        assert_eq!(device.wait_counts().other, before, "growing waits for nothing");
        assert!(renderer.shadow_stats().casters > 1024, "{:?}", renderer.shadow_stats());
        renderer.wait_idle(&mut view).unwrap();
    }
    // Returns the image of the second frame, and the number of buffers that the first frame
    // created.
    let second = |fault: Option<Fault>| {
        FaultInjection::default().install();
        let mut renderer = Renderer::new(&device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let image = Readback::new(&device, renderer.size()).unwrap();
        FaultInjection { faults: fault.into_iter().collect(), ..FaultInjection::default() }
            .install();
        let first = draw(&mut renderer, &mut view, &image);
        let buffers = calls(c"vkCreateBuffer");
        FaultInjection::default().install();
        (first.is_some(), draw(&mut renderer, &mut view, &image).unwrap(), buffers)
    };
    let (_, expected, buffers) = second(None);
    let mut failed = 0;
    for number in 0..buffers {
        let code = vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
        let fault = Fault { call: c"vkCreateBuffer", fails: number..number + 1, code };
        let (is_drawn, found, _) = second(Some(fault));
        failed += u32::from(!is_drawn);
        assert!(found == expected, "buffer {number} of {buffers}");
    }
    assert!(failed > 3, "{failed} of {buffers} buffers were missed");
    drop(device);
    let log = instance.validation_log().clone();
    drop(instance);
    assert_eq!(log.drain(), []);
}
