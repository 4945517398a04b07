//! Normals: flat ones if a file has none, as the specification requires, and repairs of broken
//! ones.

use glam::Vec3;
use scene::MorphTarget;

use super::geometry::Geometry;
use super::numbers::{direction, triangle_normal};
use super::pack::snorm16;

/// Returns the normal of a triangle, or any direction if it has no area.
fn flat(corners: [Vec3; 3]) -> Vec3 {
    triangle_normal(corners).unwrap_or_else(|| {
        let [a, b, c] = corners;
        let edge = direction(b - a).or_else(|| direction(c - a)).unwrap_or(Vec3::X);
        edge.any_orthonormal_vector()
    })
}

/// Gives every triangle its flat normal and removes tangents (3.7.2.1: tangents of the file are
/// then ignored). Triangles in one plane still share vertices, unless morph targets bend the plane.
///
/// A morph target gets the difference between the flat normals with the target at weight 1 and
/// without it. This is exact at weights 0 and 1, and a mix between them.
pub(super) fn flatten(geometry: &Geometry) -> Geometry {
    let corners = |triangle: &[u32; 3], moved: Option<&MorphTarget>| {
        triangle.map(|vertex| {
            let vertex = vertex as usize;
            let delta = moved.and_then(|target| target.positions.get(vertex));
            let rest = geometry.positions.get(vertex).copied().unwrap_or_default();
            rest + delta.map_or(Vec3::ZERO, |delta| Vec3::from_array(*delta))
        })
    };
    let of_target = |target: Option<&MorphTarget>| -> Vec<Vec3> {
        geometry.triangles.iter().map(|triangle| flat(corners(triangle, target))).collect()
    };
    let normals = of_target(None);
    let is_morphed = geometry.targets.iter().any(|target| !target.positions.is_empty());
    let (mut split, origins) = geometry.split(|triangle, _| {
        let normal = normals.get(triangle).copied().unwrap_or_default();
        // The packed normals: a difference by rounding does not split a plane.
        (normal.to_array().map(snorm16), if is_morphed { triangle } else { 0 })
    });
    let of_vertices = |of_triangles: &[Vec3]| -> Vec<Vec3> {
        let of_origin = |&[triangle, _]: &[u32; 2]| of_triangles.get(triangle as usize).copied();
        origins.iter().map(|origin| of_origin(origin).unwrap_or(Vec3::Y)).collect()
    };
    split.normals = of_vertices(&normals);
    split.tangents = Vec::new();
    for (target, of_file) in split.targets.iter_mut().zip(&geometry.targets) {
        (target.normals, target.tangents) = (Vec::new(), Vec::new());
        if !target.positions.is_empty() {
            let bent = of_vertices(&of_target(Some(of_file)));
            let both = bent.iter().zip(&split.normals);
            target.normals = both.map(|(bent, rest)| (*bent - *rest).to_array()).collect();
        }
    }
    split
}

/// Normalises all normals in place. A normal without direction gets the normal of one of its
/// triangles. Returns the number of such normals.
pub(super) fn repair(geometry: &mut Geometry) -> usize {
    let mut broken = vec![];
    for (place, normal) in geometry.normals.iter_mut().enumerate() {
        match direction(*normal) {
            Some(unit) => *normal = unit,
            None => {
                *normal = Vec3::ZERO;
                broken.push(place);
            }
        }
    }
    if broken.is_empty() {
        return 0;
    }
    for triangle in &geometry.triangles {
        let at = |vertex: u32| geometry.positions.get(vertex as usize).copied().unwrap_or_default();
        for &vertex in triangle {
            if let Some(normal) = geometry.normals.get_mut(vertex as usize)
                && *normal == Vec3::ZERO
            {
                *normal = triangle_normal(triangle.map(at)).unwrap_or_default();
            }
        }
    }
    for &place in &broken {
        if let Some(normal) = geometry.normals.get_mut(place)
            && *normal == Vec3::ZERO
        {
            *normal = Vec3::Y;
        }
    }
    broken.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    /// Returns two triangles of a square in z = 0, and one that stands on the square's edge along
    /// x.
    fn step() -> Geometry {
        Geometry {
            positions: vec![
                Vec3::ZERO,
                Vec3::X,
                vec3(1.0, 1.0, 0.0),
                Vec3::Y,
                vec3(0.5, 0.0, -1.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3], [1, 0, 4]],
            ..Geometry::default()
        }
    }

    #[test]
    fn flat_normals_split_edges_and_share_planes() {
        let flat = flatten(&step());
        assert_eq!(flat.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
        assert_eq!(flat.normals[..4], [Vec3::Z; 4]);
        assert_eq!(flat.normals[4..], [Vec3::NEG_Y; 3]);
        assert_eq!(flat.positions[4..], [Vec3::X, Vec3::ZERO, vec3(0.5, 0.0, -1.0)]);
    }

    #[test]
    fn flat_normals_turn_with_morph_targets() {
        let mut bent = step();
        let mut positions = vec![[0.0; 3]; 5];
        positions[3] = [0.0, -1.0, 1.0];
        bent.targets =
            vec![MorphTarget { positions, normals: vec![[9.0; 3]; 5], ..MorphTarget::default() }];
        let flat = flatten(&bent);
        assert_eq!(flat.positions.len(), 9, "no plane is sure to stay one");
        let turned = triangle_normal([Vec3::ZERO, vec3(1.0, 1.0, 0.0), Vec3::Z]);
        let expected = turned.expect("it has an area") - Vec3::Z;
        assert_eq!(flat.targets[0].normals[..3], [[0.0; 3]; 3]);
        assert_eq!(flat.targets[0].normals[3..6], [expected.to_array(); 3]);
    }

    #[test]
    fn triangles_without_area_get_finite_normals() {
        let line = Geometry {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::X * 2.0],
            triangles: vec![[0, 1, 2]],
            ..Geometry::default()
        };
        for normal in flatten(&line).normals {
            assert!((normal.length() - 1.0).abs() < 1e-6 && normal.dot(Vec3::X).abs() < 1e-6);
        }
        let point = Geometry { positions: vec![Vec3::ONE; 3], ..line };
        assert!(flatten(&point).normals.iter().all(|normal| normal.is_normalized()));
    }

    #[test]
    fn broken_normals_become_those_of_a_triangle() {
        let mut geometry = step();
        geometry.normals = vec![
            Vec3::NAN,
            vec3(0.0, 0.0, 5.0),
            Vec3::ZERO,
            Vec3::Y,
            vec3(f32::INFINITY, 0.0, 0.0),
        ];
        assert_eq!(repair(&mut geometry), 3);
        assert_eq!(geometry.normals, [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Y, Vec3::NEG_Y]);
        geometry.triangles.clear();
        geometry.normals[0] = Vec3::ZERO;
        assert_eq!(repair(&mut geometry), 1);
        assert_eq!(geometry.normals[0], Vec3::Y, "in no triangle");
    }
}
