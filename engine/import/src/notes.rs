//! Notes: the deviations of a shown scene from its file. A deviation that occurs a thousand times
//! is noted once, with its count.

use std::collections::BTreeMap;
use std::fmt;

/// A tolerated deviation of a file: the object in the file, and the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The object, such as "mesh 3, primitive 0"; the first object if there are several.
    pub object: String,
    /// The deviation, and the scene's replacement for it.
    pub reason: String,
    /// The number of occurrences in the file, at least 1.
    pub count: u64,
}

impl Note {
    pub(crate) fn new(object: impl Into<String>, reason: impl Into<String>) -> Self {
        Self { object: object.into(), reason: reason.into(), count: 1 }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.object, self.reason)?;
        if self.count > 1 { write!(f, " ({} times, first here)", self.count) } else { Ok(()) }
    }
}

/// A bounded collection of notes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Notes {
    listed: Vec<Note>,
    counted: BTreeMap<&'static str, Note>,
    left_out: u64,
}

impl Notes {
    /// The most notes that are listed individually.
    const MOST: usize = 64;

    /// Continues with the notes of an earlier stage.
    pub(crate) fn after(listed: Vec<Note>) -> Self {
        Self { listed, ..Self::default() }
    }

    /// Adds a note, which is created only if there is room for it.
    pub(crate) fn add(&mut self, note: impl FnOnce() -> Note) {
        if self.listed.len() < Self::MOST {
            self.listed.push(note());
        } else {
            self.left_out += 1;
        }
    }

    /// Adds a note, or increases the count of a note with the same reason, which names the first
    /// object.
    pub(crate) fn add_alike(&mut self, note: Note) {
        match self.listed.iter_mut().find(|listed| listed.reason == note.reason) {
            Some(listed) => listed.count += note.count,
            None => self.add(|| note),
        }
    }

    /// Adds a note about the scene as a whole.
    pub(crate) fn say(&mut self, reason: impl Into<String>) {
        self.add(|| Note::new("scene", reason));
    }

    /// Notes `count` occurrences of a deviation; the note names the first object.
    pub(crate) fn count(
        &mut self,
        reason: &'static str,
        count: usize,
        object: impl FnOnce() -> String,
    ) {
        if count > 0 {
            self.count_as(reason, count, || Note::new(object(), reason));
        }
    }

    /// Notes occurrences of a kind of deviation; only the first one creates a note.
    pub(crate) fn count_as(
        &mut self,
        sort: &'static str,
        count: usize,
        note: impl FnOnce() -> Note,
    ) {
        let entry = self.counted.entry(sort).or_insert_with(|| Note { count: 0, ..note() });
        entry.count += count as u64;
    }

    /// Returns all notes. The last note counts those for which there was no room.
    pub(crate) fn finish(self) -> Vec<Note> {
        let Self { mut listed, counted, left_out } = self;
        listed.extend(counted.into_values());
        if left_out > 0 {
            listed.push(Note::new("notes", format!("{left_out} more are left out")));
        }
        listed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_bounded_and_those_left_out_are_counted() {
        let mut notes = Notes::default();
        for index in 0..100 {
            notes.add(|| Note::new(format!("node {index}"), "is odd"));
        }
        notes.add_alike(Note::new("node 200", "is odd"));
        notes.count("is bent", 2, || "mesh 3".to_owned());
        notes.count("is bent", 5, || "mesh 4".to_owned());
        notes.count("is whole", 0, || "mesh 5".to_owned());
        let texts: Vec<String> = notes.finish().iter().map(Note::to_string).collect();
        assert_eq!(texts.len(), 66);
        assert_eq!(texts[0], "node 0: is odd (2 times, first here)");
        assert_eq!(texts[64], "mesh 3: is bent (7 times, first here)");
        assert_eq!(texts[65], "notes: 36 more are left out");
    }
}
