//! The panel of tools: the tree of parts, sections, edges, and other settings without keys.

use std::ops::RangeInclusive;

use antumbra::ObjectId;
use antumbra::cull::Aabb;
use antumbra::render::EdgeMode;
use egui::{
    Checkbox, Color32, ComboBox, Context, Frame, Grid, Label, Margin, Panel, RichText, ScrollArea,
    Sense, Slider, SliderClamping, Ui, vec2,
};
use samples::hud::style::{DIM, GOOD, MARGIN, MARK, NAME, VALUE};

use super::input::KEY_LINES;
use super::part_rows::{PartRow, PartRows};
use super::tools::{EDGE_MODES, MM, Measuring, Tools};
use crate::document::{Display, Document};
use crate::script::Command;
use crate::viewport::SeenObject;

/// The background of the panel, opaque even over a white image.
const GROUND: Color32 = Color32::from_rgb(26, 31, 39);

/// The width of the panel, in points.
const WIDTH: f32 = 236.0;

/// The largest share of the image that the panel covers.
const MOST_SHARE: f32 = 0.6;

/// The share of the panel's height for the tree.
const TREE_SHARE: f32 = 0.42;

/// The height of a row of the tree, in points.
const ROW_HEIGHT: f32 = 17.0;

/// The indentation of a row per enclosing group, in points.
const INDENT: f32 = 10.0;

/// The largest gap of the slider of exploded views, in millimetres.
const MOST_GAP_MM: f32 = 100.0;

/// The most parts that can be moved apart in a window: all pairs are compared.
const MOST_EXPLODED: u32 = 3000;

/// The contents of the panel.
pub struct PanelPage<'a> {
    /// The document.
    pub document: &'a Document,
    /// The box around the whole model at rest, which limits the planes.
    pub rest: Aabb,
    /// The settings of the tools.
    pub tools: Tools,
    /// The known visibility of the parts in the tree.
    pub seen: &'a [SeenObject],
    /// The number of drawn objects, if it is known.
    pub drawn: Option<u64>,
}

/// The effect of input in the panel.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelAnswer {
    /// The settings of the tools.
    pub tools: Tools,
    /// The resulting commands.
    pub commands: Vec<Command>,
}

/// The state of the panel.
pub struct ToolPanel {
    /// The rows of the tree.
    pub rows: PartRows,
    /// The row to scroll to.
    scroll_to: Option<usize>,
    /// The objects in visible rows.
    listed: Vec<ObjectId>,
}

impl ToolPanel {
    /// Creates the panel of a document.
    pub fn new(document: &Document) -> Self {
        Self { rows: PartRows::new(document), scroll_to: None, listed: Vec::new() }
    }

    /// Returns the objects in visible rows.
    pub fn listed(&self) -> &[ObjectId] {
        &self.listed
    }

    /// Opens the groups of an object in the tree, and scrolls to it.
    pub fn reveal(&mut self, document: &Document, object: ObjectId) {
        self.scroll_to = self.rows.reveal(&document.parts, object);
    }

    /// Shows the panel, if it is open, and the page of keys.
    pub fn show(&mut self, ui: &mut Ui, page: &PanelPage<'_>) -> PanelAnswer {
        let mut answer = PanelAnswer { tools: page.tools, commands: Vec::new() };
        if page.tools.has_help {
            show_keys(ui.ctx());
        }
        self.listed.clear();
        if !page.tools.has_panel {
            return answer;
        }
        let width = WIDTH.min(ui.max_rect().width() * MOST_SHARE);
        let frame = Frame::new().fill(GROUND).inner_margin(Margin::same(MARGIN as i8));
        let panel = Panel::left("tools").exact_size(width).resizable(false).frame(frame);
        panel.show(ui, |ui| {
            let height = ui.available_height();
            self.title(ui, page);
            self.tree(ui, page, height * TREE_SHARE, &mut answer);
            ui.separator();
            let rest = ScrollArea::vertical().id_salt("tools").auto_shrink(false);
            rest.show(ui, |ui| tools(ui, page, self.rows.rows().first(), &self.rows, &mut answer));
        });
        answer
    }

    fn title(&self, ui: &mut Ui, page: &PanelPage<'_>) {
        let name = RichText::new(&page.document.scene.name).color(VALUE).strong();
        ui.add(Label::new(name).truncate());
        let root = self.rows.rows().first().map(|row| self.rows.count_of(row.part));
        let count = root.unwrap_or_default();
        let drawn = page.drawn.map_or(String::new(), |drawn| format!(", {drawn} drawn"));
        let text = format!("{} of {} parts shown{drawn}", count.shown, count.all);
        ui.add(Label::new(RichText::new(text).color(NAME).small()).truncate());
    }

    fn tree(&mut self, ui: &mut Ui, page: &PanelPage<'_>, height: f32, answer: &mut PanelAnswer) {
        let mut toggled = None;
        ui.spacing_mut().item_spacing.y = 0.0;
        let mut area = ScrollArea::vertical().id_salt("tree").auto_shrink(false);
        area = area.max_height(height);
        if let Some(row) = self.scroll_to.take() {
            area = area.vertical_scroll_offset((row as f32 * ROW_HEIGHT - height * 0.5).max(0.0));
        }
        area.show_rows(ui, ROW_HEIGHT, self.rows.rows().len(), |ui, range| {
            for row in self.rows.rows().get(range).unwrap_or_default() {
                self.listed.extend(page.document.parts.node(row.part).and_then(|node| node.object));
                let is_toggled = show_row(ui, page, &self.rows, row, answer);
                toggled = toggled.or(is_toggled.then_some(row.part));
            }
        });
        ui.spacing_mut().item_spacing.y = 3.0;
        if let Some(part) = toggled {
            self.rows.toggle(part);
        }
    }
}

/// Shows a row of the tree. Returns true if its group must be opened or closed.
fn show_row(
    ui: &mut Ui,
    page: &PanelPage<'_>,
    rows: &PartRows,
    row: &PartRow,
    answer: &mut PanelAnswer,
) -> bool {
    let Some(node) = page.document.parts.node(row.part) else { return false };
    let objects = || page.document.parts.objects_of(row.part);
    let count = rows.count_of(row.part);
    let mut is_toggled = false;
    ui.horizontal(|ui| {
        ui.set_height(ROW_HEIGHT);
        ui.spacing_mut().item_spacing.x = 3.0;
        ui.add_space(row.depth as f32 * INDENT);
        let (area, response) = ui.allocate_exact_size(vec2(11.0, ROW_HEIGHT), Sense::click());
        if rows.is_group(row.part) {
            let sign = if rows.is_open(row.part) { "\u{23f7}" } else { "\u{23f5}" };
            let align = egui::Align2::CENTER_CENTER;
            let font = egui::FontId::proportional(11.0);
            ui.painter().text(area.center(), align, sign, font, NAME);
            is_toggled = response.clicked();
        } else if let Some(seen) = page.seen.iter().find(|seen| Some(seen.object) == node.object) {
            let colour = if seen.is_visible { GOOD } else { DIM };
            ui.painter().circle_filled(area.center(), 3.0, colour);
            response.on_hover_text(if seen.is_visible { "visible now" } else { "hidden now" });
        }
        let mut is_shown = count.shown > 0;
        let is_partly = is_shown && count.shown < count.all;
        let tick = Checkbox::without_text(&mut is_shown).indeterminate(is_partly);
        if ui.add(tick).clicked() {
            let display = if is_shown { Display::Shown } else { Display::Hidden };
            answer.commands.push(Command::DisplayObjects { objects: objects(), display });
        }
        let is_selected = node.object.is_some_and(|object| page.document.is_selected(object));
        let ghosted = node.object.map(|object| page.document.display(object));
        let colour = match ghosted {
            _ if is_selected => MARK,
            Some(Display::Ghosted) => NAME,
            _ if count.shown == 0 => DIM,
            _ => VALUE,
        };
        let name = match node.object {
            Some(_) => node.name.clone(),
            None => format!("{} ({})", node.name, count.all),
        };
        let label = Label::new(RichText::new(name).color(colour)).truncate().sense(Sense::click());
        if ui.add(label).clicked() {
            answer.commands.push(Command::SelectObjects(objects()));
        }
    });
    is_toggled
}

/// Shows the tools below the tree.
fn tools(
    ui: &mut Ui,
    page: &PanelPage<'_>,
    root: Option<&PartRow>,
    rows: &PartRows,
    answer: &mut PanelAnswer,
) {
    ui.spacing_mut().item_spacing = vec2(4.0, 3.0);
    ui.spacing_mut().slider_width = (ui.available_width() - 118.0).max(40.0);
    ui.horizontal_wrapped(|ui| {
        for (name, command) in [
            ("hide", Command::Hide(None)),
            ("ghost", Command::Ghost(None)),
            ("isolate", Command::Isolate),
            ("show all", Command::Show(None)),
            ("fit", Command::Fit),
        ] {
            if ui.button(name).clicked() {
                answer.commands.push(command);
            }
        }
    });
    let tools = &mut answer.tools;
    section(ui, page, tools);
    let shown = root.map_or(0, |root| rows.count_of(root.part).shown);
    if shown <= MOST_EXPLODED {
        named(ui, "apart", |ui| {
            slider(ui, &mut tools.gap_mm, 0.0..=MOST_GAP_MM, " mm");
        });
    } else {
        ui.label(
            RichText::new(format!("up to {MOST_EXPLODED} parts move apart")).color(NAME).small(),
        );
    }
    if let Some(lid) = page.document.lid {
        let whole_rad = lid.hinge.open_rad - lid.hinge.closed_rad;
        let range = 0.0..=whole_rad.to_degrees();
        named(ui, "lid", |ui| {
            slider(ui, &mut tools.lid_degrees, range, "\u{b0}");
        });
    }
    named(ui, "edges", |ui| {
        let shown = ComboBox::from_id_salt("edges").selected_text(edges_name(tools.edges));
        shown.width(ui.available_width() - 8.0).show_ui(ui, |ui| {
            for mode in EDGE_MODES {
                ui.selectable_value(&mut tools.edges, mode, edges_name(mode));
            }
        });
    });
    named(ui, "measure", |ui| {
        ui.selectable_value(&mut tools.measuring, Measuring::Off, "off");
        ui.selectable_value(&mut tools.measuring, Measuring::Distance, "distance");
        ui.selectable_value(&mut tools.measuring, Measuring::Edge, "edge");
    });
    ui.checkbox(&mut tools.is_orthographic, "orthographic");
    ui.label(RichText::new("F1: all keys").color(NAME).small());
}

/// Shows the section planes.
fn section(ui: &mut Ui, page: &PanelPage<'_>, tools: &mut Tools) {
    let least = page.rest.min * MM;
    let most = page.rest.max * MM;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let plane = &mut tools.planes[axis];
        named(ui, &format!("cut {name}"), |ui| {
            ui.checkbox(&mut plane.is_on, "");
            ui.spacing_mut().slider_width -= 44.0;
            let range = least[axis]..=most[axis].max(least[axis]);
            ui.add_enabled_ui(plane.is_on, |ui| {
                slider(ui, &mut plane.place_mm, range, "");
                ui.toggle_value(&mut plane.is_flipped, "\u{2194}").on_hover_text("the other side");
            });
        });
    }
}

/// Shows a slider. Only the user changes the value: the slider does not round or clamp it.
fn slider(ui: &mut Ui, value: &mut f32, range: RangeInclusive<f32>, suffix: &str) {
    let mut shown = *value;
    let slider = Slider::new(&mut shown, range).clamping(SliderClamping::Edits);
    if ui.add(slider.suffix(suffix).max_decimals(1)).changed() {
        *value = shown;
    }
}

fn named(ui: &mut Ui, name: &str, contents: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        let size = vec2(44.0, ui.spacing().interact_size.y);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(size.x);
            ui.label(RichText::new(name).color(NAME));
        });
        contents(ui);
    });
}

fn edges_name(mode: EdgeMode) -> &'static str {
    match mode {
        EdgeMode::Off => "shaded, no edges",
        EdgeMode::Shaded => "shaded",
        EdgeMode::ShadedWithHiddenDashed => "shaded, hidden dashed",
        EdgeMode::Visible => "visible edges",
        EdgeMode::HiddenDashed => "hidden dashed",
    }
}

/// Shows the page of keys.
fn show_keys(context: &Context) {
    let frame = Frame::new().fill(GROUND).inner_margin(Margin::same(MARGIN as i8));
    let page = egui::Window::new("keys").title_bar(false).resizable(false).frame(frame);
    let height = context.content_rect().height() - 4.0 * MARGIN;
    let page = page.default_height(height).max_height(height);
    page.anchor(egui::Align2::CENTER_CENTER, vec2(0.0, 0.0)).show(context, |ui| {
        ScrollArea::vertical().max_height(height).show(ui, |ui| {
            Grid::new("keys").num_columns(2).spacing(vec2(12.0, 2.0)).show(ui, |ui| {
                for line in KEY_LINES {
                    ui.label(RichText::new(line.key).color(MARK));
                    ui.label(RichText::new(line.what).color(VALUE));
                    ui.end_row();
                }
            });
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_panel_changes_nothing_by_itself() {
        let made = scenes::waffle_maker();
        let mut document = Document::new(made.scene, made.parts, None);
        let rest = document.shown_bounds();
        let mut tools = Tools::at_rest(&rest);
        // A plane outside of the box, and positions that sliders round.
        tools.planes[0].place_mm = rest.max.x * MM + 77.123;
        tools.planes[1].place_mm = rest.min.y * MM + 1.234_5;
        tools.planes[0].is_on = true;
        tools.planes[1].is_on = true;
        tools.gap_mm = 3.217;
        let context = Context::default();
        let mut panel = ToolPanel::new(&document);
        for name in ["body", "lid shell"] {
            let part = document.find(name).unwrap();
            document.select(part);
            document.isolate().unwrap();
            let page = PanelPage { document: &document, rest, tools, seen: &[], drawn: None };
            for _ in 0..3 {
                let mut answer = None;
                let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, vec2(800.0, 900.0));
                let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
                let mut drawn = context.run_ui(input, |ui| answer = Some(panel.show(ui, &page)));
                drawn.textures_delta.clear();
                assert_eq!(answer, Some(PanelAnswer { tools, commands: Vec::new() }));
            }
        }
    }
}
