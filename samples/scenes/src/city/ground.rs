//! The ground of one block: half of the streets around it, kerbs, pavements and a paved or planted
//! middle, as one mesh without a crack.
//!
//! Rectangles of any size lie side by side. If a corner of one lies on an edge of another, this
//! edge gets a vertex at the corner, so that no T-junction opens a crack. The edges of the tile are
//! equal on all four sides and symmetric. Their coordinates are binary fractions, so neighbouring
//! tiles share bit-identical vertices.

use glam::{Vec3, vec3};
use scene::Mesh;

use super::super::builder::{MeshBuilder, Paint};
use super::layout::TILE_M;

/// The height of the pavement over the road, in metres.
pub(crate) const PAVEMENT_M: f32 = 0.125;

/// The distance between the middle of a block and its kerbs, in metres.
pub(crate) const KERB_M: f32 = 26.0;

/// The distance between the middle of a block and the line behind which its buildings stay, in
/// metres.
pub(super) const BUILDING_LINE_M: f32 = 22.0;

const EDGE_M: f32 = TILE_M / 2.0;

/// The surface between the pavements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Middle {
    /// Slabs of stone.
    Paved,
    /// Lawn, in two greens.
    Planted,
}

/// A rectangle by its four corners, counter-clockwise from its front.
struct Plate {
    corners: [Vec3; 4],
    paint: Paint,
}

/// Plates without T-junctions between them.
#[derive(Default)]
pub(crate) struct Plates {
    plates: Vec<Plate>,
}

impl Plates {
    /// Adds a level plate from (`x0`, `z0`) to (`x1`, `z1`).
    pub(crate) fn level(&mut self, x: [f32; 2], z: [f32; 2], y: f32, paint: Paint) {
        let [x0, x1] = x;
        let [z0, z1] = z;
        let corners = [vec3(x0, y, z1), vec3(x1, y, z1), vec3(x1, y, z0), vec3(x0, y, z0)];
        self.plates.push(Plate { corners, paint });
    }

    fn upright(&mut self, from: [f32; 2], to: [f32; 2], heights: [f32; 2], paint: Paint) {
        let [low, high] = heights;
        let at = |[x, z]: [f32; 2], y: f32| vec3(x, y, z);
        let corners = [at(from, low), at(to, low), at(to, high), at(from, high)];
        self.plates.push(Plate { corners, paint });
    }

    /// Builds the plates, with a vertex at each corner of another plate.
    pub(crate) fn build(&self, builder: &mut MeshBuilder) {
        for plate in &self.plates {
            let mut outline = Vec::with_capacity(8);
            for (corner, &from) in plate.corners.iter().enumerate() {
                let to = plate.corners[(corner + 1) % 4];
                outline.push(from);
                outline.extend(self.corners_between(from, to));
            }
            if outline.len() == 4 {
                builder.polygon(&outline, plate.paint);
            } else {
                let centre = (plate.corners[0] + plate.corners[2]) / 2.0;
                builder.fan(centre, &outline, plate.paint);
            }
        }
    }

    /// Returns the corners of all plates that lie on an axis-parallel edge, in order.
    fn corners_between(&self, from: Vec3, to: Vec3) -> Vec<Vec3> {
        let length = (to - from).length();
        // A division instead of `normalize`: along an axis the result is exactly 1, and the test
        // below is exact.
        let along = (to - from) / length;
        let mut found: Vec<(f32, Vec3)> = self
            .plates
            .iter()
            .flat_map(|plate| plate.corners)
            .map(|corner| ((corner - from).dot(along), corner))
            .filter(|&(distance, corner)| {
                distance > 0.0 && distance < length && from + along * distance == corner
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.dedup();
        found.into_iter().map(|(_, corner)| corner).collect()
    }
}

struct Surfaces {
    road: Paint,
    line: Paint,
    kerb: Paint,
    slabs: [Paint; 3],
    middle: [Paint; 2],
}

fn surfaces(middle: Middle) -> Surfaces {
    let middle = match middle {
        Middle::Paved => [0xA6_9F92, 0x9D_9689],
        Middle::Planted => [0x74_8C52, 0x6B_844C],
    };
    Surfaces {
        road: Paint::srgb(0x5A_5B5E),
        line: Paint::srgb(0xD8_D6CE),
        kerb: Paint::srgb(0xBD_B9B0),
        slabs: [0xA8_A49B, 0xA2_9E95, 0xAF_ABA2].map(Paint::srgb),
        middle: middle.map(Paint::srgb),
    }
}

/// Returns the ground of a block.
pub(super) fn tile(name: &str, middle: Middle) -> Mesh {
    let mut plates = Plates::default();
    let surfaces = surfaces(middle);
    for side in 0..4 {
        street(&mut plates, side, &surfaces);
        pavement(&mut plates, side, &surfaces);
    }
    let step = BUILDING_LINE_M / 2.0;
    for column in 0..4i8 {
        for row in 0..4i8 {
            let x = -BUILDING_LINE_M + step * f32::from(column);
            let z = -BUILDING_LINE_M + step * f32::from(row);
            let paint = surfaces.middle[usize::from((column + row) % 2 != 0)];
            plates.level([x, x + step], [z, z + step], PAVEMENT_M, paint);
        }
    }
    let mut builder = MeshBuilder::default();
    plates.build(&mut builder);
    builder.finish(name)
}

/// Turns a rectangle, given by its ranges along a side (`u`) and away from the middle (`out`).
fn turned(side: usize, u: [f32; 2], out: [f32; 2]) -> ([f32; 2], [f32; 2]) {
    let flipped = |[low, high]: [f32; 2]| [-high, -low];
    match side % 4 {
        0 => (u, out),
        1 => (out, flipped(u)),
        2 => (flipped(u), flipped(out)),
        _ => (flipped(out), u),
    }
}

fn street(plates: &mut Plates, side: usize, surfaces: &Surfaces) {
    let mut level = |u: [f32; 2], out: [f32; 2], paint: Paint| {
        let (x, z) = turned(side, u, out);
        plates.level(x, z, 0.0, paint);
    };
    let line = EDGE_M - 0.125;
    level([-22.0, 22.0], [KERB_M, line], surfaces.road);
    for dash in 0..11u8 {
        let low = -22.0 + 4.0 * f32::from(dash);
        let paint = if dash % 2 == 1 { surfaces.line } else { surfaces.road };
        level([low, low + 4.0], [line, EDGE_M], paint);
    }
    for end in [-1.0f32, 1.0] {
        let along = |near: f32, far: f32| if end > 0.0 { [near, far] } else { [-far, -near] };
        level(along(22.0, 22.5), [KERB_M, EDGE_M], surfaces.road);
        level(along(25.5, 26.0), [KERB_M, EDGE_M], surfaces.road);
        for stripe in 0..6u8 {
            let low = KERB_M + f32::from(stripe);
            level(along(22.5, 25.5), [low, low + 0.5], surfaces.line);
            level(along(22.5, 25.5), [low + 0.5, low + 1.0], surfaces.road);
        }
    }
    // The crossing of two streets belongs to the previous side.
    level([KERB_M, EDGE_M], [KERB_M, EDGE_M], surfaces.road);
}

fn pavement(plates: &mut Plates, side: usize, surfaces: &Surfaces) {
    let stone = KERB_M - 0.25;
    let mut level = |u: [f32; 2], out: [f32; 2], paint: Paint| {
        let (x, z) = turned(side, u, out);
        plates.level(x, z, PAVEMENT_M, paint);
    };
    level([-stone, KERB_M], [stone, KERB_M], surfaces.kerb);
    for slab in 0..11u8 {
        let low = -22.0 + 4.0 * f32::from(slab);
        let paint = surfaces.slabs[usize::from(slab) % 3];
        level([low, low + 4.0], [BUILDING_LINE_M, stone], paint);
    }
    level([BUILDING_LINE_M, stone], [BUILDING_LINE_M, stone], surfaces.slabs[1]);
    let (x, z) = turned(side, [-KERB_M, KERB_M], [KERB_M, KERB_M]);
    let [from, to] = match side % 4 {
        0 => [[x[0], z[0]], [x[1], z[0]]],
        1 => [[x[0], z[1]], [x[0], z[0]]],
        2 => [[x[1], z[0]], [x[0], z[0]]],
        _ => [[x[0], z[0]], [x[0], z[1]]],
    };
    let face = surfaces.kerb.shade(0.7);
    plates.upright(from, to, [0.0, PAVEMENT_M], face);
}
