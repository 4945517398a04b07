//! The meshes of buildings: a table of their parts, and their assembly.

use glam::{Vec2, Vec3, vec2};
use scene::Mesh;

use super::super::builder::{Frame, MeshBuilder};
use super::super::random::Random;
use super::facade::{Entrance, Facade, Side};
use super::palette::Materials;
use super::roofs::{Roof, RoofSite};

/// The footprint of a building: the lots of a block that it covers along x and z, in sixths of the
/// block's side. All fronts face +z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Footprint {
    /// 2 by 2.
    House,
    /// 3 by 2.
    Row,
    /// 3 by 3.
    Tower,
    /// 4 by 2.
    Slab,
}

/// A sixth of the buildable side of a block, in metres.
pub(super) const LOT_M: f32 = 44.0 / 6.0;

/// The distance between a building's box and the edge of its lot, in metres: half the distance
/// between neighbours.
const CLEARANCE_M: f32 = 0.335;

/// The distance by which ledges and roofs may protrude from the walls, in metres.
const OVERHANG_M: f32 = 0.3;

impl Footprint {
    pub(super) const ALL: [Self; 4] = [Self::House, Self::Row, Self::Tower, Self::Slab];

    /// Returns the size in lots along x and z.
    pub(super) fn lots(self) -> [i8; 2] {
        match self {
            Self::House => [2, 2],
            Self::Row => [3, 2],
            Self::Tower => [3, 3],
            Self::Slab => [4, 2],
        }
    }

    /// Returns half the distance between opposite walls, in metres.
    fn half_m(self) -> Vec2 {
        let [x, z] = self.lots().map(f32::from);
        vec2(x, z) * (LOT_M / 2.0) - Vec2::splat(CLEARANCE_M + OVERHANG_M)
    }
}

struct Design {
    name: &'static str,
    footprint: Footprint,
    floors: u32,
    floor_m: f32,
    bays: [u32; 2],
    facade: Facade,
    roof: Roof,
}

const fn design(
    name: &'static str,
    footprint: Footprint,
    floors: u32,
    floor_m: f32,
    bays: [u32; 2],
    facade: Facade,
    roof: Roof,
) -> Design {
    Design { name, footprint, floors, floor_m, bays, facade, roof }
}

const DESIGNS: [Design; 21] = [
    design(
        "townhouse, hipped roof",
        Footprint::House,
        3,
        3.2,
        [4, 4],
        Facade::Framed,
        Roof::Hipped,
    ),
    design("townhouse, mansard", Footprint::House, 4, 3.3, [4, 3], Facade::Punched, Roof::Mansard),
    design("townhouse, gables", Footprint::House, 4, 3.1, [4, 3], Facade::Punched, Roof::Gabled),
    design("walk-up", Footprint::House, 5, 3.1, [4, 3], Facade::Punched, Roof::Flat),
    design("loft", Footprint::House, 5, 3.6, [5, 5], Facade::Strips, Roof::Tank),
    design("office, ribbons", Footprint::House, 6, 3.3, [6, 6], Facade::Ribbon, Roof::Flat),
    design("flats, loggias", Footprint::House, 6, 3.0, [3, 3], Facade::Loggia, Roof::Flat),
    design("high house", Footprint::House, 9, 3.2, [5, 5], Facade::Strips, Roof::Setback),
    design("row, hipped roof", Footprint::Row, 3, 3.3, [6, 4], Facade::Punched, Roof::Hipped),
    design("row, mansard", Footprint::Row, 4, 3.2, [5, 3], Facade::Punched, Roof::Mansard),
    design("row, sills", Footprint::Row, 3, 3.3, [5, 3], Facade::Framed, Roof::Flat),
    design("row, warehouse", Footprint::Row, 5, 3.6, [6, 4], Facade::Strips, Roof::Tank),
    design("row, ribbons", Footprint::Row, 5, 3.4, [8, 5], Facade::Ribbon, Roof::Setback),
    design("row, gables", Footprint::Row, 4, 3.1, [5, 3], Facade::Punched, Roof::Gabled),
    design("tower, ribbons", Footprint::Tower, 8, 3.4, [5, 5], Facade::Ribbon, Roof::Setback),
    design("tower, strips", Footprint::Tower, 11, 3.3, [5, 5], Facade::Strips, Roof::Setback),
    design("tower, tank", Footprint::Tower, 9, 3.4, [5, 5], Facade::Strips, Roof::Tank),
    design("palace", Footprint::Tower, 3, 4.0, [5, 5], Facade::Punched, Roof::Mansard),
    design("slab, loggias", Footprint::Slab, 4, 3.0, [6, 2], Facade::Loggia, Roof::Flat),
    design("slab, mansard", Footprint::Slab, 4, 3.2, [6, 2], Facade::Punched, Roof::Mansard),
    design("slab, strips", Footprint::Slab, 6, 3.3, [8, 4], Facade::Strips, Roof::Tank),
];

/// Returns the meshes of buildings, each with its footprint.
pub(super) fn meshes(materials: &Materials) -> Vec<(Footprint, Mesh)> {
    DESIGNS.iter().map(|design| (design.footprint, build(design, materials))).collect()
}

fn build(design: &Design, materials: &Materials) -> Mesh {
    // The brightness of panes does not depend on the city's seed, so a mesh depends only on its
    // design.
    let mut random = Random::keyed(0, &[i64::from(design.floors), i64::from(design.bays[0])]);
    let mut builder = MeshBuilder::default();
    let half = design.footprint.half_m();
    let ground_m = 4.0;
    for side in 0..4 {
        let along_x = side % 2 == 0;
        Side {
            frame: Frame::of_side(side, half, Vec3::ZERO),
            width_m: 2.0 * if along_x { half.x } else { half.y },
            bays: design.bays[side % 2],
            floors: design.floors,
            floor_m: design.floor_m,
            ground_m,
            facade: design.facade,
            entrance: if along_x { Entrance::Front } else { Entrance::Plain },
            materials,
        }
        .build(&mut builder, &mut random);
    }
    let eaves_m = ground_m + design.floors as f32 * design.floor_m;
    builder.band(half, 0.18, [ground_m - 0.25, ground_m + 0.05], materials.trim);
    if matches!(design.roof, Roof::Flat | Roof::Tank | Roof::Setback) {
        builder.band(half, 0.26, [eaves_m - 0.12, eaves_m + 0.2], materials.trim);
    }
    if matches!(design.facade, Facade::Punched | Facade::Framed) {
        let level = ground_m + design.floor_m * design.floors.saturating_sub(1) as f32;
        builder.band(half, 0.1, [level - 0.08, level + 0.1], materials.trim);
    }
    RoofSite { half, eaves_m, materials }.build(&mut builder, design.roof, &mut random);
    builder.darken_foot(0.72, 5.0);
    builder.finish(design.name)
}
