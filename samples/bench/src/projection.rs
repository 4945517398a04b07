//! The projection of a walk's cameras: their own, orthographic, or jittered.

use antumbra::cull::{Camera, ClipY, CullView, DepthConvention, Projection, ViewProjection};
use antumbra::glam::{Mat4, Vec2, Vec4};
use antumbra::render::{Rect, Viewpoint};

use crate::camera_path::FrameCamera;
use crate::choices::ProjectionChoice;

/// The distance at which an orthographic image is as high as the one in perspective (metres).
const SAME_HEIGHT_AT_M: f32 = 30.0;
/// The far plane of orthographic cameras (metres).
const FAR_M: f32 = 1000.0;
/// The number of frames after which the jitter repeats.
const JITTERS: u32 = 16;
/// The sub-pixel bits of a view of which only the matrix is used.
const ANY_BITS: u32 = 8;

/// Returns the viewpoint of a frame's camera on a part of the image.
pub fn viewpoint(of: &FrameCamera, projection: ProjectionChoice, area: Rect) -> Viewpoint {
    let camera = of.camera;
    match projection {
        ProjectionChoice::Perspective => camera.into(),
        ProjectionChoice::Orthographic => {
            let height = camera.projection.height_at(SAME_HEIGHT_AT_M);
            let projection = Projection::Orthographic { height, far: FAR_M };
            Camera { projection, near: 0.0, ..camera }.into()
        }
        ProjectionChoice::Jittered => {
            let [width, height] = area.size.map(|side| side.max(1) as f32);
            let moved = jitter_pixels(of.frame) * 2.0 / Vec2::new(width, height);
            // Clip space is moved by a share of w.
            let jitter = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::Z, moved.extend(0.0).extend(1.0));
            let plain = CullView::new(&camera, area.size, ANY_BITS).view_proj;
            let depth = DepthConvention::Reversed;
            let y = ClipY::Down;
            ViewProjection { matrix: jitter * plain, depth, y }.into()
        }
    }
}

/// Returns the jitter of a frame, from -0.5 to 0.5 pixels: the Halton sequence of bases 2 and 3.
fn jitter_pixels(frame: u32) -> Vec2 {
    let index = frame % JITTERS + 1;
    Vec2::new(radical_inverse(index, 2), radical_inverse(index, 3)) - 0.5
}

/// Returns the digits of a number in a base, mirrored at the radix point.
fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let mut digit = 1.0;
    let mut sum = 0.0;
    while index > 0 {
        digit /= base as f32;
        sum += (index % base) as f32 * digit;
        index /= base;
    }
    sum
}

#[cfg(test)]
mod tests {
    use antumbra::glam::Vec3;

    use super::*;

    #[test]
    fn jitters_fill_the_pixel_and_repeat() {
        let jitters: Vec<Vec2> = (0..JITTERS).map(jitter_pixels).collect();
        assert!(jitters.iter().all(|jitter| jitter.abs().max_element() <= 0.5));
        for quarter in
            [Vec2::new(-0.5, -0.5), Vec2::new(-0.5, 0.0), Vec2::new(0.0, -0.5), Vec2::ZERO]
        {
            let within = |jitter: &&Vec2| {
                (**jitter).cmpge(quarter).all() && (**jitter).cmplt(quarter + 0.5).all()
            };
            assert!(jitters.iter().filter(within).count() >= 3, "{quarter}");
        }
        assert_eq!(jitter_pixels(3), jitter_pixels(3 + JITTERS));
        assert_ne!(jitter_pixels(3), jitter_pixels(4));
    }

    #[test]
    fn a_jitter_moves_everything_by_that_part_of_a_pixel() {
        let projection = Projection::perspective(1.0);
        let camera =
            Camera { eye: Vec3::ZERO, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 };
        let area = Rect::whole([200, 100]);
        let of = FrameCamera { frame: 5, camera };
        let Viewpoint::Matrix(jittered) = viewpoint(&of, ProjectionChoice::Jittered, area) else {
            panic!("a matrix");
        };
        let plain = CullView::new(&camera, area.size, ANY_BITS).view_proj;
        for point in [Vec3::new(1.0, 2.0, -5.0), Vec3::new(-30.0, 4.0, -80.0)] {
            let pixel = |matrix: Mat4| {
                let at = matrix * point.extend(1.0);
                Vec2::new(at.x, at.y) / at.w * Vec2::new(100.0, 50.0)
            };
            let moved = pixel(jittered.matrix) - pixel(plain);
            assert!((moved - jitter_pixels(5)).length() < 1e-3, "{moved}");
        }
    }
}
