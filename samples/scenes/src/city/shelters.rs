//! Larger street furniture: kiosk, bus stop, advertising column, fountain.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};
use scene::Mesh;

use super::super::builder::{Faces, Frame, MeshBuilder, Paint, panel};
use super::palette::Materials;

/// Returns a news stand with a counter, a striped awning and a hipped roof.
pub(super) fn kiosk(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let half = vec2(1.2, 0.9);
    let coat = materials.coat.shade(0.8);
    for side in 0..4 {
        let frame = Frame::of_side(side, half, Vec3::ZERO);
        let width = 2.0 * if side % 2 == 0 { half.x } else { half.y };
        let cell = panel(0.0, 0.0, width, 2.5);
        let hole = panel(0.2, if side == 0 { 1.05 } else { 1.3 }, width - 0.2, 2.2);
        builder.recess(&frame, cell, hole, 0.15, [coat, materials.trim]);
        builder.rectangle(&frame, hole, -0.15, materials.glass[side % 3]);
        for post in 0..=4u8 {
            let u = 0.06 + (width - 0.12) * f32::from(post) / 4.0;
            builder.ledge(&frame, panel(u - 0.04, 0.1, u + 0.04, 1.0), 0.04, materials.trim);
        }
    }
    let front = Frame::of_side(0, half, Vec3::ZERO);
    builder.ledge(&front, panel(0.1, 0.98, 2.3, 1.04), 0.35, materials.wood);
    for stripe in 0..10u8 {
        let u0 = 0.22 * f32::from(stripe) + 0.1;
        let u1 = 0.22 * f32::from(stripe) + 0.32;
        let paint = if stripe % 2 == 0 { materials.trim } else { coat };
        let slope = [
            front.at(u0, 2.05, 0.8),
            front.at(u1, 2.05, 0.8),
            front.at(u1, 2.4, 0.0),
            front.at(u0, 2.4, 0.0),
        ];
        builder.polygon(&slope, paint);
        let [a, b, c, d] = slope;
        builder.polygon(&[d, c, b, a], paint.shade(0.6));
    }
    builder.band(half, 0.18, [2.5, 2.7], materials.trim);
    let wide = half + Vec2::splat(0.12);
    builder.tapered(
        vec3(-wide.x, 2.7, -wide.y),
        vec3(wide.x, 3.3, wide.y),
        Vec2::splat(0.8),
        Faces::Standing,
        materials.slate,
    );
    builder.band(half, 0.05, [0.0, 0.12], materials.stone);
    builder.finish("kiosk")
}

/// Returns a glazed shelter with a bench and a sign.
pub(super) fn bus_stop(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let steel = materials.steel.shade(0.8);
    for x in [-1.7, 0.0, 1.7] {
        builder.cuboid(
            vec3(x - 0.05, 0.0, -0.65),
            vec3(x + 0.05, 2.45, -0.55),
            Faces::Sides,
            steel,
        );
    }
    for x in [-1.7, 1.7] {
        builder.cuboid(vec3(x - 0.05, 0.0, 0.5), vec3(x + 0.05, 2.45, 0.6), Faces::Sides, steel);
    }
    for (left, right) in [(-1.64, -0.06), (0.06, 1.64)] {
        builder.cuboid(
            vec3(left, 0.3, -0.62),
            vec3(right, 2.2, -0.58),
            Faces::All,
            materials.glass[2],
        );
        builder.cuboid(vec3(left, 2.2, -0.63), vec3(right, 2.28, -0.57), Faces::All, steel);
        builder.cuboid(vec3(left, 0.22, -0.63), vec3(right, 0.3, -0.57), Faces::All, steel);
    }
    builder.cuboid(vec3(-1.72, 0.3, -0.54), vec3(-1.68, 2.2, 0.3), Faces::All, materials.glass[1]);
    builder.cuboid(
        vec3(1.67, 0.3, -0.54),
        vec3(1.73, 2.2, 0.3),
        Faces::All,
        Paint::srgb(0xD9_8A3C),
    );
    builder.cuboid(vec3(-1.85, 2.4, -0.75), vec3(1.85, 2.52, 0.75), Faces::All, materials.iron);
    builder.tapered(
        vec3(-1.8, 2.5, -0.7),
        vec3(1.8, 2.62, 0.7),
        vec2(0.3, 0.3),
        Faces::Standing,
        steel,
    );
    builder.cuboid(vec3(-1.2, 0.42, -0.5), vec3(0.9, 0.48, -0.12), Faces::All, materials.wood);
    for x in [-0.9, 0.6] {
        builder.cuboid(
            vec3(x - 0.04, 0.0, -0.4),
            vec3(x + 0.04, 0.44, -0.22),
            Faces::Sides,
            materials.iron,
        );
    }
    let pole = Affine3A::from_translation(vec3(1.7, 2.6, 0.55));
    builder.turned(&pole, &[(0.04, -0.1), (0.04, 0.75), (0.0, 0.78)], 6, steel);
    let disc = Affine3A::from_rotation_translation(
        glam::Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
        vec3(1.55, 3.1, 0.54),
    );
    builder.turned(
        &disc,
        &[(0.0, 0.0), (0.28, 0.0), (0.28, 0.05), (0.22, 0.06), (0.0, 0.06)],
        14,
        Paint::srgb(0xE3_C23A),
    );
    builder.finish("bus stop")
}

/// Returns a round column for posters with a small roof.
pub(super) fn advertising_column(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let origin = Affine3A::IDENTITY;
    let coat = materials.coat.shade(0.7);
    builder.turned(&origin, &[(0.72, 0.0), (0.72, 0.3), (0.65, 0.4)], 20, coat);
    builder.turned(&origin, &[(0.65, 0.4), (0.65, 2.8)], 20, materials.trim.tinted(0.0));
    let roof = [
        (0.65, 2.8),
        (0.82, 2.85),
        (0.82, 3.0),
        (0.6, 3.15),
        (0.35, 3.5),
        (0.12, 3.65),
        (0.1, 3.9),
        (0.0, 4.0),
    ];
    builder.turned(&origin, &roof, 20, coat);
    let posters = [0xB8_5042, 0x3E_6C8F, 0xE0_B04A, 0x5C_8A6A, 0xE7_E0D0, 0x6A_4A78];
    for (place, &hex) in posters.iter().enumerate() {
        let turn = std::f32::consts::TAU * (place as f32 + 0.5) / posters.len() as f32;
        let frame = Frame::facing(turn, 0.56);
        let low = 0.7 + 0.25 * (place % 2) as f32;
        builder.ledge(&frame, panel(-0.26, low, 0.26, low + 1.5), 0.125, Paint::srgb(hex));
    }
    builder.finish("advertising column")
}

/// Returns a fountain with two bowls.
pub(super) fn fountain(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let origin = Affine3A::IDENTITY;
    let stone = materials.stone.tinted(0.0);
    let water = Paint::srgb(0x5F_93A0);
    builder.turned(
        &origin,
        &[
            (1.85, 0.0),
            (1.85, 0.15),
            (1.7, 0.2),
            (1.65, 0.6),
            (1.8, 0.62),
            (1.8, 0.7),
            (1.5, 0.7),
            (1.5, 0.5),
        ],
        24,
        stone,
    );
    builder.turned(&origin, &[(1.5, 0.5), (0.0, 0.5)], 24, water);
    builder.turned(
        &origin,
        &[
            (0.3, 0.45),
            (0.2, 0.8),
            (0.16, 1.3),
            (0.3, 1.45),
            (0.95, 1.65),
            (1.0, 1.75),
            (0.88, 1.75),
            (0.85, 1.7),
        ],
        20,
        stone,
    );
    builder.turned(&origin, &[(0.85, 1.7), (0.0, 1.7)], 20, water);
    builder.turned(
        &origin,
        &[(0.12, 1.65), (0.1, 2.2), (0.2, 2.3), (0.1, 2.5), (0.0, 2.6)],
        12,
        stone,
    );
    builder.finish("fountain")
}
