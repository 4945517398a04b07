//! Points and lines as sprites: without duplicates, in spatial chunks that can be culled
//! individually.

use glam::{Affine3A, Vec3};
use gltf::mesh::Semantic;
use scene::{MAX_SPRITES, MeshId, SpriteEnd, SpriteShape, Sprites, pack_sprite_colour};

use super::budget::Budget;
use super::geometry::Geometry;
use super::initial_view::InitialView;
use super::materials::MaterialUse;
use super::numbers::direction;
use super::pieces::longest_side;
use super::primitives::{Facing, Primitive, Variant};
use super::solids;
use super::topology::Elements;
use crate::ImportError;
use crate::notes::Notes;

/// The most points or lines of one primitive that become solids: a solid takes as much memory as
/// fifty sprites.
const MOST_SOLIDS: u64 = 1 << 16;

/// The most sprites of a chunk that is used once.
const CHUNK: usize = 4096;

/// The end of a sprite in comparable numbers: the bits of position, colour and normal.
type End = [u32; 7];

/// The common appearance of sprites.
#[derive(Clone, Copy, Debug)]
struct Look {
    /// Half of the sprites' width.
    radius_m: f32,
    /// The factor of the sprites' colours.
    tint: [f32; 4],
    /// True if the sprites are shown at only one place.
    is_seen_once: bool,
}

/// Returns true if a primitive has more points or lines than may become solids.
pub(super) fn is_crowd(primitive: &Primitive<'_>) -> bool {
    let accessors = &primitive.source.document.as_json().accessors;
    let indices = primitive.json.indices.map(|indices| indices.value());
    let list = indices.or_else(|| primitive.attribute(Semantic::Positions));
    let count = list.and_then(|list| accessors.get(list)).map_or(0, |list| list.count.0);
    primitive.is_thin() && count > MOST_SOLIDS
}

/// The look of sprites, and the view for which they are sized.
pub(super) struct WantedSprites<'a> {
    pub(super) tint: [f32; 4],
    pub(super) is_seen_once: bool,
    pub(super) sight: &'a InitialView<'a>,
    pub(super) to_world: &'a Affine3A,
}

/// Returns a primitive as sprites, if it consists of points or lines.
pub(super) fn sprites_of(
    primitive: &Primitive<'_>,
    material: &MaterialUse,
    wanted: &WantedSprites<'_>,
    budget: &mut Budget,
    notes: &mut Notes,
) -> Result<Vec<Sprites>, ImportError> {
    let read = primitive.read(Variant::rigid(Facing::Plain), material, notes)?;
    let Some((geometry, elements)) = read else { return Ok(Vec::new()) };
    let ends = elements.vertices().len() as u64;
    budget.take(ends, 0).map_err(|over| primitive.over(&over))?;
    let &WantedSprites { tint, is_seen_once, sight, to_world } = wanted;
    let height = sight.height_at(&geometry.bounds(), to_world);
    // If positions overflow, sizes do, too.
    let radius_m = |size: f32| if size.is_finite() { size * 0.5 } else { 0.0 };
    let look = |size: f32| Look { radius_m: radius_m(size), tint, is_seen_once };
    Ok(match elements {
        Elements::Points(list) => {
            let size = solids::point_size(&geometry, &list, height);
            points(&geometry, &list, &look(size))
        }
        Elements::Lines(list) => {
            let size = solids::line_size(&geometry, &list, height);
            lines(&geometry, &list, &look(size))
        }
        Elements::Triangles(_) => Vec::new(),
    })
}

/// Returns sprites for these points, without a mesh yet.
fn points(geometry: &Geometry, points: &[u32], look: &Look) -> Vec<Sprites> {
    let all = points.iter().map(|&point| [end(geometry, point, look)]).collect();
    chunks(all, geometry, SpriteShape::Point, look)
}

/// Returns sprites for these lines, without a mesh yet.
fn lines(geometry: &Geometry, lines: &[[u32; 2]], look: &Look) -> Vec<Sprites> {
    let all = lines.iter().map(|line| {
        let mut ends = line.map(|vertex| end(geometry, vertex, look));
        // A line in the opposite direction is the same line.
        ends.sort_unstable();
        ends
    });
    chunks(all.collect(), geometry, SpriteShape::Line, look)
}

fn end(geometry: &Geometry, vertex: u32, look: &Look) -> End {
    let vertex = vertex as usize;
    let position = geometry.positions.get(vertex).copied().unwrap_or_default();
    let colour = geometry.colours.get(vertex).copied().unwrap_or([1.0; 4]);
    let colour = std::array::from_fn(|part| colour[part] * look.tint[part]);
    let normal = geometry.normals.get(vertex).and_then(|normal| direction(*normal));
    // 0 and -0 are the same place.
    let [x, y, z] = (position + Vec3::ZERO).to_array().map(f32::to_bits);
    let [nx, ny, nz] = normal.unwrap_or(Vec3::Y).to_array().map(f32::to_bits);
    [x, y, z, pack_sprite_colour(colour).to_bits(), nx, ny, nz]
}

fn position(end: &End) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|axis| f32::from_bits(end[axis])))
}

fn chunks<const ENDS: usize>(
    mut all: Vec<[End; ENDS]>,
    geometry: &Geometry,
    shape: SpriteShape,
    look: &Look,
) -> Vec<Sprites> {
    all.sort_unstable();
    all.dedup();
    let most = if look.is_seen_once { CHUNK } else { MAX_SPRITES };
    let middle =
        |ends: &[End; ENDS]| -> Vec3 { ends.iter().map(|end| position(end) / ENDS as f32).sum() };
    let mut pending = vec![all.as_mut_slice()];
    let mut chunks = Vec::new();
    while let Some(part) = pending.pop() {
        if part.is_empty() {
            continue;
        }
        if part.len() <= most {
            chunks.push(sprites(part.as_flattened(), geometry, shape, look));
            continue;
        }
        let axis = longest_side(part.iter().map(middle));
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |a, b| {
            middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(b))
        });
        let (low, high) = part.split_at_mut(half);
        pending.push(high);
        pending.push(low);
    }
    chunks
}

fn sprites(ends: &[End], geometry: &Geometry, shape: SpriteShape, look: &Look) -> Sprites {
    let normal = |end: &End| [4, 5, 6].map(|part| f32::from_bits(end[part]));
    let is_lit = !geometry.normals.is_empty();
    Sprites {
        mesh: MeshId(u32::MAX),
        shape,
        radius_m: look.radius_m,
        ends: ends
            .iter()
            .map(|end| SpriteEnd {
                position: position(end).to_array(),
                colour: f32::from_bits(end[3]),
            })
            .collect(),
        normals: if is_lit { ends.iter().map(normal).collect() } else { Vec::new() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOK: Look = Look { radius_m: 0.5, tint: [1.0; 4], is_seen_once: true };

    fn row(count: u32) -> Geometry {
        let at = |number: u32| Vec3::new(number as f32, 0.0, 0.0);
        Geometry { positions: (0..count).map(at).collect(), ..Geometry::default() }
    }

    #[test]
    fn identical_points_and_lines_are_there_once() {
        let heap = Geometry { positions: vec![Vec3::ZERO; 9], ..Geometry::default() };
        let all: Vec<u32> = (0..9).collect();
        let made = points(&heap, &all, &LOOK);
        assert_eq!((made.len(), made[0].count()), (1, 1));
        let made = lines(&row(3), &[[0, 1], [1, 0], [1, 2]], &LOOK);
        assert_eq!((made.len(), made[0].count()), (1, 2));
        let coloured = Geometry { colours: vec![[0.0; 4], [1.0; 4], [1.0; 4]], ..heap };
        assert_eq!(points(&coloured, &[0, 1, 2], &LOOK)[0].count(), 2);
        assert!(points(&Geometry::default(), &[], &LOOK).is_empty());
    }

    #[test]
    fn chunks_have_every_point_once_and_lie_side_by_side() {
        let all: Vec<u32> = (0..20_000).rev().collect();
        let made = points(&row(20_000), &all, &LOOK);
        assert_eq!(made.len(), 8);
        let mut end = -1.0;
        for chunk in &made {
            let xs = chunk.ends.iter().map(|end| end.position[0]);
            let (low, high) =
                xs.fold((f32::MAX, f32::MIN), |(low, high), x| (low.min(x), high.max(x)));
            assert!(low == end + 1.0, "{low} after {end}");
            end = high;
        }
        assert_eq!(made.iter().map(Sprites::count).sum::<usize>(), 20_000);
        let often = Look { is_seen_once: false, ..LOOK };
        assert_eq!(points(&row(20_000), &all, &often).len(), 1);
    }
}
