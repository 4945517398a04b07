//! Skins: the joints that vertices follow.

use std::collections::HashMap;

use animation::{RigNodeId, Skin};
use glam::{Affine3A, Mat4};
use scene::SkinWeights;

use super::nodes::Tree;
use super::numbers::{has_volume, mirrors};
use crate::error::Reason;
use crate::losses::Losses;
use crate::notes::Notes;
use crate::{ImportError, Source};

/// A skin that objects use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Used {
    /// The index in the list of skins.
    pub(super) skin: usize,
    /// The number of its joints.
    pub(super) joints: u32,
    /// True if it mirrors its meshes at rest.
    pub(super) is_mirrored: bool,
}

/// The skins that are used.
#[derive(Debug, Default)]
pub(super) struct Skins {
    pub(super) list: Vec<Skin>,
    known: HashMap<usize, Option<Used>>,
}

impl Skins {
    /// Returns a skin of the file. `None`, with a note, if joints are not in the scene or matrices
    /// are not finite.
    ///
    /// # Errors
    /// Such a skin, if broken parts are refused.
    pub(super) fn used(
        &mut self,
        source: &Source,
        tree: &Tree,
        index: usize,
        losses: &mut Losses,
        notes: &mut Notes,
    ) -> Result<Option<Used>, ImportError> {
        if let Some(known) = self.known.get(&index) {
            return Ok(*known);
        }
        let used = read(source, tree, index).map(|skin| {
            let matrices = skin.joints.iter().zip(&skin.inverse_bind);
            let mut matrices = matrices.map(|(joint, bind)| tree.world(*joint) * *bind);
            let is_mirrored = matrices.find(has_volume).is_some_and(|matrix| mirrors(&matrix));
            let joints = skin.joints.len() as u32;
            self.list.push(skin);
            Used { skin: self.list.len() - 1, joints, is_mirrored }
        });
        if used.is_none() {
            let what = "it has joints outside of the scene or matrices that are not finite";
            let fault = Reason::malformed(what).of(format!("skin {index}"));
            let noted = losses.leave_out(fault, "meshes on it are left out", notes);
            noted.map_err(|fault| fault.in_file(&source.file))?;
        }
        self.known.insert(index, used);
        Ok(used)
    }
}

/// Returns true for each joint of a skin that a vertex follows.
pub(crate) fn used_joints(weights: &SkinWeights) -> Vec<bool> {
    let mut is_used = vec![false; weights.joint_count as usize];
    let named = weights.joints.as_flattened().iter().zip(weights.weights.as_flattened());
    for (joint, _) in named.filter(|(_, weight)| **weight > 0.0) {
        if let Some(is_used) = is_used.get_mut(usize::from(*joint)) {
            *is_used = true;
        }
    }
    is_used
}

fn read(source: &Source, tree: &Tree, index: usize) -> Option<Skin> {
    let given = source.document.as_json().skins.get(index)?;
    let joints: Vec<RigNodeId> =
        given.joints.iter().map(|joint| tree.id_of(joint.value())).collect::<Option<_>>()?;
    let inverse_bind = match given.inverse_bind_matrices {
        Some(accessor) => source.floats::<16>(accessor.value())?,
        None => Vec::new(),
    };
    let matrix = |place: usize| {
        let columns = inverse_bind.get(place);
        columns.map_or(Affine3A::IDENTITY, |columns| {
            Affine3A::from_mat4(Mat4::from_cols_array(columns))
        })
    };
    let inverse_bind: Vec<Affine3A> = (0..joints.len()).map(matrix).collect();
    // A vertex stores the numbers of its joints in 16 bits.
    let can_be_named = joints.len() <= usize::from(u16::MAX) + 1;
    let is_finite = inverse_bind.iter().all(|matrix| matrix.is_finite());
    (can_be_named && is_finite).then_some(Skin { joints, inverse_bind })
}
