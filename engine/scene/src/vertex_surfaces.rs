//! Surfaces for scenes whose vertices hold the whole appearance, so that they look the same under
//! punctual lights.

use std::f32::consts::PI;

use glam::Vec3;

use super::mesh::{Mesh, unpack_normal};
use super::punctual_light::{LightKind, PunctualLight};
use super::surface::{Material, MaterialId, SurfaceMesh, SurfaceVertex, Surfaces};

/// The share of light that a matt dielectric transmits to its diffuse colour; the rest is
/// reflected.
pub(super) const LET_THROUGH: f32 = 1.0 - 0.04;

/// Returns surfaces for meshes without any: a matt material in the vertex colours, and a sun that
/// is as bright as `sun` on surfaces that face it.
pub(super) fn of_vertex_colours(meshes: &[Mesh], towards_sun: Vec3, sun: [f32; 3]) -> Surfaces {
    let matt =
        Material { name: "matt".to_owned(), metallic: 0.0, roughness: 1.0, ..Material::default() };
    Surfaces {
        meshes: meshes.iter().map(surface_mesh).collect(),
        materials: vec![matt],
        lights: sun_of(towards_sun, sun).into_iter().collect(),
        ..Surfaces::default()
    }
}

/// Returns the sun as a punctual light that lights a matt surface equally; `None` if it is dark.
fn sun_of(towards_sun: Vec3, sun: [f32; 3]) -> Option<PunctualLight> {
    let strongest = sun.into_iter().fold(0.0, f32::max);
    let direction = -towards_sun.try_normalize()?;
    let is_bright = strongest.is_finite() && strongest > 0.0;
    is_bright.then(|| PunctualLight {
        kind: LightKind::Directional,
        colour: sun.map(|part| part / strongest),
        intensity: strongest * PI / LET_THROUGH,
        range_m: None,
        position: Vec3::ZERO,
        direction,
        cookie: None,
    })
}

fn surface_mesh(mesh: &Mesh) -> SurfaceMesh {
    let both_sides = if mesh.has_backs { i16::MAX } else { 0 };
    let vertices = mesh.vertices.iter().map(|vertex| {
        let normal = unpack_normal(vertex.normal).normalize_or_zero();
        let tangent = normal.try_normalize().map_or(Vec3::ZERO, Vec3::any_orthonormal_vector);
        let [red, green, blue, _] = vertex.colour.to_le_bytes().map(|byte| u16::from(byte) * 257);
        SurfaceVertex {
            normal: snorm16(normal, both_sides),
            tangent: snorm16(tangent, i16::MAX),
            uv: [[0.0; 2]; 2],
            colour: [red, green, blue, u16::MAX],
        }
    });
    SurfaceMesh { vertices: vertices.collect(), material: MaterialId(0) }
}

fn snorm16(vector: Vec3, last: i16) -> [i16; 4] {
    let [x, y, z] = (vector * f32::from(i16::MAX)).round().to_array().map(|part| part as i16);
    [x, y, z, last]
}
