//! Tests of the layout of whole pages without a device: parts do not overlap, and do not leave
//! their panel or the image.

use antumbra::render;
use bench::legend::LegendEntry;
use egui::epaint::ClippedShape;
use egui::{Rect, Shape};

use super::style::PANEL;
use super::*;
use crate::window::actions::{CAMERA_KEYS, FILE_KEYS, GROUPS, KEYS, STEERING};

const SIZES: [[u32; 2]; 12] = [
    [960, 540],
    [1280, 720],
    [1920, 1080],
    [3840, 2160],
    [1080, 1920],
    [640, 360],
    [800, 600],
    [320, 180],
    [300, 200],
    [240, 700],
    [100, 80],
    [1, 1],
];

fn texts(count: usize, name: &str, value: &str) -> Vec<(String, String)> {
    (0..count).map(|_| (name.to_owned(), value.to_owned())).collect()
}

fn figure(value: &str, name: &'static str) -> HudFigure {
    HudFigure { value: value.to_owned(), name }
}

fn overview() -> Overview {
    let mut frames_ms = vec![16.6; 130];
    frames_ms[70] = 300.0;
    Overview {
        scene: "a scene whose name is longer than the panel is wide".to_owned(),
        strategy: "antumbra_queries, frozen".to_owned(),
        rate: figure("1234", "frames/s"),
        frame_time: figure("16.6", "ms/frame"),
        frames_ms,
        caption: "frame time, ms",
        budget_ms: Some(16.7),
        objects: [
            figure("999,999", "objects"),
            figure("2.00 M", "in frustum"),
            figure("12,345", "drawn"),
        ],
        split: Some(Split { drawn: 123_456, culled: 876_543 }),
        times: [figure("26.2 ms", "GPU"), figure("0.54 ms", "CPU")],
        verdict: ExactnessVerdict::Exact("exact: only hidden objects left out".to_owned()),
        hint: "F1 help, H details".to_owned(),
    }
}

fn legend(area: Option<render::Rect>) -> Legend {
    let entry = |count: u8| LegendEntry {
        colours: (0..count).map(|part| [part; 3]).collect(),
        meaning: "behind another tested box".to_owned(),
    };
    Legend { title: "Boxes that are tested", entries: (1..5).map(entry).collect(), area }
}

/// Returns a page with all parts, and a view from above in the lower right.
fn page(image_size: [u32; 2]) -> HudPage {
    let [width, height] = image_size;
    let part = [width * 2 / 5, height * 2 / 5];
    let area = render::Rect { origin: [width - part[0], height - part[1]], size: part };
    HudPage {
        overview: Some(overview()),
        details: vec![
            texts(7, "revealed in this frame", "81,366"),
            texts(9, "draw and query", "10.25 ms"),
            texts(5, "device", "a graphics card with a name that is much too long"),
            texts(11, "latency to the screen", "16.67 ms"),
        ],
        legends: vec![legend(None), legend(Some(area))],
        toast: Some("a toast".to_owned()),
        ..HudPage::default()
    }
}

/// Returns the shapes that egui draws for a page.
fn shapes(page: &HudPage, size: [u32; 2]) -> Vec<ClippedShape> {
    let (mut output, _) = Hud::default().run(page, size, 1.0);
    output.textures_delta.clear();
    std::mem::take(&mut output.shapes)
}

/// Returns the panels and the texts of a page, and the area of the image.
fn laid_out(page: &HudPage, size: [u32; 2]) -> (Vec<Rect>, Vec<(Rect, String)>, Rect) {
    let measures = Measures::of(size, 1.0);
    let mut panels = Vec::new();
    let mut texts = Vec::new();
    for ClippedShape { shape, clip_rect } in &shapes(page, size) {
        match shape {
            Shape::Rect(rect) if rect.fill == PANEL => panels.push(rect.rect),
            Shape::Text(text) => {
                let area = text.galley.rect.translate(text.pos.to_vec2());
                let is_whole = clip_rect.expand(0.6).contains_rect(area);
                assert!(is_whole, "{size:?}: '{}' is cut", text.galley.text());
                texts.push((area, text.galley.text().to_owned()));
            }
            _ => {}
        }
    }
    let size = size.map(|side| side as f32 / measures.scale);
    (panels, texts, Rect::from_min_size(egui::Pos2::ZERO, size.into()))
}

/// Returns true if areas share more than an edge and the blank rim of letters.
fn overlap(one: Rect, other: Rect) -> bool {
    one.shrink(1.5).intersects(other.shrink(1.5))
}

fn check(page: &HudPage, size: [u32; 2]) {
    let (panels, texts, screen) = laid_out(page, size);
    let said = usize::from(page.toast.is_some()) + usize::from(page.asked.is_some());
    for (place, panel) in panels.iter().enumerate() {
        // A message alone is shown in images of any size.
        let is_notice = place < said;
        assert!(is_notice || screen.expand(0.1).contains_rect(*panel), "{size:?}: {panel:?}");
        for other in &panels[..place] {
            assert!(is_notice || !overlap(*panel, *other), "{size:?}: {panel:?} {other:?}");
        }
    }
    for (place, (area, text)) in texts.iter().enumerate() {
        let is_within = panels.iter().any(|panel| panel.expand(0.6).contains_rect(*area));
        assert!(is_within, "{size:?}: '{text}' at {area:?} leaves its panel");
        for (other, other_text) in &texts[..place] {
            assert!(
                !overlap(*area, *other),
                "{size:?}: '{text}' {area:?}, '{other_text}' {other:?}"
            );
        }
    }
}

#[test]
fn nothing_overlaps_and_nothing_is_cut_off() {
    for size in SIZES {
        check(&page(size), size);
        check(&HudPage { details: Vec::new(), ..page(size) }, size);
    }
}

#[test]
fn the_overview_takes_a_quarter_of_the_width_at_most() {
    for size in SIZES {
        let with_all = page(size);
        let alone = HudPage { legends: Vec::new(), toast: None, ..with_all };
        let (panels, _, screen) = laid_out(&alone, size);
        for panel in panels {
            assert!(panel.max.x <= screen.width() * PANEL_SHARE + 0.1, "{size:?}: {panel:?}");
        }
    }
}

#[test]
fn the_most_important_numbers_are_there_at_usual_sizes() {
    for size in [[960, 540], [1280, 720], [1920, 1080], [640, 360]] {
        let (_, texts, _) = laid_out(&page(size), size);
        for wanted in ["1234", "999,999", "2.00 M", "12,345", "26.2 ms", "0.54 ms"] {
            assert!(texts.iter().any(|(_, text)| text == wanted), "{size:?}: {wanted}");
        }
    }
    let (_, texts, _) = laid_out(&page([320, 180]), [320, 180]);
    for wanted in ["1234", "12,345"] {
        assert!(texts.iter().any(|(_, text)| text == wanted), "{wanted}: {texts:?}");
    }
}

#[test]
fn details_that_have_no_room_are_named() {
    let all_shown = |size: [u32; 2]| {
        let (_, texts, _) = laid_out(&page(size), size);
        let is_said = texts.iter().any(|(_, text)| text.contains("larger window"));
        (texts.iter().any(|(_, text)| text == "latency to the screen"), is_said)
    };
    assert_eq!(all_shown([1920, 1080]), (true, false));
    assert_eq!(all_shown([960, 540]), (false, true));
}

/// Checks that messages are beside the panel, so that messages of any length leave the details
/// intact.
#[test]
fn what_is_said_takes_nothing_from_the_details() {
    let rows = |page: &HudPage, size| {
        let (_, texts, _) = laid_out(page, size);
        texts.into_iter().filter(|(area, _)| area.max.x < 0.25 * 1920.0).count()
    };
    for size in [[960, 540], [1920, 1080]] {
        let quiet = HudPage { toast: None, ..page(size) };
        let said = HudPage {
            asked: Some(HudAnswer::Rows(vec!["a row about something"; 14].join("\n"))),
            toast: Some("one line\nand another".to_owned()),
            ..page(size)
        };
        check(&said, size);
        assert_eq!(rows(&said, size), rows(&quiet, size) + 2, "{size:?}");
    }
}

#[test]
fn the_page_of_keys_fits_at_960x540() {
    let own = |(key, action): (&str, &str)| (key.to_owned(), action.to_owned());
    let mut keys = KEYS.iter().map(|(key, action, _)| own((key, action)));
    let of_file = FILE_KEYS.iter().map(|(key, action, _)| (*key, *action)).chain([CAMERA_KEYS]);
    let mut groups = vec![("Camera", STEERING.map(own).to_vec())];
    groups.extend(GROUPS.map(|(title, count)| (title, keys.by_ref().take(count).collect())));
    groups.push(("Scene out of a file", of_file.map(own).collect()));
    let count: usize = groups.iter().map(|(_, keys)| keys.len()).sum();
    for size in [[960, 540], [1280, 720], [1920, 1080]] {
        let page = HudPage { help: Some(Help { groups: groups.clone() }), ..page(size) };
        check(&page, size);
        let (panels, texts, screen) = laid_out(&page, size);
        // The titles, and the toast.
        assert_eq!(texts.len(), 2 * count + groups.len() + 1, "{size:?}");
        let keys = panels.last().unwrap();
        assert!(keys.height() < 0.6 * screen.height(), "{size:?}: {keys:?}");
    }
}

#[test]
fn signs_are_seen_without_text() {
    for sign in [Sign::Frozen, Sign::Recording, Sign::Screenshot] {
        for size in [[320, 180], [1920, 1080]] {
            let page = HudPage { signs: vec![sign], ..HudPage::default() };
            let measures = Measures::of(size, 1.0);
            let shapes = shapes(&page, size);
            assert!(shapes.iter().all(|shape| !matches!(shape.shape, Shape::Text(_))), "{sign:?}");
            let edges = shapes.iter().map(|shape| shape.shape.visual_bounding_rect());
            let around = edges.reduce(Rect::union).unwrap();
            let screen = size.map(|side| side as f32 / measures.scale);
            assert!(
                (around.max.x - screen[0]).abs() < 0.1 && (around.max.y - screen[1]).abs() < 0.1
            );
        }
    }
}

#[test]
fn numbers_are_readable() {
    let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")];
    for (number, text) in cases {
        assert_eq!(grouped(number), text);
    }
}

fn list(selected: usize) -> ChoiceList {
    let row = |place: usize| {
        (format!("strategy_{place}"), "what it does, in a phrase that is not short".repeat(2))
    };
    ChoiceList { title: "a list: keys".to_owned(), rows: (0..13).map(row).collect(), selected }
}

#[test]
fn the_selected_row_of_a_list_is_shown_whole_at_every_size() {
    for size in SIZES.into_iter().filter(|size| size[0] >= 240 && size[1] >= 180) {
        for selected in [0, 6, 12] {
            let page = HudPage { asked: Some(HudAnswer::List(list(selected))), ..page(size) };
            check(&page, size);
            let (_, texts, screen) = laid_out(&page, size);
            let label = format!("strategy_{selected}");
            let row = texts.iter().find(|(_, text)| *text == label);
            let (area, _) = row.unwrap_or_else(|| panic!("{size:?}: {label} in {texts:?}"));
            assert!(screen.contains_rect(*area), "{size:?}: {area:?}");
            let shown = texts.iter().filter(|(_, text)| text.starts_with("strategy_")).count();
            let is_said = texts.iter().any(|(_, text)| text.starts_with("... "));
            assert_eq!(is_said, shown < 13, "{size:?}: {shown} rows");
        }
    }
}

#[test]
fn a_row_is_chosen_by_a_click() {
    let size = [1280, 720];
    let page = HudPage { asked: Some(HudAnswer::List(list(0))), ..page(size) };
    for window_scale in [1.0, 2.0] {
        let measures = Measures::of(size, window_scale);
        let mut hud = Hud::default();
        let drop = |frame: Option<HudFrame>| {
            let mut frame = frame.unwrap();
            frame.textures.clear();
            frame.clicked()
        };
        assert_eq!(drop(hud.lay_out(&page, size, window_scale)), None);
        assert!(hud.lay_out(&page, size, window_scale).is_none(), "nothing changed");
        let list = hud.list.unwrap();
        assert!(!hud.is_on_list([1270.0, 10.0]));
        // Clicks from the upper edge down hit each row once, in points of the window.
        let mut clicked = Vec::new();
        for step in 0..list.height() as u32 {
            let at = list.min + egui::vec2(30.0, step as f32);
            assert!(hud.is_on_list([at.x.into(), at.y.into()]));
            let pos = (at.to_vec2() / window_scale).to_pos2();
            let button = |pressed| Event::PointerButton {
                pos,
                button: egui::PointerButton::Primary,
                pressed,
                modifiers: egui::Modifiers::NONE,
            };
            hud.take([Event::PointerMoved(pos), button(true)]);
            drop(hud.lay_out(&page, size, window_scale));
            hud.take([button(false)]);
            clicked.extend(drop(hud.lay_out(&page, size, window_scale)));
        }
        clicked.dedup();
        assert!(clicked.iter().copied().eq(0..13), "{clicked:?} at {}", measures.scale);
    }
}
