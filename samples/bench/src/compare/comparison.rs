//! The comparison of the reports of one device, from which the page is made.

use super::cases::{ANTUMBRA, Cases, FRUSTUM, IDEAL, Place};
use super::exactness::{self, Book};
use super::figures::{self, Figure, Verdict};
use super::plots;
use super::spread::{Spread, short};
use super::thumbnails::Thumbnail;
use crate::report::Report;
use crate::statistics::thousands;
use crate::strategy::strategies;

/// The frame size that the goals are for.
const ASKED_SIZE: [u32; 2] = [1280, 720];

/// A comparison.
pub struct ReportComparison<'a> {
    /// The reports, in the order of their files.
    pub reports: &'a [Report],
    /// The reports by their cases.
    pub cases: Cases<'a>,
    /// The strategy that times are divided by.
    pub yardstick: &'static str,
    /// The sizes of the city at street level that have ratios to the yardstick.
    pub sizes: Vec<u64>,
    /// The size whose details are shown.
    pub detail_size: Option<u64>,
    /// The figures, with goals and measured values.
    pub figures: Vec<Figure>,
    /// Wrong pixels per strategy and setting.
    pub books: Vec<Book>,
    /// Pictures of the walks; may be empty.
    pub thumbnails: Vec<Thumbnail>,
    /// The missing measurements, with the reasons.
    pub left_out: Vec<String>,
}

impl<'a> ReportComparison<'a> {
    /// Compares the reports of one device.
    pub fn of(reports: &'a [Report]) -> Self {
        let cases = Cases::of(reports);
        let mut sizes = cases.sizes("city", "street");
        let detail_size = sizes.iter().copied().find(|size| *size == 10_000);
        let detail_size = detail_size.or(sizes.first().copied());
        let yardstick = plots::yardstick(&cases, &sizes);
        sizes.retain(|size| {
            let case = cases.at(&Place::street(*size));
            let others = case.strategies().into_iter().filter(|name| *name != yardstick);
            others.into_iter().any(|name| case.ratio(name, yardstick).is_some())
        });
        Self {
            reports,
            yardstick,
            detail_size,
            figures: figures::all(&cases),
            books: exactness::books(&cases),
            thumbnails: Vec::new(),
            left_out: left_out(&cases, &sizes),
            sizes,
            cases,
        }
    }

    /// Returns the device: its name, its driver, its Vulkan version.
    pub fn device(&self) -> String {
        self.reports.first().map_or(String::new(), |Report { device, .. }| {
            format!("{} ({}, Vulkan {})", device.name, device.driver, device.api)
        })
    }

    /// Returns the verdicts in words, with the number of figures that have each.
    pub fn verdicts(&self) -> Vec<(Verdict, usize)> {
        let count = |verdict| {
            let same = |figure: &&Figure| figure.verdict() == verdict;
            (verdict, self.figures.iter().filter(same).count())
        };
        Verdict::COUNTED.map(count).to_vec()
    }

    /// Returns the frame time of a strategy in the city at street level, as a multiple of the
    /// yardstick's.
    pub fn ratio(&self, strategy: &str, size: u64) -> Option<Spread> {
        let case = self.cases.at(&Place::street(size));
        case.ratio(strategy, self.yardstick).map(|ratio| ratio.spread)
    }

    /// Returns the wrong pixels of a strategy in all settings, if any frame was compared.
    pub fn pixels_wrong(&self, strategy: &str) -> Option<u64> {
        let compared = |book: &&Book| book.strategy == strategy && book.frames_compared > 0;
        self.books.iter().filter(compared).map(|book| book.pixels_wrong).reduce(|a, b| a + b)
    }

    /// Returns the result in a sentence: the time of `antumbra` at the size of the details.
    pub fn headline(&self) -> Option<String> {
        let size = self.detail_size.filter(|size| self.sizes.contains(size))?;
        let antumbra = self.ratio(ANTUMBRA, size)?.median();
        let mut text = format!(
            "In a city of {} objects at street level, antumbra takes {} times the frame time of {}",
            thousands(size as f64),
            short(antumbra),
            self.yardstick
        );
        if let Some(frustum) = self.ratio(FRUSTUM, size).filter(|_| self.yardstick == IDEAL) {
            let frustum = short(frustum.median());
            text.push_str(&format!("; plain frustum culling takes {frustum} times"));
        }
        Some(text + ".")
    }

    /// Returns the reports whose times count.
    fn timed(&self) -> impl Iterator<Item = &'a Report> {
        let any_quiet = self.reports.iter().any(|report| !report.is_verified());
        self.reports.iter().filter(move |report| !any_quiet || !report.is_verified())
    }

    /// Returns the days of the measurements.
    pub fn days(&self) -> String {
        let dated = self.reports.iter().filter(|report| report.provenance.unix_s > 0);
        let days = sorted(dated.map(|report| report.provenance.day()));
        match days.as_slice() {
            [] => "day unknown".to_owned(),
            [day] => day.clone(),
            [first, .., last] => format!("{first} to {last}"),
        }
    }

    /// Returns the sizes of the timed frames, their number, and the number in flight.
    pub fn frames(&self) -> String {
        let sizes = sorted(self.timed().map(|report| report.size));
        let sizes: Vec<String> =
            sizes.iter().map(|[width, height]| format!("{width}x{height}")).collect();
        let frames = sorted(self.timed().map(|report| report.frames));
        let frames = match frames.as_slice() {
            [] => String::new(),
            [frames] => frames.to_string(),
            [least, .., most] => format!("{least} to {most}"),
        };
        let in_flight = sorted(self.timed().map(|report| report.frames_in_flight));
        let in_flight: Vec<String> = in_flight.iter().map(u32::to_string).collect();
        format!(
            "{frames} timed frames of {} per walk, {} in flight",
            sizes.join(" and "),
            in_flight.join(" and ")
        )
    }

    /// Returns warnings to the reader; there may be none.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let other: Vec<&Report> = self.timed().filter(|report| report.size != ASKED_SIZE).collect();
        if let Some([width, height]) = other.first().map(|report| report.size) {
            let [asked_width, asked_height] = ASKED_SIZE;
            warnings.push(format!(
                "{} of {} timed walks have frames of {width}x{height}: the figures are asked for at \
                 {asked_width}x{asked_height}, so this is a look, not a result.",
                other.len(),
                self.timed().count()
            ));
        }
        let few: Vec<&str> = self
            .timed()
            .filter(|report| report.runs.iter().any(|run| run.frame_times_ms.is_empty()))
            .map(|report| report.file.as_str())
            .collect();
        if !few.is_empty() {
            warnings.push(format!(
                "Made by an older walkthrough, without the times of each frame: {}.",
                few.join(", ")
            ));
        }
        let cut: Vec<&str> = self
            .reports
            .iter()
            .filter(|report| report.cut_short)
            .map(|report| report.file.as_str())
            .collect();
        if !cut.is_empty() {
            warnings.push(format!("Cut short by a signal, measure again: {}.", cut.join(", ")));
        }
        warnings
    }
}

/// Returns sentences about strategies that only smaller cases have, and about strategies of this
/// build without any case.
fn left_out(cases: &Cases<'_>, sizes: &[u64]) -> Vec<String> {
    let mut sentences = Vec::new();
    let at = |size: u64| cases.at(&Place::street(size));
    for (place, &size) in sizes.iter().enumerate() {
        let larger = sizes.get(place + 1..).unwrap_or_default();
        for name in at(size).strategies() {
            let measured_later = larger.iter().any(|later| at(*later).strategies().contains(&name));
            let Some(time) = at(size).frame_ms(name).filter(|_| !measured_later) else {
                continue;
            };
            if !larger.is_empty() {
                let size = thousands(size as f64);
                let time = short(time.median());
                sentences.push(format!(
                    "{name}: left out above {size} objects: {time} ms per frame there"
                ));
            }
        }
    }
    let measured = |name: &str| {
        let mut runs =
            cases.iter().flat_map(|(_, case)| case.reports()).flat_map(|report| &report.runs);
        runs.any(|run| run.strategy == name)
    };
    for strategy in strategies().iter().filter(|strategy| !measured(strategy.name())) {
        sentences.push(format!("{strategy}: not measured in any report"));
    }
    sentences
}

fn sorted<T: Ord>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut values: Vec<T> = values.collect();
    values.sort();
    values.dedup();
    values
}

#[cfg(test)]
mod tests;
