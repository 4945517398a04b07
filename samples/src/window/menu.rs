//! Lists to choose from and the field for a path, as a state machine with keys as input.

use std::path::PathBuf;

use crate::hud::{ChoiceList, HudAnswer};
use bench::choices;
use bench::strategy::{self, Strategy};

/// The most characters of a path.
const MOST_CHARACTERS: usize = 4096;
/// The number of rows per page of a list.
const PAGE_ROWS: usize = 14;

/// The result of a list or field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// A strategy to draw with.
    Strategy(Strategy),
    /// A generated scene to show.
    Made(choices::GeneratorChoice),
    /// A file to open.
    File(PathBuf),
    /// The path of a file will be typed.
    TypePath,
}

/// A row of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// The name of the row.
    pub label: String,
    /// The description of the row, shown after the names; may be empty.
    pub about: String,
    /// The choice of the row.
    pub choice: Choice,
}

impl Row {
    /// Creates a row without a description.
    fn plain(label: impl Into<String>, choice: Choice) -> Self {
        Self { label: label.into(), about: String::new(), choice }
    }
}

/// The effect of a key in a list or field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MenuKey {
    /// One row up.
    Up,
    /// One row down.
    Down,
    /// A page of rows up.
    PageUp,
    /// A page of rows down.
    PageDown,
    /// The first row.
    First,
    /// The last row.
    Last,
    /// The selected or typed choice is confirmed.
    Enter,
    /// The row with this index is clicked.
    Row(usize),
    /// The last character is removed.
    Backspace,
    /// Typed or pasted characters are appended.
    Text(String),
    /// The text of the clipboard is requested; it arrives as [`MenuKey::Text`].
    Paste,
}

/// An open list or field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Menu {
    /// A list of rows.
    List {
        /// The title above the rows.
        title: &'static str,
        /// The rows, at least one.
        rows: Vec<Row>,
        /// The index of the selected row.
        selected: usize,
    },
    /// A field for the path of a file.
    Path {
        /// The typed text.
        text: String,
    },
}

impl Menu {
    /// Opens a list with the current row selected.
    pub fn list(title: &'static str, rows: Vec<Row>, is_current: impl Fn(&Row) -> bool) -> Self {
        let selected = rows.iter().position(is_current).unwrap_or(0);
        Self::List { title, rows, selected }
    }

    /// Opens an empty field.
    pub fn path() -> Self {
        Self::Path { text: String::new() }
    }

    /// Returns the list or field for the HUD.
    pub fn asked(&self) -> HudAnswer {
        match self {
            Self::List { title, rows, selected } => {
                let keys = match rows.len() {
                    ..=9 => "a click, arrows and Enter, or its number",
                    10..=PAGE_ROWS => "a click, arrows and Enter; the first nine also by number",
                    _ => "a click, arrows, Page Up, Page Down and Enter",
                };
                let row = |row: &Row| (row.label.clone(), row.about.clone());
                HudAnswer::List(ChoiceList {
                    title: format!("{title}: {keys}"),
                    rows: rows.iter().map(row).collect(),
                    selected: *selected,
                })
            }
            Self::Path { text } => HudAnswer::Rows(format!(
                "the path of a file, typed or pasted (Ctrl+V), and Enter\n> {text}_"
            )),
        }
    }

    /// Handles a key; returns the choice that results from it. In a list, a digit chooses the row
    /// with this number.
    pub fn key(&mut self, key: &MenuKey) -> Option<Choice> {
        match self {
            Self::List { rows, selected, .. } => {
                let last = rows.len().saturating_sub(1);
                match key {
                    MenuKey::Up if *selected == 0 => *selected = last,
                    MenuKey::Up => *selected -= 1,
                    MenuKey::Down if *selected >= last => *selected = 0,
                    MenuKey::Down => *selected += 1,
                    MenuKey::PageUp => *selected = selected.saturating_sub(PAGE_ROWS),
                    MenuKey::PageDown => *selected = (*selected + PAGE_ROWS).min(last),
                    MenuKey::First => *selected = 0,
                    MenuKey::Last => *selected = last,
                    MenuKey::Enter => return Some(rows.get(*selected)?.choice.clone()),
                    MenuKey::Row(place) => return Some(rows.get(*place)?.choice.clone()),
                    MenuKey::Text(text) => {
                        let number: usize = text.parse().ok()?;
                        return Some(rows.get(number.checked_sub(1)?)?.choice.clone());
                    }
                    MenuKey::Backspace | MenuKey::Paste => {}
                }
                None
            }
            Self::Path { text } => {
                match key {
                    MenuKey::Text(typed) => append(text, typed),
                    MenuKey::Backspace => _ = text.pop(),
                    MenuKey::Enter => return path_of(text).map(Choice::File),
                    MenuKey::Up
                    | MenuKey::Down
                    | MenuKey::PageUp
                    | MenuKey::PageDown
                    | MenuKey::First
                    | MenuKey::Last
                    | MenuKey::Row(_)
                    | MenuKey::Paste => {}
                }
                None
            }
        }
    }
}

/// Appends typed text without line breaks and other control characters.
fn append(text: &mut String, typed: &str) {
    let room = MOST_CHARACTERS.saturating_sub(text.chars().count());
    text.extend(typed.chars().filter(|character| !character.is_control()).take(room));
}

/// Returns the path in a text, which may be quoted or a `file://` URL as copied by file managers.
fn path_of(text: &str) -> Option<PathBuf> {
    let text = text.trim();
    let quotes = |text: &str, quote: char| {
        text.strip_prefix(quote).and_then(|text| text.strip_suffix(quote)).map(str::to_owned)
    };
    let text = quotes(text, '"').or_else(|| quotes(text, '\'')).unwrap_or_else(|| text.to_owned());
    let text = match text.strip_prefix("file://") {
        Some(address) => {
            percent_encoding::percent_decode_str(address).decode_utf8_lossy().into_owned()
        }
        None => text,
    };
    let home = text.strip_prefix("~/").and_then(|rest| Some(std::env::home_dir()?.join(rest)));
    (!text.is_empty()).then(|| home.unwrap_or_else(|| PathBuf::from(text)))
}

/// Returns the list of strategies that the device supports, each with its number, its exactness,
/// and its summary.
pub fn strategies(can: impl Fn(Strategy) -> bool, current: Strategy) -> Menu {
    let row = |strategy: Strategy| Row {
        label: strategy.name().into(),
        about: if strategy.is_exact() {
            strategy.summary().to_owned()
        } else {
            format!("not exact: {}", strategy.summary())
        },
        choice: Choice::Strategy(strategy),
    };
    let all = strategy::strategies().into_iter().filter(|strategy| !strategy.needs_still_scene());
    let rows = all.filter(|strategy| can(*strategy)).map(row).collect();
    Menu::list("strategy", rows, |row| row.choice == Choice::Strategy(current))
}

/// Returns the list of scenes: the generated scenes, then files, without repetitions. The row with
/// the name `shown` is selected.
pub fn scenes(files: impl IntoIterator<Item = PathBuf>, shown: &str) -> Menu {
    let made = choices::GeneratorChoice::ALL
        .map(|scene| Row::plain(scene.to_string(), Choice::Made(scene)));
    let mut rows: Vec<Row> = made.into();
    for file in files {
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
        let row = Row::plain(name.into_owned(), Choice::File(file));
        if !rows.contains(&row) {
            rows.push(row);
        }
    }
    rows.push(Row::plain("another file ...", Choice::TypePath));
    Menu::list("scene", rows, |row| match &row.choice {
        Choice::File(file) => file.file_stem().is_some_and(|stem| stem == shown),
        _ => row.label == shown,
    })
}

#[cfg(test)]
mod tests {
    use antumbra::methods;

    use super::*;

    fn text(text: &str) -> MenuKey {
        MenuKey::Text(text.to_owned())
    }

    #[test]
    fn what_is_selected_is_marked() {
        let asked = strategies(|_| true, methods::NAIVE).asked();
        let HudAnswer::List(list) = asked else { panic!("a list") };
        assert_eq!((list.selected, list.rows[1].0.as_str()), (1, "naive"));
        for strategy in
            strategy::strategies().into_iter().filter(|strategy| !strategy.needs_still_scene())
        {
            let row = list.rows.iter().find(|(_, about)| about.contains(strategy.summary()));
            let (_, about) = row.unwrap_or_else(|| panic!("{strategy} is not explained"));
            assert_eq!(about.contains("not exact: "), !strategy.is_exact(), "{about}");
        }
        let mut menu = Menu::path();
        menu.key(&self::text("/a"));
        let HudAnswer::Rows(text) = menu.asked() else { panic!("a field") };
        assert!(text.ends_with("\n> /a_"), "{text}");
    }

    fn selected(menu: &Menu) -> &str {
        match menu {
            Menu::List { rows, selected, .. } => &rows[*selected].label,
            Menu::Path { text } => text,
        }
    }

    #[test]
    fn arrows_go_around_and_enter_takes_what_is_selected() {
        let can = |strategy| strategy != methods::HZB;
        let mut menu = strategies(can, Strategy::ANTUMBRA);
        assert_eq!(selected(&menu), "antumbra");
        for (key, expected) in [
            (MenuKey::Up, "chc"),
            (MenuKey::First, "frustum"),
            (MenuKey::Up, "antumbra_compute"),
            (MenuKey::Down, "frustum"),
            (MenuKey::Last, "antumbra_compute"),
            (MenuKey::Backspace, "antumbra_compute"),
        ] {
            assert_eq!(menu.key(&key), None);
            assert_eq!(selected(&menu), expected, "{key:?}");
        }
        let chosen = Some(Choice::Strategy(Strategy::ANTUMBRA_COMPUTE));
        assert_eq!(menu.key(&MenuKey::Enter), chosen);
    }

    #[test]
    fn digits_choose_at_once() {
        let mut menu = strategies(|_| true, Strategy::ANTUMBRA);
        assert_eq!(menu.key(&text("2")), Some(Choice::Strategy(methods::NAIVE)));
        for none in ["0", "x", "99", ""] {
            assert_eq!(menu.key(&text(none)), None, "{none}");
        }
    }

    #[test]
    fn scenes_are_listed_once() {
        let files = ["/a/one.glb", "/b/one.glb", "/a/one.glb"].map(PathBuf::from);
        let mut menu = scenes(files, "one");
        let Menu::List { rows, .. } = &menu else { panic!("a list") };
        let labels: Vec<&str> = rows.iter().map(|row| row.label.as_str()).collect();
        assert_eq!(
            labels,
            ["city", "field", "assembly", "waffle", "one.glb", "one.glb", "another file ..."]
        );
        assert_eq!(menu.key(&text("6")), Some(Choice::File("/b/one.glb".into())));
        let first = Some(Choice::File("/a/one.glb".into()));
        assert_eq!(menu.key(&MenuKey::Enter), first, "what is shown is selected");
        menu.key(&MenuKey::Last);
        assert_eq!(menu.key(&MenuKey::Enter), Some(Choice::TypePath));
    }

    #[test]
    fn pages_of_long_lists_are_turned_and_rows_are_clicked() {
        let files = (0..40).map(|number| PathBuf::from(format!("{number:02}.glb")));
        let mut menu = scenes(files, "city");
        menu.key(&MenuKey::PageDown);
        assert_eq!(selected(&menu), "10.glb");
        menu.key(&MenuKey::Up);
        assert_eq!(menu.key(&MenuKey::Enter), Some(Choice::File("09.glb".into())));
        assert_eq!(menu.key(&MenuKey::Row(12)), Some(Choice::File("08.glb".into())));
        assert_eq!(menu.key(&MenuKey::Row(99)), None);
        (0..9).for_each(|_| _ = menu.key(&MenuKey::PageDown));
        assert_eq!(selected(&menu), "another file ...");
        (0..9).for_each(|_| _ = menu.key(&MenuKey::PageUp));
        assert_eq!(selected(&menu), "city");
    }

    #[test]
    fn a_path_is_typed_or_pasted() {
        for (typed, path) in [
            (&["/a/b", ".glb"][..], "/a/b.glb"),
            (&["'/a b/c.glb'\n"], "/a b/c.glb"),
            (&["file:///a%20b/c.glb"], "/a b/c.glb"),
            (&["  scene.gltf "], "scene.gltf"),
            (&["\u{437}\u{430}.glb"], "\u{437}\u{430}.glb"),
        ] {
            let mut menu = Menu::path();
            typed.iter().for_each(|typed| assert_eq!(menu.key(&text(typed)), None));
            assert_eq!(menu.key(&MenuKey::Enter), Some(Choice::File(path.into())), "{typed:?}");
        }
        let mut menu = Menu::path();
        assert_eq!(menu.key(&MenuKey::Enter), None, "nothing is no path");
        menu.key(&text("ab\u{7}c"));
        menu.key(&MenuKey::Backspace);
        assert_eq!(selected(&menu), "ab");
        menu.key(&text(&"x".repeat(2 * MOST_CHARACTERS)));
        assert_eq!(selected(&menu).len(), MOST_CHARACTERS);
    }
}
