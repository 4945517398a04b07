//! Reports put together: all repetitions and parts of one case, and the ratios that follow from
//! them.
//!
//! A case may have been measured in parts, since plain frustum culling leaves caches cold for the
//! strategies that follow it. Two strategies that never ran in one walk are compared through a
//! third one that ran with both.

use std::collections::BTreeMap;

use super::palette;
use super::spread::{Spread, objects};
use crate::report::{Report, RunReport};
use crate::statistics::TimeSummary;

/// The yardstick: draws exactly what owns a pixel.
pub const IDEAL: &str = "ideal";
/// The baseline: draws all that is in the view frustum.
pub const FRUSTUM: &str = "frustum";
/// The engine's own method, which all figures are about.
pub const ANTUMBRA: &str = "antumbra";
/// The number of frames for which the path `cut` stays in one place.
const FRAMES_BETWEEN_CUTS: usize = 10;

/// The key of a case.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The name of the scene.
    pub scene: String,
    /// The name of the camera's path.
    pub path: String,
    /// The approximate number of objects: the one asked for, where that is known.
    pub objects: u64,
    /// The percentage of the objects that move.
    pub moving: u64,
    /// The number of views.
    pub views: u64,
}

impl Place {
    /// Returns a scene that stands still, seen by one eye.
    pub fn still(scene: &str, path: &str, objects: u64) -> Self {
        Self { scene: scene.to_owned(), path: path.to_owned(), objects, moving: 0, views: 1 }
    }

    /// Returns the city at street level, which most figures are about.
    pub fn street(objects: u64) -> Self {
        Self::still("city", "street", objects)
    }

    /// Returns its name, as "street 10k"; the scene is named where it is not the city.
    pub fn name(&self) -> String {
        let Self { scene, path, .. } = self;
        let size = objects(self.objects as f64);
        match (scene.as_str(), path.as_str()) {
            ("city", _) => format!("{path} {size}"),
            ("field", "fly") => format!("field {size}, from above"),
            ("field", "street") => format!("field {size}, from the side"),
            _ => format!("{scene} {path} {size}"),
        }
    }

    fn of(measured: &Report) -> Self {
        let number = |option: &str| measured.argument(option).and_then(|text| text.parse().ok());
        Self {
            scene: measured.scene.name.clone(),
            path: measured.path.clone(),
            objects: number("--objects").unwrap_or_else(|| two_digits(measured.scene.objects)),
            moving: number("--moving-percent").or_else(|| number("--moving")).unwrap_or(0),
            views: number("--views").unwrap_or(1),
        }
    }
}

/// Returns a count rounded to its first two digits.
fn two_digits(count: u64) -> u64 {
    let mut unit = 1;
    while count / unit >= 100 {
        unit *= 10;
    }
    (count / unit + count % unit * 2 / unit) * unit
}

/// A ratio of two strategies' times.
#[derive(Clone, Debug, PartialEq)]
pub struct Ratio {
    /// The spread over the repetitions.
    pub spread: Spread,
    /// The third strategy, through which two are compared that never ran in one walk.
    pub through: Option<String>,
}

/// Returns each of some names once, in the order in which they first appear.
pub fn distinct<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found = Vec::new();
    for name in names {
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

/// All reports of one case.
#[derive(Clone, Debug, Default)]
pub struct Case<'a> {
    reports: Vec<&'a Report>,
}

/// All cases of a comparison.
#[derive(Debug)]
pub struct Cases<'a> {
    cases: BTreeMap<Place, Case<'a>>,
}

impl<'a> Cases<'a> {
    /// Sorts reports into cases.
    pub fn of(reports: &'a [Report]) -> Self {
        let mut cases = BTreeMap::<Place, Case<'a>>::new();
        for report in reports {
            cases.entry(Place::of(report)).or_default().reports.push(report);
        }
        Self { cases }
    }

    /// Returns the case at a place; it has no reports if nothing was measured there.
    pub fn at(&self, place: &Place) -> Case<'a> {
        self.cases.get(place).cloned().unwrap_or_default()
    }

    /// Returns the strategies of the city at street level, of any of these sizes, in the order of
    /// the palette.
    pub fn street_strategies(&self, sizes: &[u64]) -> Vec<&'a str> {
        let cases = sizes.iter().map(|size| self.at(&Place::street(*size)));
        let mut names = distinct(cases.flat_map(|case| case.strategies()));
        names.sort_by_key(|name| palette::place_of(name));
        names
    }

    /// Returns every case, by its place.
    pub fn iter(&self) -> impl Iterator<Item = (&Place, &Case<'a>)> {
        self.cases.iter()
    }

    /// Returns the numbers of objects for which a still scene and path were timed, ascending. If
    /// there are cases with walks without compared frames, only these count.
    pub fn sizes(&self, scene: &str, path: &str) -> Vec<u64> {
        let same = |(place, _): &(&Place, _)| **place == Place::still(scene, path, place.objects);
        let here = || self.cases.iter().filter(same);
        let quiet = |case: &Case<'_>| case.reports.iter().any(|report| !report.is_verified());
        let any_quiet = here().any(|(_, case)| quiet(case));
        let timed = here().filter(|(_, case)| !any_quiet || quiet(case));
        timed.map(|(place, _)| place.objects).collect()
    }
}

impl<'a> Case<'a> {
    /// Returns all reports, in the order of their files.
    pub fn reports(&self) -> &[&'a Report] {
        &self.reports
    }

    /// Returns the reports whose times count: reports without compared frames, or all if there are
    /// none.
    pub fn timed(&self) -> Vec<&'a Report> {
        let quiet: Vec<_> = self.reports.iter().copied().filter(|r| !r.is_verified()).collect();
        if quiet.is_empty() { self.reports.clone() } else { quiet }
    }

    /// Returns the runs of a strategy in its walks with the most strategies, so that it can be
    /// compared with as many as possible.
    pub fn runs(&self, strategy: &str) -> Vec<&'a RunReport> {
        let mut with: Vec<_> =
            self.timed().into_iter().filter(|r| r.run(strategy).is_some()).collect();
        let most = with.iter().map(|report| report.runs.len()).max().unwrap_or(0);
        with.retain(|report| report.runs.len() == most);
        with.into_iter().filter_map(|report| report.run(strategy)).collect()
    }

    /// Returns the runs of a strategy in walks without others; if there are none, its other runs.
    /// Runs of other strategies in the same walk affect the caches and so the CPU times.
    fn runs_alone(&self, strategy: &str) -> Vec<&'a RunReport> {
        let alone = self.timed().into_iter().filter(|report| report.runs.len() == 1);
        let runs: Vec<_> = alone.filter_map(|report| report.run(strategy)).collect();
        if runs.is_empty() { self.runs(strategy) } else { runs }
    }

    /// Returns the names of the strategies, in the order in which they first appear.
    pub fn strategies(&self) -> Vec<&'a str> {
        let reports = self.timed().into_iter();
        distinct(reports.flat_map(|report| &report.runs).map(|run| run.strategy.as_str()))
    }

    /// Returns A's frame time over B's: the median of the ratios frame by frame, or the ratio of
    /// the medians in reports without it. If the two never ran in one walk, they are compared
    /// through a third strategy.
    pub fn ratio(&self, a: &str, b: &str) -> Option<Ratio> {
        if let Some(spread) = self.direct_ratio(a, b) {
            return Some(Ratio { spread, through: None });
        }
        let mut others = self.strategies();
        others.sort_by_key(|name| *name != IDEAL);
        others.into_iter().filter(|name| *name != a && *name != b).find_map(|tie| {
            let spread = self.direct_ratio(a, tie)?.times(&self.direct_ratio(tie, b)?)?;
            Some(Ratio { spread, through: Some(tie.to_owned()) })
        })
    }

    fn direct_ratio(&self, a: &str, b: &str) -> Option<Spread> {
        if a == b {
            return self.timed().iter().any(|r| r.run(a).is_some()).then(|| Spread::of([1.0]))?;
        }
        let pair = format!("{a}/{b}");
        let of = |report: &&Report| -> Option<f64> {
            let paired = report.paired_ratios.get(&pair).copied().flatten();
            paired.or_else(|| report.ratios.get(&pair).copied().flatten())
        };
        Spread::of(self.timed().iter().filter_map(of))
    }

    /// Returns A's 95th percentile over B's, from walks that both took part in.
    pub fn p95_ratio(&self, a: &str, b: &str) -> Option<Spread> {
        let of = |report: &&Report| -> Option<f64> {
            Some(report.run(a)?.frame_ms.p95? / report.run(b)?.frame_ms.p95?)
        };
        Spread::of(self.timed().iter().filter_map(of))
    }

    /// Returns A's time over B's for the frame after a jump of the path `cut`, the median over the
    /// jumps.
    ///
    /// A time ends when the CPU may continue, so the work of a frame on the device shows up to as
    /// many frames later as frames are in flight. The largest ratio in this range counts.
    pub fn after_cut_ratio(&self, a: &str, b: &str) -> Option<Spread> {
        let of = |report: &&Report| -> Option<f64> {
            let a = &report.run(a)?.frame_times_ms;
            let b = &report.run(b)?.frame_times_ms;
            let late = usize::try_from(report.frames_in_flight).ok()?;
            (0..=late).filter_map(|places| after_cut_at(a, b, places)).max_by(f64::total_cmp)
        };
        Spread::of(self.timed().iter().filter_map(of))
    }

    /// Returns a strategy's median frame time in milliseconds.
    pub fn frame_ms(&self, strategy: &str) -> Option<Spread> {
        Spread::of(self.runs(strategy).iter().filter_map(|run| run.frame_ms.median))
    }

    /// Returns a strategy's median CPU time per frame in milliseconds.
    pub fn cpu_ms(&self, strategy: &str) -> Option<Spread> {
        Spread::of(self.runs_alone(strategy).iter().filter_map(|run| run.cpu_ms.median))
    }

    /// Returns the median over repetitions of a count that every run has.
    pub fn count(&self, strategy: &str, of: impl Fn(&RunReport) -> Option<u64>) -> Option<Spread> {
        Spread::of(self.runs(strategy).iter().filter_map(|run| of(run)).map(|count| count as f64))
    }

    /// Returns the time of every frame over the path: the median of the repetitions.
    pub fn frame_times_ms(&self, strategy: &str) -> Vec<Option<f64>> {
        let runs = self.runs(strategy);
        let frames = runs.iter().map(|run| run.frame_times_ms.len()).max().unwrap_or(0);
        let at = |frame: usize| {
            TimeSummary::of(runs.iter().filter_map(|run| run.frame_times_ms.get(frame).copied()?))
        };
        (0..frames).map(|frame| at(frame).median).collect()
    }
}

fn after_cut_at(a: &[Option<f64>], b: &[Option<f64>], places: usize) -> Option<f64> {
    let jumps = (FRAMES_BETWEEN_CUTS..a.len()).step_by(FRAMES_BETWEEN_CUTS);
    let ratio = |jump: usize| Some((*a.get(jump + places)?)? / (*b.get(jump + places)?)?);
    TimeSummary::of(jumps.filter_map(ratio)).median
}

#[cfg(test)]
mod tests;
