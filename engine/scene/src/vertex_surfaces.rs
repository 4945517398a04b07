//! Surfaces for scenes whose vertices hold the whole appearance: the same look under punctual
//! lights.

use std::f32::consts::PI;

use glam::Vec3;

use super::mesh::{Mesh, unpack_normal};
use super::surface::{
    LightKind, Material, MaterialId, PunctualLight, SurfaceMesh, SurfaceVertex, Surfaces,
};
use super::{Light, Scene};

/// The share of light that a matt dielectric's surface lets through to its colour: the rest is
/// mirrored.
const LET_THROUGH: f32 = 1.0 - 0.04;

/// Returns the surfaces of a scene that has none: its vertex colours, matt, under its sun.
pub(super) fn of_vertex_colours(scene: &Scene) -> Surfaces {
    let matt =
        Material { name: "matt".to_owned(), metallic: 0.0, roughness: 1.0, ..Material::default() };
    Surfaces {
        meshes: scene.meshes.iter().map(surface_mesh).collect(),
        materials: vec![matt],
        lights: sun_of(&scene.light).into_iter().collect(),
        ..Surfaces::default()
    }
}

/// Returns the sun as a punctual light, which shines on a matt surface as brightly; `None` if it
/// does not shine.
fn sun_of(light: &Light) -> Option<PunctualLight> {
    let strongest = light.sun.into_iter().fold(0.0, f32::max);
    let direction = -light.towards_sun.try_normalize()?;
    let is_bright = strongest.is_finite() && strongest > 0.0;
    is_bright.then(|| PunctualLight {
        kind: LightKind::Directional,
        colour: light.sun.map(|part| part / strongest),
        intensity: strongest * PI / LET_THROUGH,
        range_m: None,
        position: Vec3::ZERO,
        direction,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Scene {
        let red = [1.0, 0.2, 0.0];
        let corners = [([0.0, 0.0, 0.0], red), ([1.0, 0.0, 0.0], red), ([0.0, 1.0, 0.0], red)];
        Scene::single(Mesh::of_triangles("triangle", &corners))
    }

    #[test]
    fn a_plain_scene_gets_its_colours_and_its_sun_as_surfaces() {
        let plain = triangle();
        let lit = plain.clone().with_surfaces();
        assert_eq!(lit.validate(), Ok(()));
        assert_eq!((&lit.meshes, &lit.objects), (&plain.meshes, &plain.objects));
        let surfaces = lit.surfaces.as_ref().unwrap();
        let vertex = surfaces.meshes[0].vertices[0];
        assert_eq!(vertex.normal, [0, 0, i16::MAX, 0]);
        assert_eq!(vertex.colour, [u16::MAX, 51 * 257, 0, u16::MAX]);
        let [sun] = surfaces.lights.as_slice() else { panic!("one light") };
        assert_eq!(sun.kind, LightKind::Directional);
        assert!((sun.direction + plain.light.towards_sun).length() < 1e-6);
        let diffuse = sun.colour.map(|part| part * sun.intensity * LET_THROUGH / PI);
        for (found, expected) in diffuse.into_iter().zip(plain.light.sun) {
            assert!((found - expected).abs() < 1e-5, "{diffuse:?}");
        }
        assert_eq!(lit.clone().with_surfaces(), lit, "surfaces that are there stay");
    }

    #[test]
    fn a_sun_that_does_not_shine_is_no_light() {
        let plain = triangle();
        for (towards_sun, sun) in [
            (Vec3::Y, [0.0; 3]),
            (Vec3::Y, [f32::NAN; 3]),
            (Vec3::Y, [f32::INFINITY, 1.0, 1.0]),
            (Vec3::ZERO, [1.0; 3]),
            (Vec3::NAN, [1.0; 3]),
        ] {
            let light = Light { towards_sun, sun, ..plain.light };
            let lit = Scene { light, ..plain.clone() }.with_surfaces();
            assert_eq!(lit.surfaces.unwrap().lights, [], "{towards_sun}, {sun:?}");
        }
    }

    #[test]
    fn both_sides_of_a_mesh_are_kept() {
        let mut plain = triangle();
        plain.meshes[0].has_backs = true;
        let surfaces = plain.with_surfaces().surfaces.unwrap();
        assert!(surfaces.meshes[0].vertices.iter().all(|vertex| vertex.normal[3] == i16::MAX));
    }
}
