//! Leaves out the parts of the shown scene that need a broken element.

use gltf::json::extensions::scene::khr_lights_punctual as khr;
use gltf::json::mesh::{MorphTarget, Primitive};
use gltf::json::{Node, Root};

use crate::element::{Element, Kind};
use crate::error::Fault;
use crate::extensions::instance_accessors;
use crate::placeholder::Placeholder;
use crate::reach::accessors_of;
use crate::verdict::Verdict;

/// Leaves out everything in the shown scene that needs a broken element, with a note per kind of
/// fault. Elements that only these parts used are no longer in use.
pub(crate) fn dependants(root: &mut Root, verdict: &mut Verdict) -> Result<(), Fault> {
    if !verdict.has_faults() {
        return Ok(());
    }
    textures(root, verdict)?;
    meshes(root, verdict)?;
    nodes(root, verdict)?;
    verdict.follow_again(root);
    Ok(())
}

fn textures(root: &mut Root, verdict: &mut Verdict) -> Result<(), Fault> {
    for (index, texture) in root.textures.iter_mut().enumerate() {
        let element = Kind::Texture.at(index);
        if !verdict.is_used(element) {
            continue;
        }
        if let Some(fault) = verdict.take_fault(element) {
            *texture = Placeholder::blank();
            verdict.repair(fault, "what has it is shown without it")?;
        }
        let sampler = texture.sampler.map(|sampler| Kind::Sampler.at(sampler.value()));
        if let Some(fault) = sampler.and_then(|sampler| verdict.own_fault(sampler)).cloned() {
            texture.sampler = None;
            verdict.repair(fault, "textures have the default one instead")?;
        }
    }
    Ok(())
}

fn meshes(root: &mut Root, verdict: &mut Verdict) -> Result<(), Fault> {
    for mesh in 0..root.meshes.len() {
        let element = Kind::Mesh.at(mesh);
        if !verdict.is_used(element) {
            continue;
        }
        if let Some(fault) = verdict.take_fault(element) {
            root.meshes.get_mut(mesh).into_iter().for_each(|mesh| *mesh = Placeholder::blank());
            verdict.leave_out(fault, "it is left out")?;
        }
        let count = root.meshes.get(mesh).map_or(0, |mesh| mesh.primitives.len());
        for number in 0..count {
            let given = root.meshes.get(mesh).and_then(|mesh| mesh.primitives.get(number));
            let Some(given) = given else { continue };
            let material = given.material.map(|material| Kind::Material.at(material.value()));
            let material = material.and_then(|material| verdict.own_fault(material)).cloned();
            let mut accessors = accessors_of(given);
            let accessor = accessors.find_map(|accessor| verdict.fault_of(root, accessor)).cloned();
            drop(accessors);
            let given = root.meshes.get_mut(mesh).and_then(|mesh| mesh.primitives.get_mut(number));
            let Some(given) = given else { continue };
            if let Some(fault) = accessor {
                empty_primitive(given);
                verdict.leave_out(fault, "primitives with it are left out")?;
            } else if let Some(fault) = material {
                given.material = None;
                verdict.repair(fault, "the default material is shown instead")?;
            }
        }
    }
    Ok(())
}

/// Makes a primitive draw nothing, but keeps its number of morph targets.
pub(crate) fn empty_primitive(primitive: &mut Primitive) {
    let none = MorphTarget { positions: None, normals: None, tangents: None };
    let targets = primitive.targets.as_ref().map(|targets| vec![none; targets.len()]);
    primitive.attributes.clear();
    (primitive.indices, primitive.material, primitive.targets) = (None, None, targets);
    primitive.mode = Default::default();
}

fn nodes(root: &mut Root, verdict: &mut Verdict) -> Result<(), Fault> {
    for index in 0..root.nodes.len() {
        let element = Kind::Node.at(index);
        if !verdict.is_used(element) {
            continue;
        }
        if let Some(fault) = verdict.take_fault(element) {
            verdict.empty_node(index, root);
            verdict.leave_out(fault, "it is left out with all below it")?;
        }
        let Some(node) = root.nodes.get(index) else { continue };
        let camera = node.camera.map(|camera| Kind::Camera.at(camera.value()));
        let camera = camera.and_then(|camera| verdict.own_fault(camera)).cloned();
        let light = light_of(node).and_then(|light| verdict.own_fault(light)).cloned();
        let skin = node.skin.map(|skin| Kind::Skin.at(skin.value()));
        let skin = skin.and_then(|skin| verdict.fault_of(root, skin)).cloned();
        let placed_by = |accessor: usize| verdict.fault_of(root, Kind::Accessor.at(accessor));
        let instances = { instance_accessors(node).find_map(placed_by).cloned() };
        let mesh = node.mesh.map(|mesh| Kind::Mesh.at(mesh.value()));
        let Some(node) = root.nodes.get_mut(index) else { continue };
        if let Some(fault) = camera {
            node.camera = None;
            verdict.repair(fault, "it is left out")?;
        }
        if let Some(fault) = light {
            remove_light(node);
            verdict.repair(fault, "it is left out")?;
        }
        if let Some(fault) = skin {
            verdict.remove_mesh(index, root);
            verdict.leave_out(fault, "meshes on it are left out")?;
        } else if let Some(fault) = instances.filter(|_| mesh.is_some()) {
            verdict.remove_mesh(index, root);
            verdict.leave_out(fault, "meshes whose instances it places are left out")?;
        } else if mesh.is_some_and(|mesh| verdict.is_noted(mesh)) {
            verdict.remove_mesh(index, root);
        }
    }
    Ok(())
}

fn light_of(node: &Node) -> Option<Element> {
    let named: Option<&khr::KhrLightsPunctual> =
        node.extensions.as_ref()?.khr_lights_punctual.as_ref();
    Some(Kind::Light.at(named?.light.value()))
}

/// Removes the light of a node.
pub(crate) fn remove_light(node: &mut Node) {
    if let Some(extensions) = &mut node.extensions {
        extensions.khr_lights_punctual = None;
    }
}

#[cfg(test)]
mod tests {
    use gltf::json::Index;

    use super::*;
    use crate::error::Reason;
    use crate::losses::Losses;
    use crate::notes::Notes;
    use crate::reach::Reach;

    #[test]
    fn whatever_is_noted_as_left_out_is_empty() {
        let mesh = gltf::json::Mesh { weights: Some(vec![1.0]), ..Placeholder::blank() };
        let broken = Node { children: Some(vec![Index::new(1)]), ..Node::default() };
        let shown = Node { mesh: Some(Index::new(0)), ..Node::default() };
        let nodes = vec![Index::new(0), Index::new(2)];
        let mut root = Root {
            meshes: vec![mesh],
            nodes: vec![broken, Node::default(), shown],
            scenes: vec![gltf::json::Scene { nodes, ..Placeholder::blank() }],
            ..Root::default()
        };
        let mut verdict = Verdict::new(Reach::of(&root), Losses::default(), Notes::default());
        for element in [Kind::Node.at(0), Kind::Mesh.at(0)] {
            let fault = Reason::malformed("it is broken").of(element.to_string());
            verdict.judge::<()>(element, Err(fault)).expect("it is held");
        }
        dependants(&mut root, &mut verdict).expect("they are left out");
        assert!(root.nodes[0].children.is_none() && !verdict.is_used(Kind::Node.at(1)));
        assert!(root.meshes[0].weights.is_none() && root.nodes[2].mesh.is_none());
        assert!(verdict.has_lost_mesh(0) && verdict.has_lost_mesh(2));
    }
}
