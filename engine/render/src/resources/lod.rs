//! The level of detail that each object has of its mesh, chosen for a few objects per frame.

use std::ops::Range;

use cull::{DetailLevel, DetailPolicy, ObjectId};
use gpu::IndirectDraw;
use scene::{LodLevel, MeshId, Scene};

/// The highest number of objects that one call of
/// [`Renderer::choose_detail`](crate::Renderer::choose_detail) visits.
pub const DETAIL_OBJECTS_A_CALL: usize = 2048;

/// The coarser levels of all meshes. Their draws follow the draws of the meshes.
#[derive(Clone)]
pub(crate) struct LodTable {
    of_mesh: Vec<Option<MeshForms>>,
    /// The object to visit next.
    next: usize,
}

#[derive(Clone)]
struct MeshForms {
    /// The draw of the first coarser level.
    first: u32,
    /// The errors of all levels, from the finest on, whose error is 0.
    errors_m: Vec<f32>,
}

impl MeshForms {
    /// Returns the levels of a mesh, if it has coarser ones.
    fn new(first: u32, levels: &[LodLevel]) -> Option<Self> {
        let errors_m = std::iter::once(0.0).chain(levels.iter().map(|level| level.error_m));
        (!levels.is_empty()).then(|| Self { first, errors_m: errors_m.collect() })
    }
}

impl LodTable {
    /// Appends the indices and draws of coarser levels to the indices and draws of the meshes.
    pub(crate) fn join(
        scene: &Scene,
        indices: &mut Vec<u32>,
        draws: &mut Vec<IndirectDraw>,
    ) -> Self {
        let levels = scene.surfaces.as_ref().map_or(&[][..], |surfaces| &surfaces.levels);
        let of_mesh = (0..).zip(levels).map(|(mesh, levels): (usize, _)| {
            let finest = *draws.get(mesh)?;
            let first = u32::try_from(draws.len()).ok()?;
            for level in levels {
                draws.push(IndirectDraw {
                    index_count: level.indices.len() as u32,
                    first_index: indices.len() as u32,
                    ..finest
                });
                indices.extend_from_slice(&level.indices);
            }
            MeshForms::new(first, levels)
        });
        Self { of_mesh: of_mesh.collect(), next: 0 }
    }

    /// Returns the draws of the coarser levels of a mesh.
    pub(crate) fn draws_of(&self, mesh: MeshId) -> Range<u32> {
        let forms = |forms: &MeshForms| forms.first..forms.first + forms.errors_m.len() as u32 - 1;
        self.of(mesh).map_or(0..0, forms)
    }

    /// Replaces the coarser levels of a mesh, whose draws begin at `first`.
    pub(crate) fn set(&mut self, mesh: MeshId, first: u32, levels: &[LodLevel]) {
        let place = mesh.0 as usize;
        if self.of_mesh.len() <= place {
            self.of_mesh.resize_with(place + 1, || None);
        }
        self.of_mesh[place] = MeshForms::new(first, levels);
    }

    fn of(&self, mesh: MeshId) -> Option<&MeshForms> {
        self.of_mesh.get(mesh.0 as usize)?.as_ref()
    }

    /// Returns the level of a mesh that an object with the level `now` should have.
    pub(crate) fn select_lod(
        &self,
        mesh: MeshId,
        now: u32,
        pixels_per_metre: f32,
        policy: &DetailPolicy,
    ) -> Option<u32> {
        let lods = self.of(mesh)?;
        let level = (now + 1).checked_sub(lods.first).filter(|_| now != mesh.0).unwrap_or(0);
        let level = DetailLevel(u8::try_from(level).unwrap_or(u8::MAX));
        let chosen = policy.choose(pixels_per_metre, &lods.errors_m, level);
        Some(chosen.0.checked_sub(1).map_or(mesh.0, |coarser| lods.first + u32::from(coarser)))
    }

    /// Returns true if any mesh has several levels.
    pub(crate) fn are_any(&self) -> bool {
        self.of_mesh.iter().any(Option::is_some)
    }

    /// Returns the objects to visit in this call, out of `objects`.
    pub(crate) fn next_batch(&mut self, objects: usize) -> impl Iterator<Item = ObjectId> + use<> {
        let first = self.next;
        let count = DETAIL_OBJECTS_A_CALL.min(objects);
        self.next = (first + count) % objects.max(1);
        (first..first + count).map(move |object| ObjectId((object % objects.max(1)) as u32))
    }
}

/// Returns the largest factor by which a transform, given by its rows, scales a length along an
/// axis.
pub(crate) fn stretch(rows: &[[f32; 4]; 3]) -> f32 {
    let squares = [0, 1, 2].map(|axis| rows.iter().map(|row| row[axis] * row[axis]).sum::<f32>());
    squares.into_iter().fold(0.0, f32::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Mesh, Surfaces};

    fn table() -> (LodTable, Vec<u32>, Vec<IndirectDraw>) {
        let level = |triangles: u32, error_m| LodLevel {
            indices: (0..triangles * 3).map(|corner| corner % 3).collect(),
            error_m,
        };
        let levels = vec![vec![], vec![level(4, 0.1), level(2, 0.4)], vec![level(1, 0.2)]];
        let surfaces = Surfaces { levels, ..Surfaces::default() };
        let mesh = Mesh::of_triangles("mesh", &[]);
        let mut scene = Scene::single(mesh.clone());
        scene.meshes = vec![mesh; 3];
        scene.surfaces = Some(surfaces);
        let mut indices = vec![0; 30];
        let draw = |mesh: i32| IndirectDraw {
            index_count: 9,
            vertex_offset: mesh * 10,
            ..IndirectDraw::default()
        };
        let mut draws = vec![draw(0), draw(1), draw(2)];
        let lods = LodTable::join(&scene, &mut indices, &mut draws);
        (lods, indices, draws)
    }

    #[test]
    fn coarser_levels_lie_behind_the_meshes() {
        let (_, indices, draws) = table();
        let found: Vec<_> = draws
            .iter()
            .map(|draw| (draw.index_count, draw.first_index, draw.vertex_offset))
            .collect();
        let behind = [(12, 30, 10), (6, 42, 10), (3, 48, 20)];
        assert_eq!(found[3..], behind);
        assert_eq!(indices.len(), 51);
    }

    #[test]
    fn an_object_takes_the_level_that_its_distance_allows() {
        let (lods, ..) = table();
        let policy = DetailPolicy { error_pixels: 1.0, hysteresis: 0.0, by_samples: None };
        let choose = |mesh, now, scale| lods.select_lod(MeshId(mesh), now, scale, &policy);
        assert_eq!(choose(0, 0, 0.0), None, "it has but one");
        for now in [1, 3, 4] {
            assert_eq!(choose(1, now, 100.0), Some(1));
            assert_eq!(choose(1, now, 9.0), Some(3));
            assert_eq!(choose(1, now, 2.0), Some(4));
        }
        assert_eq!((choose(2, 2, 1.0), choose(2, 5, 9.0)), (Some(5), Some(2)));
    }

    #[test]
    fn all_objects_have_their_turn() {
        let (mut lods, ..) = table();
        for objects in [1, 7, DETAIL_OBJECTS_A_CALL, DETAIL_OBJECTS_A_CALL * 2 + 9] {
            let mut seen = vec![false; objects];
            for _ in 0..objects.div_ceil(DETAIL_OBJECTS_A_CALL) {
                lods.next_batch(objects).for_each(|object| seen[object.0 as usize] = true);
            }
            assert!(seen.into_iter().all(|is_seen| is_seen), "{objects}");
            lods.next = 0;
        }
        assert_eq!(lods.next_batch(0).count(), 0);
    }
}
