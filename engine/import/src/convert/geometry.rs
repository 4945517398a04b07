//! Geometry: a primitive's attributes as lists of finite numbers, before they are packed.

use cull::Aabb;
use glam::{Vec2, Vec3, Vec4};
use scene::{MorphTarget, SkinWeights};

/// Attributes of vertices, and the triangles between them. The list of an attribute is empty or has
/// one element per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Geometry {
    pub(super) positions: Vec<Vec3>,
    /// Unit vectors that point out of the surface.
    pub(super) normals: Vec<Vec3>,
    /// Unit vectors, not necessarily orthogonal to the normals; the last component is the
    /// bitangent's sign, -1 or 1.
    pub(super) tangents: Vec<Vec4>,
    /// The two sets that the material uses.
    pub(super) uvs: [Vec<Vec2>; 2],
    /// Linear red, green, blue, alpha.
    pub(super) colours: Vec<[f32; 4]>,
    pub(super) skin: Option<SkinWeights>,
    pub(super) targets: Vec<MorphTarget>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// True if each triangle exists from both sides, so that the geometry may be mirrored at any
    /// time.
    pub(super) has_both_sides: bool,
    /// True if the second half of the triangles are the backs of the first half, or vice versa.
    pub(super) has_backs: bool,
}

impl Geometry {
    /// Returns the box around all vertices.
    pub(super) fn bounds(&self) -> Aabb {
        let at = |position: &Vec3| Aabb::new(*position, *position);
        self.positions.iter().fold(Aabb::EMPTY, |all, position| all.union(&at(position)))
    }

    /// Returns the picked vertices, without triangles: vertex `n` of the result is vertex
    /// `picks[n]` of this geometry.
    pub(super) fn gather(&self, picks: &[u32]) -> Self {
        Self {
            positions: pick(&self.positions, picks),
            normals: pick(&self.normals, picks),
            tangents: pick(&self.tangents, picks),
            uvs: [pick(&self.uvs[0], picks), pick(&self.uvs[1], picks)],
            colours: pick(&self.colours, picks),
            skin: self.skin.as_ref().map(|skin| {
                let sets = skin.sets as usize;
                SkinWeights {
                    joint_count: skin.joint_count,
                    joints: pick_groups(&skin.joints, picks, sets),
                    weights: pick_groups(&skin.weights, picks, sets),
                    sets: skin.sets,
                }
            }),
            targets: self
                .targets
                .iter()
                .map(|target| MorphTarget {
                    positions: pick(&target.positions, picks),
                    normals: pick(&target.normals, picks),
                    tangents: pick(&target.tangents, picks),
                })
                .collect(),
            triangles: Vec::new(),
            has_both_sides: self.has_both_sides,
            has_backs: self.has_backs,
        }
    }

    /// Gives each corner of a triangle a vertex of its own, except that corners with the same `key`
    /// share one. `key` receives the numbers of the triangle and of the corner.
    pub(super) fn split<K: std::hash::Hash + Eq>(
        &self,
        mut key: impl FnMut(usize, usize) -> K,
    ) -> (Self, Vec<[u32; 2]>) {
        let mut known = std::collections::HashMap::new();
        let mut picks = Vec::new();
        let mut origins = Vec::new();
        let mut triangles = Vec::with_capacity(self.triangles.len());
        for (place, triangle) in self.triangles.iter().enumerate() {
            triangles.push(std::array::from_fn(|corner| {
                let vertex = triangle[corner];
                *known.entry((vertex, key(place, corner))).or_insert_with(|| {
                    picks.push(vertex);
                    origins.push([place as u32, corner as u32]);
                    picks.len() as u32 - 1
                })
            }));
        }
        let mut split = self.gather(&picks);
        split.triangles = triangles;
        (split, origins)
    }
}

fn pick<T: Copy>(list: &[T], picks: &[u32]) -> Vec<T> {
    if list.is_empty() { Vec::new() } else { pick_groups(list, picks, 1) }
}

/// Returns the picked groups of `size` elements. Every index must be below the number of groups, as
/// in this geometry's triangles.
fn pick_groups<T: Copy>(list: &[T], picks: &[u32], size: usize) -> Vec<T> {
    let mut picked = Vec::with_capacity(picks.len() * size);
    for &vertex in picks {
        let start = vertex as usize * size;
        picked.extend_from_slice(list.get(start..start + size).unwrap_or_default());
    }
    picked
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Geometry {
        Geometry {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y],
            uvs: [vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], Vec::new()],
            skin: Some(SkinWeights {
                joint_count: 9,
                joints: (0..8).map(|group| [group; 4]).collect(),
                weights: (0..8).map(|group| [group as f32; 4]).collect(),
                sets: 2,
            }),
            targets: vec![MorphTarget {
                positions: (0..4).map(|vertex| [vertex as f32; 3]).collect(),
                ..MorphTarget::default()
            }],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Geometry::default()
        }
    }

    #[test]
    fn gathering_takes_every_attribute_along() {
        let picked = square().gather(&[3, 1, 3]);
        assert_eq!(picked.positions, [Vec3::Y, Vec3::X, Vec3::Y]);
        assert_eq!(picked.uvs, [vec![Vec2::Y, Vec2::X, Vec2::Y], Vec::new()]);
        assert_eq!(picked.normals, []);
        let skin = picked.skin.expect("it had one");
        assert_eq!(skin.joints, [6, 7, 2, 3, 6, 7].map(|group| [group; 4]));
        assert_eq!(skin.weights.len(), 6);
        assert_eq!(picked.targets[0].positions, [[3.0; 3], [1.0; 3], [3.0; 3]]);
        assert_eq!(picked.triangles, Vec::<[u32; 3]>::new());
    }

    #[test]
    fn splitting_shares_what_is_alike() {
        let (all, _) = square().split(|_, _| ());
        assert_eq!((all.positions.len(), &all.triangles), (4, &vec![[0, 1, 2], [0, 2, 3]]));
        let (apart, origins) = square().split(|triangle, _| triangle);
        assert_eq!(apart.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(apart.positions[3..], [Vec3::ZERO, Vec3::ONE, Vec3::Y]);
        assert_eq!(origins, [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2]]);
    }
}
