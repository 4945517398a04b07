//! Makes the nodes of the shown scene a forest, before any other check: everything that violates
//! this structure is left out.

use gltf::json::{Index, Node, Root, Scene};

use super::nodes::{NodePart, check_numbers, check_references};
use super::numbers::in_range;
use crate::Limits;
use crate::element::{Element, Kind};
use crate::error::{At, Fault, Reason};
use crate::leave_out::remove_light;
use crate::losses::Losses;
use crate::notes::Notes;
use crate::placeholder::Placeholder;
use crate::reach::shown_scene;

/// Leaves out nodes of the shown scene whose transform is invalid, edges to children that do not
/// exist or already have a parent, and invalid references of nodes. A file without scenes first
/// gets a scene, so that nodes below a node that is left out do not become roots.
///
/// Of the `faults` of unreadable elements, only the faults of nodes matter.
pub(crate) fn mend(
    root: &mut Root,
    faults: &[(Element, Fault)],
    limits: &Limits,
    losses: &mut Losses,
    notes: &mut Notes,
) -> Result<(), Fault> {
    let count = root.nodes.len();
    if count as u64 > limits.nodes {
        return Err(Reason::too_large("nodes", count as u64, limits.nodes).of("nodes"));
    }
    let mut mender = Mender { root, losses, notes };
    mender.mend_choice()?;
    if mender.root.scenes.is_empty() {
        mender.root.scenes.push(scene_of_all(&mender.root.nodes));
    }
    for (element, _) in faults.iter().filter(|(element, _)| element.kind == Kind::Node) {
        mender.losses.empty_node(element.index, mender.root);
    }
    let mut forest = Forest::of(count);
    for start in mender.roots()? {
        if !forest.is_new(start) {
            continue;
        }
        forest.add_root(start);
        let mut pending = vec![start];
        while let Some(node) = pending.pop() {
            mender.mend_node(node)?;
            let first = pending.len();
            mender.mend_children(node, &mut forest, &mut pending)?;
            // The first child must be processed next.
            pending.get_mut(first..).unwrap_or_default().reverse();
        }
    }
    Ok(())
}

/// Returns the scene of a file without scenes: all nodes without a parent.
fn scene_of_all(nodes: &[Node]) -> Scene {
    let mut is_child = vec![false; nodes.len()];
    for child in nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    let roots = (0..).zip(is_child).filter(|(_, is_child)| !is_child);
    Scene { nodes: roots.map(|(node, _)| Index::new(node)).collect(), ..Placeholder::blank() }
}

struct Mender<'a> {
    root: &'a mut Root,
    losses: &'a mut Losses,
    notes: &'a mut Notes,
}

impl Mender<'_> {
    /// Removes the file's choice of a scene if that scene does not exist.
    fn mend_choice(&mut self) -> Result<(), Fault> {
        let Some(named) = self.root.scene else { return Ok(()) };
        let checked = in_range("scene", named.value(), self.root.scenes.len());
        let Err(fault) = checked.at(|| "default scene".to_owned()) else { return Ok(()) };
        self.root.scene = None;
        self.losses.repair(fault, "the first one is shown, or all nodes", self.notes)
    }

    /// Returns the roots of the shown scene, each once, and removes the others from the scene's
    /// list.
    fn roots(&mut self) -> Result<Vec<usize>, Fault> {
        let Some(scene) = shown_scene(self.root) else { return Ok(Vec::new()) };
        let count = self.root.nodes.len();
        let Some(given) = self.root.scenes.get_mut(scene) else { return Ok(Vec::new()) };
        let mut is_listed = vec![false; count];
        let mut roots = Vec::with_capacity(given.nodes.len());
        for node in std::mem::take(&mut given.nodes) {
            let index = node.value();
            let object = || format!("scene {scene}");
            if let Err(fault) = in_range("node", index, count).at(object) {
                self.losses.leave_out(fault, "it is left out", self.notes)?;
            } else if std::mem::replace(&mut is_listed[index], true) {
                let fault = Reason::malformed(format!("node {index} is in it twice")).of(object());
                self.losses.repair(fault, "it is shown once", self.notes)?;
            } else {
                roots.push(node);
            }
        }
        let indices = roots.iter().map(|node| node.value()).collect();
        given.nodes = roots;
        Ok(indices)
    }

    /// Empties a node if its transform is invalid; otherwise removes its invalid references.
    fn mend_node(&mut self, index: usize) -> Result<(), Fault> {
        let Some(node) = self.root.nodes.get(index) else { return Ok(()) };
        let object = || format!("node {index}");
        if let Err(reason) = check_numbers(node) {
            self.losses.empty_node(index, self.root);
            let consequence = "it is left out with all below it";
            return self.losses.leave_out(reason.of(object()), consequence, self.notes);
        }
        // Each pass removes one part of the node.
        while let Some(node) = self.root.nodes.get(index)
            && let Err((part, reason)) = check_references(self.root, node)
        {
            let Some(node) = self.root.nodes.get_mut(index) else { return Ok(()) };
            let fault = reason.of(object());
            match part {
                NodePart::Camera => {
                    node.camera = None;
                    self.losses.repair(fault, "it has none", self.notes)?;
                }
                NodePart::Light => {
                    remove_light(node);
                    self.losses.repair(fault, "it has none", self.notes)?;
                }
                NodePart::Mesh => {
                    self.losses.remove_mesh(index, self.root);
                    self.losses.leave_out(fault, "its mesh is left out", self.notes)?;
                }
            }
        }
        Ok(())
    }

    /// Removes invalid children of a node, and appends the new ones to a list.
    fn mend_children(
        &mut self,
        index: usize,
        forest: &mut Forest,
        new: &mut Vec<usize>,
    ) -> Result<(), Fault> {
        let node = self.root.nodes.get_mut(index);
        let Some(children) = node.and_then(|node| node.children.as_mut()) else { return Ok(()) };
        let mut left_out = Ok(());
        children.retain(|child| {
            let is_new = forest.is_new(child.value());
            let adopted = forest.adopt(index, child.value());
            let is_kept = adopted.is_ok();
            match adopted {
                Ok(()) => new.extend(is_new.then_some(child.value())),
                Err(reason) if left_out.is_ok() => {
                    let fault = reason.of(format!("node {index}, children"));
                    left_out = self.losses.leave_out(fault, "it is left out here", self.notes);
                }
                Err(_) => {}
            }
            is_kept
        });
        left_out
    }
}

/// The forest of the visited nodes.
struct Forest {
    /// The parent of each node that has one.
    parents: Vec<Option<u32>>,
    /// The root below which each node was visited; [`Forest::NONE`] for nodes that were not.
    visited_below: Vec<u32>,
    /// For each root that got a parent later: the root below which this parent is.
    adopted_below: Vec<u32>,
}

impl Forest {
    const NONE: u32 = u32::MAX;

    fn of(count: usize) -> Self {
        Self {
            parents: vec![None; count],
            visited_below: vec![Self::NONE; count],
            adopted_below: vec![Self::NONE; count],
        }
    }

    /// Returns true if a node exists and was not visited.
    fn is_new(&self, node: usize) -> bool {
        self.visited_below.get(node) == Some(&Self::NONE)
    }

    fn add_root(&mut self, node: usize) {
        self.visited_below[node] = node as u32;
    }

    /// Makes a visited node the parent of another node.
    ///
    /// # Errors
    /// A child that does not exist, already has a parent, or is an ancestor of the parent.
    fn adopt(&mut self, parent: usize, child: usize) -> Result<(), Reason> {
        in_range("child node", child, self.parents.len())?;
        if let Some(other) = self.parents[child] {
            let text = format!("node {child} is a child of node {other} already");
            return Err(Reason::malformed(text));
        }
        let root = self.root_of(parent);
        if self.is_new(child) {
            self.visited_below[child] = root;
        } else if root == child as u32 {
            return Err(Reason::malformed(format!("node {child} would be its own ancestor")));
        } else {
            self.adopted_below[child] = root;
        }
        self.parents[child] = Some(parent as u32);
        Ok(())
    }

    /// Returns the root above a visited node, and shortens the path to it.
    fn root_of(&mut self, node: usize) -> u32 {
        let first = self.visited_below[node];
        let mut root = first;
        while self.adopted_below[root as usize] != Self::NONE {
            root = self.adopted_below[root as usize];
        }
        self.visited_below[node] = root;
        let mut at = first;
        while self.adopted_below[at as usize] != Self::NONE {
            at = std::mem::replace(&mut self.adopted_below[at as usize], root);
        }
        root
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_node_has_one_parent_and_is_not_above_itself() {
        let mut forest = Forest::of(6);
        forest.add_root(0);
        assert_eq!(forest.adopt(0, 1), Ok(()));
        assert_eq!(forest.adopt(1, 2), Ok(()));
        assert!(forest.adopt(2, 0).is_err() && forest.adopt(0, 0).is_err());
        assert!(forest.adopt(0, 2).is_err() && forest.adopt(1, 2).is_err());
        assert!(forest.adopt(0, 6).is_err());
        // A root may become a child in another tree; then it has a parent.
        forest.add_root(3);
        assert_eq!(forest.adopt(3, 0), Ok(()));
        assert!(forest.adopt(2, 3).is_err() && forest.adopt(3, 0).is_err());
        forest.add_root(4);
        assert_eq!(forest.adopt(4, 3), Ok(()));
        assert!(forest.adopt(2, 4).is_err());
        assert_eq!(forest.adopt(2, 5), Ok(()));
        let parents = [Some(3), Some(0), Some(1), Some(4), None, Some(2)];
        assert_eq!(forest.parents, parents);
    }
}
