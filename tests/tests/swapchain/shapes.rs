//! A circle in windows of every shape stays a circle, in the middle of black borders.

use gpu::{Device, FrameRing, Target};
use tests::xvfb::Xvfb;

use crate::show_surely;
use tests::window_fixture::WindowStage;
use tests::window_matrix::WAYS;
use tests::x11_window::X11Window;

const IMAGE: [u32; 2] = [320, 180];
const RADIUS: u32 = 60;
const BACKGROUND: [u8; 3] = [0, 0, 255];

/// Paints a white circle in the middle of blue, row by row.
fn circle(device: &Device) -> Target {
    let mut target = Target::new(device, IMAGE, "circle").unwrap();
    let mut ring = FrameRing::new(device, 1).unwrap();
    let frame = ring.begin().unwrap();
    let commands = frame.commands();
    target.prepare(commands);
    commands.rendering(target.render_target(Some([0.0, 0.0, 1.0, 1.0])), |_| {});
    let [x, y] = IMAGE.map(|side| side / 2);
    for row in 0..2 * RADIUS {
        let up = f64::from(row) + 0.5 - f64::from(RADIUS);
        let half = (f64::from(RADIUS).powi(2) - up * up).sqrt().round() as u32;
        target.prepare(commands);
        let white = target.render_target(Some([1.0; 4]));
        commands.rendering(white.within([x - half, y + row - RADIUS], [2 * half, 1]), |_| {});
    }
    frame.submit(None).unwrap();
    target.submitted();
    target
}

/// Returns the first and last columns and rows with such a pixel.
fn extent(
    pixels: &[[u8; 3]],
    size: [u32; 2],
    is_it: impl Fn(&[u8; 3]) -> bool,
) -> Option<[[u32; 2]; 2]> {
    let places = pixels.iter().zip(0_u32..).filter(|(pixel, _)| is_it(pixel));
    let places = places.map(|(_, place)| [place % size[0], place / size[0]]);
    places.fold(None, |found: Option<[[u32; 2]; 2]>, place| {
        let [least, most] = found.unwrap_or([place; 2]);
        let both = |pick: fn(u32, u32) -> u32, with: [u32; 2]| {
            [pick(with[0], place[0]), pick(with[1], place[1])]
        };
        Some([both(u32::min, least), both(u32::max, most)])
    })
}

#[test]
fn a_circle_stays_a_circle_in_windows_of_any_shape() {
    let server = Xvfb::start();
    for (driver, library) in WAYS {
        let window = X11Window::open(&server, library, IMAGE);
        let stage = WindowStage::new(driver, window.clone());
        let target = circle(&stage.device);
        let mut swapchain = stage.swapchain(&Default::default());
        // Also windows that have just been resized, while the image still has the old shape.
        for size in [IMAGE, [700, 180], [320, 700], [90, 500], [333, 181], [640, 360], [641, 200]] {
            window.resize(size);
            assert_eq!(show_surely(&mut swapchain, &target, size).size, size);
            stage.device.wait_idle().unwrap();
            let scale = (f64::from(size[0]) / 320.0).min(f64::from(size[1]) / 180.0);
            let is_right = |pixels: &[[u8; 3]]| {
                let white = extent(pixels, size, |pixel| *pixel == [255; 3])?;
                let image = extent(pixels, size, |pixel| *pixel != [0; 3])?;
                let diameter = f64::from(2 * RADIUS) * scale;
                let is_round = (0..2).all(|side| {
                    let found = f64::from(white[1][side] - white[0][side] + 1);
                    let middle = f64::from(white[1][side] + white[0][side] + 1) / 2.0;
                    let all = f64::from(image[1][side] - image[0][side] + 1);
                    // Interpolated pixels at the edge are not white.
                    (found - diameter).abs() < 4.0
                        && (middle - f64::from(size[side]) / 2.0).abs() < 2.0
                        && (all - f64::from(IMAGE[side]) * scale).abs() < 2.0
                });
                let corner = (image[0][1] * size[0] + image[0][0]) as usize;
                (is_round && pixels[corner] == BACKGROUND).then_some(())
            };
            let began = std::time::Instant::now();
            while is_right(&window.pixels(size)).is_none() {
                let found = extent(&window.pixels(size), size, |pixel| *pixel == [255; 3]);
                let late = began.elapsed() > std::time::Duration::from_secs(5);
                assert!(!late, "{driver:?}, {size:?}: the circle is at {found:?}");
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        }
        drop((swapchain, target));
        stage.end();
    }
}
