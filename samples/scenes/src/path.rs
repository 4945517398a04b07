//! Camera paths: the camera of a frame, as a pure function of the frame's number.

mod tour;

use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::fmt;
use std::str::FromStr;

use cull::{Camera, Projection, trigonometry};
use glam::{Vec2, Vec3, vec2};
use scene::{FOV_Y_RAD, NEAR_M};

use self::tour::Tour;
use super::error::GeneratorError;
use super::random::Random;
use super::routes::{Flight, Routes, Streets};

/// The height of a walker's eye above the road, in metres.
pub(crate) const EYE_HEIGHT_M: f32 = 1.7;

/// The distance that a walker covers per frame, in metres: 3 m/s at 30 frames per second.
const WALK_STEP_M: f64 = 0.1;

/// The distance that an aircraft covers per frame, in metres.
const FLY_STEP_M: f64 = 0.5;

/// The fewest frames of a circle: small circles are flown more slowly.
const FLY_LEAST_FRAMES: f64 = 120.0;

/// The number of frames for which the path `cut` stays in one place.
const CUT_FRAMES: u32 = 10;

/// The largest angle of the view to the side after a jump, in radians.
const CUT_ASIDE_RAD: f32 = 1.3;

/// The angle by which a walker glances to the left and right, in radians, and the approximate
/// distance of a full glance.
const GLANCE_RAD: f32 = 0.2;
const GLANCE_PERIOD_M: f64 = 40.0;

/// The kinds of paths, with names for [`FromStr`] and [`Display`](fmt::Display).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PathKind {
    /// `street`: a walk at eye level; nearly all objects are hidden.
    Street,
    /// `fly`: a circle over the roofs; few objects are hidden.
    Fly,
    /// `cut`: a walk that jumps to another place and direction every tenth frame.
    Cut,
}

impl PathKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Street, Self::Fly, Self::Cut];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Street => "street",
            Self::Fly => "fly",
            Self::Cut => "cut",
        }
    }
}

impl fmt::Display for PathKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for PathKind {
    type Err = GeneratorError;

    fn from_str(name: &str) -> Result<Self, GeneratorError> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| GeneratorError::UnknownPath { name: name.to_owned() })
    }
}

/// A path along routes. Walks and flights are closed, so they have any number of frames.
#[derive(Clone, Debug)]
pub struct CameraPath {
    kind: PathKind,
    route: Route,
}

#[derive(Clone, Debug)]
enum Route {
    Walk(Tour),
    Circle(Flight),
    Jumps { streets: Streets, seed: u64 },
}

impl CameraPath {
    /// Creates a path of this kind through the scene with these routes.
    ///
    /// # Errors
    /// [`GeneratorError::NoStreets`] for a walk in a scene without streets.
    pub fn new(kind: PathKind, routes: &Routes) -> Result<Self, GeneratorError> {
        let streets = &routes.streets;
        let no_streets = || GeneratorError::NoStreets;
        let route = match kind {
            PathKind::Fly => Route::Circle(routes.flight),
            PathKind::Street => {
                Route::Walk(Tour::new(streets, routes.seed).ok_or_else(no_streets)?)
            }
            PathKind::Cut if streets.xs.len() < 2 || streets.zs.len() < 2 => {
                return Err(no_streets());
            }
            PathKind::Cut => Route::Jumps { streets: streets.clone(), seed: routes.seed },
        };
        Ok(Self { kind, route })
    }

    /// Returns the kind of the path.
    pub fn kind(&self) -> PathKind {
        self.kind
    }

    /// Returns the camera of a frame.
    pub fn camera(&self, frame: u32) -> Camera {
        match &self.route {
            Route::Walk(tour) => {
                let way = f64::from(frame) * WALK_STEP_M % tour.length_m();
                let (place, heading) = tour.at(way as f32);
                // The tour has a whole number of glances, so that it closes without a jerk.
                let glances = (tour.length_m() / GLANCE_PERIOD_M).round().max(1.0);
                let phase = (way / tour.length_m() * glances).fract() as f32;
                walker(place, heading + GLANCE_RAD * trigonometry::sin(TAU * phase))
            }
            Route::Circle(flight) => aircraft(flight, frame),
            Route::Jumps { streets, seed } => jump(streets, *seed, frame),
        }
    }
}

/// Returns an angle as a horizontal direction: 0 is +x, a quarter turn is +z.
fn direction(heading: f32) -> Vec2 {
    vec2(trigonometry::cos(heading), trigonometry::sin(heading))
}

fn camera(eye: Vec3, heading: f32, up_rad: f32) -> Camera {
    let level = direction(heading) * trigonometry::cos(up_rad);
    Camera {
        eye,
        forward: Vec3::new(level.x, trigonometry::sin(up_rad), level.y),
        up: Vec3::Y,
        projection: Projection::perspective(FOV_Y_RAD),
        near: NEAR_M,
    }
}

fn walker(place: Vec2, heading: f32) -> Camera {
    camera(Vec3::new(place.x, EYE_HEIGHT_M, place.y), heading, 0.05)
}

fn aircraft(flight: &Flight, frame: u32) -> Camera {
    let around = f64::from(TAU * flight.radius_m);
    let step_m = FLY_STEP_M.min(around / FLY_LEAST_FRAMES);
    let turn = (f64::from(frame) * step_m % around / around) as f32 * TAU;
    let place = direction(turn) * flight.radius_m;
    let eye = flight.centre + Vec3::new(place.x, 0.0, place.y);
    camera(eye, turn + FRAC_PI_2 + flight.inwards_rad, -flight.down_rad)
}

fn jump(streets: &Streets, seed: u64, frame: u32) -> Camera {
    let number = frame / CUT_FRAMES;
    let step = frame % CUT_FRAMES;
    let mut random = Random::keyed(seed, &[i64::from(number), 4]);
    let xs = &streets.xs;
    let zs = &streets.zs;
    let mut line = |lines: &[f32]| random.below(lines.len() as u32) as usize;
    let column = line(xs);
    let row = line(zs);
    let along_x = random.below(2) == 0;
    let lines = if along_x { xs } else { zs };
    let from = if along_x { column } else { row }.min(lines.len().saturating_sub(2));
    let ends = [from, from + 1].map(|line| lines.get(line).copied().unwrap_or_default());
    let walked = (f64::from(step) * WALK_STEP_M) as f32;
    let whole = (f64::from(CUT_FRAMES) * WALK_STEP_M) as f32;
    let start = random.between(0.0, (ends[1] - ends[0] - whole).max(0.0));
    let forwards = random.below(2) == 0;
    let along = if forwards { ends[0] + start + walked } else { ends[1] - start - walked };
    let fixed = |lines: &[f32], line: usize| lines.get(line).copied().unwrap_or_default();
    let place = if along_x { vec2(along, fixed(zs, row)) } else { vec2(fixed(xs, column), along) };
    let ahead = match (along_x, forwards) {
        (true, true) => 0.0,
        (true, false) => PI,
        (false, true) => FRAC_PI_2,
        (false, false) => -FRAC_PI_2,
    };
    walker(place, ahead + random.between(-CUT_ASIDE_RAD, CUT_ASIDE_RAD))
}
