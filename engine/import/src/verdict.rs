//! The consequences of faults: a fault in a shown element refuses the file, and all others are
//! noted.

use std::collections::{BTreeMap, BTreeSet};

use gltf::json::Root;

use crate::element::{Element, Kind, Need};
use crate::error::Fault;
use crate::notes::{Note, Notes};
use crate::reach::{Reach, references};

/// The judge of a file's faults, by the needs of the scene.
pub(crate) struct Verdict {
    reach: Reach,
    /// The first fault of each optional element: the elements that need it are left out.
    held: BTreeMap<Element, Fault>,
    /// Unused elements whose first fault is noted: other faults often follow from it.
    noted: BTreeSet<Element>,
    pub(crate) notes: Notes,
}

impl Verdict {
    pub(crate) fn new(reach: Reach, notes: Notes) -> Self {
        Self { reach, held: BTreeMap::new(), noted: BTreeSet::new(), notes }
    }

    /// Returns the need of the scene for an element.
    pub(crate) fn need(&self, element: Element) -> Need {
        self.reach.need(element)
    }

    /// Returns true if anything that is shown uses an element.
    pub(crate) fn is_used(&self, element: Element) -> bool {
        self.need(element) != Need::None
    }

    /// Returns true if the scene cannot be shown without an element.
    pub(crate) fn is_required(&self, element: Element) -> bool {
        self.need(element) == Need::Required
    }

    /// Judges the outcome of a check of an element. Returns the value if the check passed.
    ///
    /// # Errors
    /// The fault, if the scene needs the element. A used element beyond a limit is refused in any
    /// case.
    pub(crate) fn judge<T>(
        &mut self,
        element: Element,
        checked: Result<T, Fault>,
    ) -> Result<Option<T>, Fault> {
        let fault = match checked {
            Ok(value) => return Ok(Some(value)),
            Err(fault) => fault,
        };
        match self.need(element) {
            Need::None if !self.noted.insert(element) => Ok(None),
            Need::None => {
                self.notes.count_as(element.kind.name(), 1, || {
                    let (object, reason) = fault.into_parts();
                    Note::new(object, format!("{reason}; nothing that is shown uses it"))
                });
                Ok(None)
            }
            Need::Optional if !fault.is_final() => {
                self.held.entry(element).or_insert(fault);
                Ok(None)
            }
            Need::Optional | Need::Required => Err(fault),
        }
    }

    /// Returns the fault of an element or of one that it needs.
    pub(crate) fn fault_of(&self, root: &Root, element: Element) -> Option<&Fault> {
        if self.held.is_empty() {
            return None;
        }
        // References of optional elements lead down to buffers in a few steps. A fault below often
        // causes the one above.
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

    /// Notes that an element is left out for its fault, with the consequence.
    pub(crate) fn note_left_out(&mut self, fault: Fault, consequence: &str) {
        self.notes.add(|| {
            let (object, reason) = fault.into_parts();
            Note::new(object, format!("{reason}; {consequence}"))
        });
    }

    /// Returns true if an element is used and valid.
    pub(crate) fn is_kept(&self, root: &Root, element: Element) -> bool {
        match self.need(element) {
            Need::Required => true,
            Need::Optional => self.fault_of(root, element).is_none(),
            Need::None => false,
        }
    }
}

/// Notes the broken animations, which are not played.
pub(crate) fn note_broken_animations(root: &Root, verdict: &mut Verdict) {
    for index in 0..root.animations.len() {
        let element = Kind::Animation.at(index);
        if let Some(fault) = verdict.fault_of(root, element).cloned() {
            verdict.note_left_out(fault, &format!("{element} is not played"));
        }
    }
}
