//! Checks of skins: joints must be nodes and have a matrix each.

use gltf::json::accessor::Type;
use gltf::json::{Root, Skin};

use scene::counted;

use super::attributes::{self, FLOATS};
use super::numbers::in_range;
use crate::element::Kind;
use crate::error::{At, Fault, Reason};
use crate::verdict::Verdict;

/// Checks all skins against the `parents` of the shown nodes.
pub(super) fn check(
    root: &Root,
    parents: &[Option<u32>],
    verdict: &mut Verdict,
) -> Result<(), Fault> {
    let mut tops = None;
    for (index, skin) in root.skins.iter().enumerate() {
        let element = Kind::Skin.at(index);
        let checked = check_skin(root, skin).at(|| element.to_string());
        if verdict.judge(element, checked)?.is_none() || !verdict.is_used(element) {
            continue;
        }
        let tops = tops.get_or_insert_with(|| tops_of(parents));
        let mut tops = skin.joints.iter().map(|joint| tops.get(joint.value()));
        let first = tops.next();
        if tops.any(|top| Some(top) != first) {
            let what = "its joints have no common root: each is moved by its own parents";
            verdict.notes.count(what, 1, || element.to_string());
        }
    }
    Ok(())
}

/// Returns the topmost ancestor of each node of a forest.
fn tops_of(parents: &[Option<u32>]) -> Vec<usize> {
    let mut tops = vec![usize::MAX; parents.len()];
    let mut way = Vec::new();
    for start in 0..parents.len() {
        let mut at = start;
        let top = loop {
            match (tops.get(at), parents.get(at).copied().flatten()) {
                (Some(&top), _) if top != usize::MAX => break top,
                (_, None) => break at,
                (_, Some(parent)) => {
                    way.push(at);
                    at = parent as usize;
                }
            }
        };
        for node in way.drain(..).chain([at]) {
            if let Some(slot) = tops.get_mut(node) {
                *slot = top;
            }
        }
    }
    tops
}

fn check_skin(root: &Root, skin: &Skin) -> Result<(), Reason> {
    if skin.joints.is_empty() {
        return Err(Reason::malformed("it has no joints"));
    }
    for &joint in skin.joints.iter().chain(&skin.skeleton) {
        in_range("node", joint.value(), root.nodes.len())?;
    }
    let Some(matrices) = skin.inverse_bind_matrices else {
        return Ok(());
    };
    in_range("accessor", matrices.value(), root.accessors.len())?;
    let Some(accessor) = root.get(matrices) else {
        return Ok(());
    };
    attributes::check_form(accessor, Type::Mat4, FLOATS)?;
    if accessor.count.0 < skin.joints.len() as u64 {
        let text = format!(
            "it has {}, but {}",
            counted(skin.joints.len(), "joint", "joints"),
            counted(accessor.count.0, "inverse bind matrix", "inverse bind matrices")
        );
        return Err(Reason::malformed(text));
    }
    Ok(())
}
