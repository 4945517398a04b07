//! The colours of the city: few, warm, and the same everywhere, so that a million objects look like
//! one place.

use super::super::builder::Paint;
use super::super::random::Random;

/// Plaster, brick and stone: a family of four for each kind of district.
const WALL_TINTS: [[u32; 4]; 5] = [
    [0xE8D7B5, 0xDDBD8A, 0xD9A679, 0xEFE6D2],
    [0xB8745A, 0xA65F4B, 0xC98F6F, 0xE3CDB0],
    [0xCFD3D2, 0xAEBBC2, 0xE6E2D8, 0x93A5AF],
    [0xD8C6C0, 0xCF9F95, 0xE9DCD0, 0xB88C84],
    [0xC9CFB4, 0xE5DFC4, 0xA9B59A, 0xD8C79E],
];

const VEHICLE_TINTS: [u32; 8] =
    [0xB23A32, 0x2F5D8A, 0xE9E7E1, 0x3B3E42, 0x8B9297, 0xD9A33A, 0x3F6B57, 0x6FA3B8];

const LEAF_TINTS: [u32; 5] = [0x6F9A45, 0x7FA552, 0x5B8A45, 0x93A84B, 0x4F7D4B];

const FURNITURE_TINTS: [u32; 4] = [0x2F6B5A, 0x2F4F6B, 0x7A3B35, 0x55585C];

/// The number of families of wall colours.
pub(super) const WALL_FAMILIES: u32 = WALL_TINTS.len() as u32;

/// Returns a tint for walls from one of the families.
pub(super) fn wall_tint(family: u32, random: &mut Random) -> u32 {
    let family = WALL_TINTS[family as usize % WALL_TINTS.len()];
    Paint::srgb(random.pick(&family)).shade(random.between(0.92, 1.06)).packed()
}

/// The material of a prop's tinted part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TintKind {
    /// No part of it is tinted.
    Plain,
    /// Leaves of trees and bushes.
    Leaf,
    /// The paint of cars and vans.
    Vehicle,
    /// The painted metal of street furniture.
    Furniture,
}

/// Returns a tint for this kind of object.
pub(crate) fn prop_tint(kind: TintKind, random: &mut Random) -> u32 {
    let paint = match kind {
        TintKind::Plain => Paint::srgb(0xFF_FFFF),
        TintKind::Leaf => Paint::srgb(random.pick(&LEAF_TINTS)).shade(random.between(0.85, 1.1)),
        TintKind::Vehicle => Paint::srgb(random.pick(&VEHICLE_TINTS)),
        TintKind::Furniture => Paint::srgb(random.pick(&FURNITURE_TINTS)),
    };
    paint.packed()
}

/// Returns a tint for the stone of walls and gates between districts.
pub(super) fn stone_tint(random: &mut Random) -> u32 {
    Paint::srgb(random.pick(&[0xCDBFA6, 0xC4B49A, 0xD3C7B2])).packed()
}

/// Returns the colours of the vertices of window panes.
pub(crate) fn glass_colours() -> [u32; 4] {
    Materials::new().glass.map(Paint::packed)
}

/// The materials of the meshes.
pub(crate) struct Materials {
    /// A wall, tinted by the object.
    pub(crate) wall: Paint,
    /// The sides of a window's recess.
    pub(crate) reveal: Paint,
    /// Ledges, sills and frames.
    pub(crate) trim: Paint,
    /// The ground floor's stone.
    pub(crate) stone: Paint,
    /// Window panes, from dark to bright.
    pub(crate) glass: [Paint; 4],
    /// Fired roof tiles.
    pub(crate) tile: Paint,
    /// Pitched roofs of slate.
    pub(crate) slate: Paint,
    /// The gravel of flat roofs.
    pub(crate) gravel: Paint,
    /// Dark metal: posts, canopies, wheels.
    pub(crate) iron: Paint,
    /// Bright metal: frames, rims of wheels.
    pub(crate) steel: Paint,
    /// Doors and benches.
    pub(crate) wood: Paint,
    /// Anything that is painted in the object's tint.
    pub(crate) coat: Paint,
}

impl Materials {
    pub(crate) fn new() -> Self {
        let white = Paint::srgb(0xFF_FFFF);
        Self {
            wall: white.tinted(1.0),
            reveal: Paint::srgb(0xB9_B4AA).tinted(0.8),
            trim: Paint::srgb(0xEF_E8DA).tinted(0.25),
            stone: Paint::srgb(0xC2_B8A6).tinted(0.25),
            glass: [0x2A_3C48, 0x35_4C5A, 0x48_6472, 0x66_838E].map(Paint::srgb),
            tile: Paint::srgb(0xA9_5A3E),
            slate: Paint::srgb(0x56_606A),
            gravel: Paint::srgb(0x9A_9488),
            iron: Paint::srgb(0x2E_3336),
            steel: Paint::srgb(0xA8_AEB0),
            wood: Paint::srgb(0x8A_5A38),
            coat: white.tinted(1.0),
        }
    }
}
