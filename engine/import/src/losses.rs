//! Broken parts of the shown scene: they are left out or repaired with a note, or the file is
//! refused.

use std::collections::BTreeSet;

use gltf::json::{Node, Root};

use crate::BrokenParts;
use crate::error::Fault;
use crate::extensions::INSTANCING;
use crate::notes::{Note, Notes};

/// The broken parts of the shown scene that were left out.
#[derive(Debug, Default)]
pub(crate) struct Losses {
    broken_parts: BrokenParts,
    /// The first fault because of which something is not visible.
    first: Option<Fault>,
    /// The nodes whose meshes were left out.
    without_mesh: BTreeSet<usize>,
}

impl Losses {
    pub(crate) fn new(broken_parts: BrokenParts) -> Self {
        Self { broken_parts, ..Self::default() }
    }

    /// Notes that a visible part is left out because of a fault, with the consequence.
    ///
    /// # Errors
    /// The fault, if broken parts are refused, or if the fault refuses any file.
    pub(crate) fn leave_out(
        &mut self,
        fault: Fault,
        consequence: &str,
        notes: &mut Notes,
    ) -> Result<(), Fault> {
        let first = self.first.is_none().then(|| fault.clone());
        self.repair(fault, consequence, notes)?;
        self.first = self.first.take().or(first);
        Ok(())
    }

    /// Notes that a part is shown differently from the file, with the consequence.
    pub(crate) fn repair(
        &mut self,
        fault: Fault,
        consequence: &str,
        notes: &mut Notes,
    ) -> Result<(), Fault> {
        let (object, reason) = self.hold(fault)?.into_parts();
        notes.add_alike(Note::new(object, format!("{reason}; {consequence}")));
        Ok(())
    }

    /// Judges the fault of a part whose consequence is not known yet. Returns the fault if the file
    /// may be shown without the part.
    pub(crate) fn hold(&self, fault: Fault) -> Result<Fault, Fault> {
        let is_refused = self.broken_parts == BrokenParts::Refuse || fault.is_final();
        if is_refused { Err(fault) } else { Ok(fault) }
    }

    /// Removes the mesh of a node, with everything that belongs to it.
    pub(crate) fn remove_mesh(&mut self, index: usize, root: &mut Root) {
        let Some(node) = root.nodes.get_mut(index) else { return };
        (node.mesh, node.skin, node.weights) = (None, None, None);
        if let Some(extensions) = &mut node.extensions {
            extensions.others.remove(INSTANCING);
        }
        self.without_mesh.insert(index);
    }

    /// Empties a node except for its name: it then has no references and no children.
    pub(crate) fn empty_node(&mut self, index: usize, root: &mut Root) {
        let Some(node) = root.nodes.get_mut(index) else { return };
        *node = Node { name: node.name.take(), ..Node::default() };
        self.without_mesh.insert(index);
    }

    /// Returns true if the mesh of a node was left out.
    pub(crate) fn has_lost_mesh(&self, node: usize) -> bool {
        self.without_mesh.contains(&node)
    }

    /// Takes the first fault because of which something is not visible.
    pub(crate) fn take_first(&mut self) -> Option<Fault> {
        self.first.take()
    }
}
