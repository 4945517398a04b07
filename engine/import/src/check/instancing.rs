//! The instances of meshes: `EXT_mesh_gpu_instancing`.

use std::collections::BTreeMap;

use gltf::json::accessor::Type;
use gltf::json::{Accessor, Node, Root};
use serde_json::{Map, Value};

use super::attributes::{self, FLOATS, FRACTIONS};
use crate::element::Kind;
use crate::error::{At, Fault, Reason};
use crate::extensions::{INSTANCING, index};
use crate::verdict::Verdict;

/// The accessors of a node's instances (`EXT_mesh_gpu_instancing`), each with `count` elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instancing {
    /// The number of instances, at least 1.
    pub count: usize,
    /// The accessor of translations: three floats.
    pub translation: Option<usize>,
    /// The accessor of rotations: four floats or signed normalised integers, a quaternion x, y, z,
    /// w.
    pub rotation: Option<usize>,
    /// The accessor of scales: three floats.
    pub scale: Option<usize>,
}

/// Checks the instances of all nodes. A mesh with invalid instances is removed from its node.
pub(super) fn check(
    root: &mut Root,
    verdict: &mut Verdict,
) -> Result<BTreeMap<usize, Instancing>, Fault> {
    let mut all = BTreeMap::new();
    for index in 0..root.nodes.len() {
        let Some(node) = root.nodes.get(index) else { continue };
        let element = Kind::Node.at(index);
        let found = of_node(root, node).at(|| format!("node {index}, {INSTANCING}"));
        if !verdict.is_used(element) {
            verdict.judge(element, found)?;
            continue;
        }
        match found {
            Ok(found) => all.extend(found.map(|found| (index, found))),
            Err(fault) => {
                verdict.remove_mesh(index, root);
                verdict.leave_out(fault, "its mesh is left out")?;
            }
        }
    }
    Ok(all)
}

fn of_node(root: &Root, node: &Node) -> Result<Option<Instancing>, Reason> {
    let extension =
        node.extensions.as_ref().and_then(|extensions| extensions.others.get(INSTANCING));
    let Some(extension) = extension else {
        return Ok(None);
    };
    let attributes = extension
        .get("attributes")
        .and_then(Value::as_object)
        .ok_or_else(|| Reason::malformed("it has no attributes"))?;
    let count = same_count(root, attributes)?;
    let find = |name: &str, kind, forms| -> Result<Option<usize>, Reason> {
        let Some(value) = attributes.get(name) else { return Ok(None) };
        let (index, accessor) = accessor(root, name, value)?;
        attributes::check_form(accessor, kind, forms)
            .map_err(|_| Reason::malformed(format!("its {name} has the wrong type")))?;
        Ok(Some(index))
    };
    Ok(Some(Instancing {
        count,
        translation: find("TRANSLATION", Type::Vec3, FLOATS)?,
        rotation: find("ROTATION", Type::Vec4, FRACTIONS)?,
        scale: find("SCALE", Type::Vec3, FLOATS)?,
    }))
}

/// Returns the number of instances. All attributes must have this count, including unknown ones.
fn same_count(root: &Root, attributes: &Map<String, Value>) -> Result<usize, Reason> {
    let mut count = None;
    for (name, value) in attributes {
        let here = accessor(root, name, value)?.1.count.0;
        if *count.get_or_insert(here) != here {
            return Err(Reason::malformed("its attributes have different numbers of elements"));
        }
    }
    let count = count.ok_or_else(|| Reason::malformed("it has no attributes"))?;
    usize::try_from(count)
        .map_err(|_| Reason::malformed("it has more elements than can be counted"))
}

fn accessor<'a>(
    root: &'a Root,
    name: &str,
    value: &Value,
) -> Result<(usize, &'a Accessor), Reason> {
    let index = index(value);
    let found = index.and_then(|index| Some((index, root.accessors.get(index)?)));
    found.ok_or_else(|| {
        let name = crate::error::quoted(name);
        Reason::malformed(format!("its attribute {name} is not an accessor of the file"))
    })
}
