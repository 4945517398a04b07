//! The HUD of the programs over the images of a renderer: readable, deterministic, and absent when
//! it is hidden.

use cull::Strategy;
use gpu::{Device, Readback, SampleCount};
use render::{FrameRequest, RenderView, Renderer, RendererOptions};
use samples::hud::{Hud, HudFigure, HudOverlay, HudPage, Overview};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::run_on_all;

const SIZE: [u32; 2] = [320, 180];

struct Studio {
    renderer: Renderer,
    history: RenderView,
    image: Readback,
    path: CameraPath,
    hud: Hud,
    overlay: HudOverlay,
}

impl Studio {
    fn new(device: &Device, samples: SampleCount) -> Self {
        let GeneratedScene { scene, routes } = city(200, 5).unwrap();
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let options = RendererOptions { size: SIZE, samples, ..RendererOptions::default() };
        let renderer = Renderer::new(device, &scene, &options).unwrap();
        let history = renderer.new_view().unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        let hud = Hud::default();
        let overlay = HudOverlay::new(device);
        Self { renderer, history, image, path, hud, overlay }
    }

    /// Lays out `page` and returns an image with it.
    fn show(&mut self, page: &HudPage) -> Vec<u8> {
        if let Some(frame) = self.hud.lay_out(page, SIZE, 0.5) {
            self.overlay.show(frame).unwrap();
        }
        let request = FrameRequest {
            image: Some(&self.image),
            overlay: self.overlay.shown(),
            ..FrameRequest::new(Strategy::FRUSTUM, self.path.camera(0))
        };
        self.renderer.render(&mut self.history, request).unwrap();
        self.renderer.wait_idle(&mut self.history).unwrap();
        self.image.rgba8().unwrap().to_vec()
    }
}

fn pixel(image: &[u8], place: [u32; 2]) -> [u8; 4] {
    let [x, y] = place;
    let start = (y * SIZE[0] + x) as usize * 4;
    image[start..start + 4].try_into().unwrap()
}

/// Returns a page with a frame rate, and with a toast of `letters` if there are any.
fn page(rate: &str, letters: &str) -> HudPage {
    let figure = |value: &str, name| HudFigure { value: value.to_owned(), name };
    let overview = Overview {
        frames_ms: (0..200).map(|frame| 10.0 + (frame % 9) as f32).collect(),
        budget_ms: Some(16.6),
        rate: figure(rate, "frames/s"),
        ..Overview::default()
    };
    let toast = (!letters.is_empty()).then(|| letters.to_owned());
    HudPage { overview: Some(overview), toast, ..HudPage::default() }
}

#[test]
fn the_hud_can_be_read_and_leaves_the_middle_alone() {
    run_on_all(|device| {
        for samples in [SampleCount::One, SampleCount::Four] {
            let mut studio = Studio::new(device, samples);
            let plain = studio.show(&HudPage::default());
            assert!(studio.overlay.shown().is_none(), "nothing is recorded for nothing");
            let first = studio.show(&page("60", ""));
            assert_ne!(first, plain);
            assert_eq!(pixel(&first, [310, 170]), pixel(&plain, [310, 170]));
            // All text lies on the panel's colour, through which little of the scene shows.
            assert!(pixel(&first, [2, 2])[..3].iter().all(|channel| *channel < 60));
            assert!(first.chunks(4).filter(|pixel| pixel[..3] > [220; 3][..]).count() > 20);
            assert!(studio.show(&page("60", "")) == first, "the same page looks the same");
            assert!(studio.show(&page("30", "")) != first, "another value is another image");
            assert!(studio.show(&HudPage::default()) == plain, "what is hidden is gone");
            assert!(studio.show(&page("60", "")) == first);
        }
    });
}

/// Draws pages with new letters and more triangles in each frame, so that the texture and the
/// buffers are replaced while frames use them.
#[test]
fn letters_and_triangles_that_come_later_are_there_at_once() {
    run_on_all(|device| {
        let mut studio = Studio::new(device, SampleCount::One);
        let letters = |count: u32| -> String {
            (0..count).filter_map(|place| char::from_u32(0x21 + place % 94)).collect()
        };
        let all = page("60", &letters(600));
        let mut fresh = Studio::new(device, SampleCount::One);
        let expected = fresh.show(&all);
        for count in (1..600).step_by(37) {
            let page = page("60", &letters(count));
            studio.overlay.show(studio.hud.lay_out(&page, SIZE, 0.5).unwrap()).unwrap();
            let request = FrameRequest {
                overlay: studio.overlay.shown(),
                ..FrameRequest::new(Strategy::FRUSTUM, studio.path.camera(0))
            };
            studio.renderer.render(&mut studio.history, request).unwrap();
        }
        assert!(studio.show(&all) == expected, "as if nothing had come before");
        // Dropped while a frame is in flight.
        let request = FrameRequest {
            overlay: studio.overlay.shown(),
            ..FrameRequest::new(Strategy::FRUSTUM, studio.path.camera(0))
        };
        studio.renderer.render(&mut studio.history, request).unwrap();
        drop(studio.overlay);
        studio.renderer.wait_idle(&mut studio.history).unwrap();
    });
}
