//! As much of a glTF reader as the fox needs: one skinned mesh, float accessors without strides.

use antumbra_animation::{
    Channel, Clip, Interpolation, Node, NodeId, Rest, Rig, Skin, Track, Trs, Values,
};
use glam::{Affine3A, Mat4, Quat, Vec3};
use serde_json::Value;

/// What is in the file.
pub struct Fox {
    pub rig: Rig,
    pub clips: Vec<Clip>,
    pub skin: Skin,
    pub node: NodeId,
    pub positions: Vec<[f32; 3]>,
    pub joints: Vec<[u16; 4]>,
    pub weights: Vec<[f32; 4]>,
}

struct File<'a> {
    json: Value,
    binary: &'a [u8],
}

impl File<'_> {
    fn bytes(&self, accessor: &Value, width: usize) -> &[u8] {
        let accessor = &self.json["accessors"][index(accessor)];
        let view = &self.json["bufferViews"][index(&accessor["bufferView"])];
        assert!(view["byteStride"].as_u64().is_none_or(|stride| stride == width as u64));
        let offset = |value: &Value| value["byteOffset"].as_u64().unwrap_or(0) as usize;
        let start = offset(accessor) + offset(view);
        &self.binary[start..start + index(&accessor["count"]) * width]
    }

    fn floats<const N: usize>(&self, accessor: &Value) -> Vec<[f32; N]> {
        let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
        let rows = self.bytes(accessor, N * 4).chunks_exact(N * 4);
        rows.map(|row| std::array::from_fn(|column| number(&row[column * 4..][..4]))).collect()
    }
}

fn index(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

fn numbers<const N: usize>(value: &Value, otherwise: [f32; N]) -> [f32; N] {
    match value.as_array() {
        Some(array) => std::array::from_fn(|column| array[column].as_f64().unwrap() as f32),
        None => otherwise,
    }
}

pub fn read(bytes: &[u8]) -> Fox {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let json = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
    let file = File { json, binary: &bytes[28 + word(12)..] };
    let rig = rig(&file.json);
    let skin = &file.json["skins"][0];
    let joints = skin["joints"].as_array().unwrap().iter();
    let binds = file.floats::<16>(&skin["inverseBindMatrices"]);
    let primitive = &file.json["meshes"][0]["primitives"][0]["attributes"];
    let word = |bytes: &[u8]| u16::from_le_bytes([bytes[0], bytes[1]]);
    let rows = file.bytes(&primitive["JOINTS_0"], 8).chunks_exact(8);
    let node =
        file.json["nodes"].as_array().unwrap().iter().position(|node| !node["mesh"].is_null());
    Fox {
        clips: file.json["animations"]
            .as_array()
            .unwrap()
            .iter()
            .map(|c| clip(&file, c, &rig))
            .collect(),
        skin: Skin {
            joints: joints.map(|joint| NodeId(index(joint) as u32)).collect(),
            inverse_bind: binds
                .iter()
                .map(|b| Affine3A::from_mat4(Mat4::from_cols_array(b)))
                .collect(),
        },
        node: NodeId(node.unwrap() as u32),
        positions: file.floats(&primitive["POSITION"]),
        joints: rows.map(|row| std::array::from_fn(|n| word(&row[n * 2..]))).collect(),
        weights: file.floats(&primitive["WEIGHTS_0"]),
        rig,
    }
}

fn rig(json: &Value) -> Rig {
    let nodes = json["nodes"].as_array().unwrap();
    let mut parents = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        for child in node["children"].as_array().into_iter().flatten() {
            parents[index(child)] = Some(NodeId(parent as u32));
        }
    }
    let nodes = nodes.iter().zip(parents).map(|(node, parent)| Node {
        name: node["name"].as_str().unwrap().into(),
        parent,
        rest: Rest::Parts(Trs {
            translation: numbers(&node["translation"], [0.0; 3]).into(),
            rotation: Quat::from_array(numbers(&node["rotation"], [0.0, 0.0, 0.0, 1.0]))
                .normalize(),
            scale: numbers(&node["scale"], [1.0; 3]).into(),
        }),
        weights: Vec::new(),
    });
    Rig::new(nodes.collect()).unwrap()
}

fn clip(file: &File, clip: &Value, rig: &Rig) -> Clip {
    let channels = clip["channels"].as_array().unwrap().iter().map(|channel| {
        let sampler = &clip["samplers"][index(&channel["sampler"])];
        let output = &sampler["output"];
        let vectors = || file.floats::<3>(output).into_iter().map(Vec3::from).collect();
        let values = match channel["target"]["path"].as_str().unwrap() {
            "translation" => Values::Translation(vectors()),
            "scale" => Values::Scale(vectors()),
            _ => Values::Rotation(file.floats(output).into_iter().map(Quat::from_array).collect()),
        };
        let times_s =
            file.floats::<1>(&sampler["input"]).into_iter().map(|[time_s]| time_s).collect();
        let track = Track { interpolation: Interpolation::Linear, times_s, values };
        Channel { node: NodeId(index(&channel["target"]["node"]) as u32), track }
    });
    Clip::new(clip["name"].as_str().unwrap().into(), channels.collect(), rig).unwrap()
}
