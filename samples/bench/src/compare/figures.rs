//! The figures with their goals and measured values, as a table.

use super::cases::{ANTUMBRA, Case, Cases, FRUSTUM, IDEAL, Place, Ratio};
use super::exactness::{self, Setting};
use super::noise::{self, NOISE_MAX};
use super::spread::{Spread, short};
use crate::statistics::thousands;

/// The goals of `antumbra` on `street`, as multiples of the ideal's time, by the number of objects.
pub const STREET_GOALS: [(u64, f64); 4] =
    [(2_000, 1.15), (10_000, 1.22), (40_000, 1.32), (100_000, 1.40)];
/// The strategies that it must beat in every case.
const RIVALS: [&str; 4] = ["chc", "hzb", "stop_and_wait", "next_frame"];

/// The goal of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// This value or less.
    AtMost(f64),
    /// More than this value.
    MoreThan(f64),
    /// No goal: it is counted and shown.
    Shown,
}

/// The result of a figure against its goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Reached in every repetition.
    Reached,
    /// Reached by the median, but not in every repetition.
    ReachedInMedian,
    /// Missed by the median.
    Missed,
    /// Below the theoretical bound: the measurement is wrong.
    Impossible,
    /// Not decidable: the machine was too busy, and its noise hides the result.
    TooNoisy,
    /// Not measured: a part of the figure is missing.
    NotMeasured,
    /// Shown only: there is no goal.
    Shown,
}

impl Verdict {
    /// The verdicts that are counted: all that a figure with a goal can have.
    pub const COUNTED: [Self; 6] = [
        Self::Reached,
        Self::ReachedInMedian,
        Self::Missed,
        Self::Impossible,
        Self::TooNoisy,
        Self::NotMeasured,
    ];

    /// Returns its name in words, with a symbol, so that it does not depend on colours.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reached => "✓ reached",
            Self::ReachedInMedian => "≈ reached in the median, not in every run",
            Self::Missed => "✗ not reached",
            Self::Impossible => "! impossible: below the ideal by more than the noise",
            Self::TooNoisy => "~ not judged: the machine was too busy",
            Self::NotMeasured => "– not measured",
            Self::Shown => "· shown",
        }
    }
}

/// One row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The scene, path and size.
    pub case: String,
    /// The measured quantity.
    pub what: String,
    /// The goal for the measured value.
    pub asked: Asked,
    /// The measured value.
    pub found: Option<Spread>,
    /// True if part of the figure was not measured: the rest can miss the goal but not reach it.
    pub is_partial: bool,
    /// The noise of the machine during the measurement, as a fraction of the ideal's time, if it is
    /// known.
    pub noise: Option<f64>,
    /// True if a part of it was measured to be faster than the ideal, by more than the noise.
    pub is_impossible: bool,
    /// A note for the reader beside it; may be empty.
    pub note: String,
}

impl Figure {
    /// Returns its result against the goal.
    pub fn verdict(&self) -> Verdict {
        let Some(found) = &self.found else {
            return Verdict::NotMeasured;
        };
        let holds = |value: f64| match self.asked {
            Asked::AtMost(limit) => value <= limit,
            Asked::MoreThan(limit) => value > limit,
            Asked::Shown => true,
        };
        match (self.asked, holds(found.median())) {
            (Asked::Shown, _) => Verdict::Shown,
            _ if self.is_impossible => Verdict::Impossible,
            _ if self.noise.is_some_and(|noise| noise >= NOISE_MAX) => Verdict::TooNoisy,
            (_, false) => Verdict::Missed,
            _ if self.is_partial => Verdict::NotMeasured,
            _ if holds(found.least()) && holds(found.most()) => Verdict::Reached,
            _ => Verdict::ReachedInMedian,
        }
    }

    /// Returns the goal in words.
    pub fn asked_words(&self) -> String {
        match self.asked {
            Asked::AtMost(0.0) => "0".to_owned(),
            Asked::AtMost(limit) => format!("at most {limit:.2}"),
            Asked::MoreThan(limit) => format!("more than {limit:.2}"),
            Asked::Shown => "counted and shown".to_owned(),
        }
    }

    /// Returns the measured value in words.
    pub fn found_words(&self) -> String {
        let Some(found) = &self.found else {
            return "not measured".to_owned();
        };
        let limit = match self.asked {
            Asked::AtMost(limit) | Asked::MoreThan(limit) => short(limit),
            Asked::Shown => String::new(),
        };
        if self.verdict() == Verdict::Missed && short(found.median()) == limit {
            // Rounded to two digits, the goal would look reached.
            return format!("{:.3} ({:.3} to {:.3})", found.median(), found.least(), found.most());
        }
        found.to_string()
    }

    fn new(
        case: impl Into<String>,
        what: impl Into<String>,
        asked: Asked,
        found: Option<Spread>,
    ) -> Self {
        Self {
            case: case.into(),
            what: what.into(),
            asked,
            found,
            is_partial: false,
            noise: None,
            is_impossible: false,
            note: String::new(),
        }
    }

    /// Adds the case in which it was measured, and the strategies.
    fn measured_in(mut self, case: &Case<'_>, strategies: &[&str]) -> Self {
        self.noise = noise::of_case(case);
        let least = noise::least_possible(case);
        let below = |name: &&str| noise::is_below_ideal(case, name);
        let is_over_ideal = self.what.ends_with("/ ideal");
        let found = self.found.as_ref().filter(|_| is_over_ideal);
        self.is_impossible =
            strategies.iter().any(below) || found.is_some_and(|found| found.median() < least);
        self
    }

    fn noted(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
}

/// Returns every figure that is asked for, in the order of the table.
pub fn all(cases: &Cases<'_>) -> Vec<Figure> {
    let streets = STREET_GOALS.map(|(size, _)| Place::street(size));
    let mut figures = Vec::new();
    for (place, (_, goal)) in streets.iter().zip(STREET_GOALS) {
        figures.push(ratio_at(cases, place, IDEAL, goal));
    }
    figures.extend(streets.iter().map(|place| against_rivals(cases, place)));
    for (rival, times) in [(FRUSTUM, 4.0), ("stop_and_wait", 2.6)] {
        for place in &streets {
            let case = cases.at(place);
            let what = format!("{rival} / antumbra");
            let ratio = case.ratio(rival, ANTUMBRA);
            let figure = tied(place, what, Asked::MoreThan(times), ratio);
            figures.push(figure.measured_in(&case, &[rival, ANTUMBRA]));
        }
    }
    for place in &streets {
        let what = "95th percentile, antumbra / ideal";
        let found = cases.at(place).p95_ratio(ANTUMBRA, IDEAL);
        let figure = Figure::new(place.name(), what, Asked::AtMost(1.4), found);
        figures.push(figure.measured_in(&cases.at(place), &[ANTUMBRA]));
    }
    let cut = Place::still("city", "cut", 10_000);
    figures.push(ratio_at(cases, &cut, IDEAL, 1.4));
    let what = "frame after a cut, antumbra / ideal";
    let found = cases.at(&cut).after_cut_ratio(ANTUMBRA, IDEAL);
    let figure = Figure::new(cut.name(), what, Asked::AtMost(2.5), found);
    figures.push(figure.measured_in(&cases.at(&cut), &[ANTUMBRA]));
    for objects in [10_000, 40_000] {
        figures.push(ratio_at(cases, &Place::still("city", "fly", objects), IDEAL, 1.15));
    }
    for path in ["fly", "street"] {
        figures.push(ratio_at(cases, &Place::still("field", path, 10_000), FRUSTUM, 1.02));
    }
    figures.push(cpu_growth(cases));
    figures.extend(wrong_pixels(cases));
    figures
}

fn tied(place: &Place, what: String, asked: Asked, ratio: Option<Ratio>) -> Figure {
    let note = match ratio.as_ref().and_then(|ratio| ratio.through.as_ref()) {
        Some(through) => format!("not in one walk: tied through {through}"),
        None => String::new(),
    };
    Figure::new(place.name(), what, asked, ratio.map(|ratio| ratio.spread)).noted(note)
}

fn ratio_at(cases: &Cases<'_>, place: &Place, over: &str, most: f64) -> Figure {
    let case = cases.at(place);
    let what = format!("antumbra / {over}");
    let figure = tied(place, what, Asked::AtMost(most), case.ratio(ANTUMBRA, over));
    figure.measured_in(&case, &[ANTUMBRA, over])
}

/// Returns the time of the fastest rival, as a multiple of the time of `antumbra`.
fn against_rivals(cases: &Cases<'_>, place: &Place) -> Figure {
    let case = cases.at(place);
    let mut nearest = None::<(&str, Spread)>;
    let mut missing = Vec::new();
    for rival in RIVALS {
        match case.ratio(rival, ANTUMBRA) {
            None => missing.push(rival),
            Some(Ratio { spread, .. }) => {
                if nearest.as_ref().is_none_or(|(_, least)| spread.median() < least.median()) {
                    nearest = Some((rival, spread));
                }
            }
        }
    }
    let mut notes = Vec::new();
    if let Some((rival, _)) = &nearest {
        notes.push(format!("nearest of {}: {rival}", RIVALS.join(", ")));
    }
    if !missing.is_empty() {
        notes.push(format!("not measured: {}", missing.join(", ")));
    }
    let what = "nearest rival / antumbra";
    let names: Vec<&str> = nearest.iter().map(|(rival, _)| *rival).chain([ANTUMBRA]).collect();
    let found = nearest.map(|(_, spread)| spread);
    let figure = Figure::new(place.name(), what, Asked::MoreThan(1.0), found);
    let figure = figure.noted(notes.join("; ")).measured_in(&case, &names);
    Figure { is_partial: !missing.is_empty(), ..figure }
}

fn cpu_growth(cases: &Cases<'_>) -> Figure {
    let small = cases.at(&Place::street(10_000));
    let large = cases.at(&Place::street(1_000_000));
    let growth = |of: &dyn Fn(&Case<'_>) -> Option<Spread>| of(&large)?.over(&of(&small)?);
    let times = |case: &Case<'_>| case.cpu_ms(ANTUMBRA);
    let visited = |case: &Case<'_>| case.count(ANTUMBRA, |run| run.nodes_visited);
    let mut notes = Vec::new();
    if let (Some(small), Some(large)) = (times(&small), times(&large)) {
        notes.push(format!("{} ms to {} ms", short(small.median()), short(large.median())));
    }
    if let (Some(small), Some(large)) = (visited(&small), visited(&large)) {
        let [small, large] = [small, large].map(|nodes| short(nodes.median().round()));
        notes.push(format!("nodes looked at: {small} to {large}"));
    }
    let found = growth(&times);
    let what = "CPU time in the engine, 1M / 10k objects";
    Figure::new("street 10k to 1M", what, Asked::AtMost(1.5), found).noted(notes.join("; "))
}

/// Returns the wrong pixels of all exact strategies in each setting, and of each other strategy.
fn wrong_pixels(cases: &Cases<'_>) -> Vec<Figure> {
    let books = exactness::books(cases);
    let mut figures = Vec::new();
    for setting in Setting::ALL {
        let exact = |book: &&exactness::Book| book.is_exact && book.setting == setting;
        let compared = || books.iter().filter(exact).filter(|book| book.frames_compared > 0);
        let frames: u64 = compared().map(|book| book.frames_compared).sum();
        let pixels: u64 = compared().map(|book| book.pixels_wrong).sum();
        let left: Vec<&str> = books
            .iter()
            .filter(exact)
            .filter(|book| book.frames_compared == 0 && !book.is_refused)
            .map(|book| book.strategy.as_str())
            .collect();
        let mut note = format!("{} frames compared", thousands(frames as f64));
        if !left.is_empty() {
            note.push_str(&format!("; not compared: {}", left.join(", ")));
        }
        let found = if frames > 0 { Spread::of([pixels as f64]) } else { None };
        let what = "wrong pixels of all exact strategies";
        let figure = Figure::new(setting.name(), what, Asked::AtMost(0.0), found).noted(note);
        figures.push(Figure { is_partial: !left.is_empty(), ..figure });
    }
    for book in books.iter().filter(|book| !book.is_exact && book.setting == Setting::Still) {
        let found = (book.frames_compared > 0).then_some(book.pixels_wrong as f64);
        let what = format!("wrong pixels of {}", book.strategy);
        let note = format!("{} frames compared", book.frames_compared);
        let found = found.and_then(|pixels| Spread::of([pixels]));
        figures.push(Figure::new(book.setting.name(), what, Asked::Shown, found).noted(note));
    }
    figures
}

#[cfg(test)]
mod tests;
