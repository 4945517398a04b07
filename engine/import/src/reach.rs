//! The elements of a file that the shown scene uses, directly or through references.

use gltf::Semantic;
use gltf::json::validation::Checked;
use gltf::json::{Material, Node, Root};

use crate::element::{Element, Kind, Need};
use crate::extensions::{image_of, instance_accessors, source_buffer};

/// The need of the scene for each element of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reach {
    needs: [Vec<Need>; Kind::ALL.len()],
}

impl Reach {
    /// Follows all references from the scene that is shown. Channels of animations whose nodes it
    /// does not reach are not followed.
    pub(crate) fn of(root: &Root) -> Self {
        let needs = Kind::ALL.map(|kind| vec![Need::None; kind.count(root)]);
        let mut reach = Self { needs };
        let mut pending = Vec::new();
        match shown_scene(root) {
            Some(scene) => reach.mark(Kind::Scene.at(scene), Need::Required, &mut pending),
            None => {
                for node in roots_without_scene(root) {
                    reach.mark(Kind::Node.at(node), Need::Required, &mut pending);
                }
            }
        }
        reach.follow(root, &mut pending);
        for index in 0..root.animations.len() {
            reach.mark(Kind::Animation.at(index), Need::Optional, &mut pending);
        }
        reach.follow(root, &mut pending);
        reach
    }

    /// Returns the need of the scene for an element; none if there is no such element.
    pub(crate) fn need(&self, element: Element) -> Need {
        let needs = self.needs.get(element.kind as usize);
        needs.and_then(|needs| needs.get(element.index)).copied().unwrap_or_default()
    }

    fn mark(&mut self, element: Element, need: Need, pending: &mut Vec<Element>) {
        let needs = self.needs.get_mut(element.kind as usize);
        if let Some(known) = needs.and_then(|needs| needs.get_mut(element.index))
            && *known < need
        {
            *known = need;
            pending.push(element);
        }
    }

    fn follow(&mut self, root: &Root, pending: &mut Vec<Element>) {
        let mut found = Vec::new();
        while let Some(element) = pending.pop() {
            let need = self.need(element);
            references(root, element, &mut |to| found.push(to));
            if element.kind == Kind::Animation {
                found = self.channel_accessors(root, element.index);
            }
            for to in found.drain(..) {
                let need = if to.kind == Kind::Image { Need::Optional } else { need };
                self.mark(to, need, pending);
            }
        }
    }

    fn channel_accessors(&self, root: &Root, animation: usize) -> Vec<Element> {
        let Some(animation) = root.animations.get(animation) else { return Vec::new() };
        let channels = animation.channels.iter();
        let shown = channels.filter(|channel| {
            self.need(Kind::Node.at(channel.target.node.value())) == Need::Required
        });
        let samplers = shown.filter_map(|channel| animation.samplers.get(channel.sampler.value()));
        let accessors = samplers.flat_map(|sampler| [sampler.input, sampler.output]);
        accessors.map(|accessor| Kind::Accessor.at(accessor.value())).collect()
    }
}

/// Returns the index of the scene that is shown: the one that the file names, else its first;
/// `None` if it has no scenes.
pub(crate) fn shown_scene(root: &Root) -> Option<usize> {
    let named = root.scene.map(|scene| scene.value());
    named.or_else(|| (!root.scenes.is_empty()).then_some(0))
}

/// Returns the nodes that are shown by a file without scenes: all that have no parent.
pub(crate) fn roots_without_scene(root: &Root) -> Vec<usize> {
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    (0..root.nodes.len()).filter(|node| is_child.get(*node) == Some(&false)).collect()
}

/// Calls `visit` with each element that another one refers to, whether it exists or not.
pub(crate) fn references(root: &Root, element: Element, visit: &mut dyn FnMut(Element)) {
    let index = element.index;
    match element.kind {
        Kind::Scene => {
            let nodes = root.scenes.get(index).into_iter().flat_map(|scene| &scene.nodes);
            nodes.for_each(|node| visit(Kind::Node.at(node.value())));
        }
        Kind::Node => root.nodes.get(index).into_iter().for_each(|node| of_node(node, visit)),
        Kind::Mesh => of_mesh(root, index, visit),
        Kind::Skin => {
            let skin = root.skins.get(index);
            let accessor = skin.and_then(|skin| skin.inverse_bind_matrices);
            accessor.into_iter().for_each(|it| visit(Kind::Accessor.at(it.value())));
        }
        Kind::Material => {
            let shown = root.materials.get(index).into_iter().flat_map(shown_textures);
            shown.for_each(|texture| visit(Kind::Texture.at(texture)));
        }
        Kind::Texture => {
            let Some(texture) = root.textures.get(index) else { return };
            let sampler = texture.sampler.into_iter();
            sampler.for_each(|sampler| visit(Kind::Sampler.at(sampler.value())));
            let image = image_of(texture).into_iter();
            image.for_each(|image| visit(Kind::Image.at(image)));
        }
        Kind::Image => {
            let view = root.images.get(index).and_then(|image| image.buffer_view);
            view.into_iter().for_each(|view| visit(Kind::View.at(view.value())));
        }
        Kind::Accessor => {
            let Some(accessor) = root.accessors.get(index) else { return };
            let sparse = accessor.sparse.iter();
            let parts = sparse.flat_map(|it| [it.indices.buffer_view, it.values.buffer_view]);
            let views = accessor.buffer_view.into_iter().chain(parts);
            views.for_each(|view| visit(Kind::View.at(view.value())));
        }
        Kind::View => {
            let Some(view) = root.buffer_views.get(index) else { return };
            visit(Kind::Buffer.at(view.buffer.value()));
            let compressed = source_buffer(view).into_iter();
            compressed.for_each(|buffer| visit(Kind::Buffer.at(buffer)));
        }
        Kind::Animation => {
            let Some(animation) = root.animations.get(index) else { return };
            let channels = animation.channels.iter();
            let samplers =
                channels.filter_map(|channel| animation.samplers.get(channel.sampler.value()));
            for accessor in samplers.flat_map(|sampler| [sampler.input, sampler.output]) {
                visit(Kind::Accessor.at(accessor.value()));
            }
        }
        Kind::Buffer | Kind::Camera | Kind::Light | Kind::Sampler => {}
    }
}

fn of_node(node: &Node, visit: &mut dyn FnMut(Element)) {
    let children = node.children.iter().flatten();
    children.for_each(|child| visit(Kind::Node.at(child.value())));
    node.camera.into_iter().for_each(|camera| visit(Kind::Camera.at(camera.value())));
    let extensions = node.extensions.as_ref();
    let light = extensions.and_then(|it| it.khr_lights_punctual.as_ref());
    light.into_iter().for_each(|light| visit(Kind::Light.at(light.light.value())));
    let Some(mesh) = node.mesh else { return };
    visit(Kind::Mesh.at(mesh.value()));
    node.skin.into_iter().for_each(|skin| visit(Kind::Skin.at(skin.value())));
    instance_accessors(node).for_each(|accessor| visit(Kind::Accessor.at(accessor)));
}

fn of_mesh(root: &Root, index: usize, visit: &mut dyn FnMut(Element)) {
    let primitives = root.meshes.get(index).into_iter().flat_map(|mesh| &mesh.primitives);
    for primitive in primitives {
        let material = primitive.material.into_iter();
        material.for_each(|material| visit(Kind::Material.at(material.value())));
        let is_shown = |name: &Checked<Semantic>| matches!(name, Checked::Valid(name) if !matches!(name, Semantic::Extras(_)));
        let attributes = primitive.attributes.iter().filter(|(name, _)| is_shown(name));
        let targets = primitive.targets.iter().flatten();
        let targets = targets.flat_map(|it| [it.positions, it.normals, it.tangents]).flatten();
        let accessors = attributes.map(|(_, accessor)| *accessor).chain(targets);
        for accessor in accessors.chain(primitive.indices) {
            visit(Kind::Accessor.at(accessor.value()));
        }
    }
}

/// Returns the textures that a material shows, possibly with repetitions.
fn shown_textures(material: &Material) -> impl Iterator<Item = usize> {
    let pbr = &material.pbr_metallic_roughness;
    let slots = [
        pbr.base_color_texture.as_ref().map(|it| it.index),
        pbr.metallic_roughness_texture.as_ref().map(|it| it.index),
        material.normal_texture.as_ref().map(|it| it.index),
        material.occlusion_texture.as_ref().map(|it| it.index),
        material.emissive_texture.as_ref().map(|it| it.index),
    ];
    slots.into_iter().flatten().map(|texture| texture.value())
}
