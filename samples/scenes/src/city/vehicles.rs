//! Parked cars. They face +x.

use glam::{Vec2, Vec3, vec2, vec3};
use scene::Mesh;

use super::super::builder::{Faces, MeshBuilder, Paint};
use super::palette::Materials;

/// A car's side view, from bumper to bumper, in metres along x and above the road.
struct Shape {
    name: &'static str,
    half_length: f32,
    half_width: f32,
    /// The body below the windows: (x, y), convex.
    body: &'static [(f32, f32)],
    /// The windows' outline, convex.
    cabin: &'static [(f32, f32)],
    axles: [f32; 2],
    wheel: f32,
}

pub(super) fn saloon(materials: &Materials) -> Mesh {
    car(
        &Shape {
            name: "saloon",
            half_length: 2.2,
            half_width: 0.84,
            body: &[
                (-2.18, 0.32),
                (2.15, 0.3),
                (2.2, 0.55),
                (2.1, 0.76),
                (0.9, 0.93),
                (-1.9, 0.96),
                (-2.15, 0.85),
            ],
            cabin: &[(-1.6, 0.9), (1.05, 0.88), (0.35, 1.4), (-0.75, 1.43), (-0.95, 1.38)],
            axles: [-1.35, 1.4],
            wheel: 0.32,
        },
        materials,
    )
}

/// Returns a small car with a steep back.
pub(super) fn hatchback(materials: &Materials) -> Mesh {
    car(
        &Shape {
            name: "hatchback",
            half_length: 1.9,
            half_width: 0.82,
            body: &[
                (-1.88, 0.32),
                (1.86, 0.3),
                (1.9, 0.55),
                (1.8, 0.78),
                (0.95, 0.95),
                (-1.7, 1.0),
                (-1.88, 0.8),
            ],
            cabin: &[(-1.66, 0.95), (1.15, 0.9), (0.4, 1.46), (-1.1, 1.5), (-1.3, 1.44)],
            axles: [-1.2, 1.22],
            wheel: 0.31,
        },
        materials,
    )
}

/// Returns a delivery van.
pub(super) fn van(materials: &Materials) -> Mesh {
    car(
        &Shape {
            name: "van",
            half_length: 2.25,
            half_width: 0.86,
            body: &[
                (-2.24, 0.36),
                (2.2, 0.34),
                (2.25, 0.6),
                (2.15, 0.95),
                (1.6, 1.15),
                (-2.2, 1.2),
            ],
            cabin: &[
                (-2.2, 1.1),
                (1.75, 1.05),
                (1.1, 1.95),
                (0.9, 2.0),
                (-2.1, 2.02),
                (-2.18, 1.95),
            ],
            axles: [-1.4, 1.45],
            wheel: 0.34,
        },
        materials,
    )
}

/// Adds a convex side view, extruded to both sides; its edges are bevelled by `bevel` towards the
/// flanks.
fn hull(
    builder: &mut MeshBuilder,
    outline: &[(f32, f32)],
    half_width: f32,
    bevel: f32,
    paint: Paint,
) {
    let points: Vec<Vec2> = outline.iter().map(|&(x, y)| vec2(x, y)).collect();
    let middle = points.iter().sum::<Vec2>() / points.len() as f32;
    let drawn_in = |point: Vec2| {
        let inward = middle - point;
        point + inward.normalize_or_zero() * bevel
    };
    for (position, &point) in points.iter().enumerate() {
        let next = points[(position + 1) % points.len()];
        let inner = drawn_in(point);
        let inner_next = drawn_in(next);
        let shoulder = half_width - bevel;
        let wide = |point: Vec2, z: f32| vec3(point.x, point.y, z);
        builder.polygon(
            &[
                wide(point, shoulder),
                wide(point, -shoulder),
                wide(next, -shoulder),
                wide(next, shoulder),
            ],
            paint,
        );
        builder.polygon(
            &[
                wide(point, shoulder),
                wide(next, shoulder),
                wide(inner_next, half_width),
                wide(inner, half_width),
            ],
            paint,
        );
        builder.polygon(
            &[
                wide(next, -shoulder),
                wide(point, -shoulder),
                wide(inner, -half_width),
                wide(inner_next, -half_width),
            ],
            paint,
        );
    }
    let flank =
        |z: f32| points.iter().map(|&point| drawn_in(point).extend(z)).collect::<Vec<Vec3>>();
    builder.polygon(&flank(half_width), paint);
    let far: Vec<Vec3> = flank(-half_width).into_iter().rev().collect();
    builder.polygon(&far, paint);
}

/// Adds a thin plate on a face of a hull, sunk into it so that its back is never visible.
fn plate(builder: &mut MeshBuilder, corners: [Vec3; 4], paint: Paint) {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
    let front = corners.map(|corner| corner + normal * 0.012);
    let sunk = corners.map(|corner| corner - normal * 0.02);
    builder.polygon(&front, paint);
    for corner in 0..4 {
        let next = (corner + 1) % 4;
        builder.polygon(&[sunk[corner], sunk[next], front[next], front[corner]], paint);
    }
}

/// Adds a window with a frame around it, within the face with these corners.
fn pane(builder: &mut MeshBuilder, corners: [Vec3; 4], paint: Paint) {
    let middle = corners.iter().sum::<Vec3>() / 4.0;
    plate(builder, corners.map(|corner| corner.lerp(middle, 0.14)), paint);
}

fn car(shape: &Shape, materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let coat = materials.coat.shade(0.85);
    let glass = materials.glass[0].shade(0.8);
    let half_width = shape.half_width;
    hull(&mut builder, shape.body, half_width, 0.07, coat);
    let cabin_half = half_width - 0.1;
    hull(&mut builder, shape.cabin, cabin_half, 0.1, coat);
    windows(&mut builder, shape, cabin_half, glass);
    for &axle in &shape.axles {
        for side in [-1.0f32, 1.0] {
            wheel(
                &mut builder,
                vec3(axle, shape.wheel, side * (half_width - 0.1)),
                side,
                shape.wheel,
                materials,
            );
        }
    }
    let low = 0.34;
    for side in [-1.0f32, 1.0] {
        let bumper = vec3(side * (shape.half_length - 0.08), low, 0.0);
        builder.cuboid(
            bumper - vec3(0.12, 0.0, half_width - 0.12),
            bumper + vec3(0.12, 0.16, half_width - 0.12),
            Faces::All,
            materials.iron,
        );
        let light = if side > 0.0 { Paint::srgb(0xF2_EEDC) } else { Paint::srgb(0x9A_2420) };
        for z in [-0.55f32, 0.55] {
            let place = vec3(side * (shape.half_length - 0.16), 0.62, z);
            builder.cuboid(
                place - vec3(0.13, 0.06, 0.13),
                place + vec3(0.13, 0.06, 0.13),
                Faces::All,
                light,
            );
        }
    }
    builder.finish(shape.name)
}

fn windows(builder: &mut MeshBuilder, shape: &Shape, half: f32, glass: Paint) {
    let [rear_foot, front_foot, front_top, .., rear_top] = shape.cabin else { return };
    let shoulder = half - 0.1;
    let at = |point: &(f32, f32), z: f32| vec3(point.0, point.1, z);
    pane(
        builder,
        [
            at(front_foot, shoulder),
            at(front_foot, -shoulder),
            at(front_top, -shoulder),
            at(front_top, shoulder),
        ],
        glass,
    );
    pane(
        builder,
        [
            at(rear_foot, -shoulder),
            at(rear_foot, shoulder),
            at(rear_top, shoulder),
            at(rear_top, -shoulder),
        ],
        glass,
    );
    let belt = front_foot.1.max(rear_foot.1) + 0.12;
    let top = front_top.1.min(rear_top.1) - 0.14;
    let rear = rear_foot.0 + 0.35;
    let front = front_foot.0 - 0.45;
    let rear_high = rear_top.0.max(rear_foot.0 + 0.35) + 0.1;
    let front_high = front_top.0 - 0.02;
    let split = (rear + front) / 2.0;
    for (from, to) in [
        ([rear, rear_high], [split - 0.06, split - 0.06]),
        ([split + 0.06, split + 0.06], [front, front_high]),
    ] {
        let quad = [(from[0], belt), (to[0], belt), (to[1], top), (from[1], top)];
        plate(builder, quad.map(|(x, y)| vec3(x, y, half)), glass);
        let mut far = quad.map(|(x, y)| vec3(x, y, -half));
        far.reverse();
        plate(builder, far, glass);
    }
}

fn wheel(builder: &mut MeshBuilder, centre: Vec3, side: f32, radius: f32, materials: &Materials) {
    let turn = glam::Quat::from_rotation_x(side * std::f32::consts::FRAC_PI_2);
    let place = glam::Affine3A::from_rotation_translation(turn, centre);
    let tyre = [
        (0.0, -0.12),
        (radius, -0.12),
        (radius, 0.1),
        (radius - 0.05, 0.13),
        (radius * 0.62, 0.13),
    ];
    builder.turned(&place, &tyre, 12, materials.iron.shade(0.5));
    let rim = [(radius * 0.62, 0.13), (radius * 0.55, 0.1), (radius * 0.2, 0.12), (0.0, 0.13)];
    builder.turned(&place, &rim, 12, materials.steel);
}
