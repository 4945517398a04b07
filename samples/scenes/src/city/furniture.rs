//! Small street furniture: lamps, benches, bins, hydrants and the like.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};
use scene::Mesh;

use super::super::builder::{Faces, Frame, MeshBuilder, Paint, panel};
use super::palette::Materials;

fn at(x: f32, y: f32, z: f32) -> Affine3A {
    Affine3A::from_translation(vec3(x, y, z))
}

/// Returns a transform that lays the local y axis along x, for wheels and rails.
pub(super) fn lying(centre: Vec3) -> Affine3A {
    Affine3A::from_rotation_translation(
        glam::Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2),
        centre,
    )
}

/// The name of lamp posts.
pub(crate) const LAMP_NAME: &str = "street lamp";

/// Returns the colours of a lamp's globes: at the bottom and at the top.
fn globe() -> [Paint; 2] {
    let glow = Paint::srgb(0xFF_F3D6);
    [glow.shade(0.9), glow]
}

/// Returns the colours of the vertices of a lamp's globes.
pub(crate) fn lamp_colours() -> [u32; 2] {
    globe().map(Paint::packed)
}

/// Returns a lamp post with two globes.
pub(super) fn lamp(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let coat = materials.coat.shade(0.8);
    let profile = [
        (0.24, 0.0),
        (0.24, 0.25),
        (0.17, 0.35),
        (0.15, 0.9),
        (0.09, 1.0),
        (0.06, 4.4),
        (0.1, 4.45),
        (0.1, 4.6),
        (0.04, 4.7),
        (0.0, 5.3),
    ];
    builder.turned(&at(0.0, 0.0, 0.0), &profile, 10, coat);
    builder.turned(
        &lying(vec3(-0.55, 4.5, 0.0)),
        &[(0.0, 0.0), (0.035, 0.0), (0.035, 1.1), (0.0, 1.1)],
        6,
        coat,
    );
    for x in [-0.55, 0.55] {
        builder.turned(&at(x, 4.42, 0.0), &[(0.05, 0.0), (0.12, 0.12), (0.0, 0.14)], 8, coat);
        builder.ellipsoid(vec3(x, 4.76, 0.0), vec2(0.23, 0.23), [10, 7], globe());
    }
    builder.finish(LAMP_NAME)
}

/// Returns a bench with a slatted seat and back on cast-iron sides.
pub(super) fn bench(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    for slat in 0..4u8 {
        let z = -0.2 + 0.13 * f32::from(slat);
        builder.cuboid(vec3(-0.9, 0.43, z), vec3(0.9, 0.47, z + 0.1), Faces::All, materials.wood);
    }
    for slat in 0..3u8 {
        let y = 0.56 + 0.14 * f32::from(slat);
        let z = -0.29 - 0.03 * f32::from(slat);
        builder.cuboid(vec3(-0.9, y, z), vec3(0.9, y + 0.1, z + 0.04), Faces::All, materials.wood);
    }
    let coat = materials.coat.shade(0.6);
    for x in [-0.75, 0.0, 0.75] {
        let left = x - 0.03;
        let right = x + 0.03;
        builder.cuboid(vec3(left, 0.0, 0.2), vec3(right, 0.44, 0.28), Faces::Standing, coat);
        builder.cuboid(vec3(left, 0.36, -0.28), vec3(right, 0.425, 0.25), Faces::All, coat);
        let back = [vec2(-0.3, 0.0), vec2(-0.42, 0.95), vec2(-0.36, 0.95), vec2(-0.22, 0.0)];
        builder.extruded(&back, [left + 0.005, right - 0.005], coat);
    }
    for x in [-0.75, 0.75] {
        builder.cuboid(vec3(x - 0.04, 0.6, -0.3), vec3(x + 0.04, 0.65, 0.24), Faces::All, coat);
        builder.cuboid(
            vec3(x - 0.025, 0.44, 0.17),
            vec3(x + 0.025, 0.61, 0.22),
            Faces::Sides,
            coat,
        );
    }
    builder.finish("bench")
}

/// Returns a round litter bin of upright slats.
pub(super) fn bin(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let coat = materials.coat.shade(0.7);
    builder.turned(
        &at(0.0, 0.0, 0.0),
        &[(0.0, 0.05), (0.26, 0.05), (0.29, 0.85)],
        16,
        materials.iron,
    );
    builder.turned(
        &at(0.0, 0.0, 0.0),
        &[(0.29, 0.85), (0.22, 0.85), (0.2, 0.6), (0.0, 0.6)],
        16,
        materials.iron.shade(0.6),
    );
    let rim = [(0.29, 0.8), (0.34, 0.8), (0.34, 0.9), (0.24, 0.9), (0.24, 0.86)];
    builder.turned(&at(0.0, 0.0, 0.0), &rim, 16, coat);
    builder.turned(&at(0.0, 0.0, 0.0), &[(0.3, 0.0), (0.3, 0.08), (0.2, 0.1)], 16, coat);
    for slat in 0..12u8 {
        let turn = std::f32::consts::TAU * f32::from(slat) / 12.0;
        let frame = Frame::facing(turn, 0.24);
        let area = panel(-0.05, 0.1, 0.05, 0.8);
        builder.ledge(&frame, area, 0.08, coat);
    }
    builder.finish("litter bin")
}

/// Returns a fire hydrant.
pub(super) fn hydrant() -> Mesh {
    let mut builder = MeshBuilder::default();
    let red = Paint::srgb(0xB0_3428);
    let profile = [
        (0.22, 0.0),
        (0.22, 0.06),
        (0.15, 0.08),
        (0.14, 0.55),
        (0.19, 0.57),
        (0.19, 0.63),
        (0.16, 0.65),
        (0.13, 0.77),
        (0.06, 0.83),
        (0.06, 0.9),
        (0.0, 0.9),
    ];
    builder.turned(&at(0.0, 0.0, 0.0), &profile, 14, red);
    let cap = [(0.0, 0.0), (0.07, 0.0), (0.07, 0.4), (0.09, 0.4), (0.09, 0.48), (0.0, 0.48)];
    builder.turned(
        &lying(vec3(-0.24, 0.44, 0.0)),
        &[(0.0, 0.0), (0.08, 0.0), (0.08, 0.48), (0.0, 0.48)],
        10,
        red.shade(0.85),
    );
    let forward = Affine3A::from_rotation_translation(
        glam::Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
        vec3(0.0, 0.4, -0.2),
    );
    builder.turned(&forward, &cap, 12, red.shade(0.85));
    builder.finish("hydrant")
}

/// Returns a pillar box.
pub(super) fn post_box(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let red = Paint::srgb(0xB5_3A2C);
    let origin = at(0.0, 0.0, 0.0);
    builder.turned(&origin, &[(0.33, 0.0), (0.33, 0.18), (0.3, 0.2)], 18, materials.iron);
    builder.turned(
        &origin,
        &[
            (0.3, 0.2),
            (0.3, 1.35),
            (0.35, 1.38),
            (0.35, 1.48),
            (0.3, 1.52),
            (0.18, 1.6),
            (0.0, 1.63),
        ],
        18,
        red,
    );
    let slot = Frame::facing(0.0, 0.2);
    builder.ledge(&slot, panel(-0.14, 1.18, 0.14, 1.26), 0.13, materials.iron);
    builder.ledge(&slot, panel(-0.1, 0.75, 0.1, 1.0), 0.12, Paint::srgb(0xE8_E4DA));
    builder.finish("post box")
}

/// Returns four bollards in a row.
pub(super) fn bollards(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let profile = [
        (0.12, 0.0),
        (0.12, 0.1),
        (0.08, 0.14),
        (0.07, 0.8),
        (0.09, 0.82),
        (0.09, 0.88),
        (0.05, 0.96),
        (0.0, 0.98),
    ];
    for place in 0..4u8 {
        builder.turned(&at(-1.5 + f32::from(place), 0.0, 0.0), &profile, 9, materials.iron);
    }
    for link in 0..3u8 {
        let from = vec3(-1.45 + f32::from(link), 0.7, 0.0);
        builder.turned(&lying(from), &[(0.02, 0.0), (0.02, 0.9)], 5, materials.steel);
    }
    builder.finish("bollards")
}

/// Returns five hoops to lean bicycles on.
pub(super) fn bicycle_stand(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let steel = materials.steel;
    for hoop in 0..5u8 {
        let x = -1.4 + 0.7 * f32::from(hoop);
        for z in [-0.35, 0.35] {
            builder.turned(
                &at(x, 0.0, z),
                &[(0.09, 0.0), (0.09, 0.03), (0.03, 0.04), (0.03, 0.82)],
                6,
                steel,
            );
        }
        let half = Vec2::new(0.028, 0.38);
        builder.cuboid(
            vec3(x - half.x, 0.78, -half.y),
            vec3(x + half.x, 0.84, half.y),
            Faces::All,
            steel,
        );
    }
    for z in [-0.2, 0.2] {
        builder.cuboid(
            vec3(-1.55, 0.0, z - 0.03),
            vec3(1.55, 0.05, z + 0.03),
            Faces::All,
            materials.iron,
        );
    }
    builder.finish("bicycle stand")
}
