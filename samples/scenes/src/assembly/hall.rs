//! Halls: a floor, walls with four gates, and a roof with strips of sky.

use std::f32::consts::FRAC_PI_2;

use glam::{Affine3A, vec3};
use scene::MeshId;

use super::super::builder::Paint;
use super::super::parts::PartId;
use super::super::solid::Solid;
use super::placer::{MeshList, Placer};

/// The distance between the middles of neighbouring halls, in metres.
pub(super) const PITCH_M: f32 = 24.0;

const HALF_M: f32 = 9.2;
const HEIGHT_M: f32 = 5.0;
const GATE_HALF_M: f32 = 1.6;

/// The meshes of a hall.
pub(super) struct HallMeshes {
    floor: MeshId,
    side: MeshId,
    gate_wall: MeshId,
    lintel: MeshId,
    roof: MeshId,
    beam: MeshId,
}

impl HallMeshes {
    pub(super) fn add(meshes: &mut MeshList) -> Self {
        let wall = Paint::srgb(0xAE_B6BC).tinted(0.5);
        let half = PITCH_M / 2.0;
        let floor = Solid::cuboid(vec3(-half, -0.3, -half), vec3(half, -0.02, half));
        let wide = (HALF_M - 0.12 - GATE_HALF_M) / 2.0;
        let wide_side = wide - 0.05;
        let side = Solid::cuboid(vec3(-wide_side, 0.0, -0.1), vec3(wide_side, HEIGHT_M, 0.1));
        let gate_wall = Solid::cuboid(vec3(-wide, 0.0, -0.1), vec3(wide, HEIGHT_M, 0.1));
        let lintel = Solid::cuboid(
            vec3(0.01 - GATE_HALF_M, 3.2, -0.09),
            vec3(GATE_HALF_M - 0.01, HEIGHT_M - 0.01, 0.09),
        );
        let roof = Solid::cuboid(vec3(-1.35, 0.0, -HALF_M), vec3(1.35, 0.18, HALF_M));
        let beam = Solid::cuboid(vec3(0.23 - HALF_M, -0.4, -0.08), vec3(HALF_M - 0.23, 0.0, 0.08));
        Self {
            floor: meshes.add(floor.mesh("floor", Paint::srgb(0x8B_8D8A).tinted(0.3))),
            side: meshes.add(side.mesh("side wall", wall)),
            gate_wall: meshes.add(gate_wall.mesh("gate wall", wall)),
            lintel: meshes.add(lintel.mesh("lintel", Paint::srgb(0xD8_A028).tinted(0.3))),
            roof: meshes.add(roof.mesh("roof", Paint::srgb(0x6E_7F8C).tinted(0.5))),
            beam: meshes.add(beam.mesh("beam", Paint::srgb(0x9A_4A2E).tinted(0.5))),
        }
    }

    pub(super) fn place(&self, placer: &mut Placer, hall: PartId, place: Affine3A) {
        let at = |x: f32, y: f32, z: f32| place * Affine3A::from_translation(vec3(x, y, z));
        placer.part(hall, "floor", self.floor, at(0.0, 0.0, 0.0));
        let shell = placer.group("shell".to_owned(), hall);
        let middle = (HALF_M - 0.12 + GATE_HALF_M) / 2.0;
        let out = HALF_M - 0.1;
        for side in 0..4_u8 {
            let turned = place * Affine3A::from_rotation_y(FRAC_PI_2 * f32::from(side));
            let at = |x: f32| turned * Affine3A::from_translation(vec3(x, 0.0, out));
            // The walls of two sides end at the walls of the other sides.
            let (wall, middle) = match side % 2 {
                0 => (self.gate_wall, middle),
                _ => (self.side, middle - 0.05),
            };
            for end in [-1.0, 1.0] {
                placer.part(shell, "wall", wall, at(end * middle));
            }
            placer.part(shell, "lintel", self.lintel, at(0.0));
        }
        for strip in [-2.0, -1.0, 0.0, 1.0, 2.0] {
            placer.part(shell, "roof", self.roof, at(strip * 3.4, HEIGHT_M + 0.03, 0.0));
        }
        for line in [-2.0, 0.0, 2.0] {
            placer.part(shell, "beam", self.beam, at(0.0, HEIGHT_M - 0.02, line * 3.0));
        }
    }
}
