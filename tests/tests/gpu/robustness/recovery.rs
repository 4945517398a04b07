//! A renderer that continues on another device shows what it would have shown without the loss.

use std::sync::Arc;
use std::time::Duration;

use cull::{Aabb, Hierarchy, ObjectId, SectionMode, SectionPlane, SectionPlanes, Strategy};
use glam::{Affine3A, DVec3, Quat, Vec3, vec3};
use gpu::{Device, DeviceOptions, Readback, Tick, Timeline};
use render::{
    EdgeMode, EdgeOptions, Error, FrameRequest, LightShadow, ObjectOutline, RenderView, Renderer,
    RendererOptions, SpareCapacity,
};
use scene::{LensFlare, LightId, MeshId, Object, ObjectChange, PunctualLight, Scene};
use shadows::{ShadowMethod, ShadowOptions};
use tests::fault_injection::{FAULT_ADDRESS, FAULT_DESCRIPTION, Fault, FaultInjection};
use tests::walk::images_that_differ;
use tests::{Driver, drivers, open, run_on_all};

use crate::culling::feature_soup::{LAMPS, SIZE, camera, lamp, live, scene};

/// Room for objects that are added.
const SPARE: usize = 6;

/// A renderer with a view, and the image of its newest frame.
struct Film {
    renderer: Renderer,
    view: RenderView,
}

impl Film {
    fn new(device: &Device, scene: &Arc<Scene>) -> Self {
        let options = RendererOptions {
            size: SIZE,
            spare_objects: SPARE,
            spare: SpareCapacity { lights: 3, ..Default::default() },
            ..Default::default()
        };
        let mut renderer = Renderer::new(device, scene, &options).unwrap();
        renderer.keep_scene(Arc::clone(scene)).unwrap();
        Self { view: renderer.new_view().unwrap(), renderer }
    }

    fn frame(&mut self, strategy: Strategy, number: u32) -> Readback {
        let image = Readback::new(self.renderer.device(), SIZE).unwrap();
        let request = FrameRequest::new(strategy, camera(number));
        let request = FrameRequest { image: Some(&image), ..request };
        self.renderer.render(&mut self.view, request).unwrap();
        self.renderer.wait_idle(&mut self.view).unwrap();
        image
    }
}

/// A change of a renderer, with what it is about.
type Setting = (&'static str, fn(&mut Renderer));

const SETTINGS: [Setting; 9] = [
    ("exposure and objects", |renderer| {
        renderer.set_exposure(0.6);
        let gone = ObjectChange::Remove { object: ObjectId(7) };
        let object = Object {
            mesh: MeshId(2),
            transform: Affine3A::from_scale_rotation_translation(
                vec3(0.5, 2.0, 0.5),
                Quat::from_rotation_y(0.3),
                vec3(-1.0, -1.0, -3.0),
            ),
            tint: 0xFF40_90FF,
        };
        let add = ObjectChange::Add { object };
        renderer.update(&[gone, add, add]).unwrap();
        renderer.update(&[ObjectChange::Remove { object: ObjectId(9) }]).unwrap();
    }),
    ("lights", |renderer| {
        renderer.remove_lights(&[LightId(3)]).unwrap();
        let added = renderer.add_lights(&[lamp(3, 9), lamp(5, 7), lamp(7, 4)]).unwrap();
        renderer.remove_lights(&added[1..2]).unwrap();
    }),
    ("shadow maps", |renderer| {
        let options = ShadowOptions { method: ShadowMethod::Maps, ..*renderer.shadows() };
        renderer.set_shadows(options).unwrap();
        let dark = LightShadow { is_cast: false, penumbra_m: 0.1 };
        // A single lamp among forty may cast no shadow that shows.
        for light in (4..LAMPS).step_by(2).map(LightId) {
            renderer.set_light_shadow(light, Some(dark)).unwrap();
        }
    }),
    ("flares", |renderer| {
        let flare = LensFlare::of_light(&lamp(1, 0)).unwrap();
        renderer.set_flares(&[flare]).unwrap();
    }),
    ("edges", |renderer| {
        renderer
            .set_edges(EdgeOptions { mode: EdgeMode::ShadedWithHiddenDashed, ..Default::default() })
            .unwrap();
        renderer.set_flares(&[]).unwrap();
    }),
    ("outlines", |renderer| {
        let outline = ObjectOutline {
            objects: vec![ObjectId(2)],
            colour: [0.9, 0.2, 0.1],
            width_pixels: 3.0,
        };
        renderer.set_outlined(&[outline]).unwrap();
        renderer.outline(Some(ObjectId(1))).unwrap();
    }),
    ("frames in flight", |renderer| renderer.set_frames_in_flight(3).unwrap()),
    ("shadow volumes", |renderer| {
        let options = ShadowOptions { method: ShadowMethod::Volumes, ..*renderer.shadows() };
        renderer.set_shadows(options).unwrap();
    }),
    ("section planes", |renderer| {
        let plane = SectionPlane::new(DVec3::new(0.2, 1.0, 0.1), 0.7).unwrap();
        renderer
            .set_section(SectionPlanes::new(&[plane], SectionMode::default()).unwrap())
            .unwrap();
        renderer.set_edges(EdgeOptions::default()).unwrap();
    }),
];

/// Returns a second device of the same driver.
fn another(instance: &gpu::Instance, device: &Device) -> Device {
    let adapter = instance.pick_adapter(Some(&device.adapter().name)).unwrap();
    Device::new(instance, &adapter, &DeviceOptions::default()).unwrap()
}

#[test]
fn the_images_after_a_recovery_are_those_without_the_loss() {
    check_recoveries(3);
}

#[test]
#[ignore = "long walk"]
fn the_images_after_a_recovery_from_each_setting_are_those_without_the_loss() {
    check_recoveries(1);
}

/// Makes all settings, recovers after `every`th one, and compares images with those of a renderer
/// on a device that is not lost.
fn check_recoveries(every: usize) {
    for driver in drivers() {
        let (instance, device) = open(driver);
        let scene = Arc::new(scene());
        let mut lost = Film::new(&device, &scene);
        let mut twin = Film::new(&device, &scene);
        for (number, (name, set)) in SETTINGS.into_iter().enumerate() {
            for film in [&mut lost, &mut twin] {
                set(&mut film.renderer);
                live(&mut film.renderer, &scene, number as u32);
            }
            if !(number + 1).is_multiple_of(every) {
                continue;
            }
            for frame in 0..3 {
                drop(lost.frame(Strategy::ANTUMBRA, frame));
                drop(twin.frame(Strategy::ANTUMBRA, frame));
            }
            let next = another(&instance, &device);
            lost.renderer.recover(&next).unwrap();
            for frame in [3, 4] {
                let found = lost.frame(Strategy::ANTUMBRA, frame);
                let expected = twin.frame(Strategy::FRUSTUM, frame);
                let wrong = images_that_differ(&found, &expected);
                assert_eq!(wrong, 0, "{name} on {driver:?}, frame {frame}");
            }
        }
        let messages = {
            let log = instance.validation_log().clone();
            drop((lost, twin, device, instance));
            log.drain()
        };
        assert!(messages.is_empty(), "{driver:?}: {messages:#?}");
    }
}

#[test]
fn what_cannot_recover_says_so_and_goes_on() {
    let (instance, device) = open(Driver::Lavapipe);
    let scene = Arc::new(scene());
    let mut film = Film::new(&device, &scene);
    let mut plain = Renderer::new(&device, &scene, &RendererOptions::default()).unwrap();
    assert!(!plain.keeps_scene());
    assert!(matches!(plain.recover(&device), Err(Error::SceneNotKept)));
    let other = Arc::new(Scene { objects: scene.objects[1..].to_vec(), ..(*scene).clone() });
    assert!(matches!(plain.keep_scene(other), Err(Error::OtherScene)));
    let transform = Affine3A::from_translation(Vec3::ONE);
    plain.update(&[ObjectChange::Move { object: ObjectId(1), transform }]).unwrap();
    assert!(matches!(plain.keep_scene(Arc::clone(&scene)), Err(Error::OtherScene)));
    drop(plain);
    drop(film.frame(Strategy::ANTUMBRA, 0));
    let next = another(&instance, &device);
    assert!(next.adapter().is_same_as(device.adapter()));
    let other = instance.pick_adapter(Some(Driver::SwiftShader.device_name())).unwrap();
    assert!(!next.adapter().is_same_as(&other));
    film.renderer.recover(&next).unwrap();
    let stale = film.renderer.finish(&mut film.view).map(drop);
    assert!(matches!(stale, Err(Error::ViewOfLostDevice)));
    let old = Readback::new(&device, SIZE).unwrap();
    let request = FrameRequest::new(Strategy::ANTUMBRA, camera(1));
    let request = FrameRequest { image: Some(&old), ..request };
    let refused = film.renderer.render(&mut film.view, request).unwrap_err().to_string();
    assert!(refused.contains("different `Device`s"), "{refused}");
    drop(film.frame(Strategy::ANTUMBRA, 1));
}

/// Checks that a report on a loss names the frame that the device did not finish with its passes,
/// and what the driver says of it.
#[test]
fn the_report_on_a_loss_says_where_it_was() {
    let lost = Fault {
        call: c"vkWaitSemaphores",
        fails: 0..usize::MAX,
        code: gpu::vk::Result::ERROR_DEVICE_LOST,
    };
    let silent = Fault { call: c"vkGetSemaphoreCounterValue", ..lost.clone() };
    for describes_faults in [false, true] {
        let fine = FaultInjection { describes_faults, ..FaultInjection::default() };
        let instance = tests::instance_with(fine.clone().entry());
        let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        let mut film = Film::new(&device, &Arc::new(scene()));
        let before = film.renderer.loss_report();
        assert!(!before.is_ours() && before.unfinished.is_empty(), "{before}");
        // A driver may only be asked for the fault of a lost device.
        assert_eq!((before.fault, device.is_known_lost()), (None, false));
        drop(film.frame(Strategy::ANTUMBRA, 0));
        let completed = device.completed().unwrap();
        let request = FrameRequest::new(Strategy::ANTUMBRA, camera(1));
        film.renderer.render(&mut film.view, request).unwrap();
        // From here on the device says nothing but that it is lost.
        FaultInjection { faults: vec![lost.clone(), silent.clone()], ..fine.clone() }.install();
        let waited = film.renderer.wait_idle(&mut film.view).unwrap_err();
        assert!(matches!(waited, Error::Gpu(error) if error.is_device_lost()));
        let report = film.renderer.loss_report();
        assert!(report.is_ours() && report.completed >= completed, "{report}");
        assert!(report.unfinished[0].passes.contains(&"draw visible"), "{report}");
        let fault = describes_faults.then(|| report.fault.clone().unwrap());
        assert_eq!(report.fault.is_some(), describes_faults);
        if let Some(fault) = fault {
            assert_eq!(fault.description, FAULT_DESCRIPTION.to_str().unwrap());
            assert!(fault.addresses[0].contains(&format!("{FAULT_ADDRESS:#x}")), "{report}");
            assert!(fault.codes[0].contains("the seventh"), "{report}");
        }
        fine.install();
        device.wait_idle().unwrap();
    }
}

/// Checks that a GPU which hangs, and whose driver does not lose it, is noticed, named, and left
/// for another device.
#[test]
fn a_gpu_that_hangs_is_left_for_another_device() {
    let instance = tests::instance();
    let scene = Arc::new(scene());
    for driver in Driver::ALL {
        let adapter = instance.pick_adapter(Some(driver.device_name())).unwrap();
        let wait_bound = Duration::from_millis(100);
        let options = DeviceOptions { wait_bound, ..DeviceOptions::default() };
        let device = Device::new(&instance, &adapter, &options).unwrap();
        let twin_device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        let mut film = Film::new(&device, &scene);
        let mut twin = Film::new(&twin_device, &scene);
        let gate = Timeline::new(&device, "gate").unwrap();
        let request = FrameRequest::new(Strategy::ANTUMBRA, camera(0));
        let request = FrameRequest { after: Some(gate.at(Tick(1))), ..request };
        film.renderer.render(&mut film.view, request).unwrap();
        let waited = film.renderer.wait_idle(&mut film.view).unwrap_err();
        assert!(matches!(&waited, Error::Gpu(gpu::Error::Timeout { .. })), "{waited}");
        let report = film.renderer.loss_report();
        assert!(report.is_ours() && report.unfinished[0].passes.contains(&"draw visible"));
        // The work of the GPU that hangs is not waited for.
        film.renderer.recover(&another(&instance, &twin_device)).unwrap();
        for frame in 1..4 {
            let found = film.frame(Strategy::ANTUMBRA, frame);
            let expected = twin.frame(Strategy::FRUSTUM, frame);
            assert_eq!(images_that_differ(&found, &expected), 0, "{driver:?}, frame {frame}");
        }
        gate.signal(Tick(1)).unwrap();
        drop((film, twin, gate, device, twin_device));
        assert_eq!(instance.validation_log().drain(), []);
    }
}

/// Checks that lights which the lost renderer had not looked up yet are found, that free leaves of
/// a given hierarchy are room again, that counts begin anew, and that a token which was cancelled
/// after the creation stops nothing.
#[test]
fn a_recovery_begins_from_the_newest_state() {
    run_on_all(|device| {
        let scene = Arc::new(scene());
        let mut boxes = render::object_bounds(&scene).unwrap();
        boxes.resize(boxes.len() + 3, Aabb::EMPTY);
        let cancellation = gpu::CancellationToken::default();
        let options = RendererOptions {
            size: SIZE,
            cancellation: cancellation.clone(),
            ..Default::default()
        };
        let mut films = [(); 2].map(|()| {
            let hierarchy = Hierarchy::build(&boxes).unwrap();
            let mut renderer =
                Renderer::with_hierarchy(device, &scene, hierarchy, &options).unwrap();
            renderer.keep_scene(Arc::clone(&scene)).unwrap();
            assert!(matches!(renderer.keep_scene(Arc::clone(&scene)), Err(Error::OtherScene)));
            Film { view: renderer.new_view().unwrap(), renderer }
        });
        cancellation.cancel();
        let object = Object { transform: scene.objects[3].transform, ..scene.objects[4] };
        for film in &mut films {
            let added = film.renderer.update(&[ObjectChange::Add { object }]).unwrap().added;
            film.view.watch(&added).unwrap();
            for number in 0..LAMPS {
                let dark = PunctualLight { intensity: 0.0, ..lamp(number, 0) };
                film.renderer.set_light(LightId(number), dark).unwrap();
            }
            for frame in 0..4 {
                drop(film.frame(Strategy::ANTUMBRA, frame));
            }
            // Bright again, which no frame has seen.
            for number in 0..LAMPS {
                film.renderer.set_light(LightId(number), lamp(number, 0)).unwrap();
            }
        }
        let [mut lost, mut twin] = films;
        let counted =
            |film: &Film| film.view.visible_samples().iter().map(|c| c.samples).sum::<u32>();
        assert!(!lost.view.visible_samples().is_empty());
        lost.renderer.recover(device).unwrap();
        let found = lost.frame(Strategy::ANTUMBRA, 5);
        let expected = twin.frame(Strategy::ANTUMBRA, 5);
        assert_eq!(images_that_differ(&found, &expected), 0);
        assert_eq!(counted(&lost), counted(&twin), "counts of the frame after the recovery");
    });
}
