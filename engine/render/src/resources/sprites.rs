//! Sprites on the GPU: their vectors, which follow the instances, and the corners that all sprites
//! share.
//!
//! A mesh of sprites is drawn with the vertices and indices of one pattern, which contain the
//! corner and the index of the sprite. Sprites have no vertices of their own; `sprites.glsl` finds
//! the rest from the instance.

use gpu::{Device, IndirectDraw};
use scene::limits::INSTANCE_BYTES;
use scene::{Scene, Sprites, SurfaceVertex, Vertex};

use crate::error::Error;
use crate::resources::instance::Instance;
use crate::resources::limits::check_storage;

/// The number of vectors of four numbers in the room of an instance.
const VECTORS: usize = 4;

/// The corners of a sprite, anticlockwise: the end and the side of each.
const CORNERS: [[f32; 2]; 4] = [[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]];

/// The triangles of a sprite.
const TRIANGLES: [u32; 6] = [0, 1, 2, 0, 2, 3];

fn of_scene(scene: &Scene) -> &[Sprites] {
    scene.surfaces.as_ref().map_or(&[], |surfaces| &surfaces.sprites)
}

/// Returns true if a mesh of the scene is made of sprites.
pub(crate) fn has_sprites(scene: &Scene) -> bool {
    !of_scene(scene).is_empty()
}

/// Returns the number of vectors per end of a sprite.
fn end_vectors(sprites: &Sprites) -> usize {
    if sprites.normals.is_empty() { 1 } else { 2 }
}

fn vectors(sprites: &Sprites) -> usize {
    1 + sprites.ends.len() * end_vectors(sprites)
}

/// Refuses more sprites than the device can hold after `instances` instances.
pub(crate) fn check_size(device: &Device, scene: &Scene, instances: usize) -> Result<(), Error> {
    check_storage(
        device,
        "objects, of which four points count as one,",
        (instances + blocks(scene)) as u64,
        INSTANCE_BYTES,
        "split the scene, or leave points out",
    )
}

/// Returns the number of instances that take as much room as the vectors of all sprites.
fn blocks(scene: &Scene) -> usize {
    of_scene(scene).iter().map(vectors).sum::<usize>().div_ceil(VECTORS)
}

/// Returns for each mesh the place of its sprites' vectors after `instances` instances; 0 without
/// sprites.
pub(crate) fn places(scene: &Scene, instances: usize) -> Vec<u32> {
    let mut places = vec![0; scene.meshes.len()];
    let mut next = instances * VECTORS;
    for sprites in of_scene(scene) {
        if let Some(place) = places.get_mut(sprites.mesh.0 as usize) {
            *place = next as u32;
        }
        next += vectors(sprites);
    }
    places
}

/// Appends the vectors of all sprites to the instances.
pub(crate) fn add_vectors(scene: &Scene, instances: &mut Vec<Instance>) {
    let mut vectors: Vec<[f32; VECTORS]> = Vec::with_capacity(blocks(scene) * VECTORS);
    for sprites in of_scene(scene) {
        let end_vectors = end_vectors(sprites) as f32;
        let ends = sprites.shape.ends() as f32;
        vectors.push([sprites.radius_m, end_vectors, ends, 0.0]);
        for (place, end) in sprites.ends.iter().enumerate() {
            let [x, y, z] = end.position;
            vectors.push([x, y, z, end.colour]);
            vectors.extend(sprites.normals.get(place).map(|&[x, y, z]| [x, y, z, 0.0]));
        }
    }
    vectors.resize(vectors.len().next_multiple_of(VECTORS), [0.0; VECTORS]);
    instances.reserve_exact(vectors.len() / VECTORS);
    instances.extend(vectors.as_chunks().0.iter().map(|&[a, b, c, d]: &[_; VECTORS]| Instance {
        rows: [a, b, c],
        tail: d.map(f32::to_bits),
    }));
}

/// Returns the number of sprites in the largest mesh.
fn most(scene: &Scene) -> usize {
    of_scene(scene).iter().map(Sprites::count).max().unwrap_or(0)
}

/// Returns the number of vertices and of indices of the pattern.
pub(crate) fn pattern_size(scene: &Scene) -> [usize; 2] {
    [CORNERS.len(), TRIANGLES.len()].map(|each| most(scene) * each)
}

/// Appends the pattern to all vertices and indices, and sets the draws of meshes of sprites to it.
pub(crate) fn add_pattern(
    scene: &Scene,
    vertices: &mut Vec<Vertex>,
    indices: &mut Vec<u32>,
    draws: &mut [IndirectDraw],
) {
    let first_index = indices.len() as u32;
    let vertex_offset = vertices.len() as i32;
    for number in 0..most(scene) as u32 {
        vertices.extend(CORNERS.map(|[end, side]| Vertex {
            position: [end, side, number as f32],
            normal: 0,
            colour: 0,
        }));
        let first = number * CORNERS.len() as u32;
        indices.extend(TRIANGLES.map(|corner| first + corner));
    }
    for sprites in of_scene(scene) {
        if let Some(draw) = draws.get_mut(sprites.mesh.0 as usize) {
            *draw = IndirectDraw {
                index_count: (sprites.count() * TRIANGLES.len()) as u32,
                instance_count: 1,
                first_index,
                vertex_offset,
                first_instance: 0,
            };
        }
    }
}

/// Appends a surface vertex for each vertex of the pattern.
pub(crate) fn add_surface_pattern(scene: &Scene, vertices: &mut Vec<SurfaceVertex>) {
    let nothing = bytemuck::Zeroable::zeroed();
    vertices.resize(vertices.len() + most(scene) * CORNERS.len(), nothing);
}
