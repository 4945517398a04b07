//! Where meshes are instanced: `EXT_mesh_gpu_instancing`.

use std::collections::BTreeMap;

use gltf::json::accessor::Type;
use gltf::json::{Accessor, Node, Root};
use serde_json::{Map, Value};

use super::attributes::{self, FLOATS, FRACTIONS};
use super::uses;
use crate::error::{At, Fault, Reason};
use crate::json;
use crate::reach::Kind;
use crate::source::Instancing;
use crate::verdict::Verdict;

const EXTENSION: &str = "EXT_mesh_gpu_instancing";

pub(super) fn check(
    root: &Root,
    verdict: &mut Verdict,
) -> Result<BTreeMap<usize, Instancing>, Fault> {
    if !uses(root, EXTENSION) {
        return Ok(BTreeMap::new());
    }
    let mut all = BTreeMap::new();
    for (index, node) in root.nodes.iter().enumerate() {
        let element = Kind::Node.at(index);
        let found = of_node(root, node).at(|| format!("node {index}, {EXTENSION}"));
        let found = verdict.judge(element, found)?.flatten();
        all.extend(found.filter(|_| verdict.is_used(element)).map(|found| (index, found)));
    }
    Ok(all)
}

/// Returns the indices of the accessors that place the instances of a node.
pub(crate) fn accessors(node: &Node) -> impl Iterator<Item = usize> {
    let extension = node.extensions.as_ref().and_then(|it| it.others.get(EXTENSION));
    let attributes = extension.and_then(|it| it.get("attributes")).and_then(Value::as_object);
    let indices = attributes.into_iter().flat_map(|attributes| attributes.values());
    indices.filter_map(json::index)
}

fn of_node(root: &Root, node: &Node) -> Result<Option<Instancing>, Reason> {
    let extension =
        node.extensions.as_ref().and_then(|extensions| extensions.others.get(EXTENSION));
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

/// How many instances there are: all attributes have as many, those of unknown name too.
fn same_count(root: &Root, attributes: &Map<String, Value>) -> Result<usize, Reason> {
    let mut count = None;
    for (name, value) in attributes {
        let here = accessor(root, name, value)?.1.count.0;
        if *count.get_or_insert(here) != here {
            return Err(Reason::malformed("its attributes have not the same number of elements"));
        }
    }
    let count = count.ok_or_else(|| Reason::malformed("it has no attributes"))?;
    usize::try_from(count)
        .map_err(|_| Reason::malformed("it has more elements than there are numbers"))
}

fn accessor<'a>(
    root: &'a Root,
    name: &str,
    value: &Value,
) -> Result<(usize, &'a Accessor), Reason> {
    let index = json::index(value);
    let found = index.and_then(|index| Some((index, root.accessors.get(index)?)));
    found.ok_or_else(|| {
        let name = crate::error::quoted(name);
        Reason::malformed(format!(
            "its attribute {name} is not one of the {} accessors",
            root.accessors.len()
        ))
    })
}
