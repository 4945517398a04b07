//! The document on the GPU.

use antumbra::ObjectId;
use antumbra::cull::{SectionMode, SectionPlane, SectionPlanes};
use antumbra::glam::DVec3;
use antumbra::gpu::{Device, DeviceOptions, SampleCount};
use antumbra::render::{EdgeMode, TransparencyOptions};
use bench::options::FrameSize;
use tests::{Driver, open, run};
use workshop::document::{Display, Document};
use workshop::orbit::OrbitCamera;
use workshop::script::Pixel;
use workshop::viewport::{ModelViewport, ViewportOptions};

const SIZE: FrameSize = FrameSize { width: 96, height: 64 };

const MIDDLE: Pixel = Pixel { x: 48, y: 32 };

/// Frames after which the first of them has been read.
const FRAMES: u32 = 4;

fn options() -> ViewportOptions {
    ViewportOptions {
        size: SIZE,
        samples: SampleCount::default(),
        transparency: TransparencyOptions::default(),
        keeps_scene: false,
    }
}

/// Returns the object that the newest frame that was read shows in the middle.
fn pointed(viewport: &ModelViewport) -> Option<ObjectId> {
    viewport.pointed()?.surface.map(|surface| surface.object)
}

#[test]
fn no_answer_names_an_object_by_the_id_of_another() {
    run(Driver::Lavapipe, |device| {
        let made = scenes::waffle_maker();
        let mut document = Document::new(made.scene, made.parts, None);
        let bounds = document.shown_bounds();
        let orbit = OrbitCamera::around((bounds.min + bounds.max) * 0.5, 0.3);
        let camera = orbit.camera(1.0);
        let mut viewport = ModelViewport::new(device, &document, &options()).unwrap();
        viewport.point_at(Some(MIDDLE)).unwrap();
        let draw = |viewport: &mut ModelViewport, document: &Document| {
            viewport.follow(document).unwrap();
            for _ in 0..FRAMES {
                viewport.draw(&camera, None).unwrap();
            }
        };
        draw(&mut viewport, &document);
        let upper = pointed(&viewport).expect("the model is in the middle");
        document.set_display(&[upper], Display::Hidden);
        draw(&mut viewport, &document);
        let lower = pointed(&viewport).expect("there is something below");
        assert_ne!(lower, upper);
        // The one that comes may have the id of the one that goes.
        document.set_display(&[upper], Display::Shown);
        document.set_display(&[lower], Display::Hidden);
        viewport.follow(&document).unwrap();
        assert_eq!(viewport.pointed(), None, "frames so far knew other ids");
        draw(&mut viewport, &document);
        assert_eq!(pointed(&viewport), Some(upper));
    });
}

#[test]
fn a_model_is_the_same_on_another_device_and_changes_go_on() {
    let (instance, device) = open(Driver::Lavapipe);
    {
        let made = scenes::waffle_maker();
        let mut document = Document::new(made.scene, made.parts, None);
        let bounds = document.shown_bounds();
        let middle = (bounds.min + bounds.max) * 0.5;
        let camera = OrbitCamera::around(middle, 0.3).camera(1.0);
        let objects: Vec<ObjectId> = document.objects().collect();
        let plane = SectionPlane::new(DVec3::X, f64::from(-middle.x)).unwrap();
        let section = SectionPlanes::new(&[plane], SectionMode::Intersection).unwrap();
        let options = ViewportOptions { keeps_scene: true, ..options() };
        let mut kept = ModelViewport::new(&device, &document, &options).unwrap();
        let mut twin = ModelViewport::new(&device, &document, &options).unwrap();
        document.set_display(&objects[..2], Display::Hidden);
        document.set_display(&objects[2..4], Display::Ghosted);
        for viewport in [&mut kept, &mut twin] {
            viewport.follow(&document).unwrap();
            viewport.set_section(section).unwrap();
            viewport.set_edges(EdgeMode::Visible).unwrap();
            viewport.outline(std::iter::once(objects[5]), None).unwrap();
        }
        assert_eq!(kept.image(&camera).unwrap(), twin.image(&camera).unwrap());
        let adapter = instance.pick_adapter(Some(&device.adapter().name)).unwrap();
        let another = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        kept.recover(&another).unwrap();
        assert_eq!(kept.image(&camera).unwrap(), twin.image(&camera).unwrap());
        assert_eq!(kept.pick(&camera, MIDDLE).unwrap(), twin.pick(&camera, MIDDLE).unwrap());
        document.set_display(&objects[..3], Display::Shown);
        document.set_display(&objects[6..8], Display::Hidden);
        for viewport in [&mut kept, &mut twin] {
            viewport.follow(&document).unwrap();
        }
        assert_eq!(kept.image(&camera).unwrap(), twin.image(&camera).unwrap());
        let seen = kept.visible(&camera).unwrap();
        assert_eq!(seen, twin.visible(&camera).unwrap());
        assert!(!seen.is_empty());
    }
    let log = instance.validation_log().clone();
    drop((device, instance));
    let messages = log.drain();
    assert!(messages.is_empty(), "{messages:#?}");
}
