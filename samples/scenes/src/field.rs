//! The field: objects on a plane at large distances, so that nothing is hidden from above. In this
//! scene, visibility tests only cost time.

use glam::{Vec3, vec3};
use scene::{Light, Mesh, MeshId, Object, Scene};

use super::builder::{MeshBuilder, Paint};
use super::city::ground::Plates;
use super::city::palette::{Materials, TintKind, prop_tint};
use super::city::{pavilions::pavilions, props::props};
use super::error::GeneratorError;
use super::generated::{GeneratedScene, HOVER_M, placement, room_for_objects, share};
use super::random::Random;
use super::routes::{AIRCRAFT_INWARDS_RAD, Flight, Routes, Streets};

/// The side of a cell in metres; a cell has one object in its middle.
const CELL_M: f32 = 16.0;

/// The number of cells along a side of a ground tile.
const TILE_CELLS: u8 = 4;

const TILE_M: f32 = CELL_M * TILE_CELLS as f32;

/// The distance from the origin within which walks stay, in metres.
const WALK_M: f32 = 128.0;

/// Generates a field of exactly `objects` objects, including the tiles of the ground.
///
/// # Errors
/// [`GeneratorError::ObjectCount`] if `objects` is 0 or more than
/// [`MAX_OBJECTS`](super::MAX_OBJECTS).
pub fn field(objects: u32, seed: u64) -> Result<GeneratedScene, GeneratorError> {
    let mut placed = room_for_objects(objects)?;
    let tile_objects = u32::from(TILE_CELLS).pow(2) + 1;
    let tiles = objects.div_ceil(tile_objects);
    let columns = tiles.isqrt().max(1);
    let rows = tiles.div_ceil(columns);
    let materials = Materials::new();
    let mut meshes = vec![ground()];
    let mut kinds = Vec::new();
    for mesh in pavilions(&materials) {
        kinds.push((MeshId(meshes.len() as u32), TintKind::Plain));
        meshes.push(mesh);
    }
    for prop in props(&materials) {
        kinds.push((MeshId(meshes.len() as u32), prop.tint));
        meshes.push(prop.mesh);
    }
    let first = [columns, rows].map(|count| -(i64::from(count) / 2));
    for number in 0..columns * rows {
        let budget = share(objects, number, columns * rows);
        let column = first[0] + i64::from(number % columns);
        let row = first[1] + i64::from(number / columns);
        let mut random = Random::keyed(seed, &[column, row, 3]);
        let centre = vec3(column as f32 + 0.5, 0.0, row as f32 + 0.5) * TILE_M;
        tile(&mut placed, centre, budget, &kinds, &mut random);
    }
    let ends =
        |first: i64, count: u32| [first, first + i64::from(count)].map(|end| end as f32 * TILE_M);
    let x = ends(first[0], columns);
    let z = ends(first[1], rows);
    let radius_m = ((x[1] - x[0]).min(z[1] - z[0]) * 0.35).clamp(16.0, 160.0);
    let flight = Flight {
        centre: Vec3::new((x[0] + x[1]) / 2.0, 110.0, (z[0] + z[1]) / 2.0),
        radius_m,
        // Steep enough that the upper edge of the view meets the ground at 15 degrees. At this
        // angle, a pavilion's roof does not cover objects in the next cell.
        down_rad: 0.785,
        inwards_rad: AIRCRAFT_INWARDS_RAD,
    };
    let streets = Streets { xs: aisles(x[0], x[1]), zs: aisles(z[0], z[1]), turn_radius_m: 2.5 };
    let scene = Scene {
        name: "field".to_owned(),
        meshes,
        objects: placed,
        light: Light::afternoon(),
        surfaces: None,
    };
    Ok(GeneratedScene { scene, routes: Routes { seed, streets, flight } })
}

/// Returns the lines between cells near the origin.
fn aisles(low: f32, high: f32) -> Vec<f32> {
    let low = (low.max(-WALK_M) / CELL_M) as i32;
    let high = (high.min(WALK_M) / CELL_M) as i32;
    (low..=high).map(|line| line as f32 * CELL_M).collect()
}

fn tile(
    placed: &mut Vec<Object>,
    centre: Vec3,
    budget: u32,
    kinds: &[(MeshId, TintKind)],
    random: &mut Random,
) {
    if budget == 0 {
        return;
    }
    let plain = prop_tint(TintKind::Plain, random);
    placed.push(Object { mesh: MeshId(0), transform: placement(0, 1.0, centre), tint: plain });
    let mut cells: Vec<u8> = (0..TILE_CELLS * TILE_CELLS).collect();
    random.shuffle(&mut cells);
    for &cell in cells.iter().take(budget as usize - 1) {
        let kind = random.below(kinds.len() as u32) as usize;
        let Some(&(mesh, tint)) = kinds.get(kind) else { continue };
        let cell_middle = |cell: u8| (f32::from(cell) + 0.5) * CELL_M - TILE_M / 2.0;
        let place = vec3(cell_middle(cell % TILE_CELLS), HOVER_M, cell_middle(cell / TILE_CELLS));
        let transform = placement(random.below(4) as usize, 1.0, centre + place);
        placed.push(Object { mesh, transform, tint: prop_tint(tint, random) });
    }
}

/// Returns a tile of lawn with a path around each cell.
fn ground() -> Mesh {
    let mut plates = Plates::default();
    let lawn = [0x77_8F56, 0x70_884F].map(Paint::srgb);
    let gravel = Paint::srgb(0xB5_A98E);
    let path = 1.0;
    for column in 0..TILE_CELLS {
        for row in 0..TILE_CELLS {
            let low = |cell: u8| f32::from(cell) * CELL_M - TILE_M / 2.0;
            let x = low(column);
            let z = low(row);
            let x1 = x + CELL_M;
            let z1 = z + CELL_M;
            let paint = lawn[usize::from((column + row) % 2)];
            plates.level([x + path, x1 - path], [z + path, z1 - path], 0.0, paint);
            plates.level([x, x1], [z, z + path], 0.0, gravel);
            plates.level([x, x1], [z1 - path, z1], 0.0, gravel);
            plates.level([x, x + path], [z + path, z1 - path], 0.0, gravel);
            plates.level([x1 - path, x1], [z + path, z1 - path], 0.0, gravel);
        }
    }
    let mut builder = MeshBuilder::default();
    plates.build(&mut builder);
    builder.finish("ground, lawn")
}
