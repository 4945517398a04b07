//! Halls: a floor, walls with two gates, and a roof with strips of sky.

use glam::{Affine3A, vec3};
use scene::MeshId;

use super::super::builder::Paint;
use super::super::parts::PartId;
use super::super::solid::Solid;
use super::{MeshList, Placer};

/// The distance of the middles of halls, in metres.
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
        let side = Solid::cuboid(vec3(-0.1, 0.0, -HALF_M), vec3(0.1, HEIGHT_M, HALF_M));
        let wide = (HALF_M - 0.12 - GATE_HALF_M) / 2.0;
        let gate_wall = Solid::cuboid(vec3(-wide, 0.0, -0.1), vec3(wide, HEIGHT_M, 0.1));
        let lintel = Solid::cuboid(
            vec3(0.01 - GATE_HALF_M, 3.2, -0.09),
            vec3(GATE_HALF_M - 0.01, HEIGHT_M - 0.01, 0.09),
        );
        let roof = Solid::cuboid(vec3(-1.35, 0.0, -HALF_M), vec3(1.35, 0.18, HALF_M));
        let beam = Solid::cuboid(vec3(0.13 - HALF_M, -0.4, -0.08), vec3(HALF_M - 0.13, 0.0, 0.08));
        Self {
            floor: meshes.add(floor.mesh("floor", Paint::srgb(0x8B_8D8A).tinted(0.3))),
            side: meshes.add(side.mesh("wall", wall)),
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
        for side in [-1.0, 1.0] {
            placer.part(shell, "wall", self.side, at(side * HALF_M, 0.0, 0.0));
            let z = side * (HALF_M - 0.1);
            for end in [-1.0, 1.0] {
                placer.part(shell, "gate wall", self.gate_wall, at(end * middle, 0.0, z));
            }
            placer.part(shell, "lintel", self.lintel, at(0.0, 0.0, z));
        }
        for strip in [-2.0, -1.0, 0.0, 1.0, 2.0] {
            placer.part(shell, "roof", self.roof, at(strip * 3.4, HEIGHT_M + 0.03, 0.0));
        }
        for line in [-2.0, 0.0, 2.0] {
            placer.part(shell, "beam", self.beam, at(0.0, HEIGHT_M - 0.02, line * 3.0));
        }
    }
}
