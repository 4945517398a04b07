//! The check of a host's views: numbers that nothing can be drawn or culled by are refused once per
//! view, before any object is looked at.

use thiserror::Error;

use crate::geom::camera::{Camera, Projection};
use crate::geom::view::CullView;

/// The reason why a camera or a view is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum InvalidView {
    /// A field has a number that is infinite or NaN.
    #[error("`{field}` has a number that is infinite or NaN: check what it is computed from")]
    NotFinite {
        /// The path of the field, such as `camera.eye`.
        field: &'static str,
    },
    /// The image of the view has no pixel.
    #[error(
        "a view of {}x{} pixels shows nothing: draw no frame while the window or the image is empty",
        size[0], size[1]
    )]
    NoPixels {
        /// The size of the view's image in pixels.
        size: [u32; 2],
    },
}

/// Refuses a camera that [`CullView::new`] would repair silently, for an image of `size` pixels:
/// numbers that are not finite, and an image without pixels.
///
/// # Errors
/// [`InvalidView`], with the field.
pub fn check_camera(camera: &Camera, size: [u32; 2]) -> Result<(), InvalidView> {
    let Camera { eye, forward, up, projection, near } = camera;
    check_view_size(size)?;
    check_finite("camera.eye", eye.is_finite())?;
    check_finite("camera.forward", forward.is_finite())?;
    check_finite("camera.up", up.is_finite())?;
    check_finite("camera.near", near.is_finite())?;
    match projection {
        Projection::Perspective { fov_y } => {
            check_finite("camera.projection.fov_y", fov_y.is_finite())
        }
        Projection::Orthographic { height, far } => {
            check_finite("camera.projection.height", height.is_finite())?;
            check_finite("camera.projection.far", far.is_finite())
        }
    }
}

/// Refuses a view with numbers that are not finite or without pixels. A view is finite if its
/// camera is, unless products of its numbers are beyond single precision.
///
/// # Errors
/// [`InvalidView`], with the field.
pub fn check_view(view: &CullView) -> Result<(), InvalidView> {
    check_view_size(view.size)?;
    check_finite("view.view_proj", view.view_proj.is_finite())?;
    check_finite("view.anchor", view.anchor.is_finite())?;
    check_finite("view.from_anchor", view.from_anchor.is_finite())?;
    check_finite("view.rays", view.rays.is_finite() && view.rays.near.is_finite())?;
    check_finite("view.snap_steps", view.snap_steps.iter().all(|steps| steps.is_finite()))
}

/// Refuses an image without pixels.
///
/// # Errors
/// [`InvalidView::NoPixels`].
pub fn check_view_size(size: [u32; 2]) -> Result<(), InvalidView> {
    if size.contains(&0) { Err(InvalidView::NoPixels { size }) } else { Ok(()) }
}

fn check_finite(field: &'static str, is_finite: bool) -> Result<(), InvalidView> {
    if is_finite { Ok(()) } else { Err(InvalidView::NotFinite { field }) }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geom::bounds::Aabb;
    use crate::{CullConfig, Culler, FramePlan, Hierarchy, Strategy};

    const SIZE: [u32; 2] = [64, 48];

    fn camera() -> Camera {
        Camera::look_at([0.0, 1.0, 5.0], [0.0; 3])
    }

    fn refusal(change: impl FnOnce(&mut Camera)) -> Result<(), InvalidView> {
        let mut camera = camera();
        change(&mut camera);
        check_camera(&camera, SIZE)
    }

    fn not_finite(field: &'static str) -> Result<(), InvalidView> {
        Err(InvalidView::NotFinite { field })
    }

    #[test]
    fn each_number_of_a_camera_is_checked_and_named() {
        assert_eq!(refusal(|_| ()), Ok(()));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(refusal(|camera| camera.eye.x = bad), not_finite("camera.eye"));
            assert_eq!(refusal(|camera| camera.forward.y = bad), not_finite("camera.forward"));
            assert_eq!(refusal(|camera| camera.up.z = bad), not_finite("camera.up"));
            assert_eq!(refusal(|camera| camera.near = bad), not_finite("camera.near"));
            for (projection, field) in [
                (Projection::Perspective { fov_y: bad }, "camera.projection.fov_y"),
                (Projection::Orthographic { height: bad, far: 9.0 }, "camera.projection.height"),
                (Projection::Orthographic { height: 9.0, far: bad }, "camera.projection.far"),
            ] {
                assert_eq!(refusal(|camera| camera.projection = projection), not_finite(field));
            }
        }
    }

    #[test]
    fn a_view_without_pixels_is_refused() {
        for size in [[0, 0], [0, 48], [64, 0]] {
            let expected = Err(InvalidView::NoPixels { size });
            assert_eq!(check_camera(&camera(), size), expected);
            let view = CullView { size, ..CullView::new(&camera(), SIZE, 8) };
            assert_eq!(check_view(&view), expected);
        }
        let sentence = InvalidView::NoPixels { size: [0, 48] }.to_string();
        assert!(sentence.starts_with("a view of 0x48 pixels"), "{sentence}");
    }

    /// Returns views with a number that is not finite, and the field that has it.
    fn bad_views() -> Vec<(CullView, &'static str)> {
        let good = CullView::new(&camera(), SIZE, 8);
        let mut bad = Vec::new();
        for number in [f32::NAN, f32::INFINITY] {
            let mut view = good;
            view.view_proj.x_axis.x = number;
            bad.push((view, "view.view_proj"));
            let mut view = good;
            view.anchor.y = number;
            bad.push((view, "view.anchor"));
            let mut view = good;
            view.from_anchor.w_axis.z = number;
            bad.push((view, "view.from_anchor"));
            let mut view = good;
            view.rays.origin.z = number;
            bad.push((view, "view.rays"));
            let mut view = good;
            view.rays.near = number;
            bad.push((view, "view.rays"));
            bad.push((CullView { snap_steps: [8.0, number], ..good }, "view.snap_steps"));
        }
        // Each number of the camera is finite, and products of them are not.
        let far = Camera { eye: Vec3::splat(3.0e38), ..camera() };
        assert_eq!(check_camera(&far, SIZE), Ok(()));
        bad.push((CullView::new(&far, SIZE, 8), "view.view_proj"));
        bad
    }

    #[test]
    fn each_number_of_a_view_is_checked_and_named() {
        assert_eq!(check_view(&CullView::new(&camera(), SIZE, 8)), Ok(()));
        for (view, field) in bad_views() {
            assert_eq!(check_view(&view), not_finite(field), "{view:?}");
        }
    }

    #[test]
    fn a_plan_for_an_unchecked_view_with_impossible_numbers_does_not_panic() {
        let boxes: Vec<Aabb> = (0..40)
            .map(|number| {
                let low = Vec3::new(number as f32, 0.0, -3.0);
                Aabb::new(low, low + Vec3::ONE)
            })
            .collect();
        let hierarchy = Hierarchy::build(&boxes).unwrap();
        let empty = CullView { size: [0; 2], ..CullView::new(&camera(), SIZE, 8) };
        let bad = bad_views().into_iter().map(|(view, _)| view).chain([empty]);
        for view in bad {
            for strategy in Strategy::PLANNED {
                let mut culler = Culler::new(CullConfig::default());
                let mut plan = FramePlan::default();
                for _ in 0..3 {
                    culler.plan(&hierarchy, strategy, &view, 100, &mut plan);
                }
            }
        }
    }
}
