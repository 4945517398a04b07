//! Empties all parts of a file that are not shown, so that their faults do not affect later stages.

use std::collections::BTreeMap;

use gltf::animation::Property;
use gltf::json::Root;
use gltf::json::validation::Checked;

use crate::element::{Element, Kind};
use crate::notes::Note;
use crate::placeholder::Placeholder;
use crate::reach::shown_scene;
use crate::verdict::Verdict;

/// Removes the animation channels of nodes that are not shown, and of the weights of meshes that
/// were left out. Notes the removed channels.
pub(crate) fn channels(root: &mut Root, verdict: &mut Verdict) {
    let nodes = root.nodes.len();
    for (index, animation) in root.animations.iter_mut().enumerate() {
        animation.channels.retain(|channel| {
            let is_of_weights = channel.target.path == Checked::Valid(Property::MorphTargetWeights);
            !(is_of_weights && verdict.has_lost_mesh(channel.target.node.value()))
        });
        let before = animation.channels.len();
        animation.channels.retain(|channel| {
            let node = channel.target.node.value();
            // A node that does not exist breaks the animation.
            node >= nodes || verdict.is_used(Kind::Node.at(node))
        });
        let what = "a channel moves a node that is not in the scene, and is left out";
        let dropped = before - animation.channels.len();
        let name = animation.name.clone().unwrap_or_default();
        verdict.notes.count(what, dropped, || match name.as_str() {
            "" => format!("animation {index}"),
            name => format!("animation {index} ({})", crate::error::quoted(name)),
        });
    }
}

/// Keeps only roots in the node list of the shown scene. `parents` holds the parent of each node
/// that the scene reaches, or of every node if the scene does not reach the parent.
pub(crate) fn scene_roots(root: &mut Root, parents: &[Option<u32>], verdict: &mut Verdict) {
    let mut outside: BTreeMap<usize, usize> = BTreeMap::new();
    for (index, node) in root.nodes.iter().enumerate() {
        if !verdict.is_used(Kind::Node.at(index)) {
            let children = node.children.iter().flatten();
            outside.extend(children.map(|child| (child.value(), index)));
        }
    }
    let Some(scene) = shown_scene(root).and_then(|scene| root.scenes.get_mut(scene)) else {
        return;
    };
    let notes = &mut verdict.notes;
    scene.nodes.retain(|node| {
        let node = node.value();
        if let Some(parent) = parents.get(node).copied().flatten() {
            notes.count_as("named root with its parent", 1, || {
                let reason =
                    format!("a child of node {parent} and a root of the scene: shown once");
                Note::new(format!("node {node}"), reason)
            });
            return false;
        }
        if let Some(parent) = outside.get(&node) {
            notes.count_as("named root without its parent", 1, || {
                let reason = format!(
                    "a root of the scene, although a child of node {parent}, which is not in the \
                     scene: shown without the place of that"
                );
                Note::new(format!("node {node}"), reason)
            });
        }
        true
    });
}

/// Replaces all elements that are not shown with blanks.
pub(crate) fn elements(root: &mut Root, verdict: &Verdict) {
    // Animations and images that are only partly shown, or not at all, may still refer to broken
    // elements. These are found before anything is emptied.
    let broken: Vec<Element> = [Kind::Accessor, Kind::Animation, Kind::Buffer, Kind::View]
        .into_iter()
        .flat_map(|kind| (0..kind.count(root)).map(move |index| kind.at(index)))
        .filter(|element| verdict.is_used(*element) && !verdict.is_kept(root, *element))
        .collect();
    let is_kept =
        |element: Element| verdict.is_used(element) && broken.binary_search(&element).is_err();
    empty(&mut root.accessors, Kind::Accessor, is_kept);
    empty(&mut root.animations, Kind::Animation, is_kept);
    empty(&mut root.buffers, Kind::Buffer, is_kept);
    empty(&mut root.buffer_views, Kind::View, is_kept);
    empty(&mut root.cameras, Kind::Camera, is_kept);
    empty(&mut root.images, Kind::Image, is_kept);
    empty(&mut root.materials, Kind::Material, is_kept);
    empty(&mut root.meshes, Kind::Mesh, is_kept);
    empty(&mut root.nodes, Kind::Node, is_kept);
    empty(&mut root.samplers, Kind::Sampler, is_kept);
    empty(&mut root.scenes, Kind::Scene, is_kept);
    empty(&mut root.skins, Kind::Skin, is_kept);
    empty(&mut root.textures, Kind::Texture, is_kept);
    let lights =
        root.extensions.as_mut().and_then(|extensions| extensions.khr_lights_punctual.as_mut());
    lights.into_iter().for_each(|light| empty(&mut light.lights, Kind::Light, is_kept));
    // Every view refers to a buffer.
    if root.buffers.is_empty() {
        root.buffer_views.clear();
    }
    for image in &mut root.images {
        let view = image.buffer_view.map(|view| Kind::View.at(view.value()));
        if view.is_some_and(|view| !is_kept(view)) {
            *image = Placeholder::blank();
        }
    }
}

fn empty<T: Placeholder>(list: &mut [T], kind: Kind, is_kept: impl Fn(Element) -> bool) {
    for (index, element) in list.iter_mut().enumerate() {
        if !is_kept(kind.at(index)) {
            *element = T::blank();
        }
    }
}
