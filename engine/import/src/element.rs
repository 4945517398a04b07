//! The elements of a file's lists.

use std::fmt;

use gltf::json::Root;

use crate::extensions::lights;

/// The lists of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Kind {
    Accessor,
    Animation,
    Buffer,
    View,
    Camera,
    Image,
    Light,
    Material,
    Mesh,
    Node,
    Sampler,
    Scene,
    Skin,
    Texture,
}

impl Kind {
    pub(crate) const ALL: [Self; 14] = [
        Self::Accessor,
        Self::Animation,
        Self::Buffer,
        Self::View,
        Self::Camera,
        Self::Image,
        Self::Light,
        Self::Material,
        Self::Mesh,
        Self::Node,
        Self::Sampler,
        Self::Scene,
        Self::Skin,
        Self::Texture,
    ];

    pub(crate) fn at(self, index: usize) -> Element {
        Element { kind: self, index }
    }

    /// Returns the name of an element of the list, in the singular.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Accessor => "accessor",
            Self::Animation => "animation",
            Self::Buffer => "buffer",
            Self::View => "buffer view",
            Self::Camera => "camera",
            Self::Image => "image",
            Self::Light => "light",
            Self::Material => "material",
            Self::Mesh => "mesh",
            Self::Node => "node",
            Self::Sampler => "sampler",
            Self::Scene => "scene",
            Self::Skin => "skin",
            Self::Texture => "texture",
        }
    }

    pub(crate) fn count(self, root: &Root) -> usize {
        match self {
            Self::Accessor => root.accessors.len(),
            Self::Animation => root.animations.len(),
            Self::Buffer => root.buffers.len(),
            Self::View => root.buffer_views.len(),
            Self::Camera => root.cameras.len(),
            Self::Image => root.images.len(),
            Self::Light => lights(root).len(),
            Self::Material => root.materials.len(),
            Self::Mesh => root.meshes.len(),
            Self::Node => root.nodes.len(),
            Self::Sampler => root.samplers.len(),
            Self::Scene => root.scenes.len(),
            Self::Skin => root.skins.len(),
            Self::Texture => root.textures.len(),
        }
    }
}

/// An element of a list of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Element {
    pub(crate) kind: Kind,
    pub(crate) index: usize,
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.kind.name(), self.index)
    }
}
