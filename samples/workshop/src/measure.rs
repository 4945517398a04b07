//! Measuring: the edge of a model near a point that was seen.

use antumbra::cull::View;
use antumbra::glam::{Affine3A, DVec2, DVec3, Vec3};
use antumbra::scene::{EdgeRules, FeatureEdges, Mesh};

use crate::hit::world_point;

/// The distance in pixels within which an edge is meant.
const REACH_PIXELS: f64 = 8.0;

/// Returns the length of the edge of the model that is meant by a point seen on a mesh, in metres:
/// of the nearest one in space, if it is near in the image, too. An edge goes from corner to corner
/// of the model, however many triangles lie along it. `None` if no edge is near.
pub fn edge_length(mesh: &Mesh, transform: &Affine3A, view: &View, seen: DVec3) -> Option<f64> {
    let positions: Vec<Vec3> = mesh.vertices.iter().map(|vertex| vertex.position.into()).collect();
    let edges = FeatureEdges::of_mesh(mesh, &EdgeRules::default());
    let place = |vertex: u32| {
        let position = positions.get(vertex as usize)?;
        Some(world_point(transform, *position))
    };
    let nearest_points = (0..).zip(edges.features()).filter_map(|(number, segment)| {
        let point = nearest_of_segment(place(segment.from)?, place(segment.to)?, seen);
        Some((number, point))
    });
    let apart = |point: &DVec3| point.distance(seen);
    let nearest = nearest_points.min_by(|(_, a), (_, b)| apart(a).total_cmp(&apart(b)));
    let (segment, point): (u32, DVec3) = nearest?;
    let apart_pixels = in_image(view, point).distance(in_image(view, seen));
    let chain = edges.chain_of(segment).filter(|_| apart_pixels <= REACH_PIXELS)?;
    Some(edges.chain_length(chain, &positions, transform))
}

/// Returns the point of a segment that is nearest to another point.
fn nearest_of_segment(from: DVec3, to: DVec3, point: DVec3) -> DVec3 {
    let along = to - from;
    let length_squared = along.length_squared();
    if length_squared == 0.0 {
        return from;
    }
    from + along * ((point - from).dot(along) / length_squared).clamp(0.0, 1.0)
}

/// Returns the place of a point in the image, in pixels.
fn in_image(view: &View, point: DVec3) -> DVec2 {
    let relative = point - view.anchor.as_dvec3();
    let place = view.from_anchor.as_dmat4().project_point3(relative).truncate();
    let [width, height] = view.size.map(f64::from);
    (place + 1.0) * 0.5 * DVec2::new(width, height)
}

#[cfg(test)]
mod tests {
    use antumbra::{Camera, Projection};

    use super::*;

    /// Returns a strip of so many quads, 1 m long in all and 0.2 m wide, bent nowhere.
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
        // Twice as large, and turned out of the image's plane.
        let transform = Affine3A::from_rotation_y(0.7) * Affine3A::from_scale(Vec3::splat(2.0));
        let near_edge = transform.transform_point3(Vec3::new(0.31, 0.001, 0.0)).as_dvec3();
        let in_the_middle = transform.transform_point3(Vec3::new(0.31, 0.1, 0.0)).as_dvec3();
        let near_side = transform.transform_point3(Vec3::new(0.999, 0.1, 0.0)).as_dvec3();
        for projection in
            [Projection::perspective(0.9), Projection::Orthographic { height: 2.0, far: 9.0 }]
        {
            let eye = Vec3::Z * 3.0;
            let camera = Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 };
            let view = View::new(&camera, [1000, 1000], 8);
            let length = |seen| edge_length(&mesh, &transform, &view, seen);
            assert!((length(near_edge).unwrap() - 2.0).abs() < 1e-6);
            assert!((length(near_side).unwrap() - 0.4).abs() < 1e-6);
            assert_eq!(length(in_the_middle), None);
        }
    }
}
