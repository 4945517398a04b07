//! Extensions of glTF: the supported ones, and their references to other elements.

use gltf::json::buffer::View;
use gltf::json::extensions::scene::khr_lights_punctual::Light;
use gltf::json::{Node, Root, Texture};
use serde_json::{Map, Value};

use crate::error::Reason;

/// The extensions that a file may require. Other required extensions are refused by name; other
/// used extensions are noted.
pub const SUPPORTED_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
];

/// The extension for instances of a node.
pub(crate) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// The extension for images of textures in the format WebP.
const WEBP: &str = "EXT_texture_webp";

/// The extensions for compressed views. The second one also has a newer form of attributes and one
/// more filter.
pub(crate) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Returns the extension of [`MESHOPT`] that an object has, and its value.
pub(crate) fn compression(others: &Map<String, Value>) -> Option<(&'static str, &Value)> {
    MESHOPT.into_iter().find_map(|name| Some((name, others.get(name)?)))
}

/// Returns true if a file lists an extension as used.
pub(crate) fn uses(root: &Root, extension: &str) -> bool {
    debug_assert!(SUPPORTED_EXTENSIONS.contains(&extension));
    root.extensions_used.iter().chain(&root.extensions_required).any(|used| used == extension)
}

/// Returns a number that is an index or a count, even if it is written as `1.0`.
pub(crate) fn index(value: &Value) -> Option<usize> {
    let whole =
        |float: f64| float.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(&float);
    let number = value
        .as_u64()
        .or_else(|| value.as_f64().filter(|value| whole(*value)).map(|value| value as u64));
    number.and_then(|number| usize::try_from(number).ok())
}

/// Returns the lights of `KHR_lights_punctual`.
pub(crate) fn lights(root: &Root) -> &[Light] {
    let extension =
        root.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    extension.map_or(&[], |extension| &extension.lights)
}

/// Returns the accessors of the transforms of a node's instances.
pub(crate) fn instance_accessors(node: &Node) -> impl Iterator<Item = usize> {
    let extension =
        node.extensions.as_ref().and_then(|extensions| extensions.others.get(INSTANCING));
    let attributes =
        extension.and_then(|extension| extension.get("attributes")).and_then(Value::as_object);
    let indices = attributes.into_iter().flat_map(|attributes| attributes.values());
    indices.filter_map(index)
}

/// Returns the compression extension of a view, and its value.
pub(crate) fn compression_of(view: &View) -> Option<(&'static str, &Value)> {
    view.extensions.as_ref().and_then(|all| compression(&all.others))
}

/// Returns the buffer that holds the compressed bytes of a view.
pub(crate) fn source_buffer(view: &View) -> Option<usize> {
    compression_of(view).and_then(|(_, values)| values.get("buffer")).and_then(index)
}

/// Returns the image of a texture that glTF itself names, without extensions.
pub(crate) fn plain_source(texture: &Texture) -> Option<usize> {
    // The marker of `gltf` for no source.
    const NONE: usize = u32::MAX as usize;
    Some(texture.source.value()).filter(|&source| source != NONE)
}

/// Returns the image of a texture that `EXT_texture_webp` names.
pub(crate) fn webp_source(texture: &Texture) -> Result<Option<usize>, Reason> {
    let extension = texture.extensions.as_ref().and_then(|extensions| extensions.others.get(WEBP));
    let Some(source) = extension.and_then(|extension| extension.get("source")) else {
        return Ok(None);
    };
    index(source)
        .map(Some)
        .ok_or_else(|| Reason::malformed(format!("the source of its {WEBP} is not an index")))
}

/// Returns the image that is shown for a texture.
pub(crate) fn image_of(texture: &Texture) -> Option<usize> {
    webp_source(texture).ok().flatten().or(plain_source(texture))
}
