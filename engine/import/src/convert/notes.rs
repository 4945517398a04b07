//! Notes: what of a file is shown otherwise than it says, for people. What happens a thousand times is
//! told once, with its number.

use std::collections::BTreeMap;

/// Collects notes.
#[derive(Debug, Default)]
pub(super) struct Notes {
    said: Vec<String>,
    counted: BTreeMap<&'static str, (u64, String)>,
}

impl Notes {
    /// Goes on after what reading the file has noted.
    pub(super) fn after(said: Vec<String>) -> Self {
        Self { said, counted: BTreeMap::new() }
    }

    /// Says something about the whole file.
    pub(super) fn say(&mut self, what: impl Into<String>) {
        self.said.push(what.into());
    }

    /// Counts something that happened to `count` things; where it happened first is told too.
    pub(super) fn count(
        &mut self,
        what: &'static str,
        count: usize,
        where_first: impl FnOnce() -> String,
    ) {
        if count > 0 {
            let entry = self.counted.entry(what).or_insert_with(|| (0, where_first()));
            entry.0 += count as u64;
        }
    }

    /// All of them, each a sentence.
    pub(super) fn finish(mut self) -> Vec<String> {
        for (what, (count, first)) in self.counted {
            self.said.push(format!("{what}: {count}, first in {first}"));
        }
        self.said
    }
}
