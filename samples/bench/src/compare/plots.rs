//! The plots of the comparison, out of its cases.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::{AsRelative, BindKeyPoints, IntoLogRange};

use super::bar_chart::BarChart;
use super::cases::{ANTUMBRA, Case, Cases, FRUSTUM, IDEAL, Place};
use super::figures::STREET_GOALS;
use super::line_chart::{
    Axis, LineChart, Marks, Point, Series, logarithmic, picture_with_legend, plain,
};
use super::palette;
use super::picture::{DrawError, picture};
use super::spread::Spread;
use crate::report::{Report, RunReport};
use crate::strategy::{Strategy, named};

/// The width of a plot over the whole page, in pixels.
const WIDTH: u32 = 1120;
/// The largest ratio of the enlarged plot.
const NEAR: f64 = 3.6;
/// The ratio of frame times above which they are shown on a logarithmic axis.
const WIDE: f64 = 5.0;
/// The limits of axes: values beyond them are not plausible, even if a report has them.
const SENSIBLE: [f64; 2] = [1e-6, 1e9];

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
    let Some([least, most]) = range(&series) else {
        return Ok(None);
    };
    let sizes = sizes_of(&series);
    let label = format!("frame time, times that of {over}");
    let title = format!("Frame time over that of {over}");
    let wide_label = format!("{label} (logarithmic)");
    let all = LineChart::over_sizes(&title, &wide_label, &series);
    let near_title = format!("The same, near {over}");
    let near =
        LineChart { goals: goals(&sizes), ..LineChart::over_sizes(&near_title, &label, &series) };
    let describe = format!("Frame time of every strategy over that of {over}, by scene size");
    let mut caption = format!(
        "City at street level. Each dot is the median of the ratios frame by frame to {over}, each \
         vertical line the spread of the repetitions."
    );
    if over == IDEAL {
        caption.push_str(" Short horizontal bars: the goals of antumbra.");
    }
    let svg = picture_with_legend(&describe, &series, all.marks, |area| {
        let y = logarithmic(least * 0.9, most * 1.15);
        if over != IDEAL {
            return all.draw(area, size_axis(&sizes), y);
        }
        let (left, right) = area.split_horizontally(50.percent_width());
        all.draw(&left, size_axis(&sizes), y)?;
        let shown = (least - 0.05).min(0.9)..NEAR.min(most * 1.05).max(1.5);
        near.draw(&right, size_axis(&sizes), RangedCoordf64::from(shown))
    })?;
    Ok(Some(Plot { svg, caption }))
}

/// Returns the goals of `antumbra` between the smallest and the largest of these sizes.
fn goals(sizes: &[f64]) -> Vec<(f64, f64)> {
    let goals = STREET_GOALS.into_iter().map(|(size, goal)| (size as f64, goal));
    let is_measured = |size: f64| sizes.first() <= Some(&size) && Some(&size) <= sizes.last();
    goals.filter(|(size, _)| is_measured(*size)).collect()
}

/// Returns the strategy that times are divided by.
pub fn yardstick(cases: &Cases<'_>, sizes: &[u64]) -> &'static str {
    let measured = |size: &u64| cases.at(&Place::street(*size)).strategies().contains(&IDEAL);
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
    let Some([least, most]) = range(&series) else {
        return Ok(None);
    };
    let label = "CPU time of the engine in a frame, ms (logarithmic)";
    let chart = LineChart::over_sizes("CPU time over scene size", label, &series);
    let svg = picture_with_legend(chart.title, &series, chart.marks, |area| {
        let y = logarithmic(least * 0.8, most * 1.25);
        chart.draw(area, size_axis(&sizes_of(&series)), y)
    })?;
    let caption = "City at street level; medians of all frames. At the largest sizes only some \
                   strategies were measured.";
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
    let is_wide = most / least > WIDE;
    let name = place.name();
    let chart = LineChart {
        title: &format!("Frame time over the path: {name}"),
        labels: ["frame", if is_wide { "frame time, ms (logarithmic)" } else { "frame time, ms" }],
        x_text: plain,
        series: &series,
        goals: vec![],
        marks: Marks::Line,
    };
    let svg = picture_with_legend(chart.title, &series, chart.marks, |area| {
        let x = RangedCoordf64::from(0.0..last);
        if is_wide {
            return chart.draw(area, x, logarithmic(least * 0.9, most * 1.1));
        }
        chart.draw(area, x, RangedCoordf64::from(0.0..most * 1.05))
    })?;
    let late = case.reports().iter().map(|report| report.frames_in_flight).max().unwrap_or(0);
    let mut caption = match place.path.as_str() {
        "cut" => caption_of_cuts(&case.strategies(), late),
        _ => "Medians of the repetitions, frame by frame.".to_owned(),
    };
    let both = |report: &&Report| report.run(ANTUMBRA).is_some() && report.run(FRUSTUM).is_some();
    if case.strategies().contains(&FRUSTUM) && !case.reports().iter().any(both) {
        caption.push_str(" Plain frustum culling walked apart from the others.");
    }
    Ok(Some(Plot { svg, caption }))
}

/// Returns a caption about the frames in which the work of a jump shows: later ones, except for
/// strategies that wait for results within the frame.
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
    let chart = |title: &str, of: fn(&RunReport) -> Option<u64>| BarChart {
        title: title.to_owned(),
        bars: names
            .iter()
            .map(|name| ((*name).to_owned(), case.count(name, of).map(|count| count.median())))
            .collect(),
        names_px: 146,
    };
    // A strategy with few queries may test many boxes by other means, so both charts are shown or
    // neither.
    let tests = chart("Boxes tested per frame", |run| run.tests);
    let queries = chart("Occlusion queries per frame", |run| run.queries);
    let draws = chart("Draws per frame", |run| run.draws);
    let describe = "Boxes tested, occlusion queries and draws per frame";
    let svg = picture((WIDTH, queries.height()), describe, |area| {
        for (third, chart) in area.split_evenly((1, 3)).iter().zip([tests, queries, draws]) {
            chart.draw(third)?;
        }
        Ok(())
    })?;
    let name = place.name();
    let caption = format!(
        "{name}; medians of all frames; logarithmic. Boxes are tested by queries, flags or compute \
         shaders: one tested by a query is in both counts, and a visible object may be queried by its \
         own draw, without a box. What the GPU tests by itself is not counted: all objects of \
         pyramid, and leaves below a box of ours that showed."
    );
    Ok(Some(Plot { svg, caption }))
}

/// Returns a line for each strategy; `antumbra` is drawn over all others.
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
    let at = |size: u64| cases.at(&Place::street(size));
    let point = |name: &str, size: u64| {
        let spread = value(&at(size), name)?;
        let least = spread.least();
        let most = spread.most();
        Some(Point { x: size as f64, y: spread.median(), least, most })
    };
    lines(cases.street_strategies(sizes), |name| {
        sizes.iter().filter_map(|size| point(name, *size)).collect()
    })
}

/// Returns the sizes at which something was measured, in ascending order.
fn sizes_of(series: &[Series]) -> Vec<f64> {
    let points = series.iter().flat_map(|line| &line.points);
    let mut sizes: Vec<f64> = points.map(|point| point.x).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    sizes
}

/// Returns a logarithmic axis that has a tick at each of these sizes.
fn size_axis(sizes: &[f64]) -> impl Axis + use<> {
    let [least, most] = [sizes.first(), sizes.last()].map(|size| size.copied().unwrap_or(1.0));
    (least.max(1.0) * 0.85..most.max(1.0) * 1.15).log_scale().with_key_points(sizes.to_vec())
}

/// Returns the smallest value above 0 and the largest of all lines.
fn range(series: &[Series]) -> Option<[f64; 2]> {
    let points = || series.iter().flat_map(|line| &line.points);
    let least = points().map(|point| point.least).filter(|y| *y > 0.0).reduce(f64::min)?;
    let most = points().map(|point| point.most).reduce(f64::max)?;
    Some([least, most].map(|end| end.clamp(SENSIBLE[0], SENSIBLE[1])))
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
        let times = [("ideal", 1.0), ("antumbra", 1.2), ("chc", 2.0)];
        let reports = [
            measured("city", "street", 2_000, &[times[0], times[1], times[2], ("naive", 60.0)]),
            measured("city", "street", 40_000, &times),
            measured("city", "street", 40_000, &[("frustum", 30.0), times[0]]),
        ];
        let plot = ratios(&Cases::of(&reports)).unwrap().unwrap();
        for name in ["ideal", "antumbra", "chc"] {
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
    fn any_report_is_drawn() {
        let times = |ms: f64| vec![ms, f64::MAX, ms, 0.0, f64::MIN];
        let walk = |objects| {
            let runs = [("ideal", times(1e-300)), ("antumbra", times(1e5)), ("frustum", vec![])];
            walked("city", "street", objects, &runs)
        };
        let reports = [walk(0), walk(10_000), walk(u64::MAX)];
        let cases = Cases::of(&reports);
        let place = Place::street(10_000);
        let plots = [
            ratios(&cases),
            cpu_times(&cases),
            frame_times(&cases, &place),
            counts(&cases, &place),
        ];
        for plot in plots {
            let svg = plot.unwrap().unwrap().svg;
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
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
        let names = ["antumbra", "stop_and_wait", "chc"].map(|name| (name, times()));
        let reports = [walked("city", "cut", 10_000, &names)];
        let place = Place::still("city", "cut", 10_000);
        let plot = frame_times(&Cases::of(&reports), &place).unwrap().unwrap();
        let words = "at once for those that wait for answers (stop_and_wait, chc)";
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
