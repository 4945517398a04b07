//! Gear boxes of two stages in housings of plates, in racks with doors.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};
use scene::MeshId;

use super::super::builder::Paint;
use super::super::parts::PartId;
use super::super::solid::{Solid, circle, rectangle_and_hole};
use super::placer::{MeshList, Placer};

/// The pitch diameter of a gear per tooth, in metres.
const MODULE_M: f32 = 0.004;
const PINION_TEETH: u32 = 17;
const WHEEL_TEETH: u32 = 40;
/// The distance of two shafts: the sum of the pitch radii.
const SHAFTS_M: f32 = (PINION_TEETH + WHEEL_TEETH) as f32 * MODULE_M / 2.0;
const SHAFT_RADIUS_M: f32 = 0.012;
const GEAR_WIDTH_M: f32 = 0.030;

/// The inside of a housing: half of its extents along x, y and z, in metres.
const INSIDE: Vec3 = Vec3::new(0.215, 0.098, 0.066);
const WALL_M: f32 = 0.010;
const GAP_M: f32 = 0.002;

/// The numbers of places in a rack along x, y and z, and the distances between them, in metres.
const RACK: [u8; 3] = [8, 5, 3];
const CELL: Vec3 = Vec3::new(0.70, 0.46, 0.44);

/// The meshes of gear boxes and of their racks.
pub(super) struct GearBoxMeshes {
    base: MeshId,
    cover: MeshId,
    side: MeshId,
    end: MeshId,
    pinion: MeshId,
    wheel: MeshId,
    shaft: MeshId,
    long_shaft: MeshId,
    bearing: MeshId,
    coupling: MeshId,
    bolt: MeshId,
    shelf: MeshId,
    post: MeshId,
    back_panel: MeshId,
    side_panel: MeshId,
    door: MeshId,
    handle: MeshId,
}

/// Returns a spur gear about the y axis with trapezoidal teeth and a bore for a shaft. One tooth
/// points along x.
fn gear(teeth: u32) -> Solid {
    let pitch = teeth as f32 * MODULE_M / 2.0;
    let root = pitch - 1.25 * MODULE_M;
    let tip = pitch + 0.9 * MODULE_M;
    // A tooth in shares of its pitch: its flanks are slanted, and it is narrower than its gap.
    let profile = [(-0.27, root), (-0.10, tip), (0.10, tip), (0.27, root)];
    let corners = (0..teeth).flat_map(|tooth| {
        profile
            .map(|(share, radius)| Vec2::new(TAU * (tooth as f32 + share) / teeth as f32, radius))
    });
    let corners: Vec<Vec2> = corners.collect();
    let at = |turn: f32, radius: f32| vec3(radius * turn.cos(), 0.0, -radius * turn.sin());
    let outline: Vec<Vec3> = corners.iter().map(|corner| at(corner.x, corner.y)).collect();
    let bore = SHAFT_RADIUS_M + 0.0004;
    let hole: Vec<Vec3> = corners.iter().map(|corner| at(corner.x, bore)).collect();
    Solid::pierced(&outline, &hole, vec2(-GEAR_WIDTH_M / 2.0, GEAR_WIDTH_M / 2.0))
}

/// Returns an end plate about the y axis, with a bore for the first shaft.
fn end_plate() -> Solid {
    let half = vec2(INSIDE.x + WALL_M, INSIDE.y);
    let [outline, hole] = rectangle_and_hole(-half, half, vec2(-SHAFTS_M, 0.0), 0.018, 8);
    Solid::pierced(&outline, &hole, vec2(0.0, WALL_M))
}

impl GearBoxMeshes {
    pub(super) fn add(meshes: &mut MeshList) -> Self {
        let steel = Paint::srgb(0xB4_B9BE).tinted(0.6);
        let brass = Paint::srgb(0xC8_A24C).tinted(0.5);
        let green = Paint::srgb(0x3F_7A5B).tinted(0.7);
        let dark = Paint::srgb(0x3C_4046).tinted(0.6);
        let grey = Paint::srgb(0x8E_9AA5).tinted(0.6);
        let outer = INSIDE + WALL_M;
        let base = Solid::centred(vec3(2.0 * outer.x + 0.06, WALL_M, 2.0 * outer.z));
        let cover = Solid::centred(vec3(2.0 * outer.x, WALL_M, 2.0 * outer.z));
        let side = Solid::centred(vec3(WALL_M, 2.0 * INSIDE.y, 2.0 * INSIDE.z));
        let shaft = |half: f32| {
            let r = SHAFT_RADIUS_M;
            Solid::turned(
                &[(r - 0.002, -half), (r, 0.002 - half), (r, half - 0.002), (r - 0.002, half)],
                20,
            )
        };
        let long_shaft =
            shaft(INSIDE.z + 0.030).placed(Affine3A::from_translation(vec3(0.0, 0.034, 0.0)));
        let bearing = Solid::ring(vec2(SHAFT_RADIUS_M + 0.0004, 0.026), vec2(-0.005, 0.005), 24);
        let coupling = Solid::turned(
            &[(0.026, 0.0), (0.028, 0.002), (0.028, 0.016), (0.02, 0.019), (0.02, 0.034)],
            24,
        );
        let hexagon = |y: f32| circle(0.006, y, 6);
        let bolt = Solid::loft(&[hexagon(0.0), hexagon(0.004), circle(0.0048, 0.005, 6)]);
        let size = rack_size();
        let shelf = Solid::centred(vec3(size.x, 0.03, size.z));
        let post = Solid::centred(vec3(0.05, size.y, 0.05));
        let back_panel = Solid::centred(vec3(size.x + 0.10, size.y, 0.01));
        let side_panel = Solid::centred(vec3(0.01, size.y, size.z + 0.02));
        let door = Solid::centred(vec3(size.x / 4.0 - 0.01, size.y - 0.02, 0.02));
        let handle = Solid::centred(vec3(0.03, 0.3, 0.04));
        Self {
            base: meshes.add(base.mesh("base plate", green)),
            cover: meshes.add(cover.mesh("cover", green)),
            side: meshes.add(side.mesh("side plate", green)),
            end: meshes.add(end_plate().mesh("end plate", green)),
            pinion: meshes.add(gear(PINION_TEETH).mesh("pinion", steel)),
            wheel: meshes.add(gear(WHEEL_TEETH).mesh("wheel", brass)),
            shaft: meshes.add(shaft(INSIDE.z - GAP_M).mesh("shaft", steel)),
            long_shaft: meshes.add(long_shaft.mesh("long shaft", steel)),
            bearing: meshes.add(bearing.mesh("bearing", dark)),
            coupling: meshes.add(coupling.mesh("coupling", dark)),
            bolt: meshes.add(bolt.mesh("bolt", dark)),
            shelf: meshes.add(shelf.mesh("shelf", grey)),
            post: meshes.add(post.mesh("post", dark)),
            back_panel: meshes.add(back_panel.mesh("back panel", grey)),
            side_panel: meshes.add(side_panel.mesh("side panel", grey)),
            door: meshes.add(door.mesh("door", Paint::srgb(0x2F_5E8E).tinted(0.5))),
            handle: meshes.add(handle.mesh("handle", dark)),
        }
    }

    /// Places a rack with gear boxes, as far as parts are left.
    pub(super) fn place_rack(&self, placer: &mut Placer, hall: PartId, place: Affine3A) {
        let rack = placer.group("rack of gear boxes".to_owned(), hall);
        self.place_cabinet(placer, rack, place);
        let [columns, levels, rows] = RACK;
        for level in 0..levels {
            for row in 0..rows {
                for column in 0..columns {
                    if placer.left == 0 {
                        return;
                    }
                    let step =
                        |number: u8, count: u8| f32::from(number) + 0.5 - f32::from(count) / 2.0;
                    let y = 0.089 + CELL.y * f32::from(level) + INSIDE.y + WALL_M + GAP_M;
                    let middle = vec3(step(column, columns) * CELL.x, y, step(row, rows) * CELL.z);
                    let turn = if placer.random.below(2) == 0 { 0.0 } else { PI };
                    let at = Affine3A::from_rotation_translation(
                        glam::Quat::from_rotation_y(turn),
                        middle,
                    );
                    self.place_gear_box(placer, rack, place * at);
                }
            }
        }
    }

    fn place_cabinet(&self, placer: &mut Placer, rack: PartId, place: Affine3A) {
        let size = rack_size();
        let cabinet = placer.group("cabinet".to_owned(), rack);
        let at = |x: f32, y: f32, z: f32| place * Affine3A::from_translation(vec3(x, y, z));
        let middle = size.y / 2.0 + 0.01;
        placer.part(cabinet, "back panel", self.back_panel, at(0.0, middle, -size.z / 2.0 - 0.02));
        for side in [-1.0, 1.0] {
            let x = side * (size.x / 2.0 + 0.06);
            placer.part(cabinet, "side panel", self.side_panel, at(x, middle, 0.0));
        }
        for level in 0..=RACK[1] {
            let y = 0.07 + CELL.y * f32::from(level);
            placer.part(cabinet, "shelf", self.shelf, at(0.0, y, 0.0));
        }
        for (number, door) in (0_u8..).zip([self.door; 4]) {
            // One of the doors is open.
            let is_open = u32::from(number) == placer.random.below(6);
            let x = size.x / 4.0 * (f32::from(number) - 1.5);
            let z = size.z / 2.0 + 0.04;
            let turn = if is_open { 1.2 } else { 0.0 };
            let swing = Affine3A::from_translation(vec3(-size.x / 8.0, 0.0, 0.0));
            let back = Affine3A::from_translation(vec3(size.x / 8.0, 0.0, 0.0));
            let leaf = at(x, middle, z) * swing * Affine3A::from_rotation_y(-turn) * back;
            placer.part(cabinet, "door", door, leaf);
            let grip = leaf * Affine3A::from_translation(vec3(size.x / 8.0 - 0.1, 0.0, 0.034));
            placer.part(cabinet, "handle", self.handle, grip);
        }
        for corner in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let x = corner.0 * (size.x / 2.0 + 0.028);
            let z = corner.1 * (size.z / 2.0 - 0.03);
            placer.part(cabinet, "post", self.post, at(x, middle, z));
        }
    }

    /// Places a gear box around the origin of its place, with its shafts along z.
    fn place_gear_box(&self, placer: &mut Placer, rack: PartId, place: Affine3A) {
        let gear_box = placer.group("gear box".to_owned(), rack);
        let at = |x: f32, y: f32, z: f32| place * Affine3A::from_translation(vec3(x, y, z));
        let along_z = |x: f32, z: f32| at(x, 0.0, z) * Affine3A::from_rotation_x(FRAC_PI_2);
        let housing = placer.group("housing".to_owned(), gear_box);
        let level = INSIDE.y + WALL_M / 2.0 + GAP_M;
        placer.part(housing, "base plate", self.base, at(0.0, -level, 0.0));
        placer.part(housing, "cover", self.cover, at(0.0, level, 0.0));
        for side in [-1.0, 1.0] {
            let x = side * (INSIDE.x + WALL_M / 2.0);
            placer.part(housing, "side plate", self.side, at(x, 0.0, 0.0));
        }
        placer.part(housing, "front plate", self.end, along_z(0.0, INSIDE.z + GAP_M));
        let turned = place * Affine3A::from_rotation_y(PI);
        let back = Affine3A::from_translation(vec3(0.0, 0.0, INSIDE.z + GAP_M));
        let back = turned * back * Affine3A::from_rotation_x(FRAC_PI_2);
        placer.part(housing, "back plate", self.end, back);
        let train = placer.group("gear train".to_owned(), gear_box);
        self.place_train(placer, train, place);
        let bolts = placer.group("bolts".to_owned(), gear_box);
        let y = level + WALL_M / 2.0 + 0.001;
        for x in [-0.205, 0.0, 0.205] {
            for z in [-0.062, 0.062] {
                placer.part(bolts, "bolt", self.bolt, at(x, y, z));
            }
        }
        for x in [-0.245, 0.245] {
            for z in [-0.05, 0.05] {
                let y = -level + WALL_M / 2.0 + 0.001;
                placer.part(bolts, "bolt", self.bolt, at(x, y, z));
            }
        }
        for z in [-1.0, 1.0] {
            for x in [-0.21, 0.21] {
                let facing = at(x, 0.07, z * (INSIDE.z + WALL_M + GAP_M + 0.001));
                let facing = facing * Affine3A::from_rotation_x(z * FRAC_PI_2);
                placer.part(bolts, "bolt", self.bolt, facing);
            }
        }
    }

    /// Places three shafts with two pairs of gears, their bearings, and couplings at both ends.
    fn place_train(&self, placer: &mut Placer, train: PartId, place: Affine3A) {
        let along_z = |x: f32, z: f32, turn: f32| {
            let at = Affine3A::from_translation(vec3(x, 0.0, z));
            place * at * Affine3A::from_rotation_x(FRAC_PI_2) * Affine3A::from_rotation_y(turn)
        };
        let turn = placer.random.between(0.0, TAU);
        let mesh_turn = |turn: f32, teeth: u32, other: u32| {
            // A tooth of one gear meets a gap of the other on the line between their axes.
            let pitch = TAU / other as f32;
            PI - turn * teeth as f32 / other as f32 + pitch / 2.0
        };
        let second = mesh_turn(turn, PINION_TEETH, WHEEL_TEETH);
        let third = mesh_turn(second, PINION_TEETH, WHEEL_TEETH);
        placer.part(train, "pinion", self.pinion, along_z(-SHAFTS_M, 0.026, turn));
        placer.part(train, "wheel", self.wheel, along_z(0.0, 0.026, second));
        placer.part(train, "pinion", self.pinion, along_z(0.0, -0.026, second));
        placer.part(train, "wheel", self.wheel, along_z(SHAFTS_M, -0.026, third));
        let input = along_z(-SHAFTS_M, 0.0, 0.0);
        let output = place
            * Affine3A::from_rotation_y(PI)
            * Affine3A::from_translation(vec3(-SHAFTS_M, 0.0, 0.0))
            * Affine3A::from_rotation_x(FRAC_PI_2);
        let outside = Affine3A::from_translation(vec3(0.0, INSIDE.z + 0.066, 0.0));
        for end in [input, output] {
            placer.part(train, "shaft", self.long_shaft, end);
            placer.part(train, "coupling", self.coupling, end * outside);
        }
        placer.part(train, "shaft", self.shaft, along_z(0.0, 0.0, 0.0));
        for x in [-SHAFTS_M, 0.0, SHAFTS_M] {
            for z in [-1.0, 1.0] {
                placer.part(
                    train,
                    "bearing",
                    self.bearing,
                    along_z(x, z * (INSIDE.z - 0.010), 0.0),
                );
            }
        }
    }
}

/// Returns the inside of a rack in metres.
fn rack_size() -> Vec3 {
    let [columns, levels, rows] = RACK;
    let size = vec3(f32::from(columns), f32::from(levels), f32::from(rows)) * CELL;
    size + vec3(0.0, 0.2, 0.06)
}
