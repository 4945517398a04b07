//! A chart of horizontal bars over a logarithmic axis: one count per strategy.

use plotters::prelude::{
    BindKeyPoints, ChartBuilder, Color, EmptyElement, Rectangle, TRANSPARENT, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::line_chart::logarithmic;
use super::palette::{self, FAINT, GRID, INK};
use super::picture::{Area, DrawError, label, title};
use crate::statistics::thousands;

/// The height of the title and of the axis, together.
const FRAME: u32 = 65;
/// The height of a row.
const ROW: u32 = 26;
/// The distance from a bar to the next row.
const GAP: u32 = 5;
/// The axis' beginning, low enough that a bar of 1 can be seen; 0 has no bar.
const LEAST: f64 = 0.6;

/// A chart of bars.
#[derive(Clone, Debug, PartialEq)]
pub struct BarChart {
    /// The text above it.
    pub title: String,
    /// Each strategy with its count, from above; `None` where it was not measured.
    pub bars: Vec<(String, Option<f64>)>,
    /// The width of their names, in pixels.
    pub names_px: u32,
}

impl BarChart {
    /// Returns the height that it needs, in pixels.
    pub fn height(&self) -> u32 {
        FRAME + ROW * u32::try_from(self.bars.len()).unwrap_or(0)
    }

    /// Draws the chart into an area.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn draw(&self, area: &Area<'_>) -> Result<(), DrawError> {
        let most = self.bars.iter().filter_map(|(_, count)| *count).fold(10.0, f64::max);
        // Rows are numbered by twos, so that the middle of a row is a whole number.
        let rows = i32::try_from(2 * self.bars.len()).unwrap_or(0);
        let middles = (1..rows).step_by(2).collect();
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, title())
            .margin_top(8)
            .margin_right(76)
            .x_label_area_size(30)
            .y_label_area_size(self.names_px)
            .build_cartesian_2d(logarithmic(LEAST, most), (rows..0).with_key_points(middles))?;
        let name = |middle: &i32| {
            let bar = usize::try_from(middle / 2).ok().and_then(|row| self.bars.get(row));
            bar.map_or(String::new(), |(name, _)| name.clone())
        };
        chart
            .configure_mesh()
            .disable_y_mesh()
            .bold_line_style(GRID.rgb())
            .light_line_style(TRANSPARENT)
            .axis_style(FAINT.rgb())
            .x_label_formatter(&|count| thousands(*count))
            .y_label_formatter(&name)
            .x_label_style(label(FAINT))
            .y_label_style(label(INK))
            .set_all_tick_mark_size(4)
            .draw()?;
        let beside = label(INK).pos(Pos::new(HPos::Left, VPos::Center));
        for (top, (name, count)) in (0..).step_by(2).zip(&self.bars) {
            let end = count.unwrap_or(LEAST).max(LEAST);
            if end > LEAST {
                let colour = palette::of_strategy(name).rgb();
                let mut bar = Rectangle::new([(LEAST, top), (end, top + 2)], colour.filled());
                bar.set_margin(GAP, GAP, 0, 0);
                chart.draw_series([bar])?;
            }
            let count = count.map_or("not measured".to_owned(), thousands);
            let count = Text::new(count, (7, 0), &beside);
            chart.draw_series([EmptyElement::at((end, top + 1)) + count])?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::picture::picture;
    use super::*;

    /// Returns the vertical place of a text.
    fn y_of(svg: &str, text: &str) -> i32 {
        let document = roxmltree::Document::parse(svg).expect("well-formed");
        let found = document.descendants().find(|node| node.text().map(str::trim) == Some(text));
        found.and_then(|node| node.attribute("y")?.parse().ok()).expect("it is there")
    }

    fn svg(bars: &[(&str, Option<f64>)]) -> String {
        let bars = bars.iter().map(|&(name, count)| (name.to_owned(), count)).collect();
        let chart = BarChart { title: "queries".to_owned(), bars, names_px: 146 };
        picture((500, chart.height()), "Test", |area| chart.draw(area)).unwrap()
    }

    #[test]
    fn bars_have_names_and_counts() {
        let svg = svg(&[("frustum", Some(0.0)), ("antumbra", Some(1_720.0)), ("hzb", None)]);
        for text in ["frustum", "antumbra", "hzb", "0", "1,720", "not measured", "1,000"] {
            assert!(svg.lines().any(|line| line.trim() == text), "{text} is missing in {svg}");
        }
        let drawn = |name| svg.contains(&palette::of_strategy(name).light_hex());
        assert!(svg.matches("<rect").count() == 2, "the background and one bar");
        assert!(drawn("antumbra"));
        assert_eq!(y_of(&svg, "antumbra"), y_of(&svg, "1,720"), "a count beside its name");
        assert!(y_of(&svg, "frustum") < y_of(&svg, "antumbra"), "the first one is above");
    }

    #[test]
    fn one_bar_is_drawn_between_its_row_s_edges_and_none_without_rows() {
        let bar = svg(&[("antumbra", Some(100.0))]);
        let bar = bar.lines().rfind(|line| line.starts_with("<rect")).unwrap();
        assert!(bar.contains(" height=\"16\""), "{bar}");
        assert!(svg(&[]).contains("queries"));
    }
}
