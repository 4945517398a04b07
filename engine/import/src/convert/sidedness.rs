//! Sides: the backs of double-sided materials as separate triangles, and meshes for mirrored
//! places.

use super::geometry::Geometry;

/// The place of the backs in the order of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Backs {
    /// No backs: triangles are visible only from the front.
    None,
    /// After the fronts.
    Last,
    /// Before the fronts: with a blended material, the far side is then more often drawn first.
    First,
}

/// Adds the back of every triangle, with its own vertices and reversed normals (3.9.6). Tangents
/// and bitangents are reversed, too, so that the normal texture turns with them.
pub(super) fn with_backs(geometry: &mut Geometry, backs: Backs) {
    if backs == Backs::None {
        return;
    }
    geometry.has_backs = true;
    let count = geometry.positions.len();
    let fronts = std::mem::take(&mut geometry.triangles);
    geometry.positions.extend_from_within(..);
    geometry.colours.extend_from_within(..);
    for uvs in &mut geometry.uvs {
        uvs.extend_from_within(..);
    }
    geometry.normals.extend_from_within(..);
    for normal in geometry.normals.iter_mut().skip(count) {
        *normal = -*normal;
    }
    // cross(-n, -t) is cross(n, t), so the bitangent is reversed by its sign.
    geometry.tangents.extend_from_within(..);
    for tangent in geometry.tangents.iter_mut().skip(count) {
        *tangent = -*tangent;
    }
    if let Some(skin) = &mut geometry.skin {
        skin.joints.extend_from_within(..);
        skin.weights.extend_from_within(..);
    }
    for target in &mut geometry.targets {
        target.positions.extend_from_within(..);
        for list in [&mut target.normals, &mut target.tangents] {
            list.extend_from_within(..);
            for delta in list.iter_mut().skip(count) {
                *delta = delta.map(|part| -part);
            }
        }
    }
    let turned = fronts.iter().map(|&[a, b, c]| [a, c, b].map(|vertex| vertex + count as u32));
    geometry.triangles = match backs {
        Backs::First => turned.chain(fronts.iter().copied()).collect(),
        Backs::Last | Backs::None => fronts.iter().copied().chain(turned).collect(),
    };
}

/// Reverses triangles for places that mirror: a triangle that is clockwise from outside becomes
/// counter-clockwise in the mirror. Normals and bitangents are mirrored when they are transformed.
pub(super) fn mirror(geometry: &mut Geometry) {
    for [_, second, third] in &mut geometry.triangles {
        std::mem::swap(second, third);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3, Vec4};
    use scene::{MorphTarget, SkinWeights};

    fn triangle() -> Geometry {
        Geometry {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
            uvs: [vec![Vec2::ONE; 3], Vec::new()],
            skin: Some(SkinWeights {
                joint_count: 1,
                joints: vec![[0; 4]; 6],
                weights: vec![[0.125; 4]; 6],
                sets: 2,
            }),
            targets: vec![MorphTarget {
                positions: vec![[1.0; 3]; 3],
                normals: vec![[0.5; 3]; 3],
                tangents: Vec::new(),
            }],
            triangles: vec![[0, 1, 2]],
            ..Geometry::default()
        }
    }

    #[test]
    fn backs_face_the_other_way() {
        let mut both = triangle();
        with_backs(&mut both, Backs::Last);
        assert_eq!(both.triangles, [[0, 1, 2], [3, 5, 4]]);
        assert_eq!(both.positions[3..], triangle().positions);
        assert_eq!(both.normals[2..4], [Vec3::Z, Vec3::NEG_Z]);
        assert_eq!(both.tangents[3], Vec4::new(-1.0, 0.0, 0.0, -1.0));
        let bitangent =
            |at: usize| both.normals[at].cross(both.tangents[at].truncate()) * both.tangents[at].w;
        assert_eq!(bitangent(3), -bitangent(0));
        assert_eq!((both.uvs[0].len(), both.uvs[1].len(), both.colours.len()), (6, 0, 0));
        let skin = both.skin.expect("it had one");
        assert_eq!((skin.joints.len(), skin.weights.len()), (12, 12));
        let target = &both.targets[0];
        assert_eq!((target.positions[3], target.normals[3]), ([1.0; 3], [-0.5; 3]));
        assert_eq!(target.tangents.len(), 0);
    }

    #[test]
    fn backs_of_blended_materials_come_first() {
        let mut both = triangle();
        with_backs(&mut both, Backs::First);
        assert_eq!(both.triangles, [[3, 5, 4], [0, 1, 2]]);
        let mut one = triangle();
        with_backs(&mut one, Backs::None);
        assert_eq!(one, triangle());
    }

    #[test]
    fn in_a_mirror_the_winding_turns_and_nothing_else() {
        let mut mirrored = triangle();
        mirror(&mut mirrored);
        assert_eq!(mirrored.triangles, [[0, 2, 1]]);
        mirrored.triangles = triangle().triangles;
        assert_eq!(mirrored, triangle());
    }
}
