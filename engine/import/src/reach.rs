//! The elements of a file that the shown scene uses, directly or by reference.

use gltf::Semantic;
use gltf::json::mesh::Primitive;
use gltf::json::validation::Checked;
use gltf::json::{Material, Node, Root, texture};

use crate::element::{Element, Kind};
use crate::extensions::{image_of, instance_accessors, source_buffer};

/// The elements of a file that the shown scene uses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reach {
    is_used: [Vec<bool>; Kind::ALL.len()],
}

impl Reach {
    /// Follows all references from the shown scene, except from animation channels whose nodes are
    /// not shown.
    pub(crate) fn of(root: &Root) -> Self {
        let is_used = Kind::ALL.map(|kind| vec![false; kind.count(root)]);
        let mut reach = Self { is_used };
        let mut pending = Vec::new();
        if let Some(scene) = shown_scene(root) {
            reach.mark(Kind::Scene.at(scene), &mut pending);
        }
        reach.follow(root, &mut pending);
        for index in 0..root.animations.len() {
            reach.mark(Kind::Animation.at(index), &mut pending);
        }
        reach.follow(root, &mut pending);
        reach
    }

    /// Returns true if the shown scene uses an element; false if the element does not exist.
    pub(crate) fn is_used(&self, element: Element) -> bool {
        let of_kind = self.is_used.get(element.kind as usize);
        of_kind.and_then(|of_kind| of_kind.get(element.index)) == Some(&true)
    }

    fn mark(&mut self, element: Element, pending: &mut Vec<Element>) {
        let of_kind = self.is_used.get_mut(element.kind as usize);
        if let Some(is_used @ false) = of_kind.and_then(|of_kind| of_kind.get_mut(element.index)) {
            *is_used = true;
            pending.push(element);
        }
    }

    fn follow(&mut self, root: &Root, pending: &mut Vec<Element>) {
        let mut found = Vec::new();
        while let Some(element) = pending.pop() {
            references(root, element, &mut |to| found.push(to));
            if element.kind == Kind::Animation {
                found = self.channel_accessors(root, element.index);
            }
            found.drain(..).for_each(|to| self.mark(to, pending));
        }
    }

    fn channel_accessors(&self, root: &Root, animation: usize) -> Vec<Element> {
        let Some(animation) = root.animations.get(animation) else { return Vec::new() };
        let channels = animation.channels.iter();
        let shown =
            channels.filter(|channel| self.is_used(Kind::Node.at(channel.target.node.value())));
        let samplers = shown.filter_map(|channel| animation.samplers.get(channel.sampler.value()));
        let accessors = samplers.flat_map(|sampler| [sampler.input, sampler.output]);
        accessors.map(|accessor| Kind::Accessor.at(accessor.value())).collect()
    }
}

/// Returns the index of the shown scene: the scene that the file names, else its first. `None` if
/// the file has no scenes, until [`check::forest`](crate::check::forest) adds one.
pub(crate) fn shown_scene(root: &Root) -> Option<usize> {
    let named = root.scene.map(|scene| scene.value());
    let named = named.filter(|named| *named < root.scenes.len());
    named.or_else(|| (!root.scenes.is_empty()).then_some(0))
}

/// Calls `visit` with each element to which an element refers, whether it exists or not.
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
            accessor.into_iter().for_each(|accessor| visit(Kind::Accessor.at(accessor.value())));
        }
        Kind::Material => {
            let slots = root.materials.get(index).into_iter().flat_map(texture_slots);
            slots.for_each(|(_, texture)| visit(Kind::Texture.at(texture)));
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
            let parts =
                sparse.flat_map(|sparse| [sparse.indices.buffer_view, sparse.values.buffer_view]);
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
    let light = extensions.and_then(|extensions| extensions.khr_lights_punctual.as_ref());
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
        accessors_of(primitive).for_each(&mut *visit);
    }
}

/// Returns the accessors that a primitive uses.
pub(crate) fn accessors_of(primitive: &Primitive) -> impl Iterator<Item = Element> {
    let is_shown = |name: &Checked<Semantic>| matches!(name, Checked::Valid(name) if !matches!(name, Semantic::Extras(_)));
    let attributes = primitive.attributes.iter().filter(move |(name, _)| is_shown(name));
    let targets = primitive.targets.iter().flatten();
    let targets =
        targets.flat_map(|target| [target.positions, target.normals, target.tangents]).flatten();
    let accessors = attributes.map(|(_, accessor)| *accessor).chain(targets);
    accessors.chain(primitive.indices).map(|accessor| Kind::Accessor.at(accessor.value()))
}

/// The place of a texture in a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum TextureSlot {
    BaseColour,
    MetallicRoughness,
    Normal,
    Occlusion,
    Emission,
}

impl TextureSlot {
    /// Returns true if the texture holds colours and not numbers.
    pub(crate) fn is_colour(self) -> bool {
        matches!(self, Self::BaseColour | Self::Emission)
    }

    /// Returns the slot's name for messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::BaseColour => "base colour texture",
            Self::MetallicRoughness => "metallic-roughness texture",
            Self::Normal => "normal texture",
            Self::Occlusion => "occlusion texture",
            Self::Emission => "emissive texture",
        }
    }
}

/// Returns the slots of a material that have a texture, with its index.
pub(crate) fn texture_slots(material: &Material) -> impl Iterator<Item = (TextureSlot, usize)> {
    let metallic = &material.pbr_metallic_roughness;
    let index = |info: &Option<texture::Info>| info.as_ref().map(|info| info.index);
    let slots = [
        (TextureSlot::BaseColour, index(&metallic.base_color_texture)),
        (TextureSlot::MetallicRoughness, index(&metallic.metallic_roughness_texture)),
        (TextureSlot::Normal, material.normal_texture.as_ref().map(|normal| normal.index)),
        (TextureSlot::Occlusion, material.occlusion_texture.as_ref().map(|used| used.index)),
        (TextureSlot::Emission, index(&material.emissive_texture)),
    ];
    slots.into_iter().filter_map(|(slot, texture)| Some((slot, texture?.value())))
}
