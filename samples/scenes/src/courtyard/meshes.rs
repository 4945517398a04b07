//! The meshes of the courtyard: its ground, its walls, and its objects.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};
use scene::Mesh;

use super::super::builder::{Faces, MeshBuilder, Paint};
use super::{HALF_M, SUNK_M, TILE_M};

/// Returns the ground: a chequered floor.
pub(super) fn ground() -> Mesh {
    let mut builder = MeshBuilder::default();
    let paints = [0xB9_AE98, 0xA6_9A84].map(Paint::srgb);
    let tiles = (2.0 * HALF_M / TILE_M) as u8;
    for column in 0..tiles {
        for row in 0..tiles {
            let [x, z] = [column, row].map(|tile| f32::from(tile) * TILE_M - HALF_M);
            let corners = [
                vec3(x, 0.0, z + TILE_M),
                vec3(x + TILE_M, 0.0, z + TILE_M),
                vec3(x + TILE_M, 0.0, z),
                vec3(x, 0.0, z),
            ];
            builder.polygon(&corners, paints[usize::from((column + row) % 2)]);
        }
    }
    builder.finish("courtyard ground")
}

pub(super) fn wall() -> Mesh {
    let mut builder = MeshBuilder::default();
    // Walls end just before they meet.
    let half = HALF_M - 0.82;
    let high = 4.2;
    let stone = Paint::srgb(0xC9_B79A);
    builder.cuboid(vec3(-half, -SUNK_M, -0.3), vec3(half, high, 0.3), Faces::Standing, stone);
    let coping = Paint::srgb(0x9A_6A4E);
    let end = half - 0.15;
    let low = vec3(-end, high - 0.1, -0.45);
    let top = vec3(end, high + 0.3, 0.45);
    builder.tapered(low, top, vec2(0.0, 0.3), Faces::All, coping);
    builder.finish("courtyard wall")
}

pub(super) fn column() -> Mesh {
    let mut builder = MeshBuilder::default();
    let profile = [
        // No small hollows at the foot: filters of soft shadows are as wide as hollows would be.
        (0.55, -SUNK_M),
        (0.55, 0.3),
        (0.34, 0.3),
        (0.3, 4.6),
        (0.36, 4.7),
        (0.55, 4.95),
        (0.55, 5.2),
        (0.0, 5.2),
    ];
    builder.turned(&Affine3A::IDENTITY, &profile, 24, Paint::srgb(0xE4_DBC8));
    builder.finish("column")
}

/// Returns a fence of pickets between two rails.
pub(super) fn fence() -> Mesh {
    let mut builder = MeshBuilder::default();
    let wood = Paint::srgb(0x6E_4B33);
    for picket in 0..16_u8 {
        let x = f32::from(picket) * 0.4 - 3.0;
        let low = vec3(x - 0.06, -SUNK_M, -0.03);
        let high = vec3(x + 0.06, 1.5, 0.03);
        builder.tapered(low, high, Vec2::ZERO, Faces::Standing, wood);
    }
    for y in [0.35, 1.1] {
        let low = vec3(-3.2, y, 0.032);
        let high = vec3(3.2, y + 0.12, 0.09);
        builder.cuboid(low, high, Faces::All, wood.shade(0.8));
    }
    builder.finish("fence")
}

pub(super) fn crate_box() -> Mesh {
    let mut builder = MeshBuilder::default();
    let wood = Paint::srgb(0xA8_7B4A);
    builder.cuboid(vec3(-0.55, -SUNK_M, -0.55), vec3(0.55, 1.1, 0.55), Faces::Standing, wood);
    builder.finish("crate")
}

/// Returns a figure in a long coat, with a hat, that looks along +z.
pub(super) fn figure_mesh() -> Mesh {
    let mut builder = MeshBuilder::default();
    let coat = Paint::srgb(0x8C_3B36);
    let body = [(0.0, 0.05), (0.38, 0.05), (0.26, 0.9), (0.3, 1.25), (0.12, 1.45), (0.0, 1.5)];
    builder.turned(&Affine3A::IDENTITY, &body, 16, coat);
    let skin = Paint::srgb(0xD9_A27C);
    builder.ellipsoid(vec3(0.0, 1.66, 0.0), vec2(0.14, 0.17), [12, 8], [skin, skin]);
    let hat = [(0.0, 1.76), (0.3, 1.77), (0.3, 1.79), (0.16, 1.81), (0.13, 2.0), (0.0, 2.02)];
    builder.turned(&Affine3A::IDENTITY, &hat, 16, Paint::srgb(0x2B_2A2E));
    for side in [-1.0_f32, 1.0] {
        let x = side * 0.38;
        let low = vec3(x - 0.07, 0.75, -0.07);
        let high = vec3(x + 0.07, 1.32, 0.1);
        builder.cuboid(low, high, Faces::All, coat.shade(0.85));
    }
    builder.finish("figure")
}

pub(super) fn lantern_mesh() -> Mesh {
    let mut builder = MeshBuilder::default();
    let glass = Paint::srgb(0xFF_F3D6);
    builder.ellipsoid(Vec3::ZERO, vec2(0.2, 0.24), [14, 10], [glass, glass]);
    builder.finish("lantern")
}

/// Returns a wrought bracket, from the wall behind a lamp to above its glass.
pub(super) fn bracket() -> Mesh {
    let mut builder = MeshBuilder::default();
    let iron = Paint::srgb(0x2E_2C2E);
    builder.cuboid(vec3(-0.03, 0.3, -0.6), vec3(0.03, 0.36, 0.05), Faces::All, iron);
    builder.finish("bracket")
}

/// Returns a mast for a spot.
pub(super) fn mast() -> Mesh {
    let mut builder = MeshBuilder::default();
    let profile = [(0.2, -SUNK_M), (0.2, 0.3), (0.09, 0.4), (0.07, 6.3), (0.0, 6.35)];
    builder.turned(&Affine3A::IDENTITY, &profile, 12, Paint::srgb(0x3A_3C40));
    builder.finish("mast")
}

/// Returns the housing of a spot that shines down from its origin.
pub(super) fn housing() -> Mesh {
    let mut builder = MeshBuilder::default();
    let profile = [(0.0, 0.12), (0.3, 0.12), (0.32, 0.2), (0.2, 0.6), (0.0, 0.7)];
    builder.turned(&Affine3A::IDENTITY, &profile, 16, Paint::srgb(0x3A_3C40));
    builder.finish("housing")
}

/// Returns the lens of a spot, just behind its origin.
pub(super) fn lens() -> Mesh {
    let mut builder = MeshBuilder::default();
    let profile = [(0.0, 0.03), (0.26, 0.03), (0.26, 0.09), (0.0, 0.09)];
    builder.turned(&Affine3A::IDENTITY, &profile, 16, Paint::srgb(0xFF_FAEE));
    builder.finish("lens")
}
