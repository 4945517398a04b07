//! A chart of horizontal bars over a logarithmic axis: one count per strategy.

use super::axis::Axis;
use super::canvas::{Align, Canvas, DrawError, Size};
use super::palette::{self, FAINT, GRID, INK};
use super::spread::thousands;

/// The margin around the bars.
const ABOVE: i32 = 40;
const LEFT: i32 = 146;
const RIGHT: i32 = 76;
const BELOW: i32 = 30;
/// The height of a row, and the height of the bar in it.
const ROW: i32 = 26;
const BAR: i32 = 16;
/// The axis' beginning, low enough that a bar of 1 can be seen; 0 has no bar.
const LEAST: f64 = 0.6;

/// A chart of bars.
#[derive(Clone, Debug, PartialEq)]
pub struct BarChart {
    /// The text above it.
    pub title: String,
    /// Each strategy with its count, from above; `None` where it was not measured.
    pub bars: Vec<(String, Option<f64>)>,
}

impl BarChart {
    /// Returns the height that it needs, in pixels.
    pub fn height(&self) -> u32 {
        let rows = u32::try_from(self.bars.len()).unwrap_or(0);
        ABOVE.unsigned_abs() + BELOW.unsigned_abs() + rows * ROW.unsigned_abs()
    }

    /// Draws the chart all over a canvas.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn draw(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        let (width, height) = canvas.size();
        let (right, bottom) = (width - RIGHT, height - BELOW);
        let most = self.bars.iter().filter_map(|(_, count)| *count).fold(10.0, f64::max);
        let axis = Axis::logarithmic("", LEAST, most);
        let x = |count: f64| LEFT + (f64::from(right - LEFT) * axis.place(count)).round() as i32;
        canvas.text(&self.title, (8, 16), (Align::Left, Size::Title), INK)?;
        for (tick, text) in axis.ticks.iter().filter(|(tick, _)| is_power_of_ten(*tick)) {
            canvas.line(vec![(x(*tick), ABOVE), (x(*tick), bottom)], GRID, 1)?;
            canvas.text(text, (x(*tick), bottom + 14), (Align::Centre, Size::Small), FAINT)?;
        }
        let mut middle = ABOVE + ROW / 2;
        for (name, count) in &self.bars {
            canvas.text(name, (LEFT - 8, middle), (Align::Right, Size::Small), INK)?;
            let (end, text) = match count {
                None => (LEFT, "not measured".to_owned()),
                Some(count) if *count < LEAST => (LEFT, "0".to_owned()),
                Some(count) => (x(*count), thousands(*count)),
            };
            if end > LEFT {
                let corners = [(LEFT, middle - BAR / 2), (end, middle + BAR / 2)];
                canvas.bar(corners, palette::of_strategy(name))?;
            }
            canvas.text(&text, (end + 7, middle), (Align::Left, Size::Small), INK)?;
            middle += ROW;
        }
        canvas.line(vec![(LEFT, ABOVE), (LEFT, bottom)], FAINT, 1)
    }
}

fn is_power_of_ten(value: f64) -> bool {
    (value.log10() - value.log10().round()).abs() < 1e-6
}

#[cfg(test)]
mod tests {
    use super::super::canvas::picture;
    use super::*;

    #[test]
    fn bars_have_names_and_counts() {
        let bars = [("frustum", Some(0.0)), ("antumbra", Some(1_720.0)), ("pyramid", None)];
        let bars = bars.map(|(name, count)| (name.to_owned(), count)).to_vec();
        let chart = BarChart { title: "queries".to_owned(), bars };
        let svg = picture((500, chart.height()), "Test", |canvas| chart.draw(canvas)).unwrap();
        for text in ["frustum", "antumbra", "pyramid", "0", "1,720", "not measured", "1,000"] {
            assert!(svg.lines().any(|line| line.trim() == text), "{text} is missing in {svg}");
        }
        let drawn = |name| svg.contains(&palette::of_strategy(name).light_hex());
        assert!(svg.matches("<rect").count() == 2, "the background and one bar");
        assert!(drawn("antumbra"));
    }
}
