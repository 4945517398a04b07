//! Empty elements without references: they replace elements that are broken or not shown.

use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::camera::{Perspective, Type as CameraType};
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type as LightType};
use gltf::json::texture::Sampler;
use gltf::json::validation::Checked;
use gltf::json::{
    Accessor, Animation, Buffer, Camera, Image, Index, Material, Mesh, Node, Scene, Skin, Texture,
    buffer,
};
use serde_json::Value;

/// An element of a list of the file that has an empty form.
pub(crate) trait Placeholder: Sized {
    /// Returns an element without references that is as valid as possible.
    fn blank() -> Self;

    /// Returns the blank element that replaces an unreadable one.
    fn unreadable(_given: &Value) -> Self {
        Self::blank()
    }
}

impl Placeholder for Accessor {
    fn blank() -> Self {
        Self {
            buffer_view: None,
            byte_offset: None,
            count: 1_u64.into(),
            component_type: Checked::Valid(GenericComponentType(ComponentType::F32)),
            extensions: None,
            extras: None,
            type_: Checked::Valid(Type::Scalar),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
        }
    }
}

impl Placeholder for Animation {
    fn blank() -> Self {
        let channels = Vec::new();
        let samplers = Vec::new();
        Self { extensions: None, extras: None, channels, name: None, samplers }
    }
}

impl Placeholder for Buffer {
    fn blank() -> Self {
        Self { byte_length: 0_u64.into(), name: None, uri: None, extensions: None, extras: None }
    }
}

impl Placeholder for buffer::View {
    fn blank() -> Self {
        Self {
            buffer: Index::new(0),
            byte_length: 0_u64.into(),
            byte_offset: None,
            byte_stride: None,
            name: None,
            target: None,
            extensions: None,
            extras: None,
        }
    }
}

impl Placeholder for Camera {
    fn blank() -> Self {
        let perspective = Perspective {
            aspect_ratio: None,
            yfov: 1.0,
            zfar: None,
            znear: 0.1,
            extensions: None,
            extras: None,
        };
        Self {
            name: None,
            orthographic: None,
            perspective: Some(perspective),
            type_: Checked::Valid(CameraType::Perspective),
            extensions: None,
            extras: None,
        }
    }
}

impl Placeholder for Image {
    fn blank() -> Self {
        Self {
            buffer_view: None,
            mime_type: None,
            name: None,
            uri: Some(String::new()),
            extensions: None,
            extras: None,
        }
    }
}

impl Placeholder for Light {
    fn blank() -> Self {
        Self {
            color: [1.0; 3],
            extensions: None,
            extras: None,
            intensity: 1.0,
            name: None,
            range: None,
            spot: None,
            type_: Checked::Valid(LightType::Point),
        }
    }
}

impl Placeholder for Material {
    fn blank() -> Self {
        Self::default()
    }
}

impl Placeholder for Mesh {
    fn blank() -> Self {
        let primitives = Vec::new();
        Self { extensions: None, extras: None, name: None, primitives, weights: None }
    }
}

impl Placeholder for Node {
    fn blank() -> Self {
        Self::default()
    }

    /// Keeps the readable children, so that they do not count as roots.
    fn unreadable(given: &Value) -> Self {
        let children = given.get("children").and_then(Value::as_array).into_iter().flatten();
        let index = |child: &Value| u32::try_from(child.as_u64()?).ok();
        Self {
            children: Some(children.filter_map(index).map(Index::new).collect()),
            ..Self::blank()
        }
    }
}

impl Placeholder for Sampler {
    fn blank() -> Self {
        Self::default()
    }
}

impl Placeholder for Scene {
    fn blank() -> Self {
        Self { extensions: None, extras: None, name: None, nodes: Vec::new() }
    }
}

impl Placeholder for Skin {
    fn blank() -> Self {
        Self {
            extensions: None,
            extras: None,
            inverse_bind_matrices: None,
            joints: Vec::new(),
            name: None,
            skeleton: None,
        }
    }
}

impl Placeholder for Texture {
    fn blank() -> Self {
        Self {
            name: None,
            sampler: None,
            // The marker of `gltf` for no source.
            source: Index::new(u32::MAX),
            extensions: None,
            extras: None,
        }
    }
}
