//! Cuts large meshes into pieces that lie side by side, so that each can be culled individually.

use cull::ObjectId;
use glam::Vec3;

use crate::{MeshId, Object, ObjectChange, SceneUpdate};

/// Sorts triangles with these middles into pieces of at most `most` triangles, as ascending
/// indices. A set is halved along the longest side of the box around its middles until all pieces
/// are small enough. So each piece has at least half as many triangles as any other, except for one
/// triangle.
pub fn spatial_pieces(middles: &[Vec3], most: usize) -> Vec<Vec<u32>> {
    let most = most.max(1);
    let at = |triangle: u32| middles.get(triangle as usize).copied().unwrap_or_default();
    let mut order: Vec<u32> = (0..middles.len() as u32).collect();
    let mut pending = vec![order.as_mut_slice()];
    let mut pieces = Vec::new();
    while let Some(part) = pending.pop() {
        if part.len() <= most {
            part.sort_unstable();
            pieces.push(part.to_vec());
            continue;
        }
        let corner = |part: &[u32], pick: fn(Vec3, Vec3) -> Vec3| {
            part.iter().map(|triangle| at(*triangle)).reduce(pick).unwrap_or_default()
        };
        // Halves first: the difference of two large numbers may overflow.
        let axis = (corner(part, Vec3::max) * 0.5 - corner(part, Vec3::min) * 0.5).max_position();
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |&a, &b| {
            at(a)[axis].total_cmp(&at(b)[axis]).then(a.cmp(&b))
        });
        let (low, high) = part.split_at_mut(half);
        pending.push(high);
        pending.push(low);
    }
    pieces
}

/// The sizes from which meshes are cut, and of their pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PieceLimits {
    /// The triangles above which a mesh is cut. Default: 65,536.
    pub cut_above: usize,
    /// The most triangles of a piece. Default: 8,192, which gives pieces of at least 4,096.
    pub piece: usize,
}

impl Default for PieceLimits {
    fn default() -> Self {
        Self { cut_above: 1 << 16, piece: 1 << 13 }
    }
}

/// The pieces of each object of a scene before it was cut (a *part*). Most parts have one piece.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PieceMap {
    /// The first piece of each part, then the end of the last part's pieces.
    pub(crate) firsts: Vec<u32>,
    /// The meshes of the pieces of each mesh.
    pub(crate) meshes: Vec<Vec<MeshId>>,
}

impl PieceMap {
    /// Returns the part that a piece belongs to, by its id before the cut, for example to select
    /// the part when a piece is picked. `None` for objects that were added later.
    pub fn part_of(&self, piece: ObjectId) -> Option<ObjectId> {
        let part = self.firsts.partition_point(|first| *first <= piece.0).checked_sub(1)?;
        (part + 1 < self.firsts.len()).then_some(ObjectId(part as u32))
    }

    /// Returns the pieces of a part, by its id before the cut; none if the part does not exist.
    pub fn pieces_of(&self, part: ObjectId) -> impl Iterator<Item = ObjectId> + use<> {
        let at = |place: usize| self.firsts.get(place).copied();
        let next = (part.0 as usize).checked_add(1).and_then(at).unwrap_or_default();
        let first = at(part.0 as usize).unwrap_or(next);
        (first..next).map(ObjectId)
    }

    /// Returns changes of parts as changes of all of their pieces. An added object becomes one
    /// object per piece of its mesh; the renderer returns their ids in this order.
    #[must_use]
    pub fn in_pieces(&self, mut update: SceneUpdate) -> SceneUpdate {
        let changes = std::mem::take(&mut update.objects);
        for change in changes {
            match change {
                ObjectChange::Move { object, transform } => {
                    let pieces = self.pieces_of(object);
                    let moved = |object| ObjectChange::Move { object, transform };
                    update.objects.extend(pieces.map(moved));
                }
                ObjectChange::Remove { object } => {
                    let pieces = self.pieces_of(object);
                    update.objects.extend(pieces.map(|object| ObjectChange::Remove { object }));
                }
                ObjectChange::Add { object } => {
                    let own = [object.mesh];
                    let meshes = self.meshes.get(object.mesh.0 as usize);
                    let meshes = meshes.map_or(own.as_slice(), Vec::as_slice);
                    let added = |mesh: &MeshId| Object { mesh: *mesh, ..object };
                    update.objects.extend(
                        meshes.iter().map(|mesh| ObjectChange::Add { object: added(mesh) }),
                    );
                }
            }
        }
        update
    }
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::{Mesh, Scene};

    /// Returns a scene of two objects with a small mesh each, and two that share a wavy sheet of
    /// `side` by `side` squares between them.
    fn sheet(side: u16) -> Scene {
        let corner = |x: u16, z: u16| {
            let x = f32::from(x);
            let z = f32::from(z);
            ([x, (x * 0.3).sin() + (z * 0.2).cos(), z], [0.5, 0.5, 0.5])
        };
        let square = |x: u16, z: u16| {
            let a = corner(x, z);
            let b = corner(x, z + 1);
            let c = corner(x + 1, z + 1);
            let d = corner(x + 1, z);
            [a, b, c, a, c, d]
        };
        let corners: Vec<_> =
            (0..side).flat_map(|z| (0..side).flat_map(move |x| square(x, z))).collect();
        let mut scene = Scene::single(Mesh::of_triangles("small", &corners[..6]));
        scene.meshes.push(Mesh::of_triangles("sheet", &corners));
        let small = scene.objects[0];
        let large = Object { mesh: MeshId(1), ..small };
        let moved = Object { transform: Affine3A::from_translation(Vec3::Y), ..large };
        scene.objects = vec![small, large, moved, small];
        scene
    }

    fn corners(scene: &Scene, object: &Object) -> Vec<[[u32; 3]; 3]> {
        let mesh = scene.mesh_of(object).unwrap();
        let at = |index: u32| mesh.vertices[index as usize].position.map(f32::to_bits);
        mesh.indices.as_chunks::<3>().0.iter().map(|corners| corners.map(at)).collect()
    }

    #[test]
    fn every_triangle_is_in_one_piece_and_parts_know_their_pieces() {
        let limits = PieceLimits { cut_above: 1000, piece: 128 };
        for with_surfaces in [false, true] {
            let whole = sheet(40);
            let whole = if with_surfaces { whole.with_surfaces() } else { whole };
            let mut cut = whole.clone();
            let map = cut.cut_large_meshes(limits);
            assert_eq!(cut.validate(), Ok(()));
            assert_eq!((whole.triangles(), cut.objects.len()), (cut.triangles(), 2 + 2 * 32));
            for (place, part) in (0_u32..).zip(&whole.objects) {
                let pieces: Vec<ObjectId> = map.pieces_of(ObjectId(place)).collect();
                let mut found = Vec::new();
                for piece in &pieces {
                    assert_eq!(map.part_of(*piece), Some(ObjectId(place)));
                    let object = &cut.objects[piece.0 as usize];
                    assert_eq!((object.transform, object.tint), (part.transform, part.tint));
                    let own = corners(&cut, object);
                    assert!(pieces.len() == 1 || (64..=128).contains(&own.len()), "{}", own.len());
                    found.extend(own);
                }
                let mut expected = corners(&whole, part);
                found.sort_unstable();
                expected.sort_unstable();
                assert_eq!(found, expected);
            }
            assert_eq!(map.part_of(ObjectId(cut.objects.len() as u32)), None);
            assert_eq!(map.pieces_of(ObjectId(4)).count(), 0);
        }
    }

    #[test]
    fn what_is_small_or_bends_stays_whole_and_backs_stay_with_their_fronts() {
        let whole = sheet(40);
        let mut same = whole.clone();
        let map = same.cut_large_meshes(PieceLimits::default());
        assert_eq!(same, whole);
        assert_eq!(map.part_of(ObjectId(3)), Some(ObjectId(3)));
        let limits = PieceLimits { cut_above: 10, piece: 100 };
        let mut skinned = sheet(40).with_surfaces();
        skinned.objects.truncate(2);
        let skin = super::super::SkinnedMesh { mesh: MeshId(1), skin: None, targets: Vec::new() };
        skinned.surfaces.as_mut().unwrap().skinned_meshes.push(skin);
        let before = skinned.clone();
        skinned.cut_large_meshes(limits);
        assert_eq!(skinned, before);

        let mut both = sheet(40);
        let mesh = &mut both.meshes[1];
        let backs: Vec<u32> =
            mesh.indices.as_chunks::<3>().0.iter().flat_map(|[a, b, c]| [*a, *c, *b]).collect();
        mesh.indices.extend(backs);
        mesh.has_backs = true;
        both.cut_large_meshes(limits);
        assert_eq!(both.triangles(), sheet(40).triangles());
        for object in &both.objects[1..] {
            let found = corners(&both, object);
            let (fronts, backs) = found.split_at(found.len() / 2);
            if both.mesh_of(object).unwrap().has_backs {
                assert!(fronts.iter().map(|[a, b, c]| [*a, *c, *b]).eq(backs.iter().copied()));
            }
        }
    }

    #[test]
    fn changes_of_parts_are_changes_of_all_of_their_pieces() {
        let mut scene = sheet(10);
        let map = scene.cut_large_meshes(PieceLimits { cut_above: 100, piece: 100 });
        let add = scene.objects[1];
        let object = ObjectId(2);
        let transform = Affine3A::from_translation(Vec3::Z);
        let update = SceneUpdate {
            objects: vec![
                ObjectChange::Move { object, transform },
                ObjectChange::Remove { object: ObjectId(0) },
                ObjectChange::Add { object: add },
            ],
            ..SceneUpdate::default()
        };
        let [first, second] = [3, 4].map(ObjectId);
        let meshes = [MeshId(1), MeshId(2)];
        let expected = [
            ObjectChange::Move { object: first, transform },
            ObjectChange::Move { object: second, transform },
            ObjectChange::Remove { object: ObjectId(0) },
            ObjectChange::Add { object: Object { mesh: meshes[0], ..add } },
            ObjectChange::Add { object: Object { mesh: meshes[1], ..add } },
        ];
        assert_eq!(map.in_pieces(update).objects, expected);
    }
}
