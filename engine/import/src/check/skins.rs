//! Skins: joints that are nodes, and a matrix for each.

use gltf::json::accessor::Type;
use gltf::json::{Root, Skin};

use super::attributes::{self, FLOATS};
use super::in_range;
use crate::error::{At, Fault, Reason};

pub(super) fn check(root: &Root) -> Result<(), Fault> {
    for (index, skin) in root.skins.iter().enumerate() {
        check_skin(root, skin).at(|| format!("skin {index}"))?;
    }
    Ok(())
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
            "it has {} joints, but {} inverse bind matrices",
            skin.joints.len(),
            accessor.count.0
        );
        return Err(Reason::malformed(text));
    }
    Ok(())
}
