//! A closed walk along streets that takes corners in arcs and never turns back.

use std::collections::VecDeque;
use std::f32::consts::FRAC_PI_2;

use cull::trigonometry;
use glam::{Vec2, vec2};

use super::super::random::Random;
use super::super::routes::Streets;
use super::direction;

/// The number of random legs before the tour closes.
const RANDOM_LEGS: usize = 24;

/// The distance before a corner at which the walk begins, in metres, so that short runs include a
/// turn.
const LEAD_IN_M: f32 = 9.0;

/// A crossing, and the direction in which the walk leaves it (quarter turns from +x towards +z).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stand {
    column: usize,
    row: usize,
    quarter: usize,
}

/// A straight leg from one crossing to the next, and the turn at its end.
#[derive(Clone, Copy, Debug)]
struct Leg {
    /// The distance walked before the leg, in metres.
    begin_m: f32,
    from: Vec2,
    straight_m: f32,
    heading: f32,
    /// The quarter turn at its end: -1, 0 or 1.
    turn: f32,
}

/// A closed walk.
#[derive(Clone, Debug)]
pub(super) struct Tour {
    legs: Vec<Leg>,
    radius_m: f32,
    length_m: f32,
    start_m: f32,
}

impl Tour {
    /// Creates a walk that depends on the seed; `None` if the streets form no closed walk.
    pub(super) fn new(streets: &Streets, seed: u64) -> Option<Self> {
        let grid = Grid { columns: streets.xs.len(), rows: streets.zs.len() };
        if grid.columns < 2 || grid.rows < 2 {
            return None;
        }
        let mut random = Random::keyed(seed, &[5]);
        let start = Stand { column: grid.columns / 2, row: grid.rows / 2, quarter: 0 };
        let start = grid.turns(start).into_iter().flatten().next()?;
        let mut stands = vec![start];
        let mut stand = start;
        for _ in 0..RANDOM_LEGS {
            let mut ways: Vec<Stand> = grid.successors(stand).collect();
            random.shuffle(&mut ways);
            stand = *ways.first()?;
            stands.push(stand);
        }
        stands.extend(grid.way(stand, start)?);
        Some(Self::along(streets, &stands))
    }

    /// Creates the walk along `stands`, which begins and ends with the same stand.
    fn along(streets: &Streets, stands: &[Stand]) -> Self {
        let radius_m = streets.turn_radius_m;
        let place = |stand: &Stand| {
            let at = |lines: &[f32], line: usize| lines.get(line).copied().unwrap_or_default();
            vec2(at(&streets.xs, stand.column), at(&streets.zs, stand.row))
        };
        let turn = |from: &Stand, to: &Stand| match (to.quarter + 4 - from.quarter) % 4 {
            0 => 0.0,
            1 => 1.0,
            _ => -1.0,
        };
        let mut legs: Vec<Leg> = Vec::with_capacity(stands.len());
        let mut begin_m = 0.0;
        let mut last_turn = match stands {
            [.., before, last] => turn(before, last),
            _ => 0.0,
        };
        for pair in stands.windows(2) {
            let [from, to] = pair else { continue };
            let heading = from.quarter as f32 * FRAC_PI_2;
            let ahead = direction(heading);
            let next_turn = turn(from, to);
            let rounded = |turn: f32| if turn == 0.0 { 0.0 } else { radius_m };
            let straight_m =
                place(from).distance(place(to)) - rounded(last_turn) - rounded(next_turn);
            let from = place(from) + ahead * rounded(last_turn);
            legs.push(Leg { begin_m, from, straight_m, heading, turn: next_turn });
            begin_m += straight_m + rounded(next_turn) * FRAC_PI_2;
            last_turn = next_turn;
        }
        let corner = legs.iter().find(|leg| leg.turn != 0.0);
        let start_m = corner.map_or(0.0, |leg| leg.begin_m + (leg.straight_m - LEAD_IN_M).max(0.0));
        Self { legs, radius_m, length_m: begin_m, start_m }
    }

    /// Returns the length in metres.
    pub(super) fn length_m(&self) -> f64 {
        f64::from(self.length_m)
    }

    /// Returns the position and the direction of the walk, as an angle from +x towards +z, after a
    /// distance in metres of at most its length.
    pub(super) fn at(&self, way_m: f32) -> (Vec2, f32) {
        let way = (way_m + self.start_m) % self.length_m;
        let number = self.legs.partition_point(|leg| leg.begin_m <= way).saturating_sub(1);
        let Some(leg) = self.legs.get(number) else { return (Vec2::ZERO, 0.0) };
        let ahead = direction(leg.heading);
        let walked = way - leg.begin_m;
        if walked <= leg.straight_m || leg.turn == 0.0 {
            return (leg.from + ahead * walked, leg.heading);
        }
        let angle = (walked - leg.straight_m) / self.radius_m;
        let aside = direction(leg.heading + leg.turn * FRAC_PI_2);
        let corner = leg.from + ahead * leg.straight_m;
        let place = corner
            + ahead * (self.radius_m * trigonometry::sin(angle))
            + aside * (self.radius_m * (1.0 - trigonometry::cos(angle)));
        (place, leg.heading + leg.turn * angle)
    }
}

struct Grid {
    columns: usize,
    rows: usize,
}

impl Grid {
    /// Returns the next crossing, with the same direction, if there is one.
    fn ahead(&self, stand: Stand) -> Option<Stand> {
        let Stand { column, row, quarter } = stand;
        let (column, row) = match quarter % 4 {
            0 => (column.checked_add(1)?, row),
            1 => (column, row.checked_add(1)?),
            2 => (column.checked_sub(1)?, row),
            _ => (column, row.checked_sub(1)?),
        };
        (column < self.columns && row < self.rows).then_some(Stand { column, row, quarter })
    }

    /// Returns the possible directions after a crossing: ahead, right, left; not back.
    fn turns(&self, arrived: Stand) -> [Option<Stand>; 3] {
        [0, 1, 3].map(|turn| {
            let stand = Stand { quarter: (arrived.quarter + turn) % 4, ..arrived };
            self.ahead(stand).map(|_| stand)
        })
    }

    fn successors(&self, stand: Stand) -> impl Iterator<Item = Stand> {
        self.ahead(stand).into_iter().flat_map(|arrived| self.turns(arrived)).flatten()
    }

    fn number(&self, stand: Stand) -> usize {
        (stand.row * self.columns + stand.column) * 4 + stand.quarter
    }

    /// Returns the shortest path from one stand to another, by breadth-first search: all stands
    /// after the first, including the last.
    fn way(&self, from: Stand, to: Stand) -> Option<Vec<Stand>> {
        let mut before: Vec<Option<Stand>> = vec![None; self.columns * self.rows * 4];
        let mut open = VecDeque::from([from]);
        while let Some(stand) = open.pop_front() {
            for next in self.successors(stand) {
                let known = before.get_mut(self.number(next))?;
                if known.is_none() {
                    *known = Some(stand);
                    open.push_back(next);
                }
                if next == to {
                    open.clear();
                    break;
                }
            }
        }
        let mut way = vec![to];
        let mut stand = (*before.get(self.number(to))?)?;
        while stand != from {
            way.push(stand);
            stand = (*before.get(self.number(stand))?)?;
        }
        way.reverse();
        Some(way)
    }
}
