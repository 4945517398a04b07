//! The built-in inputs of vertex shaders: none may prevent the hardware from processing a list of
//! draws.

use crate::{committed_spirv, folder};

/// Built-in inputs, by their numbers in the SPIR-V specification.
const VERTEX_INDEX: u32 = 42;
const INSTANCE_INDEX: u32 = 43;
const BASE_VERTEX: u32 = 4424;
const BASE_INSTANCE: u32 = 4425;
const DRAW_INDEX: u32 = 4426;

/// The shaders that read the vertex index, which includes the base vertex. Lists of indirect draws
/// use only the shaders of edges and the last shader. All others generate their vertices from the
/// index, in direct draws or single indirect draws. Edges find their segment by the index.
/// `volume.vert` passes the index to the geometry stage to identify the vertices of a triangle.
const WITH_VERTEX_INDEX: [&str; 15] = [
    "box_volume.vert",
    "cap.vert",
    "edge.vert",
    "edge_quads.vert",
    "edge_quads_section.vert",
    "edge_section.vert",
    "flare.vert",
    "flare_block.vert",
    "leaf_box.vert",
    "leaf_box_multiview.vert",
    "patch_capture.vert",
    "proxy.vert",
    "proxy_multiview.vert",
    "sky.vert",
    "volume.vert",
];

/// Returns the built-in variables that a module decorates.
fn built_ins(spirv: &[u8]) -> Vec<u32> {
    const DECORATE: u32 = 71;
    const MEMBER_DECORATE: u32 = 72;
    const BUILT_IN: u32 = 11;
    let words: Vec<u32> =
        spirv.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
    let mut rest = &words[5..];
    let mut found = Vec::new();
    while let [first, ..] = rest {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        match (first & 0xFFFF, instruction) {
            (DECORATE, [_, _, BUILT_IN, which, ..])
            | (MEMBER_DECORATE, [_, _, _, BUILT_IN, which, ..]) => found.push(*which),
            _ => {}
        }
        rest = after;
    }
    found
}

/// Returns the names of the engine's vertex shaders that read one of `built_in`.
fn readers(built_in: &[u32]) -> Vec<&'static str> {
    let vertex = |name: &&str| name.ends_with(".vert");
    let mut all: Vec<&str> =
        shaders::PASSES.iter().map(|shader| shader.name).filter(vertex).collect();
    all.sort_unstable();
    assert!(all.len() > WITH_VERTEX_INDEX.len());
    let reads = |name: &&str| {
        built_ins(&committed_spirv(name)).iter().any(|found| built_in.contains(found))
    };
    all.into_iter().filter(reads).collect()
}

#[test]
fn no_vertex_shader_reads_the_base_of_an_instance_or_the_number_of_a_draw() {
    let unwanted = [INSTANCE_INDEX, BASE_VERTEX, BASE_INSTANCE, DRAW_INDEX];
    assert_eq!(readers(&unwanted), [""; 0]);
    assert_eq!(readers(&[VERTEX_INDEX]), WITH_VERTEX_INDEX);
}

#[test]
fn the_number_of_an_instance_is_where_pipelines_put_it() {
    let text = std::fs::read_to_string(folder().join("instance_number.glsl")).unwrap();
    let wanted = format!("layout(location = {}) in uint instance_number;", gpu::NUMBER_LOCATION);
    assert!(text.contains(&wanted), "{wanted}");
}
