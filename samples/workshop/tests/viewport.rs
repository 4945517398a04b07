//! The document on the GPU.

use antumbra::ObjectId;
use antumbra::gpu::SampleCount;
use antumbra::render::TransparencyOptions;
use tests::{Driver, run};
use workshop::document::{Display, Document};
use workshop::orbit::OrbitCamera;
use workshop::script::Pixel;
use workshop::viewport::ModelViewport;

const SIZE: [u32; 2] = [96, 64];

const MIDDLE: Pixel = Pixel { x: 48, y: 32 };

/// Frames after which the first of them has been read.
const FRAMES: u32 = 4;

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
        let order = TransparencyOptions::default();
        let samples = SampleCount::default();
        let mut viewport = ModelViewport::new(device, &document, SIZE, samples, order).unwrap();
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
