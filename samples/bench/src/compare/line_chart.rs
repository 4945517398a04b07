//! A chart of lines: one per strategy, and the legend beside it.

use std::iter;
use std::ops::Range;

use plotters::coord::ranged1d::ValueFormatter;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::{
    BindKeyPoints, ChartBuilder, Circle, Color, EmptyElement, ErrorBar, IntoLogRange, LineSeries,
    PathElement, Ranged, SeriesLabelPosition, ShapeStyle, TRANSPARENT,
};

use super::cases::{ANTUMBRA, IDEAL};
use super::palette::{self, FAINT, GOAL, GRID, INK};
use super::picture::{Area, DrawError, label, picture, title};
use super::spread::objects;
use crate::statistics::thousands;

/// The ratio of the ends of a logarithmic axis below which its ticks are equally far apart, and the
/// one above which only powers of ten have ticks.
const FEW_TICKS: [f64; 2] = [5.0, 400.0];
/// The size of a picture of lines, and the width of the part of it that is left of the legend.
const SIZE: (u32, u32) = (1120, 430);
const CHARTS_WIDTH: i32 = 926;
/// The margin around a chart, in pixels.
const MARGIN: i32 = 12;
/// Half the width of a goal's mark, in pixels.
const GOAL_REACH: i32 = 14;
/// The radius of a dot, in pixels.
const DOT: i32 = 4;

/// One value of a line, with its spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The value along the lower axis.
    pub x: f64,
    /// The value along the left axis.
    pub y: f64,
    /// The smallest of the repetitions.
    pub least: f64,
    /// The largest.
    pub most: f64,
}

/// The look of a line's points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marks {
    /// A line alone: many points, close together.
    Line,
    /// A dot and the spread at each of few points.
    Dots,
}

/// One strategy's line.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name.
    pub strategy: String,
    /// Its points from left to right.
    pub points: Vec<Point>,
}

/// A chart of lines.
#[derive(Clone, Debug)]
pub struct LineChart<'a> {
    /// The text above it.
    pub title: &'a str,
    /// The quantities on the lower and the left axis, with units.
    pub labels: [&'a str; 2],
    /// Returns the text of a tick of the lower axis.
    pub x_text: fn(f64) -> String,
    /// The lines; later ones are drawn over earlier ones.
    pub series: &'a [Series],
    /// The goals of `antumbra`, as x and y.
    pub goals: Vec<(f64, f64)>,
    /// The look of points.
    pub marks: Marks,
}

/// An axis of a chart of lines.
pub trait Axis: Ranged<ValueType = f64> + ValueFormatter<f64> {}

impl<T: Ranged<ValueType = f64> + ValueFormatter<f64>> Axis for T {}

/// Returns an axis from `least` to `most`, both above 0, with ticks at 1, 2 and 5 times powers of
/// ten.
pub fn logarithmic(least: f64, most: f64) -> impl Axis {
    let ratio = most / least;
    let steps = if ratio > FEW_TICKS[1] { &[1.0][..] } else { &[1.0, 2.0, 5.0] };
    let powers = least.log10().floor() as i32..=most.log10().ceil() as i32;
    let ticks = powers.flat_map(|power| steps.iter().map(move |step| step * 10f64.powi(power)));
    let ticks = if ratio < FEW_TICKS[0] {
        RangedCoordf64::from(least..most).key_points(6)
    } else {
        ticks.filter(|tick| (least..=most).contains(tick)).collect()
    };
    (least..most).log_scale().with_key_points(ticks)
}

/// Returns the text of a tick.
pub fn plain(value: f64) -> String {
    if value >= 1e3 { thousands(value) } else { format!("{}", (value * 1e6).round() / 1e6) }
}

/// Returns the style of a strategy's line.
fn line(strategy: &str) -> ShapeStyle {
    let width = match strategy {
        ANTUMBRA => 4,
        IDEAL => 3,
        _ => 2,
    };
    palette::of_strategy(strategy).rgb().stroke_width(width)
}

fn dot(strategy: &str) -> ShapeStyle {
    let style = palette::of_strategy(strategy).rgb().stroke_width(2);
    if palette::is_dashed(strategy) { style } else { style.filled() }
}

impl<'a> LineChart<'a> {
    /// Creates a chart of few points over numbers of objects, without goals.
    pub fn over_sizes(title: &'a str, y_label: &'a str, series: &'a [Series]) -> Self {
        let labels = ["objects in the scene", y_label];
        Self { title, labels, x_text: objects, series, goals: Vec::new(), marks: Marks::Dots }
    }

    /// Draws the chart into an area, without its legend.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn draw(&self, area: &Area<'_>, x: impl Axis, y: impl Axis) -> Result<(), DrawError> {
        let shown = y.range();
        let mut chart = ChartBuilder::on(area)
            .caption(self.title, title())
            .margin(MARGIN)
            .x_label_area_size(46)
            .y_label_area_size(58)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .bold_line_style(GRID.rgb())
            .light_line_style(TRANSPARENT)
            .axis_style(FAINT.rgb())
            .x_desc(self.labels[0])
            .y_desc(self.labels[1])
            .x_label_formatter(&|x| (self.x_text)(*x))
            .y_label_formatter(&|y| plain(*y))
            .label_style(label(FAINT))
            .set_all_tick_mark_size(4)
            .draw()?;
        for Series { strategy, points } in self.series {
            for part in parts_below_the_top(points, &shown) {
                chart.draw_series(LineSeries::new(part, line(strategy)))?;
            }
            if self.marks == Marks::Dots {
                let within = |y: f64| y.max(shown.start).min(shown.end);
                chart.draw_series(points.iter().filter(|point| point.y <= shown.end).map(
                    |Point { x, y, least, most }| {
                        let [least, y, most] = [*least, *y, *most].map(within);
                        ErrorBar::new_vertical(*x, least, y, most, dot(strategy), 2 * DOT as u32)
                    },
                ))?;
            }
        }
        // Values on the bar or below it reach the goal.
        let across = [(-GOAL_REACH, 0), (GOAL_REACH, 0)];
        let goal = || PathElement::new(across, GOAL.rgb().stroke_width(3));
        chart.draw_series(self.goals.iter().map(|place| EmptyElement::at(*place) + goal()))?;
        Ok(())
    }
}

/// Returns the parts of a line below the end of the y axis, cut where the line crosses it. The x
/// axis is logarithmic.
fn parts_below_the_top(points: &[Point], shown: &Range<f64>) -> Vec<Vec<(f64, f64)>> {
    let top = shown.end;
    let mut corners: Vec<(f64, f64)> = Vec::new();
    for point in points {
        let x = point.x;
        let y = point.y.max(shown.start);
        if let Some(&(last_x, last_y)) = corners.last()
            && (last_y > top) != (y > top)
        {
            let share = (top - last_y) / (y - last_y);
            corners.push((last_x * (x / last_x).powf(share), top));
        }
        corners.push((x, y));
    }
    let parts = corners.split(|(_, y)| *y > top).filter(|part| part.len() > 1);
    parts.map(<[_]>::to_vec).collect()
}

/// Draws a picture of lines, with their legend on the right, and returns its SVG.
///
/// # Errors
/// When it cannot be drawn.
pub fn picture_with_legend(
    description: &str,
    series: &[Series],
    marks: Marks,
    draw: impl FnOnce(&Area<'_>) -> Result<(), DrawError>,
) -> Result<String, DrawError> {
    picture(SIZE, description, |area| {
        let (left, right) = area.split_horizontally(CHARTS_WIDTH);
        draw(&left)?;
        legend(&right, series, marks)
    })
}

/// Draws a sample and the name of each line into an area, in the order of the ends of the lines.
fn legend(area: &Area<'_>, series: &[Series], marks: Marks) -> Result<(), DrawError> {
    let end = |series: &Series| series.points.last().map_or(0.0, |point| point.y);
    let mut series: Vec<&Series> = series.iter().collect();
    series.sort_by(|a, b| end(b).total_cmp(&end(a)));
    let mut chart = ChartBuilder::on(area).build_cartesian_2d(0..1, 0..1)?;
    for Series { strategy, .. } in series {
        let line = line(strategy);
        let dot = dot(strategy);
        let name = chart.draw_series(iter::empty::<PathElement<(i32, i32)>>())?.label(strategy);
        let sample =
            move |place| EmptyElement::at(place) + PathElement::new([(0, 0), (40, 0)], line);
        match marks {
            Marks::Line => name.legend(sample),
            Marks::Dots => name.legend(move |at| sample(at) + Circle::new((DOT, 0), DOT, dot)),
        };
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::MiddleLeft)
        .legend_area_size(46)
        .label_font(label(INK))
        .draw()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use plotters::coord::ranged1d::BoldPoints;
    use proptest::prelude::*;

    fn series(name: &str, points: &[(f64, f64)]) -> Series {
        let point = |&(x, y): &(f64, f64)| Point { x, y, least: y * 0.9, most: y * 1.1 };
        Series { strategy: name.to_owned(), points: points.iter().map(point).collect() }
    }

    /// Draws lines over sizes from 1 to 100 and values up to 4, with their legend.
    fn svg(series: &[Series]) -> String {
        let chart = LineChart {
            title: "A & B",
            labels: ["objects", "times the ideal"],
            x_text: plain,
            series,
            goals: vec![(5.0, 1.0)],
            marks: Marks::Dots,
        };
        picture_with_legend("A test", series, chart.marks, |area| {
            chart.draw(area, logarithmic(1.0, 100.0), RangedCoordf64::from(0.0..4.0))
        })
        .unwrap()
    }

    fn finite() -> impl Strategy<Value = f64> {
        prop::num::f64::POSITIVE
            | prop::num::f64::NEGATIVE
            | prop::num::f64::NORMAL
            | prop::num::f64::ZERO
    }

    fn ticks(axis: &impl Axis) -> Vec<String> {
        axis.key_points(BoldPoints(6)).into_iter().map(plain).collect()
    }

    fn numbers(svg: &str, element: &str, colour: &str, attribute: &str) -> Vec<Vec<i32>> {
        let document = roxmltree::Document::parse(svg).expect("well-formed");
        let is_it = |node: &roxmltree::Node<'_, '_>| {
            let colours = [node.attribute("stroke"), node.attribute("fill")];
            node.tag_name().name() == element && colours.contains(&Some(colour))
        };
        let numbers = |text: &str| text.split([' ', ',']).filter_map(|x| x.parse().ok()).collect();
        let found = document.descendants().filter(is_it);
        found.filter_map(|node| node.attribute(attribute)).map(numbers).collect()
    }

    #[test]
    fn lines_have_their_colour_and_their_name() {
        let svg = svg(&[
            series("antumbra", &[(1.0, 1.0), (100.0, 2.0)]),
            series("ideal", &[(1.0, 1.0), (100.0, 1.0)]),
            series("naive", &[(1.0, 3.0)]),
        ]);
        for (name, dots) in [("antumbra", 3), ("ideal", 3), ("naive", 2)] {
            let colour = palette::of_strategy(name).light_hex();
            assert_eq!(numbers(&svg, "circle", &colour, "cx").len(), dots, "{name}");
            let lines = numbers(&svg, "polyline", &colour, "points");
            assert_eq!(lines.len(), dots - 1, "{name}: in the legend, and between two dots");
        }
        let names = ["naive", "antumbra", "ideal"];
        let named = svg.lines().map(str::trim).filter(|line| names.contains(line));
        assert!(named.eq(names), "not named as the lines end: {svg}");
        assert!(svg.contains("A &amp; B") && svg.contains("times the ideal"));
        assert!(svg.contains("<title>A test</title>"));
    }

    #[test]
    fn a_line_is_cut_where_it_leaves_the_plot() {
        let parts = |points: &[(f64, f64)]| {
            parts_below_the_top(&series("frustum", points).points, &(0.0..4.0))
        };
        assert_eq!(parts(&[(1.0, 2.0), (100.0, 6.0)]), [[(1.0, 2.0), (10.0, 4.0)]]);
        assert_eq!(
            parts(&[(1.0, 6.0), (4.0, 2.0), (16.0, 6.0), (20.0, 6.0)]),
            [[(2.0, 4.0), (4.0, 2.0), (8.0, 4.0)]]
        );
        let above = [(1.0, 5.0), (10.0, 6.0)];
        assert!(parts(&above).is_empty());
        let svg = svg(&[series("frustum", &above)]);
        assert!(svg.lines().any(|line| line.trim() == "frustum"), "it is in the legend");
        let colour = palette::of_strategy("frustum").light_hex();
        assert_eq!(numbers(&svg, "circle", &colour, "cx").len(), 1, "one in the legend");
    }

    #[test]
    fn a_dashed_line_has_hollow_dots_to_tell_it_by_where_it_is_a_single_point() {
        for (name, fill) in
            [("naive", palette::of_strategy("naive").light_hex()), ("batched", "none".to_owned())]
        {
            let svg = svg(&[series(name, &[(10.0, 2.0)])]);
            let dots = svg.lines().filter(|line| line.starts_with("<circle"));
            let hollow = |dot: &str| dot.contains(&format!("fill=\"{fill}\""));
            assert!(dots.clone().count() == 2 && dots.clone().all(hollow), "{name}: {svg}");
        }
    }

    #[test]
    fn values_below_the_axis_lie_at_its_end() {
        let svg = svg(&[series("frustum", &[(1.0, 0.0), (10.0, -1e300)])]);
        let colour = palette::of_strategy("frustum").light_hex();
        let dots = numbers(&svg, "circle", &colour, "cy");
        assert_eq!(dots[0], dots[1]);
        let line = &numbers(&svg, "polyline", &colour, "points")[0];
        assert_eq!([line[1], line[3]], [dots[0][0]; 2]);
    }

    #[test]
    fn an_empty_chart_is_drawn() {
        assert!(svg(&[]).contains("times the ideal"));
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(ticks(&RangedCoordf64::from(0.0..50.0)), ["0", "10", "20", "30", "40", "50"]);
        assert_eq!(ticks(&RangedCoordf64::from(0.9..2.1)), ["1", "1.2", "1.4", "1.6", "1.8", "2"]);
        assert_eq!(ticks(&RangedCoordf64::from(0.0..4_000.0)).last().unwrap(), "4,000");
        assert_eq!(ticks(&logarithmic(0.9, 51.0)), ["1", "2", "5", "10", "20", "50"]);
        assert_eq!(ticks(&logarithmic(0.05, 0.6)), ["0.05", "0.1", "0.2", "0.5"]);
        assert_eq!(ticks(&logarithmic(1.0, 1e4)), ["1", "10", "100", "1,000", "10,000"]);
        assert_eq!(ticks(&logarithmic(2.4, 3.75)), ["2.5", "3", "3.5"]);
    }

    proptest! {
        #[test]
        fn any_values_are_drawn_within_the_chart(
            values in prop::collection::vec((0.0..1e7, finite()), 0..6)
        ) {
            let svg = svg(&[series("frustum", &values)]);
            let colour = palette::of_strategy("frustum").light_hex();
            for points in numbers(&svg, "polyline", &colour, "points") {
                for point in points.chunks(2) {
                    prop_assert!((0..1120).contains(&point[0]) && (0..430).contains(&point[1]));
                }
            }
            prop_assert!(!svg.contains("NaN") && !svg.contains("inf"));
        }
    }
}
