//! The head-up display: the engine's state as numbers, a graph and signs over the image, with egui.
//!
//! A [`HudPage`] has plain values. [`Measures`] determines the size of points and the parts that
//! fit. Each part has a module that shows it: the [overview](self), the lower edge, legends, signs,
//! and the page of keys. [`HudOverlay`] draws the triangles of egui over the frames of a renderer.

mod choices;
mod graph;
mod help;
mod layout;
mod legend;
mod level;
mod notices;
mod overlay;
mod overview;
mod page;
mod panel;
mod scale;
mod signs;
pub mod style;
#[cfg(test)]
mod tests;

use egui::{ClippedPrimitive, Context, Event, FullOutput, RawInput, Rect, TexturesDelta, Ui, vec2};
use notices::Notices;

pub use layout::{Measures, PANEL_SHARE, Room};
pub use level::HudLevel;
pub use overlay::HudOverlay;
pub use page::{
    ChoiceList, ExactnessVerdict, Help, HudAnswer, HudFigure, HudPage, Legend, Overview, Sign,
    Split,
};

/// The layout of pages, with its own fonts.
pub struct Hud {
    context: Context,
    /// The last laid-out page, its image size in pixels, and the pixels per point of the window.
    page: HudPage,
    size: [u32; 2],
    window_scale: f32,
    /// The pointer's events since the last layout, in points.
    events: Vec<Event>,
    /// The area of a list, in pixels.
    list: Option<Rect>,
}

/// A page as triangles, and the letters that are new in it.
#[derive(Default)]
pub struct HudFrame {
    primitives: Vec<ClippedPrimitive>,
    textures: TexturesDelta,
    /// The pixels per point.
    scale: f32,
    /// The index of the clicked row of a list.
    clicked: Option<usize>,
}

impl Default for Hud {
    fn default() -> Self {
        let context = Context::default();
        context.options_mut(|options| options.zoom_with_keyboard = false);
        context.all_styles_mut(|style| {
            style.spacing.item_spacing = vec2(5.0, 0.0);
            // Rows are as high as their letters.
            style.spacing.interact_size.y = 0.0;
            style.interaction.selectable_labels = false;
        });
        Self {
            context,
            page: HudPage::default(),
            size: [0; 2],
            window_scale: 0.0,
            events: Vec::new(),
            list: None,
        }
    }
}

impl Hud {
    /// Lays out `page` for an image of `size` pixels, with `scale` pixels per point of the window.
    /// Parts that do not fit are left out. Returns `None` if nothing has changed since the last
    /// call.
    pub fn lay_out(&mut self, page: &HudPage, size: [u32; 2], scale: f32) -> Option<HudFrame> {
        let is_empty = *page == HudPage::default();
        let is_same = self.page == *page && self.events.is_empty();
        if is_same && (is_empty || (self.size == size && self.window_scale == scale)) {
            return None;
        }
        (self.size, self.window_scale) = (size, scale);
        self.page.clone_from(page);
        if is_empty {
            self.events.clear();
            self.list = None;
            return Some(HudFrame::default());
        }
        let (output, notices) = self.run(page, size, scale);
        self.list = notices.list.map(|area| area * output.pixels_per_point);
        Some(HudFrame { clicked: notices.clicked, ..HudFrame::of(&self.context, output) })
    }

    /// Returns egui's context, for the events of a window.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// Adds events of a window, in points of the window, for the next layout.
    pub fn take(&mut self, events: impl IntoIterator<Item = Event>) {
        let to_ours = self.window_scale / Measures::of(self.size, self.window_scale).scale;
        for mut event in events {
            match &mut event {
                Event::PointerMoved(at) | Event::PointerButton { pos: at, .. } => {
                    *at = (at.to_vec2() * to_ours).to_pos2();
                }
                Event::PointerGone => {}
                // Keys have other effects, and nothing scrolls.
                _ => continue,
            }
            self.events.push(event);
        }
    }

    /// Returns true if a place, in pixels from the upper left, is on a visible list.
    pub fn is_on_list(&self, place: [f64; 2]) -> bool {
        let [x, y] = place;
        self.list.is_some_and(|area| area.contains(egui::pos2(x as f32, y as f32)))
    }

    /// Runs egui over a page.
    fn run(&mut self, page: &HudPage, size: [u32; 2], scale: f32) -> (FullOutput, Notices) {
        let measures = Measures::of(size, scale);
        let [width, height] = size.map(|side| side as f32 / measures.scale);
        let screen = Rect::from_min_size(egui::Pos2::ZERO, vec2(width, height));
        let mut input = RawInput { screen_rect: Some(screen), ..RawInput::default() };
        let viewport = input.viewports.entry(input.viewport_id).or_default();
        viewport.native_pixels_per_point = Some(measures.scale);
        input.events = std::mem::take(&mut self.events);
        let mut notices = Notices::default();
        let output = self.context.run_ui(input, |ui| notices = show(ui, page, &measures));
        (output, notices)
    }
}

impl HudFrame {
    /// Returns the frame of a layout that a host ran in its own egui context.
    pub fn of(context: &Context, output: FullOutput) -> Self {
        let FullOutput { shapes, textures_delta, pixels_per_point: scale, .. } = output;
        let primitives = context.tessellate(shapes, scale);
        Self { primitives, textures: textures_delta, scale, clicked: None }
    }

    /// Returns the index of the clicked row of a list.
    pub fn clicked(&self) -> Option<usize> {
        self.clicked
    }
}

/// Shows a page; later parts cover earlier ones.
fn show(ui: &mut Ui, page: &HudPage, measures: &Measures) -> Notices {
    let screen = ui.max_rect();
    signs::draw(ui.painter(), &page.signs);
    signs::outline(ui.painter(), &page.marks, measures.scale);
    // The panel extends to the lower edge. Messages are beside it and hide no part of it.
    let has_panel = page.overview.is_some() && page.help.is_none();
    let mut beside = screen;
    beside.min.x += if has_panel { measures.panel_width } else { 0.0 };
    let notices = notices::show(ui, page, beside);
    let help = page.help.as_ref();
    let is_helped = help.and_then(|help| help::show(ui, help, notices.above)).is_some();
    // The page of keys is shown alone.
    if !is_helped {
        let panel = overview::show(ui, page, measures);
        let mut room = screen;
        room.min.x = panel.map_or(screen.min.x, |panel| panel.max.x);
        for legend in &page.legends {
            let area = legend::show(ui, legend, room, notices.taken, measures.scale);
            let area = area.filter(|_| legend.area.is_none());
            room.min.y = area.map_or(room.min.y, |area| area.max.y);
        }
    }
    notices
}

/// Returns a number with its thousands separated.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
