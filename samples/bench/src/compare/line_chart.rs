//! A chart of lines: grid, axes, one line per strategy with its name at its end.

use std::collections::BTreeMap;

use super::axis::Axis;
use super::canvas::{Align, Canvas, DrawError, Pixel, Size};
use super::cases::{ANTUMBRA, IDEAL};
use super::labels::spread_apart;
use super::palette::{self, FAINT, GOAL, GRID, INK};

/// The margins around the plot.
const ABOVE: i32 = 78;
const BELOW: i32 = 58;
const LEFT: i32 = 62;
const RIGHT: i32 = 166;
/// The width of a name in a row of them.
const NAME_WIDTH: i32 = 104;
/// The distance between labels.
const LABEL_GAP: i32 = 18;

/// One value of a line, with its spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The value along the axis below.
    pub x: f64,
    /// The value along the axis at the left.
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
#[derive(Clone, Debug, PartialEq)]
pub struct LineChart {
    /// The text above it.
    pub title: String,
    /// The axis below.
    pub x: Axis,
    /// The axis at the left.
    pub y: Axis,
    /// The lines; those that come later lie above.
    pub series: Vec<Series>,
    /// The goals of `antumbra`, as x and y.
    pub goals: Vec<(f64, f64)>,
    /// The look of points.
    pub marks: Marks,
}

/// The plot's rectangle in the canvas.
#[derive(Clone, Copy)]
struct Frame {
    left: i32,
    top: i32,
    right: i32,
    bottom: i32,
}

impl LineChart {
    /// Draws the chart all over a canvas.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn draw(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        let (width, height) = canvas.size();
        let frame = Frame { left: LEFT, top: ABOVE, right: width - RIGHT, bottom: height - BELOW };
        self.draw_axes(canvas, frame)?;
        for series in &self.series {
            self.draw_series(canvas, frame, series)?;
        }
        for &(x, y) in &self.goals {
            self.draw_goal(canvas, self.pixel(frame, x, y))?;
        }
        self.draw_names(canvas, frame)?;
        self.draw_names_above(canvas, frame)
    }

    fn draw_axes(&self, canvas: &Canvas<'_>, frame: Frame) -> Result<(), DrawError> {
        let Frame { left, top, right, bottom } = frame;
        canvas.text(&self.title, (8, 16), (Align::Left, Size::Title), INK)?;
        canvas.text(&self.y.label, (8, 42), (Align::Left, Size::Small), FAINT)?;
        let below = ((left + right) / 2, bottom + 42);
        canvas.text(&self.x.label, below, (Align::Centre, Size::Small), FAINT)?;
        for (tick, text) in &self.y.ticks {
            let (_, y) = self.pixel(frame, 0.0, *tick);
            canvas.line(vec![(left, y), (right, y)], GRID, 1)?;
            canvas.text(text, (left - 8, y), (Align::Right, Size::Small), FAINT)?;
        }
        for (tick, text) in &self.x.ticks {
            let x = self.pixel(frame, *tick, 0.0).0;
            canvas.line(vec![(x, top), (x, bottom)], GRID, 1)?;
            canvas.text(text, (x, bottom + 18), (Align::Centre, Size::Small), FAINT)?;
        }
        canvas.line(vec![(left, bottom), (right, bottom)], FAINT, 1)
    }

    fn draw_series(
        &self,
        canvas: &Canvas<'_>,
        frame: Frame,
        series: &Series,
    ) -> Result<(), DrawError> {
        let colour = palette::of_strategy(&series.strategy);
        let width = match series.strategy.as_str() {
            ANTUMBRA => 4,
            IDEAL => 3,
            _ => 2,
        };
        for part in self.parts_below_the_top(&series.points) {
            let pixels = part.iter().map(|&(x, y)| self.pixel(frame, x, y)).collect();
            canvas.line(pixels, colour, width)?;
        }
        if self.marks == Marks::Dots {
            for point in series.points.iter().filter(|point| point.y <= self.y.most()) {
                let (x, y) = self.pixel(frame, point.x, point.y);
                let ends = [point.least, point.most.min(self.y.most())];
                let [low, high] = ends.map(|end| self.pixel(frame, point.x, end).1);
                if low - high > 2 {
                    canvas.line(vec![(x, low), (x, high)], colour, 2)?;
                }
                canvas.dot((x, y), if series.strategy == ANTUMBRA { 5 } else { 4 }, colour)?;
            }
        }
        Ok(())
    }

    /// Returns the parts of a line that lie within the axis, cut where the line leaves it at the
    /// top.
    fn parts_below_the_top(&self, points: &[Point]) -> Vec<Vec<(f64, f64)>> {
        let top = self.y.most();
        let mut parts = vec![Vec::new()];
        for (place, point) in points.iter().enumerate() {
            let before = place.checked_sub(1).and_then(|before| points.get(before));
            let crossing = before.filter(|before| (before.y > top) != (point.y > top));
            let Some(part) = parts.last_mut() else {
                break;
            };
            if let Some(before) = crossing {
                // In pixels the line is straight, so it is cut there.
                let [low, high] = [before.y, point.y].map(|y| self.y.place(y));
                let share = (1.0 - low) / (high - low);
                part.push((before.x + (point.x - before.x) * share, top));
            }
            if point.y <= top {
                part.push((point.x, point.y));
            } else if !part.is_empty() {
                parts.push(Vec::new());
            }
        }
        parts.retain(|part| part.len() > 1);
        parts
    }

    /// Draws a short bar across: at it or below, the goal is reached.
    fn draw_goal(&self, canvas: &Canvas<'_>, (x, y): Pixel) -> Result<(), DrawError> {
        canvas.line(vec![(x - 14, y), (x + 14, y)], GOAL, 3)
    }

    /// Draws the names at the ends of the lines, tied to them: right of the plot, or inside it
    /// where lines end early.
    fn draw_names(&self, canvas: &Canvas<'_>, frame: Frame) -> Result<(), DrawError> {
        let mut columns = BTreeMap::<i32, Vec<(&str, i32)>>::new();
        let last_x = self.series.iter().flat_map(|series| series.points.last());
        let last_x = last_x.map(|point| point.x).fold(f64::MIN, f64::max);
        for series in &self.series {
            let Some(end) = series.points.last().filter(|end| end.y <= self.y.most()) else {
                continue;
            };
            let (x, y) = self.pixel(frame, end.x, end.y);
            let column = if end.x >= last_x { x.max(frame.right - 4) } else { x };
            columns.entry(column).or_default().push((&series.strategy, y));
        }
        for (x, ends) in columns {
            let wanted: Vec<i32> = ends.iter().map(|(_, y)| *y).collect();
            let places = spread_apart(&wanted, LABEL_GAP, frame.top - 8, frame.bottom + 8);
            for ((name, y), place) in ends.iter().zip(places) {
                let leader = vec![(x + 7, *y), (x + 24, place), (x + 32, place)];
                // Within the plot a leader must not look like more of its line.
                let is_outside = x >= frame.right - 4;
                let colour = if is_outside { palette::of_strategy(name) } else { FAINT };
                canvas.line(leader, colour, if is_outside { 2 } else { 1 })?;
                let size = if *name == ANTUMBRA { Size::Normal } else { Size::Small };
                canvas.text(name, (x + 37, place), (Align::Left, size), INK)?;
            }
        }
        Ok(())
    }

    /// Draws the names of lines that leave the plot at the top and do not return, at the points
    /// where they leave.
    fn draw_names_above(&self, canvas: &Canvas<'_>, frame: Frame) -> Result<(), DrawError> {
        let mut exits: Vec<(&str, i32)> = Vec::new();
        for series in &self.series {
            let leaves = series.points.last().is_some_and(|end| end.y > self.y.most());
            let parts = self.parts_below_the_top(&series.points);
            if let Some(&(x, y)) = parts.last().and_then(|part| part.last()).filter(|_| leaves) {
                exits.push((&series.strategy, self.pixel(frame, x, y).0));
            }
        }
        let wanted: Vec<i32> = exits.iter().map(|(_, x)| *x).collect();
        let places = spread_apart(&wanted, NAME_WIDTH, frame.left + 20, frame.right + RIGHT / 2);
        for ((name, _), place) in exits.iter().zip(places) {
            canvas.text(name, (place, frame.top - 10), (Align::Centre, Size::Small), INK)?;
        }
        Ok(())
    }

    fn pixel(&self, frame: Frame, x: f64, y: f64) -> Pixel {
        let between = |from: i32, to: i32, place: f64| {
            (f64::from(from) + f64::from(to - from) * place.clamp(-0.05, 1.05)).round() as i32
        };
        (
            between(frame.left, frame.right, self.x.place(x)),
            between(frame.bottom, frame.top, self.y.place(y)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::canvas::picture;
    use super::*;

    fn point(x: f64, y: f64) -> Point {
        Point { x, y, least: y * 0.9, most: y * 1.1 }
    }

    fn chart(lines: &[(&str, &[(f64, f64)])]) -> LineChart {
        let series = |&(name, points): &(&str, &[(f64, f64)])| Series {
            strategy: name.to_owned(),
            points: points.iter().map(|&(x, y)| point(x, y)).collect(),
        };
        LineChart {
            title: "A & B".to_owned(),
            x: Axis::linear("objects", 0.0, 10.0),
            y: Axis::linear("times the ideal", 0.0, 4.0),
            series: lines.iter().map(series).collect(),
            goals: vec![(5.0, 1.0)],
            marks: Marks::Dots,
        }
    }

    fn svg(chart: &LineChart) -> String {
        picture((800, 400), "A test", |canvas| chart.draw(canvas)).unwrap()
    }

    #[test]
    fn lines_have_their_colour_and_their_name() {
        let svg = svg(&chart(&[
            ("antumbra", &[(0.0, 1.0), (10.0, 2.0)]),
            ("ideal", &[(0.0, 1.0), (10.0, 1.0)]),
            ("naive", &[(0.0, 3.0)]),
        ]));
        for name in ["antumbra", "ideal", "naive"] {
            assert!(svg.lines().any(|line| line.trim() == name), "{name} is not named in {svg}");
            let colour = palette::of_strategy(name).light_hex();
            assert!(svg.contains(&format!("fill=\"{colour}\"")), "{name} has no dot");
        }
        let line = format!("stroke=\"{}\"", palette::of_strategy("antumbra").light_hex());
        assert!(svg.lines().any(|text| text.contains("<polyline") && text.contains(&line)));
        assert!(svg.contains("A &amp; B") && svg.contains("times the ideal"));
        assert!(svg.contains("<title>A test</title>"));
    }

    #[test]
    fn a_line_is_cut_where_it_leaves_the_plot() {
        let leaves = chart(&[("frustum", &[(0.0, 2.0), (10.0, 6.0)])]);
        assert_eq!(
            leaves.parts_below_the_top(&leaves.series[0].points),
            [[(0.0, 2.0), (5.0, 4.0)]]
        );
        let returns = chart(&[("frustum", &[(0.0, 6.0), (4.0, 2.0), (8.0, 6.0), (10.0, 6.0)])]);
        assert_eq!(
            returns.parts_below_the_top(&returns.series[0].points),
            [[(2.0, 4.0), (4.0, 2.0), (6.0, 4.0)]]
        );
        assert!(svg(&leaves).lines().any(|line| line.trim() == "frustum"), "named where it leaves");
        let above = chart(&[("frustum", &[(0.0, 5.0), (10.0, 6.0)])]);
        assert!(above.parts_below_the_top(&above.series[0].points).is_empty());
        assert!(!svg(&above).contains("frustum"));
    }

    #[test]
    fn an_empty_chart_is_drawn() {
        assert!(svg(&chart(&[])).contains("times the ideal"));
    }
}
