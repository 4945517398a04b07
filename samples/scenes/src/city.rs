//! The procedural city: blocks of buildings and street furniture in walled districts, so that at
//! eye level a street and hardly anything of the rest of the city is visible.
//!
//! Streets run straight through a district of six by six blocks and end at a gate house between
//! walls. The view from a street is the same in a city of ten thousand objects and of a million;
//! only the hidden part grows.

mod buildings;
mod facade;
mod furniture;
pub(super) mod ground;
mod layout;
pub(super) mod palette;
pub(super) mod pavilions;
mod plants;
pub(super) mod props;
mod roofs;
mod shelters;
mod vehicles;
mod walls;

use glam::{Vec2, Vec3, vec2, vec3};
use scene::{Light, Mesh, MeshId, Object, Scene};

use self::buildings::Footprint;
pub(super) use self::furniture::{LAMP_NAME, lamp_colours};
use self::ground::{KERB_M, Middle, PAVEMENT_M};
use self::layout::{Axis, Court, DIVISIONS, Plan, block_centre, boundary_m};
pub(super) use self::palette::glass_colours;
use self::palette::{Materials, TintKind, prop_tint, stone_tint, wall_tint};
use self::props::Site;
use super::error::GeneratorError;
use super::generated::{GeneratedScene, HOVER_M, placement, room_for_objects, share};
use super::random::Random;
use super::routes::{AIRCRAFT_INWARDS_RAD, Flight, Routes, Streets};

/// The distance between a district's wall and the walking line along it, in metres.
const WALL_WALK_M: f32 = 5.4;

/// The gap between the kerb and a parked car, and between the kerb and an object on the pavement,
/// in metres.
const PARKING_GAP_M: f32 = 0.35;
const PAVEMENT_GAP_M: f32 = 0.15;

/// Generates a city of exactly `objects` objects.
///
/// # Errors
/// [`GeneratorError::ObjectCount`] if `objects` is 0 or more than
/// [`MAX_OBJECTS`](super::MAX_OBJECTS).
pub fn city(objects: u32, seed: u64) -> Result<GeneratedScene, GeneratorError> {
    let room = room_for_objects(objects)?;
    let plan = Plan::new(objects);
    let (kit, meshes) = Kit::new();
    let mut city = City { seed, plan, kit, meshes, objects: room };
    let blocks = city.plan.blocks();
    let columns = city.plan.columns.clone();
    let rows = city.plan.rows.clone();
    let mut number = 0;
    for row in rows.first()..rows.last() {
        for column in columns.first()..columns.last() {
            let budget =
                share(objects, number, blocks).saturating_add_signed(city.swing(number, blocks));
            city.block(column, row, budget);
            number += 1;
        }
    }
    let routes = Routes { seed, streets: streets(&city.plan), flight: flight(&city.plan) };
    let scene = Scene {
        name: "city".to_owned(),
        meshes: city.meshes,
        objects: city.objects,
        light: Light::afternoon(),
        surfaces: None,
    };
    Ok(GeneratedScene { scene, routes })
}

/// A kind of prop with its properties for the layout of a block.
#[derive(Clone, Copy)]
struct Choice {
    mesh: MeshId,
    tint: TintKind,
}

/// The meshes by use.
struct Kit {
    grounds: [MeshId; 2],
    wall: MeshId,
    gate_house: MeshId,
    corner_tower: MeshId,
    /// The buildings, by footprint in the order of [`Footprint::ALL`].
    buildings: [Vec<MeshId>; 4],
    lamps: Vec<Choice>,
    pavement: Vec<Choice>,
    parking: Vec<Choice>,
    court: Vec<Choice>,
}

impl Kit {
    fn new() -> (Self, Vec<Mesh>) {
        let materials = Materials::new();
        let mut meshes = Vec::new();
        let mut add = |mesh: Mesh| {
            meshes.push(mesh);
            MeshId(meshes.len() as u32 - 1)
        };
        let mut kit = Self {
            grounds: [
                add(ground::tile("ground, paved", Middle::Paved)),
                add(ground::tile("ground, planted", Middle::Planted)),
            ],
            wall: add(walls::wall(&materials)),
            gate_house: add(walls::gate_house(&materials)),
            corner_tower: add(walls::corner_tower(&materials)),
            buildings: Default::default(),
            lamps: Vec::new(),
            pavement: Vec::new(),
            parking: Vec::new(),
            court: Vec::new(),
        };
        for (footprint, mesh) in buildings::meshes(&materials) {
            let id = add(mesh);
            for (kind, ids) in Footprint::ALL.iter().zip(&mut kit.buildings) {
                if *kind == footprint {
                    ids.push(id);
                }
            }
        }
        for prop in props::props(&materials) {
            let choice = Choice { mesh: add(prop.mesh), tint: prop.tint };
            let choices = match prop.site {
                Site::Lamp => &mut kit.lamps,
                Site::Pavement => &mut kit.pavement,
                Site::Parking => &mut kit.parking,
                Site::Court => &mut kit.court,
            };
            choices.extend((0..prop.weight).map(|_| choice));
        }
        (kit, meshes)
    }
}

fn choose<T: Copy>(choices: &[T], random: &mut Random) -> Option<T> {
    choices.get(random.below(choices.len() as u32) as usize).copied()
}

/// A place for a prop in a block.
#[derive(Clone, Copy)]
enum Slot {
    /// A place on the pavement of a side, this far along it.
    Pavement { side: usize, along: f32 },
    /// A place on the road at a side, this far along it.
    Parking { side: usize, along: f32 },
    /// A place in the court.
    Court { place: Vec2 },
}

struct City {
    seed: u64,
    plan: Plan,
    kit: Kit,
    meshes: Vec<Mesh>,
    objects: Vec<Object>,
}

impl City {
    /// Returns the number of objects that move from a block to its neighbour. It is small: blocks
    /// differ, but the sum stays the same.
    fn swing(&self, number: u32, blocks: u32) -> i32 {
        if number ^ 1 >= blocks || blocks < 16 {
            return 0;
        }
        let swing = Random::keyed(self.seed, &[i64::from(number / 2), 1]).below(5) as i32 - 2;
        if number.is_multiple_of(2) { swing } else { -swing }
    }

    fn block(&mut self, column: i32, row: i32, budget: u32) {
        let limit = self.objects.len() + budget as usize;
        let centre = block_centre(column, row);
        let mut random = Random::keyed(self.seed, &[i64::from(column), i64::from(row), 0]);
        let number = random.below(DIVISIONS.len() as u32) as usize;
        let Some(division) = DIVISIONS.get(number) else { return };
        let ground = self.kit.grounds[usize::from(division.court == Court::Open)];
        let plain = prop_tint(TintKind::Plain, &mut random);
        self.put(limit, ground, placement(0, 1.0, vec3(centre.x, 0.0, centre.y)), plain);
        self.closures(limit, column, row, &mut random);
        let columns = &self.plan.columns;
        let rows = &self.plan.rows;
        let district = [columns.district(column), rows.district(row)];
        let family =
            Random::keyed(self.seed, &[district[0], district[1], 2]).below(palette::WALL_FAMILIES);
        for lot in division.lots {
            let kind = Footprint::ALL.iter().position(|kind| *kind == lot.footprint).unwrap_or(0);
            let Some(mesh) = choose(&self.kit.buildings[kind], &mut random) else { continue };
            let side = lot.facing();
            let place = centre + lot.centre();
            let tint = wall_tint(family, &mut random);
            let position = vec3(place.x, PAVEMENT_M + HOVER_M, place.y);
            self.put(limit, mesh, placement(side, 1.0, position), tint);
        }
        self.props(limit, [column, row], division.court, &mut random);
    }

    fn put(&mut self, limit: usize, mesh: MeshId, transform: glam::Affine3A, tint: u32) {
        if self.objects.len() < limit {
            self.objects.push(Object { mesh, transform, tint });
        }
    }

    /// Adds walls, gate houses and towers on this block's lower boundaries, and on its upper
    /// boundaries at the end of the city.
    fn closures(&mut self, limit: usize, column: i32, row: i32, random: &mut Random) {
        let own = |at: i32, last: i32| if at + 1 == last { at..at + 2 } else { at..at + 1 };
        let xs = own(column, self.plan.columns.last());
        let zs = own(row, self.plan.rows.last());
        let middle = block_centre(column, row);
        for x in xs.clone() {
            if self.plan.columns.is_cut(x) {
                let tint = stone_tint(random);
                self.put(
                    limit,
                    self.kit.wall,
                    placement(1, 1.0, vec3(boundary_m(x), HOVER_M, middle.y)),
                    tint,
                );
            }
        }
        for z in zs.clone() {
            if self.plan.rows.is_cut(z) {
                let tint = stone_tint(random);
                self.put(
                    limit,
                    self.kit.wall,
                    placement(0, 1.0, vec3(middle.x, HOVER_M, boundary_m(z))),
                    tint,
                );
            }
        }
        for x in xs.clone() {
            for z in zs.clone() {
                let cut_x = self.plan.columns.is_cut(x);
                let cut_z = self.plan.rows.is_cut(z);
                let mesh = match (cut_x, cut_z) {
                    (true, true) => self.kit.corner_tower,
                    (false, false) => continue,
                    _ => self.kit.gate_house,
                };
                let tint = stone_tint(random);
                let position = vec3(boundary_m(x), HOVER_M, boundary_m(z));
                self.put(limit, mesh, placement(usize::from(cut_x), 1.0, position), tint);
            }
        }
    }

    fn props(&mut self, limit: usize, cell: [i32; 2], court: Court, random: &mut Random) {
        let [column, row] = cell;
        let centre = block_centre(column, row);
        for side in 0..4 {
            let lamp = choose(&self.kit.lamps, random);
            self.prop(limit, lamp, centre, Slot::Pavement { side, along: -12.0 }, random);
        }
        let mut slots: Vec<Slot> = Vec::with_capacity(80);
        for side in 0..4 {
            let boundary_is_cut = match side {
                0 => self.plan.rows.is_cut(row + 1),
                1 => self.plan.columns.is_cut(column + 1),
                2 => self.plan.rows.is_cut(row),
                _ => self.plan.columns.is_cut(column),
            };
            let places = (0..11u8)
                .map(|place| -20.0 + 4.0 * f32::from(place))
                .filter(|&along| along != -12.0);
            slots.extend(places.map(|along| Slot::Pavement { side, along }));
            if !boundary_is_cut {
                let places = (0..7u8).map(|place| -18.0 + 6.0 * f32::from(place));
                slots.extend(places.map(|along| Slot::Parking { side, along }));
            }
        }
        if court == Court::Open {
            let around = [vec2(-4.4, -4.4), vec2(4.4, -4.4), vec2(-4.4, 4.4), vec2(4.4, 4.4)];
            slots.extend(around.map(|place| Slot::Court { place }));
            slots.push(Slot::Court { place: Vec2::ZERO });
        }
        random.shuffle(&mut slots);
        for slot in slots {
            if self.objects.len() >= limit {
                break;
            }
            let choices = match slot {
                Slot::Pavement { .. } => &self.kit.pavement,
                Slot::Parking { .. } => &self.kit.parking,
                Slot::Court { place } if place == Vec2::ZERO => &self.kit.court,
                Slot::Court { .. } => &self.kit.pavement,
            };
            let choice = choose(choices, random);
            self.prop(limit, choice, centre, slot, random);
        }
    }

    fn prop(
        &mut self,
        limit: usize,
        choice: Option<Choice>,
        centre: Vec2,
        slot: Slot,
        random: &mut Random,
    ) {
        let Some(choice) = choice else { return };
        let Some(bounds) = self.meshes.get(choice.mesh.0 as usize).map(|mesh| mesh.bounds) else {
            return;
        };
        let tint = prop_tint(choice.tint, random);
        let scale = if choice.tint == TintKind::Leaf { random.between(0.85, 1.0) } else { 1.0 };
        let extent = bounds.max.abs().max(bounds.min.abs()) * scale;
        // Slots are 4 m apart, parking slots 6 m, so short objects may be shifted to the left or
        // right.
        let jitter = if extent.x < 1.5 { random.between(-0.3, 0.3) } else { 0.0 };
        let around = 2 * random.below(2) as usize;
        let (side, along, out, low) = match slot {
            Slot::Pavement { side, along } => {
                (side, along, KERB_M - PAVEMENT_GAP_M - extent.z, PAVEMENT_M)
            }
            Slot::Parking { side, along } => (side, along, KERB_M + PARKING_GAP_M + extent.z, 0.0),
            Slot::Court { place } => {
                let position = vec3(centre.x + place.x, PAVEMENT_M + HOVER_M, centre.y + place.y);
                self.put(limit, choice.mesh, placement(around, scale, position), tint);
                return;
            }
        };
        let place = placement(side, 1.0, vec3(centre.x, low + HOVER_M, centre.y));
        let position = place.transform_point3(vec3(along + jitter, 0.0, out));
        let turn = if matches!(slot, Slot::Parking { .. }) || choice.tint == TintKind::Leaf {
            side + around
        } else {
            side
        };
        self.put(limit, choice.mesh, placement(turn, scale, position), tint);
    }
}

/// Returns the walking lines in the middle district: along its streets and inside its walls.
fn streets(plan: &Plan) -> Streets {
    let lines = |axis: &Axis| {
        let [first, last] = axis.middle;
        let inner = (first + 1..last).map(boundary_m);
        let walls = [boundary_m(first) + WALL_WALK_M, boundary_m(last) - WALL_WALK_M];
        [walls[0]].into_iter().chain(inner).chain([walls[1]]).collect()
    };
    Streets { xs: lines(&plan.columns), zs: lines(&plan.rows), turn_radius_m: 2.5 }
}

fn flight(plan: &Plan) -> Flight {
    let ends = |axis: &Axis| [boundary_m(axis.first()), boundary_m(axis.last())];
    let [x0, x1] = ends(&plan.columns);
    let [z0, z1] = ends(&plan.rows);
    let radius_m = ((x1 - x0).min(z1 - z0) * 0.35).clamp(16.0, 160.0);
    Flight {
        centre: Vec3::new((x0 + x1) / 2.0, 64.0, (z0 + z1) / 2.0),
        radius_m,
        down_rad: 0.32,
        inwards_rad: AIRCRAFT_INWARDS_RAD,
    }
}
