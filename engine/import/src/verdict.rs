//! The consequences of faults. The fault of an element that the shown scene uses is held until the
//! parts that need the element are left out. All other faults are noted.

use std::collections::{BTreeMap, BTreeSet};

use gltf::json::{Mesh, Root};

use crate::element::{Element, Kind};
use crate::error::Fault;
use crate::losses::Losses;
use crate::notes::{Note, Notes};
use crate::reach::{Reach, references};

/// Decides about a file's faults by the elements that the shown scene uses.
pub(crate) struct Verdict {
    reach: Reach,
    /// The first fault of each used element; the parts that need the element are left out.
    held: BTreeMap<Element, Fault>,
    /// Elements whose first fault is noted: later faults often follow from it.
    noted: BTreeSet<Element>,
    losses: Losses,
    pub(crate) notes: Notes,
}

impl Verdict {
    pub(crate) fn new(reach: Reach, losses: Losses, notes: Notes) -> Self {
        Self { reach, held: BTreeMap::new(), noted: BTreeSet::new(), losses, notes }
    }

    /// Returns true if the shown scene uses an element.
    pub(crate) fn is_used(&self, element: Element) -> bool {
        self.reach.is_used(element)
    }

    /// Follows the references of the shown scene again, after parts were left out.
    pub(crate) fn follow_again(&mut self, root: &Root) {
        self.reach = Reach::of(root);
    }

    /// Judges the result of a check of an element. Returns the value if the check passed.
    ///
    /// # Errors
    /// The fault, if it refuses the file.
    pub(crate) fn judge<T>(
        &mut self,
        element: Element,
        checked: Result<T, Fault>,
    ) -> Result<Option<T>, Fault> {
        let fault = match checked {
            Ok(value) => return Ok(Some(value)),
            Err(fault) => fault,
        };
        if self.is_used(element) {
            let fault = self.losses.hold(fault)?;
            // Without its scene, nothing of the file can be shown.
            if element.kind == Kind::Scene {
                return Err(fault);
            }
            self.held.entry(element).or_insert(fault);
        } else if self.noted.insert(element) {
            self.notes.count_as(element.kind.name(), 1, || {
                let (object, reason) = fault.into_parts();
                Note::new(object, format!("{reason}; nothing that is shown uses it"))
            });
        }
        Ok(None)
    }

    /// Returns true if a used element may be broken.
    pub(crate) fn has_faults(&self) -> bool {
        !self.held.is_empty()
    }

    /// Returns the fault of the element itself.
    pub(crate) fn own_fault(&self, element: Element) -> Option<&Fault> {
        self.held.get(&element)
    }

    /// Takes the fault of the element itself. Later faults of the element are not noted.
    pub(crate) fn take_fault(&mut self, element: Element) -> Option<Fault> {
        let fault = self.held.remove(&element)?;
        self.noted.insert(element);
        Some(fault)
    }

    /// Returns true if a fault of an element was noted.
    pub(crate) fn is_noted(&self, element: Element) -> bool {
        self.noted.contains(&element)
    }

    /// Returns the fault of an element, or of an element that it needs.
    pub(crate) fn fault_of(&self, root: &Root, element: Element) -> Option<&Fault> {
        if self.held.is_empty() {
            return None;
        }
        // References of accessors, skins, animations and images reach buffers in a few steps. The
        // deepest fault often causes the others.
        let mut deepest: Option<(usize, &Fault)> = None;
        let mut pending = vec![(0, element)];
        while let Some((depth, element)) = pending.pop() {
            if let Some(fault) = self.held.get(&element)
                && deepest.is_none_or(|(deepest, _)| deepest < depth)
            {
                deepest = Some((depth, fault));
            }
            references(root, element, &mut |to| pending.push((depth + 1, to)));
        }
        deepest.map(|(_, fault)| fault)
    }

    /// Returns an error if every visible part was left out.
    ///
    /// # Errors
    /// The first fault because of which something was left out.
    pub(crate) fn refuse_empty(&mut self, root: &Root) -> Result<(), Fault> {
        let meshes = root.meshes.iter().enumerate();
        let mut shown = meshes.filter(|(index, _)| self.is_used(Kind::Mesh.at(*index)));
        let is_empty =
            |mesh: &Mesh| mesh.primitives.iter().all(|primitive| primitive.attributes.is_empty());
        if shown.any(|(_, mesh)| !is_empty(mesh)) {
            return Ok(());
        }
        self.losses.take_first().map_or(Ok(()), Err)
    }

    /// Notes that a visible part is left out because of a fault.
    pub(crate) fn leave_out(&mut self, fault: Fault, consequence: &str) -> Result<(), Fault> {
        self.losses.leave_out(fault, consequence, &mut self.notes)
    }

    /// Notes that a part is shown differently from the file because of a fault.
    pub(crate) fn repair(&mut self, fault: Fault, consequence: &str) -> Result<(), Fault> {
        self.losses.repair(fault, consequence, &mut self.notes)
    }

    /// Removes the mesh of a node, with everything that belongs to it.
    pub(crate) fn remove_mesh(&mut self, index: usize, root: &mut Root) {
        self.losses.remove_mesh(index, root);
    }

    /// Empties a node except for its name.
    pub(crate) fn empty_node(&mut self, index: usize, root: &mut Root) {
        self.losses.empty_node(index, root);
    }

    /// Returns true if the mesh of a node was left out.
    pub(crate) fn has_lost_mesh(&self, node: usize) -> bool {
        self.losses.has_lost_mesh(node)
    }

    /// Returns true if an element is used and valid.
    pub(crate) fn is_kept(&self, root: &Root, element: Element) -> bool {
        self.is_used(element) && self.fault_of(root, element).is_none()
    }

    /// Returns the broken parts that were left out, and all notes.
    pub(crate) fn finish(self) -> (Losses, Vec<Note>) {
        (self.losses, self.notes.finish())
    }
}

/// Notes the broken animations, which are not played.
pub(crate) fn note_broken_animations(root: &Root, verdict: &mut Verdict) -> Result<(), Fault> {
    for index in 0..root.animations.len() {
        let element = Kind::Animation.at(index);
        if let Some(fault) = verdict.fault_of(root, element).cloned() {
            verdict.repair(fault, &format!("{element} is not played"))?;
        }
    }
    Ok(())
}
