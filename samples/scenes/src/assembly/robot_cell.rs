//! Robot cells: an arm of six axes behind a fence, a table with work, and a control cabinet.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Affine3A, Vec3, vec2, vec3};
use scene::MeshId;

use super::super::builder::Paint;
use super::super::parts::PartId;
use super::super::solid::Solid;
use super::placer::{MeshList, Placer};

/// Half the side of the fence, in metres, and the width of its panels.
const FENCE_M: f32 = 3.0;
const PANEL_M: f32 = 1.5;

/// The meshes of robot cells.
pub(super) struct RobotCellMeshes {
    post: MeshId,
    panel: MeshId,
    plinth: MeshId,
    turret: MeshId,
    arm: MeshId,
    forearm: MeshId,
    wrist: MeshId,
    joint: MeshId,
    drive: MeshId,
    finger: MeshId,
    table: MeshId,
    workpiece: MeshId,
    cabinet: MeshId,
    board: MeshId,
    chip: MeshId,
}

/// Returns a hollow box with walls of this thickness, in metres.
fn hollow(size: Vec3, wall: f32) -> Solid {
    Solid::centred(size).without(&Solid::centred(size - 2.0 * wall))
}

/// Returns a fence panel with a frame and bars, around its middle.
fn fence_panel() -> Solid {
    let mut panel = Solid::default();
    let width = PANEL_M - 0.08;
    for y in [-0.95, 0.95] {
        let bar = Solid::centred(vec3(width, 0.04, 0.03));
        panel = panel.and(&bar.placed(Affine3A::from_translation(vec3(0.0, y, 0.0))));
    }
    for number in 0..15_u8 {
        let bar = Solid::centred(vec3(0.012, 1.84, 0.012));
        let x = (f32::from(number) / 14.0 - 0.5) * (width - 0.03);
        panel = panel.and(&bar.placed(Affine3A::from_translation(vec3(x, 0.0, 0.0))));
    }
    panel
}

impl RobotCellMeshes {
    pub(super) fn add(meshes: &mut MeshList) -> Self {
        let orange = Paint::srgb(0xE0_6A1E).tinted(0.4);
        let dark = Paint::srgb(0x30_3338).tinted(0.5);
        let steel = Paint::srgb(0xB6_BBC0).tinted(0.5);
        let arm = Solid::turned(
            &[(0.10, 0.0), (0.13, 0.04), (0.11, 0.35), (0.09, 0.66), (0.07, 0.70)],
            28,
        );
        let forearm = Solid::turned(&[(0.09, 0.0), (0.10, 0.03), (0.06, 0.55), (0.05, 0.58)], 28);
        let plinth = Solid::turned(&[(0.34, 0.0), (0.34, 0.05), (0.24, 0.08), (0.22, 0.30)], 32);
        let turret = Solid::turned(&[(0.21, 0.0), (0.23, 0.03), (0.23, 0.20), (0.15, 0.28)], 32);
        let wrist = Solid::turned(&[(0.045, 0.0), (0.055, 0.02), (0.055, 0.12), (0.035, 0.14)], 24);
        let joint = hollow_drum(0.12, 0.15);
        let drive = Solid::turned(&[(0.06, -0.09), (0.07, -0.08), (0.07, 0.08), (0.06, 0.09)], 24);
        let cabinet = hollow(vec3(0.8, 1.6, 0.5), 0.02);
        let board = Solid::centred(vec3(0.6, 0.004, 0.36));
        let chip = Solid::centred(vec3(0.06, 0.012, 0.06));
        let table = Solid::centred(vec3(1.2, 0.06, 0.8));
        let workpiece = Solid::ring(vec2(0.03, 0.07), vec2(0.0, 0.05), 24);
        Self {
            post: meshes.add(Solid::centred(vec3(0.06, 2.2, 0.06)).mesh("fence post", dark)),
            panel: meshes
                .add(fence_panel().mesh("fence panel", Paint::srgb(0xE2_C022).tinted(0.3))),
            plinth: meshes.add(plinth.mesh("plinth", dark)),
            turret: meshes.add(turret.mesh("turret", orange)),
            arm: meshes.add(arm.mesh("upper arm", orange)),
            forearm: meshes.add(forearm.mesh("forearm", orange)),
            wrist: meshes.add(wrist.mesh("wrist", steel)),
            joint: meshes.add(joint.mesh("joint cover", dark)),
            drive: meshes.add(drive.mesh("joint drive", steel)),
            finger: meshes.add(Solid::centred(vec3(0.02, 0.10, 0.04)).mesh("finger", steel)),
            table: meshes.add(table.mesh("table", steel)),
            workpiece: meshes.add(workpiece.mesh("workpiece", Paint::srgb(0xA8_7F4A).tinted(0.5))),
            cabinet: meshes
                .add(cabinet.mesh("control cabinet", Paint::srgb(0xC8_CBC6).tinted(0.4))),
            board: meshes.add(board.mesh("board", Paint::srgb(0x23_6B3A).tinted(0.4))),
            chip: meshes.add(chip.mesh("module", dark)),
        }
    }

    /// Places a robot cell around the middle of its place.
    pub(super) fn place(&self, placer: &mut Placer, hall: PartId, place: Affine3A) {
        let cell = placer.group("robot cell".to_owned(), hall);
        let at = |x: f32, y: f32, z: f32| place * Affine3A::from_translation(vec3(x, y, z));
        self.place_robot(placer, cell, at(0.0, 0.0, -0.4));
        let work = placer.group("work".to_owned(), cell);
        placer.part(work, "table", self.table, at(0.3, 0.7, 1.2));
        for number in 0..8_u8 {
            let x = -0.15 + 0.28 * f32::from(number % 4);
            let z = if number < 4 { 1.05 } else { 1.35 };
            placer.part(work, "workpiece", self.workpiece, at(x, 0.735, z));
        }
        self.place_cabinet(placer, cell, at(-2.2, 0.0, -2.3));
        let fence = placer.group("fence".to_owned(), cell);
        for side in 0..4_u8 {
            let turned = place * Affine3A::from_rotation_y(TAU / 4.0 * f32::from(side));
            for number in 0..4_u8 {
                let x = -FENCE_M + PANEL_M * f32::from(number);
                let at = |x: f32, y: f32| turned * Affine3A::from_translation(vec3(x, y, FENCE_M));
                placer.part(fence, "fence post", self.post, at(x, 1.1));
                // Leave an entrance.
                if side != 0 || number != 3 {
                    placer.part(fence, "fence panel", self.panel, at(x + PANEL_M / 2.0, 1.2));
                }
            }
        }
    }

    /// Places the arm: each part is relative to the previous one, turned about its joint.
    fn place_robot(&self, placer: &mut Placer, cell: PartId, place: Affine3A) {
        let robot = placer.group("robot".to_owned(), cell);
        let up = |y: f32| Affine3A::from_translation(vec3(0.0, y, 0.0));
        let mut turn = |low: f32, high: f32| placer.random.between(low, high);
        let waist = turn(-1.2, 1.2);
        let shoulder = turn(-0.2, 0.7);
        let elbow = turn(0.9, 1.7);
        let bend = turn(-0.6, 0.6);
        placer.part(robot, "plinth", self.plinth, place * up(0.002));
        let turret = place * up(0.31) * Affine3A::from_rotation_y(waist);
        placer.part(robot, "turret", self.turret, turret);
        let on_turret = turret * up(0.45) * Affine3A::from_rotation_x(shoulder);
        self.place_joint(placer, robot, on_turret, 1.0);
        let arm = on_turret * up(0.135);
        placer.part(robot, "upper arm", self.arm, arm);
        let at_elbow = arm * up(0.84) * Affine3A::from_rotation_x(elbow);
        self.place_joint(placer, robot, at_elbow, 1.0);
        let forearm = at_elbow * up(0.135);
        placer.part(robot, "forearm", self.forearm, forearm);
        let at_wrist = forearm * up(0.66) * Affine3A::from_rotation_x(bend);
        self.place_joint(placer, robot, at_wrist, 0.55);
        let wrist = at_wrist * up(0.075);
        placer.part(robot, "wrist", self.wrist, wrist);
        for side in [-0.025, 0.025] {
            let finger = wrist * Affine3A::from_translation(vec3(side, 0.20, 0.0));
            placer.part(robot, "finger", self.finger, finger);
        }
    }

    /// Places a joint whose axis lies along x, with its drive inside.
    fn place_joint(&self, placer: &mut Placer, robot: PartId, place: Affine3A, size: f32) {
        let across =
            place * Affine3A::from_rotation_z(FRAC_PI_2) * Affine3A::from_scale(Vec3::splat(size));
        let joint = placer.group("joint".to_owned(), robot);
        placer.part(joint, "joint cover", self.joint, across);
        placer.part(joint, "joint drive", self.drive, across);
    }

    fn place_cabinet(&self, placer: &mut Placer, cell: PartId, place: Affine3A) {
        let cabinet = placer.group("control".to_owned(), cell);
        let at = |x: f32, y: f32, z: f32| place * Affine3A::from_translation(vec3(x, y, z));
        placer.part(cabinet, "control cabinet", self.cabinet, at(0.0, 0.81, 0.0));
        for number in 0..8_u8 {
            let y = 0.15 + 0.18 * f32::from(number);
            placer.part(cabinet, "board", self.board, at(0.0, y, 0.0));
            for x in [-0.2, 0.0, 0.2] {
                placer.part(cabinet, "module", self.chip, at(x, y + 0.010, 0.0));
            }
        }
    }
}

/// Returns a closed hollow drum about the y axis.
fn hollow_drum(radius: f32, half: f32) -> Solid {
    let drum = |inset: f32| {
        Solid::turned(
            &[
                (radius - 0.015 - inset, inset - half),
                (radius - inset, 0.015 + inset - half),
                (radius - inset, half - 0.015 - inset),
                (radius - 0.015 - inset, half - inset),
            ],
            28,
        )
    };
    drum(0.0).without(&drum(0.01))
}
