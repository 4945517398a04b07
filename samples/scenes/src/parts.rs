//! The tree of a model's parts, as in CAD programs.

use cull::ObjectId;

/// The id of a node of a tree of parts: an index into [`PartTree::nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PartId(pub u32);

/// A part, or a group of parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartNode {
    /// The name, for people.
    pub name: String,
    /// The group of the node; `None` for the root.
    pub parent: Option<PartId>,
    /// The object of the part; `None` for a group.
    pub object: Option<ObjectId>,
}

/// The parts of a model, in groups. The root is the first node, and parents precede their children.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartTree {
    /// The nodes.
    pub nodes: Vec<PartNode>,
}

impl PartTree {
    /// Returns a tree with only a root.
    pub(crate) fn of_root(name: &str) -> Self {
        let mut tree = Self::default();
        tree.add(PartNode { name: name.to_owned(), parent: None, object: None });
        tree
    }

    pub(crate) fn add(&mut self, node: PartNode) -> PartId {
        self.nodes.push(node);
        PartId(self.nodes.len() as u32 - 1)
    }

    pub(crate) fn group(&mut self, name: impl Into<String>, parent: PartId) -> PartId {
        self.add(PartNode { name: name.into(), parent: Some(parent), object: None })
    }

    /// Returns the node with this id, if there is one.
    pub fn node(&self, part: PartId) -> Option<&PartNode> {
        self.nodes.get(part.0 as usize)
    }

    /// Returns the objects of a node and of all its descendants, in ascending order.
    pub fn objects_of(&self, part: PartId) -> Vec<ObjectId> {
        let mut is_within = vec![false; self.nodes.len()];
        let mut objects = Vec::new();
        for (place, node) in self.nodes.iter().enumerate() {
            let parent = node.parent.and_then(|parent| is_within.get(parent.0 as usize).copied());
            let within = place == part.0 as usize || parent == Some(true);
            is_within[place] = within;
            objects.extend(node.object.filter(|_| within));
        }
        objects.sort_unstable();
        objects
    }
}
