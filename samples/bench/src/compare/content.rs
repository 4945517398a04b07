//! The content of a comparison without its form: the page and the table are made from it.

use super::cases::{ANTUMBRA, Cases, FRUSTUM, IDEAL, Place};
use super::exactness::{self, Book};
use super::figures::{self, Figure, Verdict};
use super::input::Measured;
use super::noise;
use super::palette;
use super::picture::DrawError;
use super::plots::{self, Plot};
use super::spread::{Spread, short, thousands};
use super::thumbnails::Thumbnail;
use crate::strategy::strategies;

/// The paths whose frame times are plotted, with their sizes.
const SHOWN_PATHS: [(&str, u64); 4] =
    [("street", 10_000), ("cut", 10_000), ("fly", 10_000), ("street", 40_000)];
/// The frame size that the figures are asked for.
const ASKED_SIZE: [u32; 2] = [1280, 720];

/// One strategy on `street`, over all sizes.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodRow {
    /// The name of the strategy.
    pub strategy: String,
    /// The frame times at each of the sizes, as multiples of the yardstick's.
    pub ratios: Vec<Option<Spread>>,
    /// True at each size where it was measured to be faster than the ideal by more than the noise.
    pub impossible: Vec<bool>,
    /// The CPU time per frame in milliseconds, at the size of the details.
    pub cpu_ms: Option<Spread>,
    /// The draws per frame.
    pub draws: Option<Spread>,
    /// The boxes tested per frame, by all mechanisms.
    pub tests: Option<Spread>,
    /// The occlusion queries per frame.
    pub queries: Option<Spread>,
    /// The wrong pixels in all settings, if any frame was compared.
    pub pixels_wrong: Option<u64>,
}

/// The content of a comparison.
pub struct Content {
    /// The device: its name, its driver, its Vulkan version.
    pub device: String,
    /// The days of the measurements.
    pub days: String,
    /// The sizes of the timed frames, their number, and the number of repetitions.
    pub frames: String,
    /// The steadiness of the machine, in a sentence without its end.
    pub steadiness: String,
    /// Pictures of the walks; may be empty.
    pub thumbnails: Vec<Thumbnail>,
    /// Warnings to the reader; may be empty.
    pub warnings: Vec<String>,
    /// The strategy that ratios are taken to.
    pub yardstick: &'static str,
    /// The sizes of the columns of [`Self::methods`].
    pub sizes: Vec<u64>,
    /// The size of its details.
    pub detail_size: Option<u64>,
    /// Every strategy on `street`.
    pub methods: Vec<MethodRow>,
    /// The figures: asked for, and found.
    pub figures: Vec<Figure>,
    /// Wrong pixels per strategy and setting.
    pub books: Vec<Book>,
    /// The missing measurements, with the reasons.
    pub left_out: Vec<String>,
    /// Ratios over sizes.
    pub ratios: Option<Plot>,
    /// The other plots.
    pub plots: Vec<Plot>,
    /// The file and the command line of every report.
    pub commands: Vec<(String, String)>,
}

impl Content {
    /// Gathers the content from reports of one device, of which there must be at least one.
    ///
    /// # Errors
    /// When a plot cannot be drawn.
    pub fn of(reports: &[Measured]) -> Result<Self, DrawError> {
        let cases = Cases::of(reports);
        let sizes = cases.sizes("city", "street");
        let detail_size =
            sizes.iter().copied().find(|size| *size == 10_000).or(sizes.first().copied());
        let books = exactness::books(&cases);
        let yardstick = plots::yardstick(&cases, &sizes);
        let mut plots = Vec::new();
        for (path, size) in SHOWN_PATHS {
            plots.extend(plots::frame_times(&cases, &Place::still("city", path, size))?);
        }
        plots.extend(plots::cpu_times(&cases)?);
        if let Some(size) = detail_size {
            plots.extend(plots::counts(&cases, &Place::still("city", "street", size))?);
        }
        let device = reports.first().map(|report| &report.device);
        let command =
            |report: &Measured| (report.file.clone(), report.provenance.command.join(" "));
        Ok(Self {
            device: device.map_or(String::new(), |device| {
                format!("{} ({}, Vulkan {})", device.name, device.driver, device.api)
            }),
            days: days(reports),
            frames: frames(reports),
            steadiness: noise::verdict(&cases),
            thumbnails: Vec::new(),
            warnings: warnings(reports),
            yardstick,
            methods: methods(&cases, &ratio_sizes(&cases, &sizes, yardstick), detail_size, &books),
            sizes: ratio_sizes(&cases, &sizes, yardstick),
            detail_size,
            figures: figures::all(&cases),
            left_out: left_out(&cases, &ratio_sizes(&cases, &sizes, yardstick)),
            books,
            ratios: plots::ratios(&cases)?,
            plots,
            commands: reports.iter().map(command).collect(),
        })
    }

    /// Returns the verdicts in words, with the number of figures that have each.
    pub fn verdicts(&self) -> Vec<(Verdict, usize)> {
        Verdict::COUNTED
            .into_iter()
            .map(|verdict| {
                let same = |figure: &&Figure| figure.verdict() == verdict;
                (verdict, self.figures.iter().filter(same).count())
            })
            .collect()
    }

    /// Returns the result in a sentence: the time of `antumbra` at the size of the details.
    pub fn headline(&self) -> Option<String> {
        let size = self.detail_size?;
        let column = self.sizes.iter().position(|column| *column == size)?;
        let ratio = |name: &str| {
            let row = self.methods.iter().find(|row| row.strategy == name)?;
            row.ratios.get(column)?.clone()
        };
        let antumbra = ratio(ANTUMBRA)?.median();
        let mut text = format!(
            "In a city of {} objects at street level, antumbra takes {} times the frame time of {}",
            thousands(size as f64),
            short(antumbra),
            self.yardstick
        );
        if let Some(frustum) = ratio(FRUSTUM).filter(|_| self.yardstick == IDEAL) {
            let frustum = short(frustum.median());
            text.push_str(&format!("; plain frustum culling takes {frustum} times"));
        }
        Some(text + ".")
    }
}

/// Returns the sizes at which there are ratios to the yardstick.
fn ratio_sizes(cases: &Cases<'_>, sizes: &[u64], yardstick: &str) -> Vec<u64> {
    let known = |size: &&u64| {
        let case = cases.at(&Place::still("city", "street", **size));
        case.strategies()
            .iter()
            .any(|name| *name != yardstick && case.ratio(name, yardstick).is_some())
    };
    sizes.iter().filter(known).copied().collect()
}

fn methods(
    cases: &Cases<'_>,
    sizes: &[u64],
    detail_size: Option<u64>,
    books: &[Book],
) -> Vec<MethodRow> {
    let yardstick = plots::yardstick(cases, sizes);
    let mut names: Vec<&str> = Vec::new();
    for size in sizes {
        for name in cases.at(&Place::still("city", "street", *size)).strategies() {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names.sort_by_key(|name| palette::place_of(name));
    let detail = detail_size.map(|size| cases.at(&Place::still("city", "street", size)));
    let detail = detail.unwrap_or_default();
    let ratio = |name: &str, size: u64| {
        let ratio = cases.at(&Place::still("city", "street", size)).ratio(name, yardstick);
        ratio.map(|ratio| ratio.spread)
    };
    let is_impossible = |name: &str, size: u64| {
        noise::is_below_ideal(&cases.at(&Place::still("city", "street", size)), name)
    };
    let wrong = |name: &str| {
        let compared = |book: &&Book| book.strategy == name && book.frames_compared > 0;
        let mut compared = books.iter().filter(compared).peekable();
        compared.peek().is_some().then(|| compared.map(|book| book.pixels_wrong).sum())
    };
    let row = |name: &str| MethodRow {
        strategy: name.to_owned(),
        ratios: sizes.iter().map(|size| ratio(name, *size)).collect(),
        impossible: sizes.iter().map(|size| is_impossible(name, *size)).collect(),
        cpu_ms: detail.cpu_ms(name),
        draws: detail.count(name, |run| run.draws),
        tests: detail.count(name, |run| run.tests),
        queries: detail.count(name, |run| run.queries),
        pixels_wrong: wrong(name),
    };
    names.into_iter().map(row).collect()
}

/// Returns sentences about strategies that smaller cases have and larger ones have not, and about
/// those of this build without any case.
fn left_out(cases: &Cases<'_>, sizes: &[u64]) -> Vec<String> {
    let mut sentences = Vec::new();
    let at = |size: u64| cases.at(&Place::still("city", "street", size));
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

/// Returns the reports whose times count.
fn timed(reports: &[Measured]) -> impl Iterator<Item = &Measured> {
    let any_quiet = reports.iter().any(|report| !report.is_verified());
    reports.iter().filter(move |report| !any_quiet || !report.is_verified())
}

fn sorted<T: Ord>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut values: Vec<T> = values.collect();
    values.sort();
    values.dedup();
    values
}

fn days(reports: &[Measured]) -> String {
    let dated = reports.iter().filter(|report| report.provenance.unix_s > 0);
    let days = sorted(dated.map(|report| report.provenance.day()));
    match days.as_slice() {
        [] => "day unknown".to_owned(),
        [day] => day.clone(),
        [first, .., last] => format!("{first} to {last}"),
    }
}

fn frames(reports: &[Measured]) -> String {
    let sizes = sorted(timed(reports).map(|report| report.size));
    let sizes: Vec<String> =
        sizes.iter().map(|[width, height]| format!("{width}x{height}")).collect();
    let frames = sorted(timed(reports).map(|report| report.frames));
    let frames = match frames.as_slice() {
        [] => String::new(),
        [frames] => frames.to_string(),
        [least, .., most] => format!("{least} to {most}"),
    };
    let in_flight = sorted(timed(reports).map(|report| report.frames_in_flight));
    let in_flight: Vec<String> = in_flight.iter().map(u32::to_string).collect();
    format!(
        "{frames} timed frames of {} per walk, {} in flight",
        sizes.join(" and "),
        in_flight.join(" and ")
    )
}

fn warnings(reports: &[Measured]) -> Vec<String> {
    let mut warnings = Vec::new();
    let other: Vec<&Measured> = timed(reports).filter(|report| report.size != ASKED_SIZE).collect();
    if let Some([width, height]) = other.first().map(|report| report.size) {
        let [asked_width, asked_height] = ASKED_SIZE;
        warnings.push(format!(
            "{} of {} timed walks have frames of {width}x{height}: the figures are asked for at \
             {asked_width}x{asked_height}, so this is a look, not a result.",
            other.len(),
            timed(reports).count()
        ));
    }
    let few: Vec<&str> = timed(reports)
        .filter(|report| report.runs.iter().any(|run| run.frame_times_ms.is_empty()))
        .map(|report| report.file.as_str())
        .collect();
    if !few.is_empty() {
        warnings.push(format!(
            "Made by an older walkthrough, without the times of each frame: {}.",
            few.join(", ")
        ));
    }
    let cut: Vec<&str> = reports
        .iter()
        .filter(|report| report.cut_short)
        .map(|report| report.file.as_str())
        .collect();
    if !cut.is_empty() {
        warnings.push(format!("Cut short by a signal, measure again: {}.", cut.join(", ")));
    }
    warnings
}

#[cfg(test)]
mod tests;
