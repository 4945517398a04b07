//! The cube in a corner of the image that shows the direction of the eye and turns the view: a
//! click on a face, an edge or a corner shows the model from this side.

use antumbra::glam::{Vec2, Vec3};

use crate::orbit::{CubeView, OrbitCamera};

/// Half an edge of the cube's image, in points, seen straight on.
const HALF_EDGE_POINTS: f32 = 27.0;

/// The largest share of the image's shorter side for half an edge.
const MOST_SHARE: f32 = 0.11;

/// The distance of the cube's middle from the corner, in half edges.
const INSET: f32 = 2.0;

/// The limits of the cells of a face, in half edges from its middle.
const LIMITS: [f32; 4] = [-1.0, -CubeView::EDGE, CubeView::EDGE, 1.0];

/// The least cosine of the angle at which a face is drawn.
const LEAST_FACING: f32 = 0.02;

/// The cube at its place, in pixels from the upper left.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewCube {
    /// The middle.
    pub middle: Vec2,
    /// Half of an edge, seen straight on.
    pub half_edge: f32,
}

/// A cell of a face that faces the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeCell {
    /// The corners in the image, in order.
    pub corners: [Vec2; 4],
    /// The view that a click on the cell selects.
    pub view: CubeView,
    /// The cosine of the angle between the face and the eye's plane.
    pub facing: f32,
}

/// The name of a face that faces the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeLabel {
    /// The place of the face's middle.
    pub at: Vec2,
    /// The name.
    pub name: &'static str,
    /// The cosine of the angle between the face and the eye's plane.
    pub facing: f32,
}

/// A face that faces the eye: the outward axis, and two axes within the face.
struct Face {
    outward: Vec3,
    along: Vec3,
    across: Vec3,
    facing: f32,
}

impl ViewCube {
    /// Returns the cube in the upper right of an image of `size` pixels.
    pub fn in_corner(size: Vec2, pixels_per_point: f32) -> Self {
        let most = size.min_element() * MOST_SHARE;
        let half_edge = (HALF_EDGE_POINTS * pixels_per_point).min(most);
        Self { middle: Vec2::new(size.x - INSET * half_edge, INSET * half_edge), half_edge }
    }

    /// Returns the view at a place of the image; `None` outside of the cube.
    pub fn view_at(&self, camera: &OrbitCamera, place: Vec2) -> Option<CubeView> {
        let offset = (place - self.middle) / self.half_edge;
        // The corners are farthest from the middle.
        if offset.is_nan() || offset.length() > 3.0_f32.sqrt() {
            return None;
        }
        let forward = camera.forward();
        let in_plane = camera.right() * offset.x - camera.up() * offset.y;
        CubeView::under(in_plane - forward * 9.0, forward)
    }

    /// Returns the cells that face the eye.
    pub fn cells(&self, camera: &OrbitCamera) -> Vec<CubeCell> {
        let mut cells = Vec::with_capacity(27);
        for face in faces(camera) {
            for row in 0..3 {
                for column in 0..3 {
                    let corner = |along: f32, across: f32| {
                        let point = face.outward + face.along * along + face.across * across;
                        self.place(camera, point)
                    };
                    let left = LIMITS[column];
                    let right = LIMITS[column + 1];
                    let low = LIMITS[row];
                    let high = LIMITS[row + 1];
                    let corners = [
                        corner(left, low),
                        corner(right, low),
                        corner(right, high),
                        corner(left, high),
                    ];
                    let side = face.outward
                        + face.along * (column as f32 - 1.0)
                        + face.across * (row as f32 - 1.0);
                    let view = CubeView::of_side(side.to_array().map(|part| part as i8));
                    cells.extend(view.map(|view| CubeCell { corners, view, facing: face.facing }));
                }
            }
        }
        cells
    }

    /// Returns the names of the faces that face the eye.
    pub fn labels(&self, camera: &OrbitCamera) -> Vec<CubeLabel> {
        let label = |face: Face| CubeLabel {
            at: self.place(camera, face.outward),
            name: name(face.outward),
            facing: face.facing,
        };
        faces(camera).map(label).collect()
    }

    fn place(&self, camera: &OrbitCamera, point: Vec3) -> Vec2 {
        let offset = Vec2::new(point.dot(camera.right()), -point.dot(camera.up()));
        self.middle + offset * self.half_edge
    }
}

/// Returns the faces that face the eye.
fn faces(camera: &OrbitCamera) -> impl Iterator<Item = Face> {
    let forward = camera.forward();
    Vec3::AXES.into_iter().filter_map(move |axis| {
        let outward = if axis.dot(forward) > 0.0 { -axis } else { axis };
        let facing = -outward.dot(forward);
        // The other two axes, in cyclic order.
        let along = Vec3::new(axis.z, axis.x, axis.y);
        let across = Vec3::new(axis.y, axis.z, axis.x);
        (facing >= LEAST_FACING).then_some(Face { outward, along, across, facing })
    })
}

fn name(outward: Vec3) -> &'static str {
    match outward.to_array() {
        [x, ..] if x > 0.5 => "right",
        [x, ..] if x < -0.5 => "left",
        [_, y, _] if y > 0.5 => "top",
        [_, y, _] if y < -0.5 => "bottom",
        [.., z] if z > 0.0 => "front",
        _ => "back",
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn each_of_the_26_views_is_clicked_where_it_is_drawn() {
        let cube = ViewCube::in_corner(Vec2::new(1280.0, 800.0), 1.0);
        let mut clicked = HashSet::new();
        for yaw in 0..16 {
            for pitch in [-1.2_f32, -0.5, 0.0, 0.4, 1.1] {
                let around = OrbitCamera::around(Vec3::ZERO, 1.0);
                let camera = OrbitCamera { yaw_rad: yaw as f32 * 0.41, pitch_rad: pitch, ..around };
                for cell in cube.cells(&camera) {
                    let middle = cell.corners.iter().sum::<Vec2>() * 0.25;
                    assert_eq!(cube.view_at(&camera, middle), Some(cell.view), "{camera:?}");
                    clicked.insert(cell.view);
                }
            }
        }
        assert_eq!(clicked.len(), 26);
        let camera = OrbitCamera::around(Vec3::ZERO, 1.0);
        assert_eq!(cube.view_at(&camera, Vec2::ZERO), None);
        let names: Vec<&str> = cube.labels(&camera).iter().map(|label| label.name).collect();
        assert_eq!(names, ["right", "top", "front"]);
    }

    #[test]
    fn the_cube_is_whole_in_small_images() {
        for size in [Vec2::new(300.0, 200.0), Vec2::new(40.0, 900.0), Vec2::new(3840.0, 2160.0)] {
            let cube = ViewCube::in_corner(size, 2.0);
            let camera = OrbitCamera::around(Vec3::ZERO, 1.0);
            for corner in cube.cells(&camera).iter().flat_map(|cell| cell.corners) {
                assert!(corner.cmpge(Vec2::ZERO).all() && corner.cmple(size).all(), "{corner}");
            }
        }
        assert_eq!(
            ViewCube::default().view_at(&OrbitCamera::around(Vec3::ZERO, 1.0), Vec2::ONE),
            None
        );
    }
}
