//! A small scene as a GLB: a wall, boxes behind it, a door in it that slides, and two cameras.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

/// The bytes of a buffer, and the views and accessors of it.
#[derive(Default)]
struct Bytes {
    all: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Bytes {
    /// Adds numbers; returns their accessor.
    fn floats(&mut self, kind: &str, width: usize, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let rows = numbers.chunks_exact(width);
        let extreme = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            let columns = (0..width).map(|column| rows.clone().map(move |row| row[column]));
            columns.map(|column| column.reduce(pick).unwrap_or_default()).collect()
        };
        let min = extreme(f32::min);
        let max = extreme(f32::max);
        let count = numbers.len() / width;
        self.add(
            &bytes,
            json!({"componentType": 5126, "type": kind, "count": count, "min": min, "max": max}),
        )
    }

    fn indices(&mut self, numbers: &[u16]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.add(&bytes, json!({"componentType": 5123, "type": "SCALAR", "count": numbers.len()}))
    }

    fn add(&mut self, bytes: &[u8], mut accessor: Value) -> usize {
        self.all.resize(self.all.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.all.len(), "byteLength": bytes.len()});
        self.all.extend_from_slice(bytes);
        accessor["bufferView"] = self.views.len().into();
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

/// Returns a box from -1 to 1, its faces apart: positions, normals, indices.
fn cube() -> (Vec<f32>, Vec<f32>, Vec<u16>) {
    let mut positions = Vec::new();
    let mut normals = Vec::new();
    let mut indices = Vec::new();
    for axis in 0..3 {
        for side in [-1.0_f32, 1.0] {
            let first = (positions.len() / 3) as u16;
            for (u, v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut corner = [0.0; 3];
                let mut normal = [0.0; 3];
                (corner[axis], normal[axis]) = (side, side);
                (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (u, v);
                positions.extend(corner);
                normals.extend(normal);
            }
            let turn = if side > 0.0 { [0, 1, 2, 0, 2, 3] } else { [0, 2, 1, 0, 3, 2] };
            indices.extend(turn.map(|index| first + index));
        }
    }
    (positions, normals, indices)
}

/// Returns the scene. The camera `walk` goes along the wall for two seconds, `still` stands; the
/// clip `door` lasts one.
pub fn small() -> Vec<u8> {
    small_seen_by(&json!({"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}))
}

/// Returns the scene with other cameras.
pub fn small_seen_by(camera: &Value) -> Vec<u8> {
    small_with(Some(camera), 7.0, 7.0)
}

/// Returns the scene with all of its nodes and clips, and no camera.
pub fn small_without_cameras() -> Vec<u8> {
    small_with(None, 7.0, 7.0)
}

/// Returns the scene with the camera `walk` going right before the wall.
pub fn small_before_the_wall() -> Vec<u8> {
    let camera = json!({"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}});
    small_with(Some(&camera), 1.0, 1.0)
}

/// Returns the scene with the camera `walk` going away from the wall, right before which it begins.
pub fn small_leaving_the_wall() -> Vec<u8> {
    let camera = json!({"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}});
    small_with(Some(&camera), 1.0, 7.0)
}

/// The note about [`small_with_lamps`] with more than 16 lamps.
pub const LAMPS_NOTE: &str =
    "64 objects are reached by more than 16 lights: the weakest of them are left out";

/// Returns the scene with so many lamps that reach everything.
pub fn small_with_lamps(lamps: usize) -> Vec<u8> {
    let small = small();
    let length = u32::from_le_bytes(small[12..16].try_into().expect("a length")) as usize;
    let document = &small[20..20 + length];
    let buffer = &small[28 + length..];
    let mut document: Value = serde_json::from_slice(document).expect("JSON");
    document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    document["extensions"] = json!({
        "KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 5.0}]},
    });
    let nodes = document["nodes"].as_array_mut().expect("nodes");
    let first = nodes.len();
    let lamp = json!({"extensions": {"KHR_lights_punctual": {"light": 0}}});
    nodes.extend(std::iter::repeat_n(lamp, lamps));
    let shown = document["scenes"][0]["nodes"].as_array_mut().expect("nodes");
    shown.extend((first..first + lamps).map(Value::from));
    glb(&document, buffer)
}

/// Writes files of which none is a scene, or omits them. Returns their names.
pub fn write_unreadable(folder: &Path) -> [&'static str; 5] {
    let whole = small();
    let cut = "cut.glb";
    let empty = "empty.glb";
    let text = "text.gltf";
    for (file, bytes) in [(cut, &whole[..whole.len() / 2]), (empty, b""), (text, b"no JSON")] {
        fs::write(folder.join(file), bytes).expect("the target folder is writable");
    }
    fs::create_dir(folder.join("folder.glb")).expect("the target folder is writable");
    ["missing.glb", cut, empty, text, "folder.glb"]
}

fn small_with(camera: Option<&Value>, first_z: f32, last_z: f32) -> Vec<u8> {
    let mut bytes = Bytes::default();
    let (positions, normals, indices) = cube();
    let positions = bytes.floats("VEC3", 3, &positions);
    let normals = bytes.floats("VEC3", 3, &normals);
    let indices = bytes.indices(&indices);
    let keys = bytes.floats("SCALAR", 1, &[0.0, 0.5, 1.0]);
    let slides = bytes.floats("VEC3", 3, &[0.0, 1.0, 0.0, 2.2, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let ends = bytes.floats("SCALAR", 1, &[0.0, 2.0]);
    let walked = bytes.floats("VEC3", 3, &[-6.0, 1.2, first_z, 6.0, 1.2, last_z]);
    let mut nodes = vec![
        json!({"name": "left", "mesh": 0, "translation": [-6.1, 1.0, 0.0], "scale": [5.0, 1.5, 0.1]}),
        json!({"name": "right", "mesh": 0, "translation": [6.1, 1.0, 0.0], "scale": [5.0, 1.5, 0.1]}),
        json!({"name": "door", "mesh": 0, "translation": [0.0, 1.0, 0.0], "scale": [1.05, 1.5, 0.06]}),
        json!({"name": "walk", "camera": 0, "translation": [-6.0, 1.2, first_z]}),
        json!({"name": "still", "camera": 0, "translation": [0.5, 1.2, 8.0]}),
        json!({"name": "floor", "mesh": 1, "translation": [0.0, -0.7, 0.0], "scale": [14.0, 0.1, 14.0]}),
    ];
    for place in 0..60_u8 {
        let column = f32::from(place % 12);
        let row = f32::from(place / 12);
        nodes.push(json!({
            "name": format!("box {place}"), "mesh": 1 + place % 2,
            "translation": [column * 1.5 - 8.0, 0.4, -2.0 - row * 1.5], "scale": [0.4, 0.8, 0.4],
        }));
    }
    let primitive = |material: usize| {
        let attributes = json!({"POSITION": positions, "NORMAL": normals});
        json!({"primitives": [{"attributes": attributes, "indices": indices, "material": material}]})
    };
    let material = |colour: [f32; 4]| json!({"pbrMetallicRoughness": {"baseColorFactor": colour, "metallicFactor": 0.0}});
    let clip = |name: &str, node: usize, input: usize, output: usize| {
        json!({
            "name": name,
            "samplers": [{"input": input, "output": output}],
            "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}],
        })
    };
    if camera.is_none() {
        for node in nodes.iter_mut().filter_map(Value::as_object_mut) {
            node.remove("camera");
        }
    }
    let document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes,
        "meshes": [primitive(0), primitive(1), primitive(2)],
        "materials": [material([0.7, 0.7, 0.6, 1.0]), material([0.8, 0.2, 0.1, 1.0]), material([0.1, 0.3, 0.8, 1.0])],
        "cameras": camera.into_iter().collect::<Vec<_>>(),
        "animations": [clip("walk", 3, ends, walked), clip("door", 2, keys, slides)],
        "accessors": bytes.accessors,
        "bufferViews": bytes.views,
        "buffers": [{"byteLength": bytes.all.len()}],
    });
    glb(&document, &bytes.all)
}

/// Returns a ball of 2,208 triangles, 7 metres before the camera `still`.
pub fn ball() -> Vec<u8> {
    const AROUND: u16 = 48;
    const ROWS: u16 = 24;
    let mut bytes = Bytes::default();
    let point = |number: u16| {
        let row = number / AROUND;
        let column = number % AROUND;
        let turn = f32::from(column) / f32::from(AROUND) * std::f32::consts::TAU;
        let (radius, y) = (f32::from(row) / f32::from(ROWS) * std::f32::consts::PI).sin_cos();
        [radius * turn.sin(), y, radius * turn.cos()]
    };
    let points: Vec<[f32; 3]> = (0..AROUND * (ROWS + 1)).map(point).collect();
    let quads = (0..AROUND * ROWS).flat_map(|quad| {
        let row = quad / AROUND;
        let column = quad % AROUND;
        let [a, b] = [column, (column + 1) % AROUND].map(|column| row * AROUND + column);
        let upper = [a, a + AROUND, b];
        let lower = [b, a + AROUND, b + AROUND];
        [(row > 0).then_some(upper), (row + 1 < ROWS).then_some(lower)].into_iter().flatten()
    });
    let indices: Vec<u16> = quads.flatten().collect();
    let points = bytes.floats("VEC3", 3, points.as_flattened());
    let indices = bytes.indices(&indices);
    let attributes = json!({"POSITION": points, "NORMAL": points});
    let document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"name": "ball", "mesh": 0},
            {"name": "still", "camera": 0, "translation": [0.0, 0.0, 8.0]},
        ],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": indices}]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}],
        "accessors": bytes.accessors,
        "bufferViews": bytes.views,
        "buffers": [{"byteLength": bytes.all.len()}],
    });
    glb(&document, &bytes.all)
}

/// Returns red points at the corners of a square, a green loop of lines around it, slightly turned;
/// no camera.
pub fn thin() -> Vec<u8> {
    let mut bytes = Bytes::default();
    let square = |half: f32, turned: f32| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y): (f32, f32)| [half * (x - turned * y), half * (y + turned * x), 0.0])
    };
    let points = bytes.floats("VEC3", 3, square(1.0, 0.0).as_flattened());
    let lines = bytes.floats("VEC3", 3, square(1.5, 0.06).as_flattened());
    let primitive = |positions: usize, mode: u32, material: usize| {
        let attributes = json!({"POSITION": positions});
        json!({"primitives": [{"attributes": attributes, "mode": mode, "material": material}]})
    };
    let material = |colour: [f32; 4]| json!({"pbrMetallicRoughness": {"baseColorFactor": colour}});
    plain(
        &[primitive(points, 0, 0), primitive(lines, 2, 1)],
        &[material([1.0, 0.0, 0.0, 1.0]), material([0.0, 1.0, 0.0, 1.0])],
        &bytes,
    )
}

/// Returns one transparent mesh of two cards, red before blue, in that order or the other.
pub fn cards(order: [usize; 2]) -> Vec<u8> {
    let mut bytes = Bytes::default();
    let card = |side: f32, z: f32| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y): (f32, f32)| [x * side, y * side, z])
    };
    let places = [card(1.0, 1.0), card(1.5, 0.0)];
    let colours = [[1.0, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.5]];
    let positions =
        bytes.floats("VEC3", 3, order.map(|card| places[card]).as_flattened().as_flattened());
    let colours = order.map(|card| [colours[card]; 4]);
    let colours = bytes.floats("VEC4", 4, colours.as_flattened().as_flattened());
    let indices = bytes.indices(&[0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7]);
    let attributes = json!({"POSITION": positions, "COLOR_0": colours});
    let mesh =
        json!({"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]});
    let unlit = json!({"alphaMode": "BLEND", "extensions": {"KHR_materials_unlit": {}}});
    plain(&[mesh], &[unlit], &bytes)
}

/// Returns a square that a texture covers twice in each direction by `KHR_texture_transform`. The
/// texture is red on its left half and blue on its right one, `png` is its file.
pub fn transformed(png: &[u8]) -> Vec<u8> {
    let mut bytes = Bytes::default();
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let positions = bytes.floats("VEC3", 3, corners.map(|(x, y)| [x, y, 0.0]).as_flattened());
    let uvs = bytes.floats("VEC2", 2, corners.map(|(x, y)| [x, y]).as_flattened());
    let indices = bytes.indices(&[0, 1, 2, 0, 2, 3]);
    bytes.add(png, json!({"componentType": 5121, "type": "SCALAR", "count": 1}));
    let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
    let mesh =
        json!({"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]});
    let moved = json!({"KHR_texture_transform": {"scale": [2.0, 2.0]}});
    let material = json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": moved}},
        "extensions": {"KHR_materials_unlit": {}},
    });
    plain(&[mesh], &[material], &bytes)
}

/// Returns a scene with one node per mesh, and nothing else.
fn plain(meshes: &[Value], materials: &[Value], bytes: &Bytes) -> Vec<u8> {
    let nodes: Vec<Value> = (0..meshes.len()).map(|mesh| json!({"mesh": mesh})).collect();
    // The bytes behind all numbers are an image.
    let is_image = |accessor: &&Value| accessor["componentType"] == 5121;
    let images: Vec<Value> = bytes
        .accessors
        .iter()
        .filter(is_image)
        .map(|image| json!({"bufferView": image["bufferView"], "mimeType": "image/png"}))
        .collect();
    let document = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit", "KHR_texture_transform"],
        "textures": images.iter().map(|_| json!({"source": 0})).collect::<Vec<_>>(),
        "images": images,
        "scene": 0,
        "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes, "meshes": meshes, "materials": materials,
        "accessors": bytes.accessors,
        "bufferViews": bytes.views,
        "buffers": [{"byteLength": bytes.all.len()}],
    });
    glb(&document, &bytes.all)
}

/// Returns a GLB of a document and its buffer.
pub fn glb(document: &Value, buffer: &[u8]) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], bytes: &[u8], filler: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), filler);
        let mut chunk = (bytes.len() as u32).to_le_bytes().to_vec();
        chunk.extend_from_slice(kind);
        chunk.extend(bytes);
        chunk
    };
    let json = chunk(b"JSON", document.to_string().as_bytes(), b' ');
    let binary = chunk(b"BIN\0", buffer, 0);
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(((12 + json.len() + binary.len()) as u32).to_le_bytes());
    [file, json, binary].concat()
}
