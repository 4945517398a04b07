//! Levels of detail: creates coarser levels of meshes by quadric error simplification (the crate
//! `meshopt`).

use ::meshopt::{SimplifyOptions, VertexDataAdapter};
use scene::{Alpha, LodLevel, Mesh, Scene, SurfaceMesh, SurfaceVertex};

use crate::Note;
use crate::error::quoted;

/// The options of coarser levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelOptions {
    /// The most coarser levels of a mesh.
    pub most: usize,
    /// The wanted ratio of triangles from one level to the next, 0 to 1. A level with more than
    /// nine tenths of the triangles of the previous one is discarded.
    pub share: f32,
    /// The number of triangles below which a mesh gets no coarser levels.
    pub least_triangles: usize,
    /// The largest error of a level, relative to the mesh's largest extent.
    pub most_error: f32,
}

impl Default for LevelOptions {
    fn default() -> Self {
        Self { most: 6, share: 0.5, least_triangles: 64, most_error: 0.1 }
    }
}

/// The number of attributes besides positions that simplification should preserve: the normal and
/// texture coordinates.
const ATTRIBUTES: usize = 5;
const ATTRIBUTE_WEIGHTS: [f32; ATTRIBUTES] = [0.5, 0.5, 0.5, 0.2, 0.2];

/// Creates coarser levels, and returns a note if meshes are [crowded](is_crowded).
pub(crate) fn make_levels(scene: &mut Scene, options: &LevelOptions) -> Option<Note> {
    let mut crowded = Vec::new();
    let surfaces = scene.surfaces.as_mut()?;
    let mut is_fixed = vec![false; scene.meshes.len()];
    for skinned_mesh in &surfaces.skinned_meshes {
        if let Some(is_fixed) = is_fixed.get_mut(skinned_mesh.mesh.0 as usize) {
            *is_fixed = true;
        }
    }
    let is_transparent = |surface: &SurfaceMesh| {
        let material = surfaces.materials.get(surface.material.0 as usize);
        material.is_some_and(|material| material.alpha == Alpha::Blend)
    };
    let meshes = scene.meshes.iter().zip(&surfaces.meshes).zip(is_fixed);
    surfaces.levels = meshes
        .map(|((mesh, surface), is_fixed)| {
            if is_fixed || is_transparent(surface) {
                Vec::new()
            } else if is_crowded(mesh) {
                crowded.push(&mesh.name);
                Vec::new()
            } else {
                levels(mesh, surface, options)
            }
        })
        .collect();
    let first = crowded.first()?;
    let reason = "it has no levels of detail, since too many of its triangles meet in a corner";
    let object = format!("mesh {}", quoted(first));
    Some(Note { count: crowded.len() as u64, ..Note::new(object, reason) })
}

/// The most triangles that may meet in a corner, as the mean over all corners of triangles. A disc
/// of 6,144 triangles around one vertex is at this limit: it takes about twice as long per triangle
/// as a grid. Above the limit, the time per triangle is proportional to the number that meet.
const MOST_MET: u64 = 2048;

/// Returns true if simplifying the mesh would take too long per triangle, because too many
/// triangles meet in its corners: the simplifier visits all triangles of a vertex for each of its
/// edges that may collapse.
fn is_crowded(mesh: &Mesh) -> bool {
    let mut met = vec![0_u32; mesh.vertices.len()];
    for index in &mesh.indices {
        if let Some(met) = met.get_mut(*index as usize) {
            *met = met.saturating_add(1);
        }
    }
    let squares = met.iter().map(|met| u64::from(*met) * u64::from(*met));
    let sum = squares.fold(0, u64::saturating_add);
    sum > MOST_MET.saturating_mul(mesh.indices.len() as u64)
}

/// Returns the coarser levels of one mesh.
fn levels(mesh: &Mesh, surface: &SurfaceMesh, options: &LevelOptions) -> Vec<LodLevel> {
    let triangles = mesh.indices.len() / 3;
    let positions: Vec<[f32; 3]> = mesh.vertices.iter().map(|vertex| vertex.position).collect();
    let adapter =
        VertexDataAdapter::new(bytemuck::cast_slice(&positions), size_of::<[f32; 3]>(), 0);
    let is_whole = surface.vertices.len() == positions.len()
        && mesh.indices.iter().all(|index| (*index as usize) < positions.len());
    let (Ok(adapter), true) = (adapter, is_whole && triangles >= options.least_triangles) else {
        return Vec::new();
    };
    let attributes: Vec<f32> = surface.vertices.iter().flat_map(attributes_of).collect();
    let size = mesh.bounds.max - mesh.bounds.min;
    let most_error_m = size.max_element() * options.most_error;
    let mut levels: Vec<LodLevel> = Vec::new();
    let mut before = triangles;
    for _ in 0..options.most {
        let wanted = (before as f32 * options.share.clamp(0.0, 1.0)) as usize;
        let mut error_m = 0.0;
        // Always from the finest level, since the errors of a chain of levels would add up.
        let indices = ::meshopt::simplify_with_attributes_and_locks(
            &mesh.indices,
            &adapter,
            &attributes,
            &ATTRIBUTE_WEIGHTS,
            size_of::<[f32; ATTRIBUTES]>(),
            &vec![false; positions.len()],
            wanted * 3,
            most_error_m,
            SimplifyOptions::ErrorAbsolute,
            Some(&mut error_m),
        );
        let found = indices.len() / 3;
        let is_worth_it = found > 0 && found * 10 <= before * 9;
        if !is_worth_it || !error_m.is_finite() {
            break;
        }
        // A coarser level counts as no better than a finer one, whatever error was found.
        let error_m = levels.last().map_or(error_m, |last| last.error_m.max(error_m));
        levels.push(LodLevel { indices, error_m });
        before = found;
    }
    levels
}

fn attributes_of(vertex: &SurfaceVertex) -> [f32; ATTRIBUTES] {
    let [x, y, z, _] = vertex.normal.map(|part| f32::from(part) / 32767.0);
    let [u, v] = vertex.uv[0];
    [x, y, z, u, v]
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use scene::{MaterialId, Surfaces, Vertex, bounds_of_vertices};

    use super::*;

    /// Returns a ball of `rings` rings around the y axis, of radius 1.
    fn ball(rings: u32) -> (Mesh, SurfaceMesh) {
        let point = |ring: u32, side: u32| {
            let down = std::f32::consts::PI * ring as f32 / rings as f32;
            let around = std::f32::consts::TAU * side as f32 / rings as f32;
            Vec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin())
        };
        let points: Vec<Vec3> = (0..=rings)
            .flat_map(|ring| (0..=rings).map(move |side| point(ring, side % rings)))
            .collect();
        let quads =
            (0..rings).flat_map(|ring| (0..rings).map(move |side| ring * (rings + 1) + side));
        let indices = quads.flat_map(|first| {
            let below = first + rings + 1;
            [first, first + 1, below, below, first + 1, below + 1]
        });
        let vertices: Vec<Vertex> = points
            .iter()
            .map(|point| Vertex { position: point.to_array(), normal: 0, colour: 0 })
            .collect();
        let snorm = |part: f32| (part * 32767.0) as i16;
        let surface = points.iter().map(|point| SurfaceVertex {
            normal: [snorm(point.x), snorm(point.y), snorm(point.z), 0],
            tangent: [32767, 0, 0, 32767],
            uv: [[0.0; 2]; 2],
            colour: [u16::MAX; 4],
        });
        let surface = SurfaceMesh { vertices: surface.collect(), material: MaterialId(0) };
        let bounds = bounds_of_vertices(&vertices);
        let indices = indices.collect();
        let name = "ball".to_owned();
        (Mesh { name, vertices, indices, bounds, has_backs: false }, surface)
    }

    #[test]
    fn forms_get_coarser_and_say_by_how_much() {
        let (mesh, surface) = ball(48);
        let levels = levels(&mesh, &surface, &LevelOptions::default());
        assert!(levels.len() >= 3, "{}", levels.len());
        let mut before = LodLevel { indices: mesh.indices.clone(), error_m: 0.0 };
        for level in levels {
            assert!(level.indices.len() * 10 <= before.indices.len() * 9);
            assert!(level.error_m >= before.error_m && level.error_m <= 0.2 + 1.0e-6);
            assert!(level.indices.iter().all(|index| (*index as usize) < mesh.vertices.len()));
            // Corners stay on the ball, so the middle of a triangle is farthest from it.
            for corners in level.indices.chunks_exact(3) {
                let at =
                    |corner: usize| Vec3::from(mesh.vertices[corners[corner] as usize].position);
                let middle = (at(0) + at(1) + at(2)) / 3.0;
                assert!(1.0 - middle.length() <= level.error_m * 2.0 + 0.01, "{level:?}");
            }
            before = level;
        }
    }

    /// Returns a fan of triangles around a middle.
    fn disc(triangles: u32) -> (Mesh, SurfaceMesh) {
        let (mut mesh, mut surface) = ball(5);
        let around = |number: u32| std::f32::consts::TAU * number as f32 / triangles as f32;
        let rim = (0..triangles).map(|number| {
            let (sin, cos) = around(number).sin_cos();
            Vertex { position: [cos, sin, 0.0], normal: 0, colour: 0 }
        });
        let middle = Vertex { position: [0.0; 3], normal: 0, colour: 0 };
        mesh.vertices = std::iter::once(middle).chain(rim).collect();
        mesh.indices =
            (0..triangles).flat_map(|index| [0, index + 1, (index + 1) % triangles + 1]).collect();
        mesh.bounds = bounds_of_vertices(&mesh.vertices);
        surface.vertices = vec![surface.vertices[0]; mesh.vertices.len()];
        (mesh, surface)
    }

    #[test]
    fn meshes_whose_triangles_all_meet_have_one_form_and_a_note() {
        let is_crowded_disc = |triangles| is_crowded(&disc(triangles).0);
        assert!(!is_crowded_disc(6_000) && is_crowded_disc(6_200) && is_crowded_disc(400_000));
        assert!(!is_crowded(&ball(200).0));

        let (fan, on_fan) = disc(400_000);
        let (fine, on_fine) = ball(48);
        let mut scene = Scene::single(fan.clone());
        scene.meshes = vec![fan.clone(), fine, fan];
        let meshes = vec![on_fan.clone(), on_fine, on_fan];
        scene.surfaces = Some(Surfaces { meshes, ..Surfaces::default() });
        let note = make_levels(&mut scene, &LevelOptions::default()).unwrap();
        assert!(note.reason.starts_with("it has no levels of detail") && note.count == 2, "{note}");
        let levels = scene.surfaces.as_ref().unwrap().levels.clone();
        assert!(levels[0].is_empty() && levels[1].len() >= 3 && levels[2].is_empty());
        scene.surfaces.as_mut().unwrap().meshes.clear();
        assert_eq!(make_levels(&mut scene, &LevelOptions::default()), None);
    }

    #[test]
    fn small_meshes_and_broken_ones_have_one_form() {
        let options = LevelOptions::default();
        let (mesh, surface) = ball(5);
        assert!(levels(&mesh, &surface, &options).is_empty());
        let (mut mesh, mut surface) = ball(20);
        assert!(!levels(&mesh, &surface, &options).is_empty());
        mesh.indices[7] = 100_000;
        assert!(levels(&mesh, &surface, &options).is_empty());
        mesh.indices[7] = 0;
        surface.vertices.pop();
        assert!(levels(&mesh, &surface, &options).is_empty());
    }
}
