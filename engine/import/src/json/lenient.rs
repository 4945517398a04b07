//! The lenient reader for JSON that `gltf` refuses: each element of its lists is read individually.
//! A fault belongs only to its element, so it refuses the file only if the element is shown.

use std::collections::BTreeSet;

use gltf::json::Root;
use gltf::json::extensions::scene::khr_lights_punctual::Light;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::names::object_name;
use super::{lists, wide, words};
use crate::element::{Element, Kind};
use crate::error::{Fault, Reason};
use crate::notes::{Note, Notes};
use crate::placeholder::Placeholder;

/// A root whose elements are valid JSON structures, or blank with a fault.
pub(crate) struct Parsed {
    pub(crate) root: Root,
    /// The faults of blank elements of the root's lists.
    pub(crate) faults: Vec<(Element, Fault)>,
    /// The names of the extensions of objects, at most 64.
    pub(crate) extension_names: BTreeSet<String>,
}

const LIGHTS: &str = "KHR_lights_punctual";

/// The most unreadable elements: a blank takes more memory than the two characters of a broken
/// element.
const MOST_FAULTS: usize = 4096;

/// Reads the root object of a file.
pub(super) fn parse(mut object: Map<String, Value>, notes: &mut Notes) -> Result<Parsed, Fault> {
    let mut faults = Vec::new();
    let mut lists = Lists { object: &mut object, faults: &mut faults };
    let accessors = lists.take("accessors", Kind::Accessor)?;
    let animations = lists.take_prepared("animations", Kind::Animation, |index, animation| {
        drop_channels_without_node(index, animation, notes);
    })?;
    let buffers = lists.take("buffers", Kind::Buffer)?;
    let buffer_views = lists.take("bufferViews", Kind::View)?;
    let cameras = lists.take("cameras", Kind::Camera)?;
    let images = lists.take("images", Kind::Image)?;
    let materials = lists.take("materials", Kind::Material)?;
    let meshes = lists.take("meshes", Kind::Mesh)?;
    let nodes = lists.take("nodes", Kind::Node)?;
    let samplers = lists.take("samplers", Kind::Sampler)?;
    let scenes = lists.take_prepared("scenes", Kind::Scene, |_, scene| {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    })?;
    let skins = lists.take("skins", Kind::Skin)?;
    let textures = lists.take("textures", Kind::Texture)?;
    let lights = take_lights(&mut object, &mut faults, notes)?;

    let mut rest = Value::Object(object);
    make_whole(&mut rest);
    wide::check(&rest)?;
    // By reference as elements are: readers of each kind would be compiled a second time.
    let mut root: Root = serde_path_to_error::deserialize(&rest).map_err(|error| {
        let object = object_name(String::new(), error.path().iter());
        Reason::malformed(words::sentence(&error.into_inner().to_string())).of(object)
    })?;
    (root.accessors, root.animations, root.buffers) = (accessors, animations, buffers);
    (root.buffer_views, root.cameras, root.images) = (buffer_views, cameras, images);
    (root.materials, root.meshes, root.nodes) = (materials, meshes, nodes);
    (root.samplers, root.scenes, root.skins, root.textures) = (samplers, scenes, skins, textures);
    if !lights.is_empty() {
        let extensions = root.extensions.get_or_insert_default();
        extensions.khr_lights_punctual.get_or_insert_default().lights = lights;
    }
    Ok(Parsed { root, faults, extension_names: BTreeSet::new() })
}

struct Lists<'a> {
    object: &'a mut Map<String, Value>,
    faults: &'a mut Vec<(Element, Fault)>,
}

impl Lists<'_> {
    fn take<T: Placeholder + DeserializeOwned>(
        &mut self,
        key: &str,
        kind: Kind,
    ) -> Result<Vec<T>, Fault> {
        self.take_prepared(key, kind, |_, _| {})
    }

    fn take_prepared<T: Placeholder + DeserializeOwned>(
        &mut self,
        key: &str,
        kind: Kind,
        mut prepare: impl FnMut(usize, &mut Value),
    ) -> Result<Vec<T>, Fault> {
        let Some(value) = self.object.remove(key) else { return Ok(Vec::new()) };
        let Value::Array(list) = value else {
            return Err(Reason::malformed("it must be a list").of(key));
        };
        let mut elements = Vec::with_capacity(list.len().min(1 << 16));
        for (index, mut value) in list.into_iter().enumerate() {
            prepare(index, &mut value);
            let element = kind.at(index);
            let read = read(&mut value, element);
            elements.push(read.or_else(|fault| self.hold(element, fault, &value))?);
        }
        Ok(elements)
    }

    /// Records the fault of an unreadable element, and returns a blank.
    ///
    /// # Errors
    /// The fault, if there are too many.
    fn hold<T: Placeholder>(
        &mut self,
        element: Element,
        fault: Fault,
        given: &Value,
    ) -> Result<T, Fault> {
        if self.faults.len() == MOST_FAULTS {
            return Err(fault);
        }
        self.faults.push((element, fault));
        Ok(T::unreadable(given))
    }
}

fn read<T: DeserializeOwned>(value: &mut Value, element: Element) -> Result<T, Fault> {
    if value.is_array() {
        let reason = Reason::malformed("it must be an object, and is a list");
        return Err(reason.of(element.to_string()));
    }
    make_whole(value);
    wide::check(value).and_then(|()| lists::check(value)).map_err(|fault| {
        let (key, reason) = fault.into_parts();
        Reason::malformed(reason).of(format!("{element}, {key}"))
    })?;
    serde_path_to_error::deserialize(&*value).map_err(|error| {
        let object = object_name(element.to_string(), error.path().iter());
        Reason::malformed(words::sentence(&error.into_inner().to_string())).of(object)
    })
}

/// Turns numbers such as `1.0` into integers, which some fields require; their values do not
/// change. The JSON reader has limited the depth.
fn make_whole(value: &mut Value) {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    match value {
        Value::Number(number) => {
            let float = number
                .as_f64()
                .filter(|float| number.is_f64() && float.fract() == 0.0 && float.abs() <= EXACT);
            // The sign of -0.0 would be lost.
            if let Some(float) = float.filter(|float| *float != 0.0 || float.is_sign_positive()) {
                *value = Value::from(float as i64);
            }
        }
        Value::Array(values) => values.iter_mut().for_each(make_whole),
        Value::Object(entries) => {
            let entries = entries.iter_mut().filter(|(key, _)| *key != "extras");
            entries.for_each(|(_, value)| make_whole(value));
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// Removes channels whose target has no node. They are valid if an extension defines their targets.
fn drop_channels_without_node(index: usize, animation: &mut Value, notes: &mut Notes) {
    let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else {
        return;
    };
    let before = channels.len();
    // A value that is not an object stays, and is a fault.
    channels.retain(|channel| match channel.get("target").and_then(Value::as_object) {
        Some(target) => target.contains_key("node"),
        None => true,
    });
    notes.count("a channel has no node, and is not played", before - channels.len(), || {
        format!("animation {index}")
    });
}

/// Takes the list of lights. An extension without a list has no lights.
fn take_lights(
    object: &mut Map<String, Value>,
    faults: &mut Vec<(Element, Fault)>,
    notes: &mut Notes,
) -> Result<Vec<Light>, Fault> {
    let extensions = object.get_mut("extensions").and_then(Value::as_object_mut);
    let Some(extension) = extensions.and_then(|extensions| extensions.remove(LIGHTS)) else {
        return Ok(Vec::new());
    };
    let Value::Object(mut extension) = extension else {
        notes
            .add(|| Note::new(format!("extensions, {LIGHTS}"), "it is not an object, and ignored"));
        return Ok(Vec::new());
    };
    let mut lists = Lists { object: &mut extension, faults };
    lists.take("lights", Kind::Light)
}
