//! Flat images over the scene: at the place where they were laid out, without effect elsewhere,
//! and removable.

use cull::Strategy;
use gpu::{Device, Readback};
use render::{FlatVertex, FrameRequest, Renderer, RendererOptions, ViewState};
use samples::hud::{Hud, HudFigure, HudPage, Overview};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::run_on_all;

const SIZE: [u32; 2] = [320, 180];

struct Studio {
    renderer: Renderer,
    history: ViewState,
    image: Readback,
    path: CameraPath,
}

impl Studio {
    fn new(device: &Device) -> Self {
        let GeneratedScene { scene, routes } = city(200, 5).unwrap();
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let options = RendererOptions { size: SIZE, ..RendererOptions::default() };
        let renderer = Renderer::new(device, &scene, &options).unwrap();
        let history = renderer.new_view().unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        Self { renderer, history, image, path }
    }

    fn image(&mut self, frame: u32) -> Vec<u8> {
        let request = FrameRequest {
            image: Some(&self.image),
            ..FrameRequest::new(Strategy::ANTUMBRA, self.path.camera(frame))
        };
        self.renderer.render(&mut self.history, &request).unwrap();
        self.renderer.drain(&mut self.history).unwrap();
        self.image.rgba8().unwrap().to_vec()
    }
}

fn pixel(image: &[u8], [x, y]: [u32; 2]) -> [u8; 4] {
    let start = (y * SIZE[0] + x) as usize * 4;
    image[start..start + 4].try_into().unwrap()
}

/// Returns two triangles over a rectangle of the image.
fn rectangle(from: [f32; 2], to: [f32; 2], colour: [u8; 4]) -> ([FlatVertex; 4], [u32; 6]) {
    let corner = |x: usize, y: usize| FlatVertex {
        position: [[from, to][x][0], [from, to][y][1]],
        texture_position: [x as f32, y as f32],
        colour,
    };
    ([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)], [0, 1, 2, 0, 2, 3])
}

#[test]
fn what_is_flat_is_where_it_was_laid_out() {
    run_on_all(|device| {
        let mut studio = Studio::new(device);
        let plain = studio.image(3);
        let overlay = studio.renderer.flat_overlay().unwrap();
        overlay.begin_atlas([2, 2]).unwrap();
        overlay.write_atlas([0, 0], [2, 2], [[255; 4]; 4].into_iter()).unwrap();
        let (vertices, indices) = rectangle([20.0, 10.0], [60.0, 50.0], [255, 0, 0, 255]);
        overlay.add([0, 0], [40, 180], &vertices, &indices);
        overlay.add([0, 0], SIZE, &vertices, &[0, 1, 9, 4, 4]);
        let drawn = studio.image(3);
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let is_inside = (20..40).contains(&x) && (10..50).contains(&y);
                let expected = if is_inside { [255, 0, 0, 255] } else { pixel(&plain, [x, y]) };
                assert_eq!(pixel(&drawn, [x, y]), expected, "{x}, {y}");
            }
        }
        studio.renderer.flat_overlay().unwrap().clear();
        assert!(studio.image(3) == plain, "what was cleared is gone");
        studio.renderer.drop_flat_overlay();
        assert!(studio.image(3) == plain);
    });
}

#[test]
fn an_atlas_is_written_piece_by_piece_and_sampled_in_linear_light() {
    run_on_all(|device| {
        let mut studio = Studio::new(device);
        let overlay = studio.renderer.flat_overlay().unwrap();
        overlay.begin_atlas([4, 1]).unwrap();
        let (vertices, indices) = rectangle([0.0, 0.0], [4.0, 1.0], [255; 4]);
        overlay.add([0, 0], SIZE, &vertices, &indices);
        let plain = studio.image(0);
        let overlay = studio.renderer.flat_overlay().unwrap();
        overlay.write_atlas([1, 0], [1, 1], [[188, 94, 0, 255]].into_iter()).unwrap();
        assert_eq!(pixel(&studio.image(0), [1, 0]), [188, 94, 0, 255]);
        let overlay = studio.renderer.flat_overlay().unwrap();
        // Half covered by white: as much light as the mean of both has.
        overlay.write_atlas([2, 0], [1, 1], [[128; 4]].into_iter()).unwrap();
        let drawn = studio.image(0);
        assert_eq!(pixel(&drawn, [1, 0]), [188, 94, 0, 255], "earlier pieces stay");
        assert_eq!(pixel(&drawn, [0, 0]), pixel(&plain, [0, 0]), "never written is transparent");
        let light = |encoded: u8| {
            let encoded = f64::from(encoded) / 255.0;
            if encoded <= 0.040_45 {
                encoded / 12.92
            } else {
                ((encoded + 0.055) / 1.055).powf(2.4)
            }
        };
        for channel in 0..3 {
            let below = light(pixel(&plain, [2, 0])[channel]);
            let expected = below + (1.0 - below) * 128.0 / 255.0;
            let found = light(pixel(&drawn, [2, 0])[channel]);
            assert!((expected - found).abs() < 0.01, "{expected} {found}");
        }
        let overlay = studio.renderer.flat_overlay().unwrap();
        for (origin, size, pixels) in [
            ([3, 0], [2, 1], 2),
            ([0, 0], [1, 1], 2),
            ([0, 0], [0, 0], 0),
            ([u32::MAX, 0], [1, 1], 1),
        ] {
            let refused = overlay.write_atlas(origin, size, vec![[0; 4]; pixels].into_iter());
            assert!(refused.unwrap_err().to_string().contains("of an atlas of 4x1"));
        }
        assert!(overlay.begin_atlas([0, 5]).is_err());
    });
}

#[test]
fn the_hud_can_be_read_and_leaves_the_middle_alone() {
    run_on_all(|device| {
        let mut studio = Studio::new(device);
        let plain = studio.image(0);
        let figure = |value: &str, name| HudFigure { value: value.to_owned(), name };
        let mut overview = Overview {
            frames_ms: (0..200).map(|frame| 10.0 + (frame % 9) as f32).collect(),
            budget_ms: Some(16.6),
            rate: figure("60", "frames/s"),
            ..Overview::default()
        };
        let page = HudPage { overview: Some(overview.clone()), ..HudPage::default() };
        let mut hud = Hud::default();
        let mut show = |page: &HudPage, studio: &mut Studio| {
            hud.lay_out(page, SIZE, 0.5, studio.renderer.flat_overlay().unwrap()).unwrap();
            studio.image(0)
        };
        let first = show(&page, &mut studio);
        assert_ne!(first, plain);
        assert_eq!(pixel(&first, [310, 170]), pixel(&plain, [310, 170]));
        assert!(show(&page, &mut studio) == first, "the same page looks the same");
        overview.rate.value = "30".to_owned();
        let page = HudPage { overview: Some(overview), ..HudPage::default() };
        assert!(show(&page, &mut studio) != first, "another value is another image");
    });
}
