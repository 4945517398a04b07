//! The assembly: a factory with gear boxes, conveyors and robot cells in halls. Like a CAD
//! assembly, it has few shapes, many instances, and nearly all of its parts are inside of
//! something.

mod conveyor;
mod gear_box;
mod hall;
mod placer;
mod robot_cell;

use glam::{Affine3A, Vec3, vec3};
use scene::{Light, Scene};

use self::conveyor::ConveyorMeshes;
use self::gear_box::GearBoxMeshes;
use self::hall::{HallMeshes, PITCH_M};
use self::placer::{MeshList, Placer};
use self::robot_cell::RobotCellMeshes;
use super::error::GeneratorError;
use super::generated::{GeneratedScene, room_for_objects, share};
use super::parts::{PartId, PartTree};
use super::random::Random;
use super::routes::{Flight, Routes, Streets};

/// The most parts of a hall with its contents: fewer than there is room for.
const HALL_PARTS: u32 = 1400;

/// The distance from the origin within which walks stay, in metres.
const WALK_M: f32 = 120.0;

/// An assembly: its scene, and the tree of its parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// The objects, one per part, each a closed solid, and the routes.
    pub generated: GeneratedScene,
    /// The parts by halls, machines and groups.
    pub parts: PartTree,
}

/// The meshes of all parts, grouped by machine.
struct Shapes {
    hall: HallMeshes,
    gear_box: GearBoxMeshes,
    conveyor: ConveyorMeshes,
    robot_cell: RobotCellMeshes,
}

/// Makes an assembly of exactly `parts` parts, some 1,400 of them in each hall.
///
/// # Errors
/// [`GeneratorError::ObjectCount`] if `parts` is 0 or more than
/// [`MAX_OBJECTS`](super::MAX_OBJECTS).
pub fn assembly(parts: u32, seed: u64) -> Result<Assembly, GeneratorError> {
    let objects = room_for_objects(parts)?;
    let mut meshes = MeshList::default();
    let shapes = Shapes {
        hall: HallMeshes::add(&mut meshes),
        gear_box: GearBoxMeshes::add(&mut meshes),
        conveyor: ConveyorMeshes::add(&mut meshes),
        robot_cell: RobotCellMeshes::add(&mut meshes),
    };
    let halls = parts.div_ceil(HALL_PARTS);
    let columns = halls.isqrt().max(1);
    let rows = halls.div_ceil(columns);
    let tree = PartTree::of_root("assembly");
    let random = Random::keyed(seed, &[]);
    let mut placer = Placer { objects, parts: tree, left: 0, random };
    let first = |count: u32| -i64::from(count / 2);
    for number in 0..columns * rows {
        let column = first(columns) + i64::from(number % columns);
        let row = first(rows) + i64::from(number / columns);
        placer.left = share(parts, number, columns * rows);
        placer.random = Random::keyed(seed, &[column, row, 11]);
        let middle = vec3(column as f32 + 0.5, 0.0, row as f32 + 0.5) * PITCH_M;
        shapes.hall_at(&mut placer, number, Affine3A::from_translation(middle));
    }
    // Between the halls and through their gates; around the hall only if it is a single one.
    let lines = |count: u32| {
        let line = |number: u32| (first(count) as f32 + number as f32 * 0.5) * PITCH_M;
        let ends = if count == 1 { 0..=2 } else { 1..=2 * count - 1 };
        ends.map(line).filter(|line| line.abs() <= WALK_M).collect::<Vec<_>>()
    };
    let width_m = rows.min(columns) as f32 * PITCH_M;
    let middle = |count: u32| (first(count) as f32 + count as f32 * 0.5) * PITCH_M;
    let flight = Flight {
        centre: Vec3::new(middle(columns), 22.0, middle(rows)),
        radius_m: (width_m * 0.5).clamp(20.0, 90.0),
        down_rad: 0.6,
        // Halls are few and large, so they are visible from the whole circle.
        inwards_rad: 1.1,
    };
    let streets = Streets { xs: lines(columns), zs: lines(rows), turn_radius_m: 2.0 };
    let Placer { objects, parts, .. } = placer;
    let scene = Scene {
        name: "assembly".to_owned(),
        meshes: meshes.meshes,
        objects,
        light: Light::afternoon(),
        surfaces: None,
    };
    let generated = GeneratedScene { scene, routes: Routes { seed, streets, flight } };
    Ok(Assembly { generated, parts })
}

impl Shapes {
    /// Places a hall with its machines, as far as parts are left.
    fn hall_at(&self, placer: &mut Placer, number: u32, place: Affine3A) {
        let hall = placer.group(format!("hall {}", number + 1), PartId(0));
        self.hall.place(placer, hall, place);
        let quarter = |number: u32| {
            let side = |is_far: bool| if is_far { -1.0 } else { 1.0 };
            let middle = vec3(side(number & 1 == 0) * 4.7, 0.0, side(number & 2 == 0) * 4.5);
            // The far quarters are turned, so that all machines face the aisle.
            let turn = if number & 2 == 0 { 0.0 } else { std::f32::consts::PI };
            place * Affine3A::from_translation(middle) * Affine3A::from_rotation_y(turn)
        };
        let mut a = 0;
        let mut b = 1;
        let mut c = 2;
        let mut d = 3;
        if placer.random.below(2) == 1 {
            std::mem::swap(&mut a, &mut c);
            std::mem::swap(&mut b, &mut d);
        }
        if placer.random.below(2) == 1 {
            std::mem::swap(&mut a, &mut b);
        }
        placer.at_most(placer.left / 4, |placer| {
            self.robot_cell.place(placer, hall, quarter(a));
        });
        placer.at_most(placer.left / 4, |placer| {
            self.conveyor.place(placer, hall, quarter(b));
        });
        placer.at_most(placer.left.div_ceil(2), |placer| {
            self.gear_box.place_rack(placer, hall, quarter(c));
        });
        self.gear_box.place_rack(placer, hall, quarter(d));
    }
}
