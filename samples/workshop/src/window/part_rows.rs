//! The rows of the tree of parts: the rows of open groups, with the number of shown parts.

use antumbra::ObjectId;
use scenes::{PartId, PartTree};

use crate::document::{Display, Document};

/// A row of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartRow {
    /// The part or group.
    pub part: PartId,
    /// The number of enclosing groups.
    pub depth: u32,
}

/// The numbers of parts in a part or group; a part contains itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartCount {
    /// The number of all parts.
    pub all: u32,
    /// The number of parts that are not hidden.
    pub shown: u32,
}

/// The rows of a tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartRows {
    /// The first child of each node.
    first_child: Vec<Option<PartId>>,
    next: Vec<Option<PartId>>,
    is_open: Vec<bool>,
    counts: Vec<PartCount>,
    rows: Vec<PartRow>,
}

impl PartRows {
    /// Creates the rows of a document, with the root open.
    pub fn new(document: &Document) -> Self {
        let nodes = &document.parts.nodes;
        let mut first_child = vec![None; nodes.len()];
        let mut next = vec![None; nodes.len()];
        // From the last node on, so that each child is inserted before its siblings.
        for (place, node) in nodes.iter().enumerate().rev() {
            let parent = node.parent.and_then(|parent| first_child.get_mut(parent.0 as usize));
            if let Some(first) = parent {
                next[place] = first.replace(PartId(place as u32));
            }
        }
        let mut is_open = vec![false; nodes.len()];
        if let Some(root) = is_open.first_mut() {
            *root = true;
        }
        let mut rows = Self { first_child, next, is_open, counts: Vec::new(), rows: Vec::new() };
        rows.count(document);
        rows.lay_out();
        rows
    }

    /// Returns the rows, from the top.
    pub fn rows(&self) -> &[PartRow] {
        &self.rows
    }

    /// Returns true for a group.
    pub fn is_group(&self, part: PartId) -> bool {
        self.first_child.get(part.0 as usize).is_some_and(Option::is_some)
    }

    /// Returns true if a group is open.
    pub fn is_open(&self, part: PartId) -> bool {
        self.is_open.get(part.0 as usize) == Some(&true)
    }

    /// Returns the number of parts in a part or group.
    pub fn count_of(&self, part: PartId) -> PartCount {
        self.counts.get(part.0 as usize).copied().unwrap_or_default()
    }

    /// Opens a group, or closes it.
    pub fn toggle(&mut self, part: PartId) {
        if let Some(is_open) = self.is_open.get_mut(part.0 as usize) {
            *is_open = !*is_open;
            self.lay_out();
        }
    }

    /// Opens all groups around an object's part. Returns the index of its row.
    pub fn reveal(&mut self, tree: &PartTree, object: ObjectId) -> Option<usize> {
        let place = tree.nodes.iter().position(|node| node.object == Some(object))?;
        let mut around = tree.nodes[place].parent;
        while let Some(group) = around {
            *self.is_open.get_mut(group.0 as usize)? = true;
            around = tree.node(group).and_then(|node| node.parent);
        }
        self.lay_out();
        self.rows.iter().position(|row| row.part.0 as usize == place)
    }

    /// Counts the shown parts again, after a change of the document.
    pub fn count(&mut self, document: &Document) {
        let nodes = &document.parts.nodes;
        self.counts = vec![PartCount::default(); nodes.len()];
        // Parents precede their children.
        for (place, node) in nodes.iter().enumerate().rev() {
            if let Some(object) = node.object {
                self.counts[place].all += 1;
                let is_shown = document.display(object) != Display::Hidden;
                self.counts[place].shown += u32::from(is_shown);
            }
            let count = self.counts[place];
            let parent = node.parent.and_then(|parent| self.counts.get_mut(parent.0 as usize));
            if let Some(parent) = parent {
                parent.all += count.all;
                parent.shown += count.shown;
            }
        }
    }

    fn lay_out(&mut self) {
        self.rows.clear();
        let mut around: Vec<PartId> = Vec::new();
        let mut now = (!self.is_open.is_empty()).then_some(PartId(0));
        while let Some(part) = now {
            self.rows.push(PartRow { part, depth: around.len() as u32 });
            let place = part.0 as usize;
            now = self.first_child[place].filter(|_| self.is_open[place]);
            if now.is_some() {
                around.push(part);
            } else {
                now = self.next[place];
            }
            while now.is_none() {
                let Some(group) = around.pop() else { break };
                now = self.next[group.0 as usize];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(rows: &PartRows, document: &Document) -> Vec<String> {
        let name = |row: &PartRow| document.parts.node(row.part).unwrap().name.clone();
        rows.rows().iter().map(name).collect()
    }

    #[test]
    fn groups_open_and_close_and_count_what_is_shown() {
        let made = scenes::waffle_maker();
        let mut document = Document::new(made.scene, made.parts, None);
        let mut rows = PartRows::new(&document);
        let closed = rows.rows().len();
        let base = rows.rows()[1].part;
        assert!(rows.is_group(base) && !rows.is_open(base));
        rows.toggle(base);
        let shown = names(&rows, &document);
        assert!(shown.len() > closed && shown.contains(&"body".to_owned()), "{shown:?}");
        rows.toggle(base);
        assert_eq!(rows.rows().len(), closed);

        let body = document.find("body").unwrap();
        let place = rows.reveal(&document.parts, body[0]).unwrap();
        assert_eq!(names(&rows, &document)[place], "body");
        let root = rows.rows()[0].part;
        let all = rows.count_of(root);
        assert_eq!(all, PartCount { all: document.objects().count() as u32, shown: all.all });
        document.set_display(&body, Display::Hidden);
        rows.count(&document);
        assert_eq!(rows.count_of(root).shown, all.all - 1);
        assert_eq!(rows.count_of(rows.rows()[place].part), PartCount { all: 1, shown: 0 });
    }

    #[test]
    fn each_part_of_an_open_tree_has_one_row() {
        let made = scenes::assembly(2000, 1).unwrap();
        let document = Document::new(made.generated.scene, made.parts, None);
        let mut rows = PartRows::new(&document);
        let mut place = 0;
        while let Some(row) = rows.rows().get(place).copied() {
            if rows.is_group(row.part) && !rows.is_open(row.part) {
                rows.toggle(row.part);
            }
            place += 1;
        }
        assert_eq!(rows.rows().len(), document.parts.nodes.len());
        let mut parts: Vec<u32> = rows.rows().iter().map(|row| row.part.0).collect();
        parts.sort_unstable();
        parts.dedup();
        assert_eq!(parts.len(), document.parts.nodes.len());
    }
}
