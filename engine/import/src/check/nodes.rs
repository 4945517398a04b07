//! Checks of nodes: their references, and that they are a forest.

use gltf::json::{Node, Root};

use super::meshes;
use super::numbers::{finite, in_range};
use crate::element::Kind;
use crate::error::{At, Fault, Reason};
use crate::extensions::lights;
use crate::notes::Note;
use crate::verdict::Verdict;

/// A part of a node that can be invalid individually.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NodePart {
    Camera,
    Light,
    Mesh,
}

/// Checks all nodes and scenes. Shown nodes form a forest with valid references and numbers
/// already; weights that do not fit the targets of their meshes are removed. Returns the parents of
/// the shown nodes.
pub(super) fn check(root: &mut Root, verdict: &mut Verdict) -> Result<Vec<Option<u32>>, Fault> {
    let mut parents: Vec<Option<u32>> = vec![None; root.nodes.len()];
    let mut are_all_shown = true;
    for index in 0..root.nodes.len() {
        let element = Kind::Node.at(index);
        if verdict.is_used(element) {
            mend_weights(root, index, verdict)?;
            adopt_children(&mut parents, index, root)?;
            continue;
        }
        are_all_shown = false;
        let Some(node) = root.nodes.get(index) else { continue };
        let checked = check_references(root, node)
            .map_err(|(_, reason)| reason)
            .and_then(|()| check_weights(root, node))
            .and_then(|()| check_numbers(node))
            .and_then(|()| check_children(node, root.nodes.len()))
            .at(|| element.to_string());
        verdict.judge(element, checked)?;
    }
    let root = &*root;
    if !are_all_shown && let Err(fault) = check_forest(root) {
        verdict.notes.add(|| {
            let (object, reason) = fault.into_parts();
            Note::new(object, format!("{reason}; not all of that is shown"))
        });
    }
    check_scenes(root, verdict)?;
    Ok(parents)
}

/// Removes weights of a node that do not fit its mesh.
fn mend_weights(root: &mut Root, index: usize, verdict: &mut Verdict) -> Result<(), Fault> {
    let Some(node) = root.nodes.get(index) else { return Ok(()) };
    let Err(reason) = check_weights(root, node) else { return Ok(()) };
    root.nodes.get_mut(index).into_iter().for_each(|node| node.weights = None);
    verdict.repair(reason.of(Kind::Node.at(index).to_string()), "they are ignored")
}

/// Checks that all nodes are a forest, whether they are shown or not.
///
/// # Errors
/// A node with two parents, or that is its own ancestor.
fn check_forest(root: &Root) -> Result<(), Fault> {
    let mut parents: Vec<Option<u32>> = vec![None; root.nodes.len()];
    for index in 0..root.nodes.len() {
        adopt_children(&mut parents, index, root)?;
    }
    check_ancestors(&parents)
}

fn check_children(node: &Node, count: usize) -> Result<(), Reason> {
    let mut children = node.children.iter().flatten();
    children.try_for_each(|child| in_range("child node", child.value(), count))
}

/// Checks that a node has one weight per target of its mesh.
fn check_weights(root: &Root, node: &Node) -> Result<(), Reason> {
    let Some(mesh) = node.mesh.and_then(|mesh| root.get(mesh)) else { return Ok(()) };
    meshes::check_weights(node.weights.as_deref(), meshes::target_count(mesh))
}

/// Checks the references of a node except its children.
///
/// # Errors
/// The first part of the node that is invalid.
pub(super) fn check_references(root: &Root, node: &Node) -> Result<(), (NodePart, Reason)> {
    let of = |part: NodePart| move |reason: Reason| (part, reason);
    if let Some(camera) = node.camera {
        in_range("camera", camera.value(), root.cameras.len()).map_err(of(NodePart::Camera))?;
    }
    if let Some(skin) = node.skin {
        in_range("skin", skin.value(), root.skins.len()).map_err(of(NodePart::Mesh))?;
    }
    if let Some(mesh) = node.mesh {
        in_range("mesh", mesh.value(), root.meshes.len()).map_err(of(NodePart::Mesh))?;
    }
    let light =
        node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    if let Some(light) = light {
        let checked = in_range("light", light.light.value(), lights(root).len());
        checked.map_err(of(NodePart::Light))?;
    }
    Ok(())
}

/// Checks the numbers of a node's transform.
pub(super) fn check_numbers(node: &Node) -> Result<(), Reason> {
    finite("matrix", node.matrix.as_ref().map_or(&[], |matrix| matrix))?;
    finite("translation", node.translation.as_ref().map_or(&[], |translation| translation))?;
    finite("rotation", node.rotation.as_ref().map_or(&[], |rotation| &rotation.0))?;
    finite("scale", node.scale.as_ref().map_or(&[], |scale| scale))
}

/// Notes the parent of a node's children; a child may have only one parent.
fn adopt_children(parents: &mut [Option<u32>], index: usize, root: &Root) -> Result<(), Fault> {
    let node = root.nodes.get(index);
    let children = node.and_then(|node| node.children.as_deref()).unwrap_or_default();
    for child in children.iter().map(|child| child.value()) {
        let Some(parent) = parents.get_mut(child) else { continue };
        if let Some(other) = parent.replace(index as u32) {
            let text = format!("node {child} is a child of node {other} already");
            return Err(Reason::malformed(text).of(format!("node {index}, children")));
        }
    }
    Ok(())
}

/// Checks that every node leads to a root. Each node has at most one parent, so other nodes are on
/// a cycle or below one.
fn check_ancestors(parents: &[Option<u32>]) -> Result<(), Fault> {
    let mut leads_to_root = vec![false; parents.len()];
    for start in 0..parents.len() {
        let mut at = start;
        let mut steps = 0;
        while let Some(parent) = parents[at].filter(|_| !leads_to_root[at]) {
            at = parent as usize;
            steps += 1;
            // More steps upwards than there are nodes end on the cycle.
            if steps > parents.len() {
                return Err(Reason::malformed("it is its own ancestor").of(format!("node {at}")));
            }
        }
        at = start;
        while !std::mem::replace(&mut leads_to_root[at], true) {
            at = parents[at].map_or(at, |parent| parent as usize);
        }
    }
    Ok(())
}

fn check_scenes(root: &Root, verdict: &mut Verdict) -> Result<(), Fault> {
    // The last scene that lists each node.
    let mut seen_in: Vec<Option<u32>> = vec![None; root.nodes.len()];
    for (index, scene) in root.scenes.iter().enumerate() {
        let mut nodes = scene.nodes.iter().map(|node| node.value());
        let checked = nodes.try_for_each(|node| {
            in_range("node", node, root.nodes.len())?;
            match seen_in[node].replace(index as u32) {
                Some(scene) if scene as usize == index => {
                    Err(Reason::malformed(format!("node {node} is in it twice")))
                }
                _ => Ok(()),
            }
        });
        verdict.judge(Kind::Scene.at(index), checked.at(|| format!("scene {index}")))?;
    }
    Ok(())
}
