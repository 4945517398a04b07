//! Low buildings without an upper floor, for scenes in which nothing is hidden from above.

use glam::{Vec2, Vec3, vec2, vec3};
use scene::Mesh;

use super::super::builder::{Faces, Frame, MeshBuilder, panel};
use super::super::random::Random;
use super::facade::{Entrance, Facade, Side};
use super::palette::Materials;

/// Returns three pavilions of at most 9 by 9 metres and a height of 4 metres.
pub(crate) fn pavilions(materials: &Materials) -> [Mesh; 3] {
    [
        pavilion("pavilion, square", vec2(3.9, 3.9), [4, 4], materials),
        pavilion("pavilion, long", vec2(4.1, 2.6), [5, 3], materials),
        pavilion("pavilion, small", vec2(2.6, 2.4), [3, 3], materials),
    ]
}

fn pavilion(name: &str, half: Vec2, bays: [u32; 2], materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let mut random = Random::keyed(0, &[i64::from(bays[0]), i64::from(bays[1])]);
    let wall_m = 2.9;
    for side in 0..4 {
        let frame = Frame::of_side(side, half, Vec3::ZERO);
        let width_m = 2.0 * if side % 2 == 0 { half.x } else { half.y };
        let bays = bays[side % 2];
        Side {
            frame,
            width_m,
            bays,
            floors: 0,
            floor_m: 0.0,
            ground_m: wall_m,
            facade: Facade::Punched,
            entrance: Entrance::Front,
            materials,
        }
        .build(&mut builder, &mut random);
        for post in 0..=bays {
            let u = (width_m * post as f32 / bays as f32).clamp(0.14, width_m - 0.14);
            builder.ledge(
                &frame,
                panel(u - 0.13, 0.3, u + 0.13, wall_m - 0.1),
                0.12,
                materials.wall,
            );
        }
    }
    builder.band(half, 0.16, [0.0, 0.3], materials.stone);
    builder.band(half, 0.35, [wall_m - 0.1, wall_m + 0.1], materials.trim);
    let wide = half + Vec2::splat(0.28);
    builder.tapered(
        vec3(-wide.x, wall_m + 0.1, -wide.y),
        vec3(wide.x, wall_m + 0.9, wide.y),
        Vec2::splat(1.4),
        Faces::Standing,
        materials.tile,
    );
    let light = half * 0.3;
    builder.cuboid(
        vec3(-light.x, wall_m + 0.85, -light.y),
        vec3(light.x, wall_m + 1.05, light.y),
        Faces::Standing,
        materials.glass[2],
    );
    builder.darken_foot(0.75, 4.0);
    builder.finish(name)
}
