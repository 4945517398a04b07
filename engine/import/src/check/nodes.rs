//! Nodes: what they refer to, and that they are a forest.

use gltf::json::{Node, Root};

use super::{finite, in_range, meshes};
use crate::Limits;
use crate::error::{At, Fault, Reason};

pub(super) fn check(root: &Root, limits: &Limits) -> Result<(), Fault> {
    let count = root.nodes.len();
    if count as u64 > limits.nodes {
        return Err(Reason::too_large("nodes", count as u64, limits.nodes).of("nodes"));
    }
    let mut parents: Vec<Option<u32>> = vec![None; count];
    // There may be very many: all that is asked of a node is asked while it is at hand.
    for (index, node) in root.nodes.iter().enumerate() {
        check_references(root, node)
            .and_then(|()| check_numbers(node))
            .at(|| format!("node {index}"))?;
        adopt_children(&mut parents, index, node)?;
    }
    check_ancestors(&parents)?;
    check_scenes(root, &parents)
}

fn check_references(root: &Root, node: &Node) -> Result<(), Reason> {
    if let Some(camera) = node.camera {
        in_range("camera", camera.value(), root.cameras.len())?;
    }
    if let Some(skin) = node.skin {
        in_range("skin", skin.value(), root.skins.len())?;
    }
    if let Some(mesh) = node.mesh {
        in_range("mesh", mesh.value(), root.meshes.len())?;
        let targets = root.meshes.get(mesh.value()).map_or(0, meshes::target_count);
        meshes::check_weights(node.weights.as_deref(), targets)?;
    }
    let light =
        node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    if let Some(light) = light {
        in_range("light", light.light.value(), super::materials::lights(root).len())?;
    }
    Ok(())
}

fn check_numbers(node: &Node) -> Result<(), Reason> {
    finite("matrix", node.matrix.as_ref().map_or(&[], |matrix| matrix))?;
    finite("translation", node.translation.as_ref().map_or(&[], |translation| translation))?;
    finite("rotation", node.rotation.as_ref().map_or(&[], |rotation| &rotation.0))?;
    finite("scale", node.scale.as_ref().map_or(&[], |scale| scale))?;
    finite("weight", node.weights.as_deref().unwrap_or_default())
}

/// Notes the parent of a node's children, of which each has one at most.
fn adopt_children(parents: &mut [Option<u32>], index: usize, node: &Node) -> Result<(), Fault> {
    let count = parents.len();
    for child in node.children.iter().flatten().map(|child| child.value()) {
        let at = || format!("node {index}, children");
        let parent =
            parents.get_mut(child).ok_or_else(|| Reason::out_of_range("node", child, count));
        if let Some(other) = parent.at(at)?.replace(index as u32) {
            let text = format!("node {child} is a child of node {other} already");
            return Err(Reason::malformed(text).of(at()));
        }
    }
    Ok(())
}

/// Where each node has one parent at most, those that lead to no root are on a circle or hang on one.
fn check_ancestors(parents: &[Option<u32>]) -> Result<(), Fault> {
    let mut leads_to_root = vec![false; parents.len()];
    for start in 0..parents.len() {
        let mut at = start;
        let mut steps = 0;
        while let Some(parent) = parents[at].filter(|_| !leads_to_root[at]) {
            at = parent as usize;
            steps += 1;
            // As many steps up as there are nodes end on the circle.
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

fn check_scenes(root: &Root, parents: &[Option<u32>]) -> Result<(), Fault> {
    if let Some(scene) = root.scene {
        in_range("scene", scene.value(), root.scenes.len()).at(|| "default scene".to_owned())?;
    }
    // The last scene that each node was seen in.
    let mut seen_in: Vec<Option<u32>> = vec![None; parents.len()];
    for (index, scene) in root.scenes.iter().enumerate() {
        for node in scene.nodes.iter().map(|node| node.value()) {
            check_scene_root(node, parents)
                .and_then(|()| match seen_in[node].replace(index as u32) {
                    Some(scene) if scene as usize == index => {
                        Err(Reason::malformed(format!("node {node} is in it twice")))
                    }
                    _ => Ok(()),
                })
                .at(|| format!("scene {index}"))?;
        }
    }
    Ok(())
}

fn check_scene_root(node: usize, parents: &[Option<u32>]) -> Result<(), Reason> {
    in_range("node", node, parents.len())?;
    match parents[node] {
        Some(parent) => {
            Err(Reason::malformed(format!("node {node} is no root, but a child of node {parent}")))
        }
        None => Ok(()),
    }
}
