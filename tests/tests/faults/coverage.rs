//! The listing of what can fail in the engine, and what did.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use tests::every_call::{NAMES, number_of};

use crate::table::Row;

/// The codes that calls of the programs may return, and those that they were made to return.
pub struct Coverage<'a> {
    met: BTreeSet<&'a (&'static str, String)>,
    injected: BTreeSet<&'a (&'static str, String)>,
}

impl<'a> Coverage<'a> {
    /// Collects what the programs met.
    pub fn of(rows: &'a [Row]) -> Self {
        let met = rows.iter().flat_map(|row| &row.met).collect();
        Self { met, injected: rows.iter().flat_map(|row| &row.injected).collect() }
    }

    /// Writes a table of Markdown. Returns false if a code was never injected.
    pub fn print(&self) -> bool {
        let mut functions = BTreeMap::<&str, Vec<&str>>::new();
        for (name, code) in &self.met {
            functions.entry(name).or_default().push(code);
        }
        println!("\n| function | codes | injected | not injected |");
        println!("|---|---|---|---|");
        let mut missing = 0;
        for (name, codes) in &functions {
            let is_left = |code: &&&str| !self.injected.contains(&(*name, (**code).to_owned()));
            let left: Vec<&str> = codes.iter().filter(is_left).copied().collect();
            missing += left.len();
            let done = codes.len() - left.len();
            println!("| `{name}` | {} | {done} | {} |", codes.len(), left.join(", "));
        }
        let pairs = self.met.len();
        println!("{} functions, {pairs} codes of them, {missing} never injected", functions.len());
        let engine = named_by_the_engine();
        let unmet: Vec<&str> =
            engine.iter().copied().filter(|name| !functions.contains_key(name)).collect();
        println!("named by the engine, and called by no program: {}", unmet.join(", "));
        missing == 0
    }
}

/// Returns the functions with a code whose names are in the engine's errors.
fn named_by_the_engine() -> BTreeSet<&'static str> {
    let engine = Path::new(env!("CARGO_MANIFEST_DIR")).join("../engine");
    let mut names = BTreeSet::new();
    let mut folders = vec![engine];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("the engine").map_while(Result::ok) {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(path).expect("a source");
                let words = text.split('"').filter_map(number_of);
                names.extend(words.map(|number| NAMES[number]));
            }
        }
    }
    names
}
