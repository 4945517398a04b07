//! The boundary of a district: walls along its edge, a gate house across the end of each street,
//! and a round tower at each corner.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};
use scene::Mesh;

use super::super::builder::{Faces, Frame, MeshBuilder, panel};
use super::super::random::Random;
use super::facade::{Entrance, Facade, Side};
use super::layout::TILE_M;
use super::palette::Materials;

/// Half the width of gate houses and corner towers, in metres; both fill a square of this size.
pub(super) const POST_HALF_M: f32 = 4.5;

/// The distance between a wall and the posts at its ends, in metres.
const GAP_M: f32 = 0.3;

/// The half extents of a wall without its piers and coping.
const WALL_HALF: Vec2 = vec2(TILE_M / 2.0 - POST_HALF_M - GAP_M - 0.25, 0.5);
const WALL_HEIGHT_M: f32 = 12.0;

/// Returns a wall along x from post to post: blind arches between piers on both sides, and a coping
/// on top.
pub(super) fn wall(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let wall = materials.wall;
    let pier = materials.wall.shade(0.9);
    let arches = 9u32;
    for side in [0, 2] {
        let frame = Frame::of_side(side, WALL_HALF, Vec3::ZERO);
        let width = 2.0 * WALL_HALF.x;
        for arch in 0..arches {
            let edge = |arch: u32| width * arch as f32 / arches as f32;
            let u0 = edge(arch);
            let u1 = edge(arch + 1);
            blind_arch(&mut builder, &frame, [u0, u1], materials);
        }
        for place in 0..=arches {
            let u = (width * place as f32 / arches as f32).clamp(0.35, width - 0.35);
            let area = panel(u - 0.35, 0.0, u + 0.35, WALL_HEIGHT_M - 0.6);
            builder.ledge(&frame, area, 0.22, pier);
        }
    }
    for side in [1, 3] {
        let frame = Frame::of_side(side, WALL_HALF, Vec3::ZERO);
        let end = panel(0.0, 0.0, 2.0 * WALL_HALF.y, WALL_HEIGHT_M);
        builder.rectangle(&frame, end, 0.0, wall);
    }
    builder.band(WALL_HALF, 0.12, [0.0, 0.9], materials.stone);
    let half = WALL_HALF + Vec2::splat(0.25);
    let low = WALL_HEIGHT_M - 0.35;
    let high = WALL_HEIGHT_M + 0.15;
    builder.cuboid(
        vec3(-half.x, low, -half.y),
        vec3(half.x, high, half.y),
        Faces::All,
        materials.trim,
    );
    builder.darken_foot(0.75, 5.0);
    builder.finish("district wall")
}

/// Adds a recess that ends in a round arch.
fn blind_arch(builder: &mut MeshBuilder, frame: &Frame, ends: [f32; 2], materials: &Materials) {
    let [u0, u1] = ends;
    let middle = (u0 + u1) / 2.0;
    let radius = 2.0;
    let spring = 7.2;
    let foot = 1.2;
    let depth = 0.2;
    let steps = 10u16;
    let arc: Vec<(f32, f32)> = (0..=steps)
        .map(|step| {
            let (sin, cos) = (std::f32::consts::PI * f32::from(step) / f32::from(steps)).sin_cos();
            (middle + radius * cos, spring + radius * sin)
        })
        .collect();
    let at = |(u, v): (f32, f32), d: f32| frame.at(u, v, d);
    let wall = materials.wall;
    let reveal = materials.reveal.shade(0.85);
    let back = materials.wall.shade(0.8);
    // Below the arch: left, right and under the opening; above it: in steps up to the top.
    let right = arc[0];
    let left = arc[arc.len() - 1];
    builder.polygon(
        &[at((u0, 0.0), 0.0), at((left.0, foot), 0.0), at(left, 0.0), at((u0, spring), 0.0)],
        wall,
    );
    builder.polygon(
        &[at((right.0, foot), 0.0), at((u1, 0.0), 0.0), at((u1, spring), 0.0), at(right, 0.0)],
        wall,
    );
    builder.polygon(
        &[
            at((u0, 0.0), 0.0),
            at((u1, 0.0), 0.0),
            at((right.0, foot), 0.0),
            at((left.0, foot), 0.0),
        ],
        wall,
    );
    let top = |u: f32| if u > middle { (u1, WALL_HEIGHT_M) } else { (u0, WALL_HEIGHT_M) };
    builder.polygon(&[at(right, 0.0), at((u1, spring), 0.0), at(top(u1), 0.0)], wall);
    builder.polygon(&[at((u0, spring), 0.0), at(left, 0.0), at(top(u0), 0.0)], wall);
    for pair in arc.windows(2) {
        let a = pair[0];
        let b = pair[1];
        let corner = if a.0 + b.0 > 2.0 * middle { u1 } else { u0 };
        builder.polygon(&[at(a, 0.0), at((corner, WALL_HEIGHT_M), 0.0), at(b, 0.0)], wall);
        builder.polygon(&[at(a, 0.0), at(b, 0.0), at(b, -depth), at(a, -depth)], reveal);
    }
    let crown = arc[arc.len() / 2];
    builder.polygon(
        &[at(crown, 0.0), at((u1, WALL_HEIGHT_M), 0.0), at((u0, WALL_HEIGHT_M), 0.0)],
        wall,
    );
    let low_left = (left.0, foot);
    let low_right = (right.0, foot);
    builder.polygon(
        &[at(low_right, 0.0), at(right, 0.0), at(right, -depth), at(low_right, -depth)],
        reveal,
    );
    builder.polygon(
        &[at(left, 0.0), at(low_left, 0.0), at(low_left, -depth), at(left, -depth)],
        reveal,
    );
    builder.polygon(
        &[at(low_left, 0.0), at(low_right, 0.0), at(low_right, -depth), at(low_left, -depth)],
        reveal,
    );
    let mut opening = vec![at(low_left, -depth), at(low_right, -depth)];
    opening.extend(arc.iter().map(|&point| at(point, -depth)));
    builder.polygon(&opening, back);
}

/// Returns a slender house for the end of a street.
pub(super) fn gate_house(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let mut random = Random::keyed(0, &[77]);
    let half = Vec2::splat(POST_HALF_M - 0.3);
    let ground_m = 4.5;
    let floors = 5;
    let floor_m = 3.4;
    for side in 0..4 {
        Side {
            frame: Frame::of_side(side, half, Vec3::ZERO),
            width_m: 2.0 * half.x,
            bays: 3,
            floors,
            floor_m,
            ground_m,
            facade: Facade::Punched,
            entrance: Entrance::Front,
            materials,
        }
        .build(&mut builder, &mut random);
    }
    let eaves = ground_m + floors as f32 * floor_m;
    builder.band(half, 0.2, [ground_m - 0.2, ground_m + 0.1], materials.trim);
    builder.band(half, 0.28, [eaves - 0.2, eaves + 0.2], materials.trim);
    let top = half + Vec2::splat(0.1);
    builder.tapered(
        vec3(-top.x, eaves + 0.2, -top.y),
        vec3(top.x, eaves + 5.5, top.y),
        top - Vec2::splat(0.6),
        Faces::Sides,
        materials.slate,
    );
    let lantern = Affine3A::from_translation(Vec3::Y * (eaves + 5.3));
    builder.turned(
        &lantern,
        &[(0.7, 0.0), (0.7, 1.5), (0.95, 1.5), (0.0, 4.0)],
        10,
        materials.trim,
    );
    builder.darken_foot(0.75, 5.0);
    builder.finish("gate house")
}

/// Returns a round tower with rings of windows, merlons and a pointed roof.
pub(super) fn corner_tower(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let origin = Affine3A::IDENTITY;
    let radius = POST_HALF_M - 0.6;
    let segments = 28;
    let wall = materials.wall;
    builder.turned(
        &origin,
        &[(radius + 0.3, 0.0), (radius + 0.3, 1.2), (radius, 1.6)],
        segments,
        materials.stone,
    );
    let levels = [1.6, 5.6, 6.0, 10.2, 10.6, 14.8];
    for (storey, pair) in levels.windows(2).enumerate() {
        let low = pair[0];
        let high = pair[1];
        if storey % 2 == 0 {
            builder.turned(&origin, &[(radius, low), (radius, high)], segments, wall);
        } else {
            let profile =
                [(radius, low), (radius + 0.2, low), (radius + 0.2, high), (radius, high)];
            builder.turned(&origin, &profile, segments, materials.trim);
        }
    }
    let crown = [
        (radius, 14.8),
        (radius + 0.55, 15.6),
        (radius + 0.55, 16.8),
        (radius + 0.1, 16.8),
        (radius + 0.1, 16.0),
    ];
    builder.turned(&origin, &crown, segments, wall);
    builder.turned(
        &origin,
        &[(radius + 0.1, 16.0), (radius - 0.9, 16.0)],
        segments,
        materials.gravel,
    );
    builder.turned(&origin, &[(radius - 0.9, 16.0), (radius - 0.9, 18.0)], segments, wall);
    builder.turned(
        &origin,
        &[(radius - 0.9, 17.9), (radius - 0.5, 17.9), (0.0, 23.5)],
        segments,
        materials.tile,
    );
    for window in 0..24u8 {
        let ring = window / 8;
        let place = window % 8;
        let turn = std::f32::consts::TAU * (f32::from(place) + 0.5 * f32::from(ring % 2)) / 8.0;
        let frame = Frame::facing(turn, radius - 0.35);
        let low = 2.6 + 4.5 * f32::from(ring);
        builder.ledge(&frame, panel(-0.55, low, 0.55, low + 2.1), 0.55, materials.trim);
        let pane = panel(-0.4, low + 0.15, 0.4, low + 1.95);
        builder.ledge(&frame, pane, 0.59, materials.glass[usize::from(ring)]);
    }
    builder.darken_foot(0.75, 5.0);
    builder.finish("corner tower")
}
