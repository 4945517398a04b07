//! A city in the proportions of the samples' one, and walks through it.

use antumbra_cull::{Aabb, Camera, Projection};
use glam::{Quat, Vec2, Vec2Swizzles, Vec3, Vec3Swizzles, vec2, vec3};

use crate::image::Shift;
use crate::random::Random;
use crate::scene::{Scene, city};

/// The distance between the middles of neighbouring blocks (metres).
const TILE_M: f32 = 64.0;
/// The number of blocks along a side of a district.
const DISTRICT: i32 = 6;
/// A sixth of the side of a block that can be built on (metres).
const LOT_M: f32 = 44.0 / 6.0;
/// The distance between a building's box and the edge of its lot, and between the box and the
/// walls (metres).
const CLEARANCE_M: f32 = 0.335;
const OVERHANG_M: f32 = 0.3;
/// The distance from the middle of a block to the kerb (metres).
const KERB_M: f32 = 26.0;

/// A place for a building, in lots: its corner and its size.
type Lot = [i8; 4];

/// Ways to divide six by six lots.
const DIVISIONS: [&[Lot]; 5] = [
    &[
        [0, 0, 2, 2],
        [2, 0, 2, 2],
        [4, 0, 2, 2],
        [0, 2, 2, 2],
        [4, 2, 2, 2],
        [0, 4, 2, 2],
        [2, 4, 2, 2],
        [4, 4, 2, 2],
    ],
    &[
        [0, 0, 3, 2],
        [3, 0, 3, 2],
        [0, 2, 2, 2],
        [4, 2, 2, 2],
        [0, 4, 2, 2],
        [2, 4, 2, 2],
        [4, 4, 2, 2],
    ],
    &[[0, 0, 3, 2], [3, 0, 3, 2], [0, 2, 2, 2], [4, 2, 2, 2], [0, 4, 3, 2], [3, 4, 3, 2]],
    &[[0, 0, 4, 2], [4, 0, 2, 4], [2, 4, 4, 2], [0, 2, 2, 4], [2, 2, 2, 2]],
    &[[0, 0, 3, 3], [3, 0, 3, 3], [0, 3, 3, 3], [3, 3, 3, 3]],
];

/// A scene under construction.
#[derive(Default)]
struct City {
    bounds: Vec<Aabb>,
    solids: Vec<Aabb>,
}

impl City {
    /// Adds an object on the ground with the size of its box, and the part of the box that is
    /// solid.
    fn put(&mut self, place: Vec2, size: Vec3, solid: [Vec3; 2]) {
        let corner = vec3(place.x - size.x * 0.5, 0.13, place.y - size.z * 0.5);
        self.bounds.push(Aabb::new(corner, corner + size));
        let [low, high] = solid.map(|share| corner + size * share);
        self.solids.push(Aabb::new(low, high));
    }

    fn whole(&mut self, place: Vec2, size: Vec3) {
        self.put(place, size, [Vec3::ZERO, Vec3::ONE]);
    }

    fn block(&mut self, middle: Vec2, random: &mut Random) {
        let half = vec3(TILE_M * 0.5, 0.06, TILE_M * 0.5);
        let ground = vec3(middle.x, 0.06, middle.y);
        self.bounds.push(Aabb::new(ground - half, ground + half));
        self.solids.push(Aabb::new(ground - half, ground + half));
        for lot in DIVISIONS[random.below(DIVISIONS.len())] {
            let [x, z, width, depth] = lot.map(f32::from);
            let place = (vec2(x + width * 0.5, z + depth * 0.5) - 3.0) * LOT_M;
            let floors = match width as u32 * depth as u32 {
                4 => 3 + random.below(7),
                9 => 3 + random.below(9),
                _ => 3 + random.below(4),
            };
            let roof_m = [0.4, 2.5, 4.0][random.below(3)];
            let walls_m = 4.0 + 3.2 * floors as f32;
            let sides = vec2(width, depth) * LOT_M - 2.0 * CLEARANCE_M;
            let size = vec3(sides.x, walls_m + roof_m, sides.y);
            let inset = Vec3::new(OVERHANG_M / size.x, 0.0, OVERHANG_M / size.z);
            let top = Vec3::ONE.with_y(walls_m / size.y);
            self.put(middle + place, size, [inset, top - inset]);
        }
        for side in 0..4_u8 {
            let turn = Vec2::from_angle(f32::from(side) * std::f32::consts::FRAC_PI_2);
            let mut at = |along: f32, out: f32, size: Vec3, solid: [Vec3; 2]| {
                let place = middle + turn.rotate(vec2(along, out));
                let swap = |size: Vec3| if side % 2 == 0 { size } else { size.zyx() };
                self.put(place, swap(size), solid.map(swap));
            };
            // A lamp, trees and small things on the pavement, and cars at the kerb.
            let pole = [vec3(0.35, 0.0, 0.45), vec3(0.65, 1.0, 0.55)];
            at(-12.0, KERB_M - 0.9, vec3(0.4, 5.0, 1.4), pole);
            for place in 0..11_u8 {
                let along = -20.0 + 4.0 * f32::from(place);
                let small = random.point(0.4, 1.1);
                if along != -12.0 && random.chance(0.12) {
                    at(
                        along,
                        KERB_M - 0.8,
                        small,
                        [Vec3::splat(0.1).with_y(0.0), Vec3::splat(0.9)],
                    );
                }
                if along != -12.0 && random.chance(0.05) {
                    let crown = [vec3(0.2, 0.4, 0.2), vec3(0.8, 0.9, 0.8)];
                    at(along, KERB_M - 1.8, vec3(3.2, 6.0, 3.2), crown);
                }
                if random.chance(0.12) {
                    let body = [vec3(0.05, 0.15, 0.1), vec3(0.95, 0.6, 0.9)];
                    at(along, KERB_M + 1.3, vec3(4.3, 1.5, 1.8), body);
                }
            }
        }
    }

    /// Adds the walls around the districts, gate houses at the ends of streets, and towers.
    fn walls(&mut self, blocks: i32) {
        for line in (-blocks..=blocks).filter(|line| line.rem_euclid(DISTRICT) == DISTRICT / 2) {
            for block in -blocks..=blocks {
                let end = vec2(line as f32, block as f32) * TILE_M;
                let middle = end + vec2(0.0, TILE_M * 0.5);
                let long_m = TILE_M - 10.0;
                if block < blocks {
                    self.whole(middle, vec3(1.5, 12.0, long_m));
                    self.whole(middle.yx(), vec3(long_m, 12.0, 1.5));
                }
                self.whole(end, vec3(9.0, 16.0, 9.0));
                if block.rem_euclid(DISTRICT) != DISTRICT / 2 {
                    self.whole(end.yx(), vec3(9.0, 16.0, 9.0));
                }
            }
        }
    }
}

/// Returns a city of `2 * blocks` by `2 * blocks` blocks around the origin. Streets run along the
/// multiples of 64 m; the middle district lies between -192 m and 192 m.
pub fn district_city(random: &mut Random, blocks: i32) -> Scene {
    let mut city = City::default();
    for row in -blocks..blocks {
        for column in -blocks..blocks {
            let middle = (vec2(column as f32, row as f32) + 0.5) * TILE_M;
            city.block(middle, random);
        }
    }
    city.walls(blocks);
    let City { bounds, solids } = city;
    let shifts: Vec<Shift> = vec![[0.0; 2]; bounds.len()];
    Scene { bounds, solids, shifts }
}

/// A scene of the experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The city of the simulated GPU: solid blocks on a narrow grid, without an end.
    Blocks,
    /// The city in walled districts.
    Districts,
}

impl Place {
    pub fn scene(self, random: &mut Random) -> Scene {
        match self {
            Self::Blocks => Scene::solid(city(random, 24)),
            Self::Districts => district_city(random, 5),
        }
    }

    /// Returns the distance between streets, and the place of a street (metres).
    fn grid_m(self) -> [f32; 2] {
        match self {
            Self::Blocks => [8.0, -1.25],
            Self::Districts => [TILE_M, 0.0],
        }
    }
}

/// A way to move, at 60 frames per second.
#[derive(Clone, Copy, Debug)]
pub enum Motion {
    /// A walk straight ahead, at a speed (metres per second).
    Straight(f32),
    /// A walk that takes corners and looks left and right, at a speed (metres per second).
    Walk(f32),
    /// A turn at a place, at an angular speed (radians per second).
    Turn(f32),
    /// A circle over the roofs, at a speed (metres per second).
    Fly(f32),
}

/// The angle by which a walker looks to the left and right (radians), and the distance in which it
/// does so (metres).
const GLANCE_RAD: f32 = 0.2;
const GLANCE_PERIOD_M: f32 = 40.0;
const TURN_RADIUS_M: f32 = 2.5;

impl Motion {
    /// Returns the camera of a frame of the walk that begins after `start` metres or radians.
    pub fn camera(self, place: Place, start: f32, frame: u32) -> Camera {
        let [tile_m, street_m] = place.grid_m();
        let seconds = frame as f32 / 60.0;
        let walker = |place: Vec2, heading: f32| camera(vec3(place.x, 1.7, place.y), heading, 0.05);
        match self {
            Self::Straight(speed) => {
                let along = start + speed * seconds - tile_m;
                walker(vec2(street_m, street_m + along), std::f32::consts::FRAC_PI_2)
            }
            Self::Walk(speed) => {
                let way = start + speed * seconds;
                let [place, heading] = staircase(way, tile_m);
                let glance = GLANCE_RAD * (std::f32::consts::TAU * way / GLANCE_PERIOD_M).sin();
                walker(place + street_m, heading.x + glance)
            }
            Self::Turn(speed) => {
                let along = (start * 17.0) % tile_m;
                walker(vec2(street_m, street_m + along), start + speed * seconds)
            }
            Self::Fly(speed) => {
                let radius_m = 160.0;
                let turn = start + speed * seconds / radius_m;
                let place = Vec2::from_angle(turn) * radius_m;
                let heading = turn + std::f32::consts::FRAC_PI_2 + 0.6;
                camera(vec3(place.x, 64.0, place.y), heading, -0.32)
            }
        }
    }
}

/// Returns the place of a walk around a square of two blocks, and its heading in x.
fn staircase(way_m: f32, tile_m: f32) -> [Vec2; 2] {
    let arc_m = TURN_RADIUS_M * std::f32::consts::FRAC_PI_2;
    let straight_m = 2.0 * tile_m - 2.0 * TURN_RADIUS_M;
    let leg_m = straight_m + arc_m;
    let leg = (way_m / leg_m).floor();
    let walked_m = way_m - leg * leg_m;
    let quarter = (leg as i32).rem_euclid(4) as f32 * std::f32::consts::FRAC_PI_2;
    let angle = (walked_m - straight_m).max(0.0) / TURN_RADIUS_M;
    let ahead = walked_m.min(straight_m) + TURN_RADIUS_M * (1.0 + angle.sin());
    let aside = TURN_RADIUS_M * (1.0 - angle.cos());
    let local = vec2(ahead - tile_m, aside - tile_m);
    [Vec2::from_angle(quarter).rotate(local), Vec2::splat(quarter + angle)]
}

fn camera(eye: Vec3, heading: f32, up_rad: f32) -> Camera {
    let level = Quat::from_rotation_y(-heading) * Vec3::X;
    Camera {
        eye,
        forward: level * up_rad.cos() + Vec3::Y * up_rad.sin(),
        up: Vec3::Y,
        projection: Projection::perspective(std::f32::consts::FRAC_PI_3),
        near: 0.2,
    }
}
