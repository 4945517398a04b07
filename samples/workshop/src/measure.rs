//! Measures the edge of a model near a seen point.

use antumbra::cull::CullView;
use antumbra::glam::{Affine3A, DVec2, DVec3, Vec3};
use antumbra::scene::{EdgeRules, FeatureEdges, Mesh};

use crate::hit::world_point;

/// The distance in pixels within which an edge is selected.
const REACH_PIXELS: f64 = 8.0;

/// An edge of a model near a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearEdge {
    /// The length from corner to corner, in metres.
    pub length_m: f64,
    /// The distance of its nearest point from the pixel, in pixels.
    pub apart_pixels: f64,
}

/// Returns the edge of the model at a point seen on a mesh: the nearest edge in space, if it is
/// also near a place of the image, in pixels. An edge extends from corner to corner of the model,
/// regardless of the number of triangles along it. `None` if no edge is near.
pub fn near_edge(
    mesh: &Mesh,
    transform: &Affine3A,
    view: &CullView,
    seen: DVec3,
    place: DVec2,
) -> Option<NearEdge> {
    let positions: Vec<Vec3> = mesh.vertices.iter().map(|vertex| vertex.position.into()).collect();
    let edges = FeatureEdges::of_mesh(mesh, &EdgeRules::default());
    let corner = |vertex: u32| {
        let position = positions.get(vertex as usize)?;
        Some(world_point(transform, *position))
    };
    let nearest_points = (0..).zip(edges.features()).filter_map(|(number, segment)| {
        let point = nearest_of_segment(corner(segment.from)?, corner(segment.to)?, seen);
        Some((number, point))
    });
    let apart = |point: &DVec3| point.distance(seen);
    let nearest = nearest_points.min_by(|(_, a), (_, b)| apart(a).total_cmp(&apart(b)));
    let (segment, point): (u32, DVec3) = nearest?;
    let apart_pixels = in_image(view, point).distance(place);
    let chain = edges.chain_of(segment).filter(|_| apart_pixels <= REACH_PIXELS)?;
    Some(NearEdge { length_m: edges.chain_length(chain, &positions, transform), apart_pixels })
}

fn nearest_of_segment(from: DVec3, to: DVec3, point: DVec3) -> DVec3 {
    let along = to - from;
    let length_squared = along.length_squared();
    if length_squared == 0.0 {
        return from;
    }
    from + along * ((point - from).dot(along) / length_squared).clamp(0.0, 1.0)
}

/// Returns the place of a point in the image, in pixels.
pub fn in_image(view: &CullView, point: DVec3) -> DVec2 {
    let relative = point - view.anchor.as_dvec3();
    let place = view.from_anchor.as_dmat4().project_point3(relative).truncate();
    let [width, height] = view.size.map(f64::from);
    (place + 1.0) * 0.5 * DVec2::new(width, height)
}

#[cfg(test)]
mod tests {
    use antumbra::{Camera, Projection};

    use super::*;

    /// Returns a flat strip of `quads` quads, 1 m long and 0.2 m wide.
    fn strip(quads: u32) -> Mesh {
        let grey = [0.5; 3];
        let mut corners = Vec::new();
        for quad in 0..quads {
            let at = |offset: u32| (quad + offset) as f32 / quads as f32;
            let left = at(0);
            let right = at(1);
            let a = [left, 0.0, 0.0];
            let b = [right, 0.0, 0.0];
            let c = [right, 0.2, 0.0];
            let d = [left, 0.2, 0.0];
            corners.extend([a, b, c, a, c, d].map(|corner| (corner, grey)));
        }
        Mesh::of_triangles("strip", &corners)
    }

    #[test]
    fn an_edge_of_five_triangles_is_one_edge_in_any_projection() {
        let mesh = strip(5);
        // Twice as large, and rotated out of the image plane.
        let transform = Affine3A::from_rotation_y(0.7) * Affine3A::from_scale(Vec3::splat(2.0));
        let near_long = transform.transform_point3(Vec3::new(0.31, 0.001, 0.0)).as_dvec3();
        let in_the_middle = transform.transform_point3(Vec3::new(0.31, 0.1, 0.0)).as_dvec3();
        let near_side = transform.transform_point3(Vec3::new(0.999, 0.1, 0.0)).as_dvec3();
        for projection in
            [Projection::perspective(0.9), Projection::Orthographic { height: 2.0, far: 9.0 }]
        {
            let eye = Vec3::Z * 3.0;
            let camera = Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 };
            let view = CullView::new(&camera, [1000, 1000], 8);
            let length = |seen| {
                let place = in_image(&view, seen);
                near_edge(&mesh, &transform, &view, seen, place).map(|edge| edge.length_m)
            };
            assert!((length(near_long).unwrap() - 2.0).abs() < 1e-6);
            assert!((length(near_side).unwrap() - 0.4).abs() < 1e-6);
            assert_eq!(length(in_the_middle), None);
        }
    }
}
