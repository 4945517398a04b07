//! A lid on a hinge that turns until it touches something, by conservative advancement.
//!
//! A point at a distance of `r` from the axis moves by at most `r` times the angle. So a part at a
//! distance of `d` from another part cannot touch it within an angle of `d / r`. Each pair of parts
//! has its own safe angle, and only the pair whose safe angle ends first is measured again. No
//! contact between two measurements is missed, however thin a part is. The angles at which a pair
//! was found to be apart are kept, so dragging back and forth needs few new measurements.

use antumbra::glam::{Affine3A, Quat, Vec3};
use parry3d::math::{Pose, Real, Rot3, Vector};
use parry3d::query;
use parry3d::shape::TriMesh;
use scenes::Hinge;
use thiserror::Error;

/// The distance at which parts count as touching, in metres.
pub const TOUCH_M: f32 = 2.0e-5;

/// Millimetres per metre. The distance queries have absolute tolerances and take triangles of a few
/// thousandths of a unit for points: in metres they would find contacts that do not exist.
const MM: f32 = 1000.0;

/// The angle by which interpenetrating parts are turned at a time, in radians.
const ENTANGLED_STEP_RAD: f32 = 0.002;

/// The most measurements per turn. A turn that needs more stops before a contact.
const MOST_MEASUREMENTS: usize = 20_000;

/// The triangles of a part in the world, at the hinge's angle 0.
#[derive(Clone, Debug, PartialEq)]
pub struct CollisionSolid {
    /// The number of the part, for reports.
    pub part: usize,
    /// The corners, in metres.
    pub corners: Vec<Vec3>,
    /// Three indices of corners for each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// A solid that cannot be used for collisions.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("part {part} cannot collide: {reason}")]
pub struct BadSolid {
    /// The number of the part.
    pub part: usize,
    /// The reason.
    pub reason: String,
}

/// The end of a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// The angle at which it ended, in radians.
    pub angle_rad: f32,
    /// The parts in contact: a part of the lid, and a fixed one. `None` if the turn reached its
    /// target.
    pub contact: Option<Contact>,
}

/// Two parts that touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contact {
    /// The number of the part that turned.
    pub moving: usize,
    /// The number of the part that stood still.
    pub fixed: usize,
}

/// A part in the form that collision queries need.
struct Shape {
    part: usize,
    mesh: TriMesh,
}

/// Two parts that may touch.
#[derive(Clone, Copy)]
struct Pair {
    moving: usize,
    fixed: usize,
    /// The largest distance of the moving part from the axis.
    radius_m: f32,
    /// The angles at which they are known to be apart.
    free: FreeAngles,
}

/// A range of angles of the hinge at which two parts do not touch, in radians. It is empty unless
/// `low_rad` is below `high_rad`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FreeAngles {
    low_rad: f32,
    high_rad: f32,
}

impl FreeAngles {
    const NONE: Self = Self { low_rad: 0.0, high_rad: 0.0 };

    /// Returns the range around an angle at which a pair is `distance_m` apart. It ends where half
    /// of the touching distance may be left.
    fn around(angle_rad: f32, distance_m: f32, radius_m: f32) -> Self {
        let reach_rad = ((distance_m - 0.5 * TOUCH_M) / radius_m).max(0.0);
        Self { low_rad: angle_rad - reach_rad, high_rad: angle_rad + reach_rad }
    }

    /// Returns the union of this range and a known one if they overlap, else this range.
    fn joined(self, known: Self) -> Self {
        if known.high_rad < self.low_rad || self.high_rad < known.low_rad {
            return self;
        }
        Self {
            low_rad: self.low_rad.min(known.low_rad),
            high_rad: self.high_rad.max(known.high_rad),
        }
    }

    /// Returns the angle from `from_rad` to the end of the range in the direction of `sign`; `None`
    /// if `from_rad` is outside of the range.
    fn ahead_rad(&self, from_rad: f32, sign: f32) -> Option<f32> {
        let end_rad = if sign < 0.0 { self.low_rad } else { self.high_rad };
        let is_inside = self.low_rad < from_rad && from_rad < self.high_rad;
        is_inside.then_some((end_rad - from_rad).abs())
    }
}

/// The state of a pair during a turn.
#[derive(Clone, Copy)]
struct PairTurn {
    /// The index of the pair.
    pair: usize,
    /// The angle from the start up to which the pair cannot touch, in radians.
    safe_rad: f32,
    /// True once the pair was found apart.
    was_apart: bool,
}

/// The parts on both sides of a hinge.
pub struct LidCollision {
    hinge: Hinge,
    moving: Vec<Shape>,
    fixed: Vec<Shape>,
    /// The pairs that can collide: all pairs except those that interpenetrate by design, such as a
    /// pin and its bearing.
    pairs: Vec<Pair>,
}

impl LidCollision {
    /// Creates the collision of moving and fixed parts. Pairs that interpenetrate at the hinge's
    /// closed angle do so by design and never collide.
    ///
    /// # Errors
    /// A solid without triangles, or with indices that do not fit.
    pub fn new(
        hinge: Hinge,
        moving: &[CollisionSolid],
        fixed: &[CollisionSolid],
    ) -> Result<Self, BadSolid> {
        let moving_shapes = moving.iter().map(shape).collect::<Result<Vec<Shape>, BadSolid>>()?;
        let fixed_shapes = fixed.iter().map(shape).collect::<Result<Vec<Shape>, BadSolid>>()?;
        let mut collision =
            Self { hinge, moving: moving_shapes, fixed: fixed_shapes, pairs: Vec::new() };
        for (moving_index, solid) in moving.iter().enumerate() {
            let radii = solid.corners.iter().map(|corner| radius_m(&hinge, *corner));
            let radius_m = radii.fold(f32::MIN_POSITIVE, f32::max);
            for fixed_index in 0..fixed.len() {
                let free = FreeAngles::NONE;
                let mut pair = Pair { moving: moving_index, fixed: fixed_index, radius_m, free };
                let distance_m = collision.distance_m(pair, hinge.closed_rad);
                if distance_m > 0.0 {
                    pair.free = FreeAngles::around(hinge.closed_rad, distance_m, radius_m);
                    collision.pairs.push(pair);
                }
            }
        }
        Ok(collision)
    }

    /// Turns from one angle towards another, within the hinge's limits, until two present parts
    /// touch. A pair that touches at the start does not block the turn if it separates. Neither
    /// does a pair that interpenetrates at the start, until it is apart: one of its parts was not
    /// present before.
    pub fn turn(&mut self, from_rad: f32, to_rad: f32, is_there: &dyn Fn(usize) -> bool) -> Turn {
        let Hinge { shut_rad, open_rad, .. } = self.hinge;
        let to_rad = to_rad.clamp(shut_rad, open_rad);
        let sign = if to_rad < from_rad { -1.0 } else { 1.0 };
        let whole_rad = (to_rad - from_rad).abs();
        let mut turns = self.pair_turns(from_rad, sign, is_there);
        for _ in 0..MOST_MEASUREMENTS {
            let first = turns.iter_mut().min_by(|a, b| a.safe_rad.total_cmp(&b.safe_rad));
            let Some(turn) = first.filter(|turn| turn.safe_rad < whole_rad) else {
                return Turn { angle_rad: to_rad, contact: None };
            };
            let angle_rad = from_rad + sign * turn.safe_rad;
            let pair = self.pairs[turn.pair];
            let step_rad = TOUCH_M / pair.radius_m;
            let distance_m = self.distance_m(pair, angle_rad);
            if distance_m == 0.0 && !turn.was_apart {
                turn.safe_rad += ENTANGLED_STEP_RAD;
                continue;
            }
            turn.was_apart = true;
            if distance_m > TOUCH_M {
                let free = FreeAngles::around(angle_rad, distance_m, pair.radius_m);
                let free = free.joined(pair.free);
                self.pairs[turn.pair].free = free;
                turn.safe_rad += free.ahead_rad(angle_rad, sign).unwrap_or(step_rad);
            } else if self.separates(pair, angle_rad, sign * step_rad) {
                turn.safe_rad += step_rad;
            } else {
                let contact = Contact {
                    moving: self.moving[pair.moving].part,
                    fixed: self.fixed[pair.fixed].part,
                };
                return Turn { angle_rad, contact: Some(contact) };
            }
        }
        let reached_rad = turns.iter().fold(whole_rad, |least, turn| least.min(turn.safe_rad));
        Turn { angle_rad: from_rad + sign * reached_rad, contact: None }
    }

    /// Returns the turns of the pairs that are present, with their known free angles.
    fn pair_turns(
        &self,
        from_rad: f32,
        sign: f32,
        is_there: &dyn Fn(usize) -> bool,
    ) -> Vec<PairTurn> {
        let are_there = |pair: &Pair| {
            is_there(self.moving[pair.moving].part) && is_there(self.fixed[pair.fixed].part)
        };
        let known = self.pairs.iter().enumerate().filter(|(_, pair)| are_there(pair));
        let turn_of = |(index, pair): (usize, &Pair)| {
            let ahead_rad = pair.free.ahead_rad(from_rad, sign);
            PairTurn {
                pair: index,
                safe_rad: ahead_rad.unwrap_or(0.0),
                was_apart: ahead_rad.is_some(),
            }
        };
        known.map(turn_of).collect()
    }

    /// Returns true if a touching pair is farther apart after a small step.
    fn separates(&self, pair: Pair, angle_rad: f32, step_rad: f32) -> bool {
        let now_m = self.distance_m(pair, angle_rad);
        self.distance_m(pair, angle_rad + step_rad) > now_m
    }

    /// Returns the distance of a pair, in metres; 0 if the surfaces intersect.
    fn distance_m(&self, pair: Pair, angle_rad: f32) -> f32 {
        let moved = pose(&rotation(&self.hinge, angle_rad));
        let moving = &self.moving[pair.moving].mesh;
        let fixed = &self.fixed[pair.fixed].mesh;
        // Two triangle meshes are always supported.
        let found = query::distance(&moved, moving, &Pose::IDENTITY, fixed);
        found.map_or(0.0, |found| found.distance / MM)
    }
}

/// Returns the rotation about the axis of a hinge, which may be beyond its limits.
pub fn rotation(hinge: &Hinge, angle_rad: f32) -> Affine3A {
    let turn = Quat::from_axis_angle(hinge.axis, angle_rad);
    Affine3A::from_rotation_translation(turn, hinge.point - turn * hinge.point)
}

/// Returns the distance of a point from the axis of a hinge, in metres.
fn radius_m(hinge: &Hinge, point: Vec3) -> f32 {
    (point - hinge.point).reject_from_normalized(hinge.axis).length()
}

fn shape(solid: &CollisionSolid) -> Result<Shape, BadSolid> {
    let part = solid.part;
    let refuse = |reason: String| BadSolid { part, reason };
    let count = solid.corners.len() as u32;
    if solid.triangles.as_flattened().iter().any(|corner| *corner >= count) {
        return Err(refuse("an index names a corner that it does not have".to_owned()));
    }
    let corners = solid.corners.iter().map(|corner| vector(*corner)).collect();
    let mesh = TriMesh::new(corners, solid.triangles.clone());
    Ok(Shape { part, mesh: mesh.map_err(|error| refuse(error.to_string()))? })
}

/// Returns a place or a displacement in millimetres, for the queries.
fn vector(of: Vec3) -> Vector {
    let of_mm = of * MM;
    Vector::new(of_mm.x, of_mm.y, of_mm.z)
}

fn pose(of: &Affine3A) -> Pose {
    let (_, turn, place) = of.to_scale_rotation_translation();
    let [x, y, z, w]: [Real; 4] = turn.to_array();
    Pose::from_parts(vector(place), Rot3::from_xyzw(x, y, z, w))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the twelve triangles of a box.
    fn box_solid(part: usize, min: Vec3, max: Vec3) -> CollisionSolid {
        let corner = |index: usize| {
            let side = |bit: usize| if index >> bit & 1 == 1 { max } else { min };
            Vec3::new(side(0).x, side(1).y, side(2).z)
        };
        let triangles = [
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        CollisionSolid {
            part,
            corners: (0..8).map(corner).collect(),
            triangles: triangles.to_vec(),
        }
    }

    /// Returns the hinge of a lid that is two metres long, a centimetre above a body.
    fn hinge() -> Hinge {
        let point = Vec3::new(0.0, 0.01, -1.0);
        Hinge { point, axis: Vec3::NEG_X, shut_rad: 0.0, closed_rad: 0.0, open_rad: 2.0 }
    }

    fn lid() -> CollisionSolid {
        box_solid(1, Vec3::new(-1.0, 0.01, -1.0), Vec3::new(1.0, 0.06, 1.0))
    }

    fn body() -> CollisionSolid {
        box_solid(2, Vec3::new(-1.0, -1.0, -1.0), Vec3::new(1.0, 0.0, 1.0))
    }

    /// Returns a ceiling, 0.8 m over the body.
    fn ceiling() -> CollisionSolid {
        box_solid(3, Vec3::new(-1.0, 0.8, -1.0), Vec3::new(1.0, 0.9, 1.0))
    }

    fn collision(fixed: &[CollisionSolid]) -> LidCollision {
        LidCollision::new(hinge(), &[lid()], fixed).unwrap()
    }

    #[test]
    fn a_lid_turns_until_it_touches() {
        let turn = collision(&[body(), ceiling()]).turn(0.0, 1.5, &|_| true);
        // The upper edge of the lid's end moves on an arc about the axis and reaches the ceiling.
        let radius_m = 2.0_f32.hypot(0.05);
        let expected_rad = (0.79 / radius_m).asin() - 0.05_f32.atan2(2.0);
        assert!((turn.angle_rad - expected_rad).abs() < 2.0 * TOUCH_M, "{turn:?}");
        assert!(turn.angle_rad <= expected_rad, "it stops before it penetrates: {turn:?}");
        assert_eq!(turn.contact, Some(Contact { moving: 1, fixed: 3 }));
    }

    #[test]
    fn what_touches_at_the_start_may_separate_but_not_go_on() {
        let mut collision = collision(&[body(), ceiling()]);
        let touching_rad = collision.turn(0.0, 1.5, &|_| true).angle_rad;
        let back = collision.turn(touching_rad, 0.0, &|_| true);
        assert_eq!(back, Turn { angle_rad: 0.0, contact: None });
        let further = collision.turn(touching_rad, 1.5, &|_| true);
        assert!(further.contact.is_some() && (further.angle_rad - touching_rad).abs() < 1e-4);
    }

    #[test]
    fn what_comes_back_amid_a_part_lets_it_out() {
        let mut collision = collision(&[body(), ceiling()]);
        let beyond = collision.turn(0.0, 1.0, &|part| part != 3);
        assert_eq!(beyond, Turn { angle_rad: 1.0, contact: None });
        let back = collision.turn(1.0, 0.0, &|_| true);
        assert_eq!(back, Turn { angle_rad: 0.0, contact: None });
    }

    #[test]
    fn what_is_not_there_is_no_contact() {
        let turn = collision(&[body(), ceiling()]).turn(0.0, 1.5, &|part| part != 3);
        assert_eq!(turn, Turn { angle_rad: 1.5, contact: None });
    }

    #[test]
    fn what_is_known_to_be_free_is_not_measured_again() {
        let mut collision = collision(&[body(), ceiling()]);
        let first = collision.turn(0.0, 1.5, &|_| true);
        let known: Vec<FreeAngles> = collision.pairs.iter().map(|pair| pair.free).collect();
        // Each pair is known to be apart all the way from the closed lid to the contact.
        for free in &known {
            let ahead_rad = free.ahead_rad(1e-4, 1.0).unwrap();
            assert!(ahead_rad > first.angle_rad - 2e-4, "{free:?}, {first:?}");
        }
        let back = collision.turn(first.angle_rad, 0.0, &|_| true);
        assert_eq!(back, Turn { angle_rad: 0.0, contact: None });
        let again = collision.turn(0.0, 1.5, &|_| true);
        assert!((again.angle_rad - first.angle_rad).abs() < TOUCH_M, "{first:?}, {again:?}");
        assert_eq!(again.contact, first.contact);
    }

    #[test]
    fn a_sheet_thinner_than_any_step_stops_it() {
        let sheet = box_solid(7, Vec3::new(-0.5, 0.9, 0.5), Vec3::new(0.5, 0.900_01, 0.9));
        let turn = collision(&[body(), sheet]).turn(0.0, 1.9, &|_| true);
        assert_eq!(turn.contact, Some(Contact { moving: 1, fixed: 7 }));
        assert!(turn.angle_rad > 0.3 && turn.angle_rad < 0.8, "{turn:?}");
    }

    #[test]
    fn small_triangles_near_each_other_do_not_touch() {
        let made = scenes::waffle_maker();
        let lid = crate::document::Lid { group: made.lid, hinge: made.hinge };
        let mut document = crate::document::Document::new(made.scene, made.parts, Some(lid));
        // Lid and body are 0.6 mm apart along their rims, which have round corners.
        let turn = document.turn_lid(1.0).unwrap();
        assert_eq!(turn, Turn { angle_rad: 1.0, contact: None });
        let back = document.turn_lid(0.0).unwrap();
        assert_eq!(back, Turn { angle_rad: made.hinge.closed_rad, contact: None });
        let shut = document.turn_lid(-1.0).unwrap();
        assert!(shut.angle_rad < -0.001 && shut.angle_rad > made.hinge.shut_rad, "{shut:?}");
        assert!(shut.contact.is_some());
    }

    #[test]
    fn the_limits_of_the_hinge_hold() {
        let turn = collision(&[body()]).turn(0.0, 9.0, &|_| true);
        assert_eq!(turn, Turn { angle_rad: 2.0, contact: None });
    }

    #[test]
    fn a_pin_in_its_bearing_is_no_contact() {
        let pin = box_solid(3, Vec3::new(-1.0, 0.0, -1.01), Vec3::new(1.0, 0.02, -0.99));
        let turn = collision(&[pin]).turn(0.0, 1.0, &|_| true);
        assert_eq!(turn, Turn { angle_rad: 1.0, contact: None });
    }

    #[test]
    fn broken_solids_are_refused() {
        let mut broken = lid();
        broken.triangles.push([0, 1, 99]);
        let refused = LidCollision::new(hinge(), &[broken], &[body()]).err().unwrap();
        assert!(refused.to_string().contains("part 1 cannot collide"), "{refused}");
        let empty = CollisionSolid { part: 5, corners: Vec::new(), triangles: Vec::new() };
        assert!(LidCollision::new(hinge(), &[empty], &[body()]).is_err());
    }
}
