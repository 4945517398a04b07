//! Small valid files, made here: each test changes one part.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

/// The component type of bytes.
pub const U8: u32 = 5121;
/// The component type of signed 16-bit integers.
pub const I16: u32 = 5122;
/// The component type of 16-bit integers.
pub const U16: u32 = 5123;
/// The component type of 32-bit integers.
pub const U32: u32 = 5125;
/// The component type of floats.
pub const F32: u32 = 5126;

/// A file: its JSON, and one buffer.
#[derive(Clone)]
pub struct GltfFile {
    /// The JSON of the file, which a test changes as it needs.
    pub json: Value,
    /// The contents of its buffer.
    pub binary: Vec<u8>,
}

impl GltfFile {
    /// Returns one triangle on one node.
    pub fn triangle() -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "buffers": [], "bufferViews": [], "accessors": [],
        });
        let mut scene = Self { json, binary: Vec::new() };
        let positions = scene.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let indices = scene.numbers(U16, "SCALAR", 3, &[0, 0, 1, 0, 2, 0]);
        scene.set(
            "/meshes",
            json!([{ "primitives": [{ "attributes": { "POSITION": positions }, "indices": indices }] }]),
        );
        scene
    }

    /// Appends to a list of the JSON, and returns the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Adds textures of the first images, each shown by a material of a primitive of the first
    /// mesh.
    pub fn show_images(&mut self, count: usize) {
        let primitive = self.json["meshes"][0]["primitives"][0].clone();
        let primitives = (0..count).map(|material| {
            let mut primitive = primitive.clone();
            primitive["material"] = json!(material);
            primitive
        });
        self.set("/meshes/0/primitives", primitives.collect());
        let texture = |image| json!({ "source": image });
        let material = |texture| json!({ "emissiveTexture": { "index": texture } });
        self.set("/textures", (0..count).map(texture).collect());
        self.set("/materials", (0..count).map(material).collect());
    }

    /// Sets the value at a JSON pointer; objects on the way are made.
    pub fn set(&mut self, pointer: &str, value: Value) {
        let mut place = &mut self.json;
        for key in pointer.split('/').skip(1) {
            place = match key.parse::<usize>() {
                Ok(index) if place.is_array() => {
                    let list = place.as_array_mut().expect("a list");
                    if index == list.len() {
                        list.push(Value::Null);
                    }
                    &mut list[index]
                }
                _ => &mut place[key],
            };
        }
        *place = value;
    }

    /// Removes the value at a JSON pointer.
    pub fn remove(&mut self, pointer: &str) {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = self.json.pointer_mut(parent).expect("it exists");
        parent.as_object_mut().expect("an object").remove(key).expect("it exists");
    }

    /// Appends bytes and a view of them; returns the view's index.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view =
            json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() });
        self.binary.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    /// Appends an accessor with a view of its own; returns its index.
    pub fn numbers(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({ "bufferView": view, "componentType": component, "type": kind, "count": count });
        self.push("accessors", accessor)
    }

    /// Appends an accessor of floats, with their bounds where these are finite; returns its index.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let components = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let accessor = self.numbers(F32, kind, values.len() / components, &bytes);
        if values.iter().all(|value| value.is_finite()) {
            let of_axis = |axis| values.iter().skip(axis).step_by(components).copied();
            let axes = 0..components;
            let min = axes.clone().map(|axis| of_axis(axis).fold(f32::INFINITY, f32::min));
            let max = axes.map(|axis| of_axis(axis).fold(f32::NEG_INFINITY, f32::max));
            let min: Vec<f32> = min.collect();
            let max: Vec<f32> = max.collect();
            self.set(&format!("/accessors/{accessor}/min"), json!(min));
            self.set(&format!("/accessors/{accessor}/max"), json!(max));
        }
        accessor
    }

    /// Returns its buffer as a data URI.
    pub fn data_uri(&self) -> String {
        let data = BASE64_STANDARD.encode(&self.binary);
        format!("data:application/octet-stream;base64,{data}")
    }

    /// Returns it as .gltf, its buffer in a data URI.
    pub fn gltf(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].as_array().is_some_and(Vec::is_empty) {
            let uri = self.data_uri();
            json["buffers"] = json!([{ "byteLength": self.binary.len(), "uri": uri }]);
        }
        json.to_string().into_bytes()
    }

    /// Returns it as .glb.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].as_array().is_some_and(Vec::is_empty) {
            json["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        }
        glb_of(&[(b"JSON", json.to_string().as_bytes()), (b"BIN\0", &self.binary)])
    }
}

/// Returns a GLB of these chunks.
pub fn glb_of(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, bytes) in chunks {
        let padding = if *kind == b"JSON" { b' ' } else { 0 };
        let length = bytes.len().next_multiple_of(4);
        body.extend_from_slice(&(length as u32).to_le_bytes());
        body.extend_from_slice(*kind);
        body.extend_from_slice(bytes);
        body.resize(body.len() + length - bytes.len(), padding);
    }
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend_from_slice(&(body.len() as u32 + 12).to_le_bytes());
    glb.extend(body);
    glb
}

/// Returns a file that uses everything supported.
pub fn everything() -> GltfFile {
    let mut scene = GltfFile::triangle();
    add_surface(&mut scene);
    add_life(&mut scene);
    let places = scene.floats("VEC3", &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    let turns =
        scene.numbers(I16, "VEC4", 2, &[0, 0, 0, 0, 0, 0, 255, 127, 0, 0, 0, 0, 0, 0, 255, 127]);
    scene.set(&format!("/accessors/{turns}/normalized"), json!(true));
    scene.set(
        "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes",
        json!({ "TRANSLATION": places, "ROTATION": turns }),
    );
    let camera = json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } });
    scene.set("/cameras", json!([camera]));
    scene.set(
        "/nodes/3",
        json!({ "camera": 0, "translation": [0, 0, 5], "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
    );
    scene.set("/scenes/0/nodes", json!([0, 1, 3]));
    let light = json!({ "type": "spot", "intensity": 3.0, "spot": { "outerConeAngle": 0.5 } });
    scene.set("/extensions/KHR_lights_punctual/lights", json!([light]));
    scene.set(
        "/extensionsUsed",
        json!([
            "KHR_lights_punctual",
            "EXT_mesh_gpu_instancing",
            "KHR_texture_transform",
            "EXT_texture_webp"
        ]),
    );
    scene
}

/// Adds texture coordinates, a colour, a material, and images of all formats.
fn add_surface(scene: &mut GltfFile) {
    let uv = scene.numbers(U8, "VEC2", 3, &[0, 0, 9, 9, 255, 0, 9, 9, 0, 255]);
    scene.set(&format!("/accessors/{uv}/normalized"), json!(true));
    scene.set(&format!("/bufferViews/{uv}/byteStride"), json!(4));
    let colour = scene.floats("VEC4", &[1.0; 12]);
    let attributes = "/meshes/0/primitives/0/attributes";
    scene.set(&format!("{attributes}/TEXCOORD_0"), json!(uv));
    scene.set(&format!("{attributes}/COLOR_0"), json!(colour));
    let png = scene.view(&encoded(image::ImageFormat::Png));
    let jpeg = scene.view(&encoded(image::ImageFormat::Jpeg));
    let webp = BASE64_STANDARD.encode(encoded(image::ImageFormat::WebP));
    scene.set(
        "/images",
        json!([
            { "bufferView": png, "mimeType": "image/png" },
            { "bufferView": jpeg, "mimeType": "image/jpeg" },
            { "uri": format!("data:image/webp;base64,{webp}") },
        ]),
    );
    scene.set("/samplers", json!([{ "magFilter": 9728, "wrapS": 33071 }]));
    scene.set(
        "/textures",
        json!([
            { "source": 0, "sampler": 0 },
            { "source": 1 },
            { "source": 0, "extensions": { "EXT_texture_webp": { "source": 2 } } },
        ]),
    );
    scene.set(
        "/materials",
        json!([{
            "pbrMetallicRoughness": {
                "baseColorTexture": {
                    "index": 0, "extensions": { "KHR_texture_transform": { "scale": [2.0, 2.0] } },
                },
            },
            "normalTexture": { "index": 1, "scale": 0.5 },
            "emissiveTexture": { "index": 2 },
            "alphaMode": "MASK",
        }]),
    );
    scene.set("/meshes/0/primitives/0/material", json!(0));
}

/// Adds a skinned mesh with a morph target, and an animation of it.
fn add_life(scene: &mut GltfFile) {
    let joints = scene.numbers(U8, "VEC4", 3, &[0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
    let weights =
        scene.floats("VEC4", &[0.5, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let moved = sparse(scene);
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let binds = scene.floats("MAT4", &[identity, identity].concat());
    scene.set(
        "/meshes/1",
        json!({ "weights": [0.5], "primitives": [{
            "attributes": { "POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights },
            "targets": [{ "POSITION": moved }],
        }] }),
    );
    scene.set("/nodes/1", json!({ "mesh": 1, "skin": 0, "children": [2] }));
    scene.set("/nodes/2", json!({ "translation": [0.0, 1.0, 0.0] }));
    scene.set("/skins", json!([{ "joints": [1, 2], "inverseBindMatrices": binds }]));
    let times = scene.floats("SCALAR", &[0.0, 1.0]);
    let turns = scene.floats("VEC4", &[[0.0, 0.0, 0.0, 1.0]; 6].concat());
    let moves = scene.floats("SCALAR", &[0.0, 1.0]);
    scene.set(
        "/animations",
        json!([{
            "samplers": [
                { "input": times, "output": turns, "interpolation": "CUBICSPLINE" },
                { "input": times, "output": moves },
            ],
            "channels": [
                { "sampler": 0, "target": { "node": 2, "path": "rotation" } },
                { "sampler": 1, "target": { "node": 1, "path": "weights" } },
            ],
        }]),
    );
}

/// Returns an accessor of three positions without a base, of which the last is replaced.
fn sparse(scene: &mut GltfFile) -> usize {
    let indices = scene.view(&[2, 0]);
    let values = scene.view(&[1.0f32, 2.0, 3.0].map(f32::to_le_bytes).concat());
    scene.push(
        "accessors",
        json!({ "componentType": F32, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [1, 2, 3], "sparse": {
            "count": 1,
            "indices": { "bufferView": indices, "componentType": U16 },
            "values": { "bufferView": values },
        } }),
    )
}

/// Returns a small image in this format.
pub fn encoded(format: image::ImageFormat) -> Vec<u8> {
    let pixels =
        image::RgbImage::from_fn(16, 8, |x, y| image::Rgb([x as u8 * 16, y as u8 * 32, 77]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    pixels.write_to(&mut bytes, format).expect("it can be encoded");
    bytes.into_inner()
}
