//! The places of blocks, districts and lots.

use glam::Vec2;

use super::buildings::{Footprint, LOT_M};

/// The distance between the middles of neighbouring blocks, in metres: a binary fraction, so that
/// neighbouring ground tiles have exactly the same edges.
pub(super) const TILE_M: f32 = 64.0;

/// The number of blocks along a side of a district.
const DISTRICT_BLOCKS: i32 = 6;

/// The average number of objects per block: a tile, 5 to 9 buildings, 12 to 18 props.
const OBJECTS_PER_BLOCK: f64 = 23.0;

/// One direction of the city: blocks `first..last`, cut into districts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Axis {
    /// The block boundaries with walls, from the first to the last, ascending.
    cuts: Vec<i32>,
    /// The blocks of the middle district, which lies around the origin.
    pub(super) middle: [i32; 2],
}

impl Axis {
    fn new(blocks: i32) -> Self {
        if blocks <= DISTRICT_BLOCKS + 2 {
            return Self { cuts: vec![0, blocks], middle: [0, blocks] };
        }
        let before = (blocks - DISTRICT_BLOCKS) / 2;
        let after = blocks - DISTRICT_BLOCKS - before;
        let mut cuts: Vec<i32> = outward(before).iter().rev().map(|cut| -cut).collect();
        cuts.extend([0, DISTRICT_BLOCKS]);
        cuts.extend(outward(after).iter().map(|cut| DISTRICT_BLOCKS + cut));
        Self { cuts, middle: [0, DISTRICT_BLOCKS] }
    }

    /// Returns the first block.
    pub(super) fn first(&self) -> i32 {
        self.cuts.first().copied().unwrap_or(0)
    }

    /// Returns one past the last block.
    pub(super) fn last(&self) -> i32 {
        self.cuts.last().copied().unwrap_or(0)
    }

    /// Returns true if walls stand on this block boundary.
    pub(super) fn is_cut(&self, boundary: i32) -> bool {
        self.cuts.binary_search(&boundary).is_ok()
    }

    /// Returns the number of the district along this axis; the middle district has the same number
    /// in cities of any size.
    pub(super) fn district(&self, block: i32) -> i64 {
        let count = |boundary: i32| self.cuts.partition_point(|&cut| cut <= boundary) as i64;
        count(block) - count(self.middle[0])
    }
}

/// Returns the ends of the districts in `blocks` blocks beyond the middle district; the last one
/// may have another size.
fn outward(blocks: i32) -> Vec<i32> {
    if blocks == 0 {
        return Vec::new();
    }
    let districts = ((blocks + DISTRICT_BLOCKS / 2) / DISTRICT_BLOCKS).max(1);
    (1..districts).map(|district| district * DISTRICT_BLOCKS).chain([blocks]).collect()
}

/// The whole city's grid.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) columns: Axis,
    pub(super) rows: Axis,
}

impl Plan {
    /// Creates a nearly square grid for about this number of objects.
    pub(super) fn new(objects: u32) -> Self {
        let blocks = (f64::from(objects) / OBJECTS_PER_BLOCK).max(1.0);
        let columns = blocks.sqrt().floor().max(1.0);
        let rows = (blocks / columns).round().max(1.0);
        Self { columns: Axis::new(columns as i32), rows: Axis::new(rows as i32) }
    }

    /// Returns the number of blocks.
    pub(super) fn blocks(&self) -> u32 {
        let length = |axis: &Axis| axis.last().abs_diff(axis.first());
        length(&self.columns) * length(&self.rows)
    }
}

/// Returns the position of a block boundary, in metres: the middle of the district around the
/// origin is at 0.
pub(super) fn boundary_m(boundary: i32) -> f32 {
    (boundary - DISTRICT_BLOCKS / 2) as f32 * TILE_M
}

/// Returns the middle of a block, in metres.
pub(super) fn block_centre(column: i32, row: i32) -> Vec2 {
    Vec2::new(boundary_m(column), boundary_m(row)) + Vec2::splat(TILE_M / 2.0)
}

/// A place for a building: the lot coordinates of its corner, and its footprint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lot {
    x: i8,
    z: i8,
    pub(super) footprint: Footprint,
    /// The axis of the block along which the footprint's x runs.
    across: Across,
}

/// The orientation of a footprint in its block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Across {
    /// The footprint's x is along the block's x.
    No,
    /// The footprint's x is along the block's z.
    Yes,
}

const fn lot(x: i8, z: i8, footprint: Footprint) -> Lot {
    Lot { x, z, footprint, across: Across::No }
}

const fn tall(x: i8, z: i8, footprint: Footprint) -> Lot {
    Lot { x, z, footprint, across: Across::Yes }
}

impl Lot {
    /// Returns the size in lots, along the block's x and z.
    pub(super) fn size(&self) -> [i8; 2] {
        let [x, z] = self.footprint.lots();
        match self.across {
            Across::No => [x, z],
            Across::Yes => [z, x],
        }
    }

    /// Returns the middle relative to the middle of the block, in metres.
    pub(super) fn centre(&self) -> Vec2 {
        let [width, depth] = self.size().map(f32::from);
        let corner = Vec2::new(f32::from(self.x), f32::from(self.z));
        (corner + Vec2::new(width, depth) / 2.0 - Vec2::splat(3.0)) * LOT_M
    }

    /// Returns the side (0: +z, 1: +x, 2: -z, 3: -x) that its front faces: the nearest street that
    /// it can face.
    pub(super) fn facing(&self) -> usize {
        let centre = self.centre();
        let [width, depth] = self.size();
        let along_z = if width == depth { centre.y.abs() >= centre.x.abs() } else { width > depth };
        let is_positive = if along_z { centre.y >= 0.0 } else { centre.x >= 0.0 };
        let first_side = if along_z { 0 } else { 1 };
        if is_positive { first_side } else { first_side + 2 }
    }
}

/// The middle of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Court {
    /// Covered by a building: there is no court.
    Built,
    /// Open: the middle four lots are free.
    Open,
}

/// A way to divide a block among buildings.
pub(super) struct Division {
    pub(super) lots: &'static [Lot],
    pub(super) court: Court,
}

use Footprint::{House, Row, Slab, Tower};

/// The divisions, each a partition of six by six lots, except for a court.
pub(super) const DIVISIONS: [Division; 8] = [
    Division {
        lots: &[
            lot(0, 0, House),
            lot(2, 0, House),
            lot(4, 0, House),
            lot(0, 2, House),
            lot(4, 2, House),
            lot(0, 4, House),
            lot(2, 4, House),
            lot(4, 4, House),
        ],
        court: Court::Open,
    },
    Division {
        lots: &[
            lot(0, 0, Row),
            lot(3, 0, Row),
            lot(0, 2, House),
            lot(4, 2, House),
            lot(0, 4, House),
            lot(2, 4, House),
            lot(4, 4, House),
        ],
        court: Court::Open,
    },
    Division {
        lots: &[
            lot(0, 0, Row),
            lot(3, 0, Row),
            lot(0, 2, House),
            lot(4, 2, House),
            lot(0, 4, Row),
            lot(3, 4, Row),
        ],
        court: Court::Open,
    },
    Division {
        lots: &[
            lot(0, 0, Slab),
            tall(4, 0, Slab),
            lot(2, 4, Slab),
            tall(0, 2, Slab),
            lot(2, 2, House),
        ],
        court: Court::Built,
    },
    Division {
        lots: &[
            lot(0, 0, Tower),
            lot(3, 0, Tower),
            tall(0, 3, Row),
            tall(2, 3, Row),
            tall(4, 3, Row),
        ],
        court: Court::Built,
    },
    Division {
        lots: &[
            tall(0, 0, Row),
            tall(2, 0, Row),
            tall(4, 0, Row),
            tall(0, 3, Row),
            tall(2, 3, Row),
            tall(4, 3, Row),
        ],
        court: Court::Built,
    },
    Division {
        lots: &[
            lot(0, 0, House),
            lot(2, 0, House),
            lot(4, 0, House),
            lot(0, 2, House),
            lot(2, 2, House),
            lot(4, 2, House),
            lot(0, 4, House),
            lot(2, 4, House),
            lot(4, 4, House),
        ],
        court: Court::Built,
    },
    Division {
        lots: &[
            lot(0, 0, Slab),
            lot(4, 0, House),
            lot(0, 2, House),
            lot(4, 2, House),
            lot(0, 4, House),
            lot(2, 4, Slab),
        ],
        court: Court::Open,
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divisions_cover_a_block_once() {
        for (number, division) in DIVISIONS.iter().enumerate() {
            let mut covered = [[0u8; 6]; 6];
            for lot in division.lots {
                let x = lot.x;
                let z = lot.z;
                let [width, depth] = lot.size();
                for column in x..x + width {
                    for row in z..z + depth {
                        covered[column as usize][row as usize] += 1;
                    }
                }
            }
            for (column, cells) in covered.iter().enumerate() {
                for (row, &count) in cells.iter().enumerate() {
                    let court = (2..4).contains(&column) && (2..4).contains(&row);
                    let free = court && division.court == Court::Open;
                    assert_eq!(count, u8::from(!free), "division {number} at {column}, {row}");
                }
            }
        }
    }

    #[test]
    fn fronts_face_a_street_along_their_longer_side() {
        for lot in DIVISIONS.iter().flat_map(|division| division.lots) {
            let [width, depth] = lot.size();
            let faces_along_z = lot.facing().is_multiple_of(2);
            assert!(width == depth || faces_along_z == (width > depth), "{lot:?}");
        }
    }

    #[test]
    fn districts_are_six_blocks_and_the_middle_one_never_moves() {
        for blocks in 1..400 {
            let axis = Axis::new(blocks);
            assert_eq!(axis.last() - axis.first(), blocks);
            assert!(axis.cuts.windows(2).all(|pair| (1..=8).contains(&(pair[1] - pair[0]))));
            assert_eq!(axis.district(axis.middle[0]), 0);
            assert_eq!(axis.district(axis.middle[1] - 1), 0);
            if blocks > 8 {
                assert_eq!(axis.middle, [0, 6]);
            }
        }
    }
}
