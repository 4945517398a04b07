//! The plots of the comparison, out of its cases.

use super::axis::Axis;
use super::bar_chart::BarChart;
use super::canvas::{DrawError, picture};
use super::cases::{ANTUMBRA, Case, Cases, FRUSTUM, IDEAL, Place};
use super::figures::{STREET_GOALS, case_name};
use super::input::{Measured, MeasuredRun};
use super::line_chart::{LineChart, Marks, Point, Series};
use super::palette;
use super::spread::{Spread, objects};
use crate::strategy::{Strategy, named};

/// The width of a plot over the whole page, in pixels.
const WIDTH: u32 = 1120;
const HEIGHT: u32 = 430;
/// The largest ratio that is shown once more, larger.
const NEAR: f64 = 3.6;
/// The ratio of frame times above which they are shown on a logarithmic axis.
const WIDE: f64 = 5.0;

/// A plot, and the text that explains it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Its SVG.
    pub svg: String,
    /// A sentence below.
    pub caption: String,
}

/// Plots the frame time of every strategy over scene sizes on `street`, as a multiple of the
/// ideal's (of plain frustum culling's, where the ideal was not measured): the whole range, and the
/// range near the ideal.
///
/// # Errors
/// When it cannot be drawn.
pub fn ratios(cases: &Cases<'_>) -> Result<Option<Plot>, DrawError> {
    let sizes = cases.sizes("city", "street");
    let over = yardstick(cases, &sizes);
    let ratio = |case: &Case<'_>, name: &str| case.ratio(name, over).map(|ratio| ratio.spread);
    let series = over_sizes(cases, &sizes, &ratio);
    let Some((x, [least, most])) = size_axis(&series, "objects in the scene").zip(range(&series))
    else {
        return Ok(None);
    };
    let label = format!("frame time, times that of {over}");
    let all = LineChart {
        title: format!("Frame time over that of {over}"),
        x: x.clone(),
        y: Axis::logarithmic(&format!("{label} (logarithmic)"), least * 0.9, most * 1.15),
        series: series.clone(),
        goals: vec![],
        marks: Marks::Dots,
    };
    let describe = format!("Frame time of every strategy over that of {over}, by scene size");
    let mut caption = format!(
        "City at street level. Each dot is the median of the ratios frame by frame to {over}, each \
         vertical line the spread of the repetitions."
    );
    let svg = if over == IDEAL {
        caption.push_str(
            " Short horizontal bars: the goals of antumbra. Lines that leave the right plot are \
             named at its top.",
        );
        let near = LineChart {
            title: format!("The same, near {over}"),
            y: Axis::linear(&label, (least - 0.05).min(0.9), NEAR.min(most * 1.05).max(1.5)),
            goals: goals(&x),
            x,
            series,
            marks: Marks::Dots,
        };
        picture((WIDTH, HEIGHT + 40), &describe, |canvas| {
            let (left, right) = canvas.split_at(i32::try_from(WIDTH / 2).unwrap_or(0));
            all.draw(&left)?;
            near.draw(&right)
        })?
    } else {
        picture((WIDTH, HEIGHT), &describe, |canvas| all.draw(canvas))?
    };
    Ok(Some(Plot { svg, caption }))
}

/// Returns the goals of `antumbra` at the sizes of an axis.
fn goals(x: &Axis) -> Vec<(f64, f64)> {
    let goals = STREET_GOALS.into_iter().map(|(size, goal)| (size as f64, goal));
    goals.filter(|(size, _)| (0.0..=1.0).contains(&x.place(*size))).collect()
}

/// Returns the strategy that ratios are taken to.
pub fn yardstick(cases: &Cases<'_>, sizes: &[u64]) -> &'static str {
    let measured =
        |size: &u64| cases.at(&Place::still("city", "street", *size)).strategies().contains(&IDEAL);
    if sizes.iter().any(measured) { IDEAL } else { FRUSTUM }
}

/// Plots the CPU time over scene sizes on `street`.
///
/// # Errors
/// When it cannot be drawn.
pub fn cpu_times(cases: &Cases<'_>) -> Result<Option<Plot>, DrawError> {
    let sizes: Vec<u64> =
        cases.sizes("city", "street").into_iter().filter(|size| *size >= 10_000).collect();
    let series = over_sizes(cases, &sizes, &|case, name| case.cpu_ms(name));
    let Some((x, [least, most])) = size_axis(&series, "objects in the scene").zip(range(&series))
    else {
        return Ok(None);
    };
    let label = "CPU time of the engine in a frame, ms (logarithmic)";
    let chart = LineChart {
        title: "CPU time over scene size".to_owned(),
        x,
        y: Axis::logarithmic(label, least * 0.8, most * 1.25),
        series,
        goals: vec![],
        marks: Marks::Dots,
    };
    let svg = picture((WIDTH, HEIGHT), "CPU time over scene size", |canvas| chart.draw(canvas))?;
    let caption = "City at street level; medians of all frames. At the largest sizes only what is \
                   named there was measured.";
    Ok(Some(Plot { svg, caption: caption.to_owned() }))
}

/// Plots the time of every frame over one path.
///
/// # Errors
/// When it cannot be drawn.
pub fn frame_times(cases: &Cases<'_>, place: &Place) -> Result<Option<Plot>, DrawError> {
    let case = cases.at(place);
    let line = |name: &str| {
        let times = case.frame_times_ms(name);
        let point = |(frame, time): (usize, &Option<f64>)| {
            time.map(|y| Point { x: frame as f64, y, least: y, most: y })
        };
        times.iter().enumerate().filter_map(point).collect()
    };
    let series = lines(case.strategies(), line);
    let Some([least, most]) = range(&series) else {
        return Ok(None);
    };
    let last =
        series.iter().flat_map(|line| line.points.last()).map(|end| end.x).fold(1.0, f64::max);
    let label = "frame time, ms";
    let y = if most / least > WIDE {
        Axis::logarithmic(&format!("{label} (logarithmic)"), least * 0.9, most * 1.1)
    } else {
        Axis::linear(label, 0.0, most * 1.05)
    };
    let name = case_name(&place.scene, &place.path, place.objects);
    let title = format!("Frame time over the path: {name}");
    let x = Axis::linear("frame", 0.0, last);
    let chart = LineChart { title, x, y, series, goals: vec![], marks: Marks::Line };
    let svg = picture((WIDTH, HEIGHT), &chart.title, |canvas| chart.draw(canvas))?;
    let late = case.reports().iter().map(|report| report.frames_in_flight).max().unwrap_or(0);
    let mut caption = match place.path.as_str() {
        "cut" => caption_of_cuts(&case.strategies(), late),
        _ => "Medians of the repetitions, frame by frame.".to_owned(),
    };
    let both = |report: &&Measured| report.run(ANTUMBRA).is_some() && report.run(FRUSTUM).is_some();
    if case.strategies().contains(&FRUSTUM) && !case.reports().iter().any(both) {
        caption.push_str(" Plain frustum culling walked apart from the others.");
    }
    Ok(Some(Plot { svg, caption }))
}

/// Returns a caption about the frames in which the work of a jump shows: later, but for strategies
/// that wait for it within the frame.
fn caption_of_cuts(strategies: &[&str], late: u32) -> String {
    let waits = |name: &&&str| named(name).is_some_and(Strategy::is_blocking);
    let waiting: Vec<&str> = strategies.iter().filter(waits).copied().collect();
    let mut caption = format!(
        "Every tenth frame jumps; its work shows {late} frames later, since as many are in flight"
    );
    if !waiting.is_empty() {
        let waiting = waiting.join(", ");
        caption.push_str(&format!("; at once for those that wait for answers ({waiting})"));
    }
    caption + "."
}

/// Plots the tests, queries and draws per frame of every strategy.
///
/// # Errors
/// When it cannot be drawn.
pub fn counts(cases: &Cases<'_>, place: &Place) -> Result<Option<Plot>, DrawError> {
    let case = cases.at(place);
    let mut names = case.strategies();
    names.sort_by_key(|name| palette::place_of(name));
    if names.is_empty() {
        return Ok(None);
    }
    let chart = |title: &str, of: fn(&MeasuredRun) -> Option<u64>| BarChart {
        title: title.to_owned(),
        bars: names
            .iter()
            .map(|name| ((*name).to_owned(), case.count(name, of).map(|count| count.median())))
            .collect(),
    };
    // Whoever has few queries may test many boxes by other means: both, or neither.
    let tests = chart("Boxes tested per frame", |run| run.tests);
    let queries = chart("Occlusion queries per frame", |run| run.queries);
    let draws = chart("Draws per frame", |run| run.draws);
    let describe = "Boxes tested, occlusion queries and draws per frame";
    let svg = picture((WIDTH, queries.height()), describe, |canvas| {
        let third = i32::try_from(WIDTH / 3).unwrap_or(0);
        let (left, rest) = canvas.split_at(third);
        let (middle, right) = rest.split_at(third);
        tests.draw(&left)?;
        queries.draw(&middle)?;
        draws.draw(&right)
    })?;
    let name = case_name(&place.scene, &place.path, place.objects);
    let caption = format!(
        "{name}; medians of all frames; logarithmic. Boxes are tested by queries, flags or compute \
         shaders: one tested by a query is in both counts, and a visible object may be queried by its \
         own draw, without a box. What the GPU tests by itself is not counted: all objects of \
         pyramid, and leaves below a box of ours that showed."
    );
    Ok(Some(Plot { svg, caption }))
}

/// Returns a line for each strategy, `antumbra` above all others.
fn lines(names: Vec<&str>, line: impl Fn(&str) -> Vec<Point>) -> Vec<Series> {
    let mut names = names;
    names.sort_by_key(|name| (*name == ANTUMBRA, palette::place_of(name)));
    let series = |name: &str| Series { strategy: name.to_owned(), points: line(name) };
    names.into_iter().map(series).filter(|series| !series.points.is_empty()).collect()
}

fn over_sizes(
    cases: &Cases<'_>,
    sizes: &[u64],
    value: &dyn Fn(&Case<'_>, &str) -> Option<Spread>,
) -> Vec<Series> {
    let at = |size: u64| cases.at(&Place::still("city", "street", size));
    let mut names = Vec::new();
    for case in sizes.iter().map(|size| at(*size)) {
        for name in case.strategies() {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    let point = |name: &str, size: u64| {
        let spread = value(&at(size), name)?;
        let (least, most) = (spread.least(), spread.most());
        Some(Point { x: size as f64, y: spread.median(), least, most })
    };
    lines(names, |name| sizes.iter().filter_map(|size| point(name, *size)).collect())
}

/// Returns a logarithmic axis that has a tick at each size at which something was measured.
fn size_axis(series: &[Series], label: &str) -> Option<Axis> {
    let mut sizes: Vec<f64> =
        series.iter().flat_map(|line| &line.points).map(|point| point.x).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    let (least, most) = (*sizes.first()?, *sizes.last()?);
    let ticks = sizes.into_iter().map(|size| (size, objects(size))).collect();
    Some(Axis::logarithmic(label, least * 0.85, most * 1.15).with_ticks(ticks))
}

/// Returns the smallest value above 0 and the largest of all lines.
fn range(series: &[Series]) -> Option<[f64; 2]> {
    let points = || series.iter().flat_map(|line| &line.points);
    let least = points().map(|point| point.least).filter(|y| *y > 0.0).reduce(f64::min)?;
    let most = points().map(|point| point.most).reduce(f64::max)?;
    Some([least, most])
}

#[cfg(test)]
mod tests {
    use super::super::testing::{measured, walked};
    use super::*;

    fn has_line(svg: &str, strategy: &str) -> bool {
        let colour = format!("stroke=\"{}\"", palette::of_strategy(strategy).light_hex());
        svg.lines().any(|line| line.contains("<polyline") && line.contains(&colour))
    }

    #[test]
    fn sizes_and_strategies_are_in_the_plot_of_ratios() {
        let times = [("ideal", 1.0), ("antumbra", 1.2), ("coherent", 2.0)];
        let reports = [
            measured("city", "street", 2_000, &[times[0], times[1], times[2], ("naive", 60.0)]),
            measured("city", "street", 40_000, &times),
            measured("city", "street", 40_000, &[("frustum", 30.0), times[0]]),
        ];
        let plot = ratios(&Cases::of(&reports)).unwrap().unwrap();
        for name in ["ideal", "antumbra", "coherent"] {
            assert!(has_line(&plot.svg, name), "{name}");
        }
        for text in ["2k", "40k", "naive", "frustum", "frame time, times that of ideal"] {
            assert!(plot.svg.lines().any(|line| line.trim() == text), "{text}");
        }
        assert!(has_goals(&plot.svg));
    }

    fn has_goals(svg: &str) -> bool {
        let colour = format!("stroke=\"{}\"", palette::GOAL.light_hex());
        svg.lines().any(|line| line.contains("<polyline") && line.contains(&colour))
    }

    #[test]
    fn without_the_ideal_ratios_are_to_frustum_culling() {
        let times = [("frustum", 5.0), ("antumbra", 1.2)];
        let reports = [measured("city", "street", 2_000, &times)];
        let plot = ratios(&Cases::of(&reports)).unwrap().unwrap();
        assert!(plot.svg.contains("times that of frustum") && plot.caption.contains("frustum"));
        assert!(!has_goals(&plot.svg), "goals are in times of the ideal");
    }

    #[test]
    fn what_was_not_measured_has_no_plot() {
        let reports = [measured("field", "fly", 500, &[("antumbra", 1.0)])];
        let cases = Cases::of(&reports);
        assert_eq!(ratios(&cases).unwrap(), None);
        assert_eq!(cpu_times(&cases).unwrap(), None);
        assert_eq!(frame_times(&cases, &Place::still("city", "cut", 10_000)).unwrap(), None);
        assert_eq!(counts(&cases, &Place::still("city", "cut", 10_000)).unwrap(), None);
    }

    #[test]
    fn frame_times_and_counts_name_every_strategy() {
        let times =
            |scale: f64| (0..40).map(|frame| scale * (2.0 + f64::from(frame % 10))).collect();
        let reports =
            [walked("city", "cut", 10_000, &[("antumbra", times(1.0)), ("frustum", times(9.0))])];
        let cases = Cases::of(&reports);
        let place = Place::still("city", "cut", 10_000);
        let path = frame_times(&cases, &place).unwrap().unwrap();
        assert!(has_line(&path.svg, "antumbra") && has_line(&path.svg, "frustum"));
        assert!(path.svg.contains("logarithmic") && path.caption.contains("2 frames later"));
        assert!(!path.caption.contains("at once"), "nobody waits: {}", path.caption);
        let bars = counts(&cases, &place).unwrap().unwrap();
        let titles = ["Boxes tested per frame", "Occlusion queries per frame", "Draws per frame"];
        for text in titles.into_iter().chain(["300", "120", "0", "50"]) {
            assert!(bars.svg.lines().any(|line| line.trim() == text), "{text}");
        }
    }

    #[test]
    fn who_waits_shows_the_work_of_a_cut_at_once() {
        let times = || vec![1.0; 30];
        let names = ["antumbra", "stop_and_wait", "coherent"].map(|name| (name, times()));
        let reports = [walked("city", "cut", 10_000, &names)];
        let place = Place::still("city", "cut", 10_000);
        let plot = frame_times(&Cases::of(&reports), &place).unwrap().unwrap();
        let words = "at once for those that wait for answers (stop_and_wait, coherent)";
        assert!(plot.caption.contains("2 frames later") && plot.caption.contains(words));
    }

    #[test]
    fn cpu_times_reach_from_ten_thousand_objects_on() {
        let at = |size| measured("city", "street", size, &[("antumbra", 10.0)]);
        let reports = [at(2_000), at(10_000), at(1_000_000)];
        let plot = cpu_times(&Cases::of(&reports)).unwrap().unwrap();
        let says = |text: &str| plot.svg.lines().any(|line| line.trim() == text);
        assert!(says("10k") && says("1M") && !says("2k") && has_line(&plot.svg, "antumbra"));
    }
}
