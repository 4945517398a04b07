//! The glow at night: the globes of lit lamps, and some windows. It is a texture of a few texels,
//! which vertices select by their coordinates.

use cull::Aabb;
use glam::Affine2;
use scene::{
    Encoding, Filter, Image, ImageId, Material, MaterialId, Mesh, MeshId, Sampler, Scene, Surfaces,
    Texture, TextureId, TextureUse, Wrap,
};

use super::super::city::{glass_colours, lamp_colours};
use super::super::random::Random;
use super::lamps::lamp_mesh;

/// The name of the material that glows.
pub const GLOW_NAME: &str = "glow";

/// The emission of the globes, and of the brightest windows.
const EMISSION: [f32; 3] = [2.6, 2.0, 1.2];

/// The texels of the texture: no glow, globes, and windows from dim to bright.
const TEXELS: [[u8; 4]; 4] =
    [[0, 0, 0, 255], [255, 255, 255, 255], [92, 88, 80, 255], [150, 128, 92, 255]];

/// The number of windows per lit window.
const WINDOWS_PER_LIT: u32 = 4;

/// The height from which on a mesh with glass counts as a building, in metres.
const BUILDING_M: f32 = 6.0;

/// Adds a copy of the scene's lamp with glowing globes. Returns its id, if there are lamps.
pub(super) fn add_lit_lamp(scene: &mut Scene) -> Option<MeshId> {
    let lamp = lamp_mesh(scene)?;
    let material = glow_material(scene.surfaces.as_mut()?);
    let mesh = scene.meshes.get(lamp.0 as usize)?.clone();
    let surfaces = scene.surfaces.as_mut()?;
    let mut surface = surfaces.meshes.get(lamp.0 as usize)?.clone();
    let globes = lamp_colours();
    for (vertex, surface) in mesh.vertices.iter().zip(&mut surface.vertices) {
        surface.uv[0] = texel(usize::from(globes.contains(&vertex.colour)));
    }
    surface.material = material;
    surfaces.meshes.push(surface);
    scene.meshes.push(Mesh { name: format!("{}, lit", mesh.name), ..mesh });
    Some(MeshId(scene.meshes.len() as u32 - 1))
}

/// Makes a whole mesh glow.
pub(crate) fn let_glow(scene: &mut Scene, mesh: MeshId) {
    let Some(surfaces) = &mut scene.surfaces else { return };
    let material = glow_material(surfaces);
    if let Some(surface) = surfaces.meshes.get_mut(mesh.0 as usize) {
        surface.material = material;
        surface.vertices.iter_mut().for_each(|vertex| vertex.uv[0] = texel(1));
    }
}

/// Makes some windows of buildings glow, the same windows in each building of a kind.
pub(super) fn light_windows(scene: &mut Scene) {
    let Some(surfaces) = &mut scene.surfaces else { return };
    let material = glow_material(surfaces);
    let glass = glass_colours();
    for (number, (mesh, surface)) in (0_i64..).zip(scene.meshes.iter().zip(&mut surfaces.meshes)) {
        let Aabb { min, max } = mesh.bounds;
        let has_glass = mesh.vertices.iter().any(|vertex| glass.contains(&vertex.colour));
        if !has_glass || max.y - min.y < BUILDING_M {
            continue;
        }
        surface.material = material;
        let panes = panes_of(mesh, &glass);
        for (pane, surface) in panes.into_iter().zip(&mut surface.vertices) {
            let light = pane.map_or(0, |pane| {
                let mut random = Random::keyed(0x6c_6974, &[number, i64::from(pane)]);
                match random.below(WINDOWS_PER_LIT) {
                    0 => 2 + random.below(2) as usize,
                    _ => 0,
                }
            });
            surface.uv[0] = texel(light);
        }
    }
}

/// Returns the pane of each vertex of glass: the least vertex that triangles connect it to.
fn panes_of(mesh: &Mesh, glass: &[u32]) -> Vec<Option<u32>> {
    let is_glass = |vertex: u32| {
        mesh.vertices.get(vertex as usize).is_some_and(|vertex| glass.contains(&vertex.colour))
    };
    let mut panes: Vec<Option<u32>> =
        (0..mesh.vertices.len() as u32).map(|vertex| is_glass(vertex).then_some(vertex)).collect();
    loop {
        let mut changed = false;
        for triangle in mesh.indices.as_chunks::<3>().0 {
            let of = |vertex: &u32| panes.get(*vertex as usize).copied().flatten();
            let Some(least) = triangle.iter().filter_map(of).min() else { continue };
            for vertex in triangle {
                if let Some(Some(pane)) = panes.get_mut(*vertex as usize)
                    && *pane > least
                {
                    *pane = least;
                    changed = true;
                }
            }
        }
        if !changed {
            return panes;
        }
    }
}

/// Returns the coordinates of the middle of a texel.
fn texel(number: usize) -> [f32; 2] {
    [(number as f32 + 0.5) / TEXELS.len() as f32, 0.5]
}

/// Returns the material that glows by its texture, and adds it if necessary.
fn glow_material(surfaces: &mut Surfaces) -> MaterialId {
    let there = surfaces.materials.iter().position(|material| material.name == GLOW_NAME);
    if let Some(there) = there {
        return MaterialId(there as u32);
    }
    let image = ImageId(surfaces.images.len() as u32);
    let size = [TEXELS.len() as u32, 1];
    surfaces.images.push(Image::of_rgba8(GLOW_NAME, size, TEXELS.concat()));
    let texture = TextureId(surfaces.textures.len() as u32);
    let sampler = Sampler {
        wrap: [Wrap::Clamp; 2],
        magnified: Filter::Nearest,
        minified: Filter::Nearest,
        between_levels: None,
    };
    surfaces.textures.push(Texture { image, encoding: Encoding::Srgb, sampler });
    surfaces.materials.push(Material {
        name: GLOW_NAME.to_owned(),
        metallic: 0.0,
        roughness: 1.0,
        emission: EMISSION,
        emission_texture: Some(TextureUse { texture, uv_set: 0, transform: Affine2::IDENTITY }),
        ..Material::default()
    });
    MaterialId(surfaces.materials.len() as u32 - 1)
}
