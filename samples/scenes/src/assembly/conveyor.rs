//! Conveyors: two rails on legs, rollers in bearings, and a belt around them with parcels.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine3A, Vec3, vec2, vec3};
use scene::MeshId;

use super::super::builder::Paint;
use super::super::parts::PartId;
use super::super::solid::Solid;
use super::placer::{MeshList, Placer};

const LENGTH_M: f32 = 6.0;
const HALF_WIDTH_M: f32 = 0.35;
const HEIGHT_M: f32 = 0.8;
const ROLLERS: u8 = 30;
const ROLLER_RADIUS_M: f32 = 0.04;

/// The meshes of conveyors.
pub(super) struct ConveyorMeshes {
    rail: MeshId,
    leg: MeshId,
    foot: MeshId,
    strut: MeshId,
    roller: MeshId,
    bearing: MeshId,
    belt: MeshId,
    motor: MeshId,
    guard: MeshId,
    parcels: [MeshId; 3],
}

/// Returns a loop around all rollers with the outline of a belt: straight above and below, and
/// round at the ends. It lies in the x-z plane with its width along y.
fn belt() -> Solid {
    let ring = |radius: f32| -> Vec<Vec3> {
        let half = LENGTH_M / 2.0 - 0.1;
        let end = |sign: f32| {
            (0..=12_u8).map(move |step| {
                let (sin, cos) = (PI * f32::from(step) / 12.0 - FRAC_PI_2).sin_cos();
                vec3(sign * (half + radius * cos), 0.0, -sign * radius * sin)
            })
        };
        end(1.0).chain(end(-1.0)).collect()
    };
    let width = HALF_WIDTH_M - 0.05;
    Solid::pierced(
        &ring(ROLLER_RADIUS_M + 0.009),
        &ring(ROLLER_RADIUS_M + 0.003),
        vec2(-width, width),
    )
}

impl ConveyorMeshes {
    pub(super) fn add(meshes: &mut MeshList) -> Self {
        let yellow = Paint::srgb(0xD9_9A21).tinted(0.5);
        let steel = Paint::srgb(0xAF_B5BB).tinted(0.5);
        let dark = Paint::srgb(0x35_383C).tinted(0.5);
        let rail = Solid::centred(vec3(LENGTH_M, 0.14, 0.03));
        let leg = Solid::centred(vec3(0.06, HEIGHT_M - 0.11, 0.06));
        let foot = Solid::turned(&[(0.06, 0.0), (0.06, 0.012), (0.02, 0.02)], 16);
        let strut = Solid::centred(vec3(0.04, 0.04, 2.0 * HALF_WIDTH_M - 0.07));
        let half = HALF_WIDTH_M - 0.035;
        let roller = [
            (0.012, -half),
            (0.012, 0.02 - half),
            (ROLLER_RADIUS_M, 0.022 - half),
            (ROLLER_RADIUS_M, half - 0.022),
            (0.012, half - 0.02),
            (0.012, half),
        ];
        let roller = Solid::turned(&roller, 20);
        let bearing = Solid::ring(vec2(0.0125, 0.028), vec2(-0.007, 0.007), 20);
        let motor =
            [(0.0, 0.0), (0.07, 0.0), (0.09, 0.02), (0.09, 0.22), (0.08, 0.24), (0.0, 0.24)];
        let motor = Solid::turned(&motor, 24);
        let guard = Solid::centred(vec3(LENGTH_M - 0.4, 0.06, 0.015));
        let parcel = |size: Vec3, hex: u32, name: &str| {
            let solid = Solid::cuboid(size * vec3(-0.5, 0.0, -0.5), size * vec3(0.5, 1.0, 0.5));
            solid.mesh(name, Paint::srgb(hex).tinted(0.8))
        };
        Self {
            rail: meshes.add(rail.mesh("rail", yellow)),
            leg: meshes.add(leg.mesh("leg", yellow)),
            foot: meshes.add(foot.mesh("foot", dark)),
            strut: meshes.add(strut.mesh("strut", yellow)),
            roller: meshes.add(roller.mesh("roller", steel)),
            bearing: meshes.add(bearing.mesh("roller bearing", dark)),
            belt: meshes.add(belt().mesh("belt", dark)),
            motor: meshes.add(motor.mesh("motor", Paint::srgb(0x2C_6AA0).tinted(0.4))),
            guard: meshes.add(guard.mesh("guard", steel)),
            parcels: [
                meshes.add(parcel(vec3(0.4, 0.3, 0.3), 0xB0_8456, "carton")),
                meshes.add(parcel(vec3(0.3, 0.18, 0.4), 0xA2_7A50, "flat carton")),
                meshes.add(parcel(vec3(0.35, 0.22, 0.35), 0x3A_6EA5, "crate")),
            ],
        }
    }

    /// Places a conveyor along x.
    pub(super) fn place(&self, placer: &mut Placer, hall: PartId, place: Affine3A) {
        let conveyor = placer.group("conveyor".to_owned(), hall);
        let at = |x: f32, y: f32, z: f32| place * Affine3A::from_translation(vec3(x, y, z));
        let frame = placer.group("frame".to_owned(), conveyor);
        let sides = [-1.0, 1.0];
        for side in sides {
            placer.part(frame, "rail", self.rail, at(0.0, HEIGHT_M, side * HALF_WIDTH_M));
        }
        for step in [-1.5, -0.5, 0.5, 1.5] {
            let x = step * 1.7;
            for side in sides {
                let z = side * HALF_WIDTH_M;
                let middle = (HEIGHT_M - 0.11) / 2.0 + 0.03;
                placer.part(frame, "leg", self.leg, at(x, middle, z));
                placer.part(frame, "foot", self.foot, at(x, 0.002, z));
            }
            placer.part(frame, "strut", self.strut, at(x, 0.35, 0.0));
        }
        let across =
            |x: f32, z: f32| at(x, HEIGHT_M + 0.02, z) * Affine3A::from_rotation_x(FRAC_PI_2);
        placer.part(conveyor, "belt", self.belt, across(0.0, 0.0));
        self.place_load(placer, conveyor, place);
        let rollers = placer.group("rollers".to_owned(), conveyor);
        let step = (LENGTH_M - 0.2) / f32::from(ROLLERS - 1);
        for number in 0..ROLLERS {
            let x = 0.1 - LENGTH_M / 2.0 + step * f32::from(number);
            placer.part(rollers, "roller", self.roller, across(x, 0.0));
            for side in sides {
                let z = side * (HALF_WIDTH_M - 0.025);
                placer.part(rollers, "roller bearing", self.bearing, across(x, z));
            }
        }
    }

    /// Places the drive, the guards and the parcels on the belt.
    fn place_load(&self, placer: &mut Placer, conveyor: PartId, place: Affine3A) {
        let at = |x: f32, y: f32, z: f32| place * Affine3A::from_translation(vec3(x, y, z));
        let drive = at(-LENGTH_M / 2.0 + 0.9, HEIGHT_M - 0.02, HALF_WIDTH_M + 0.03);
        placer.part(conveyor, "motor", self.motor, drive * Affine3A::from_rotation_x(FRAC_PI_2));
        for side in [-1.0, 1.0] {
            let guard = at(0.0, HEIGHT_M + 0.2, side * (HALF_WIDTH_M + 0.01));
            placer.part(conveyor, "guard", self.guard, guard);
        }
        let load = placer.group("load".to_owned(), conveyor);
        for number in 0..7_u8 {
            let parcel = placer.random.pick(&self.parcels);
            let x = -2.55 + 0.85 * f32::from(number) + placer.random.between(-0.1, 0.1);
            let turn = Affine3A::from_rotation_y(placer.random.between(-0.25, 0.25));
            let top = HEIGHT_M + 0.02 + ROLLER_RADIUS_M + 0.012;
            placer.part(load, "parcel", parcel, at(x, top, 0.0) * turn);
        }
    }
}
