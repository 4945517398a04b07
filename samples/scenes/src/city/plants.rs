//! Trees and planters.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};
use scene::Mesh;

use super::super::builder::{Faces, MeshBuilder, Paint};
use super::palette::Materials;

fn leaves() -> [Paint; 2] {
    let light = Paint::srgb(0xFF_FFFF).tinted(1.0);
    [light.shade(0.42), light]
}

fn trunk(builder: &mut MeshBuilder, materials: &Materials, radius: f32, height: f32) {
    let profile =
        [(radius * 1.6, 0.0), (radius * 1.1, 0.35), (radius, height * 0.6), (radius * 0.7, height)];
    builder.turned(&Affine3A::IDENTITY, &profile, 8, materials.wood.shade(0.55));
}

fn crown(builder: &mut MeshBuilder, parts: &[(Vec3, Vec2)]) {
    for &(centre, radii) in parts {
        builder.ellipsoid(centre, radii, [10, 7], leaves());
    }
}

/// Returns a street tree with a round, lumpy crown.
pub(super) fn round_tree(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    trunk(&mut builder, materials, 0.16, 3.6);
    crown(
        &mut builder,
        &[
            (vec3(0.0, 4.6, 0.0), vec2(1.35, 1.5)),
            (vec3(0.7, 4.1, 0.3), vec2(1.0, 0.95)),
            (vec3(-0.65, 4.2, 0.45), vec2(1.05, 1.0)),
            (vec3(0.1, 4.0, -0.75), vec2(1.0, 0.95)),
        ],
    );
    builder.finish("round tree")
}

/// Returns a poplar: tall and slender.
pub(super) fn tall_tree(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    trunk(&mut builder, materials, 0.14, 3.0);
    crown(
        &mut builder,
        &[
            (vec3(0.0, 4.6, 0.0), vec2(1.05, 2.9)),
            (vec3(0.35, 3.3, 0.3), vec2(0.85, 1.6)),
            (vec3(-0.35, 3.5, -0.2), vec2(0.85, 1.7)),
        ],
    );
    builder.finish("tall tree")
}

/// Returns a tree with branches that carry separate, flat crowns.
pub(super) fn spreading_tree(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    trunk(&mut builder, materials, 0.18, 4.4);
    let boughs = [(0.95, 3.9, 0.2), (-0.8, 4.3, 0.55), (-0.1, 4.0, -0.95)];
    for (x, y, z) in boughs {
        let root = Vec3::Y * 2.4;
        let tip = vec3(x, y, z);
        let turn = glam::Quat::from_rotation_arc(Vec3::Y, (tip - root).normalize_or_zero());
        let place = Affine3A::from_rotation_translation(turn, root);
        let profile = [(0.08, 0.0), (0.05, (tip - root).length())];
        builder.turned(&place, &profile, 6, materials.wood.shade(0.55));
    }
    crown(
        &mut builder,
        &[
            (vec3(0.95, 4.1, 0.2), vec2(0.9, 0.6)),
            (vec3(-0.8, 4.5, 0.55), vec2(1.0, 0.65)),
            (vec3(-0.1, 4.2, -0.9), vec2(0.95, 0.6)),
            (vec3(0.05, 5.3, 0.0), vec2(1.25, 0.75)),
        ],
    );
    builder.finish("spreading tree")
}

/// Returns a concrete trough with three shrubs.
pub(super) fn planter(materials: &Materials) -> Mesh {
    let mut builder = MeshBuilder::default();
    let stone = materials.stone.tinted(0.0);
    let half = vec2(1.2, 0.45);
    let high = 0.6;
    builder.tapered(
        vec3(-half.x, 0.0, -half.y),
        vec3(half.x, high - 0.1, half.y),
        Vec2::splat(0.05),
        Faces::Sides,
        stone,
    );
    builder.band(half - Vec2::splat(0.05), 0.07, [high - 0.12, high], stone.shade(1.1));
    builder.cuboid(
        vec3(-half.x + 0.05, high - 0.1, -half.y + 0.05),
        vec3(half.x - 0.05, high, half.y - 0.05),
        Faces::Standing,
        materials.wood.shade(0.35),
    );
    crown(
        &mut builder,
        &[
            (vec3(-0.72, 0.8, 0.0), vec2(0.4, 0.42)),
            (vec3(0.02, 0.9, 0.03), vec2(0.42, 0.5)),
            (vec3(0.72, 0.78, -0.02), vec2(0.4, 0.38)),
        ],
    );
    builder.finish("planter")
}
