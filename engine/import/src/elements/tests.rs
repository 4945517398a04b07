//! Tests that picked elements equal the same elements of a full read, and that reading them costs
//! no more than their number.

use std::cell::Cell;

use serde_json::json;

use super::*;

thread_local! {
    /// The number of elements that this thread has read.
    pub(super) static READ: Cell<u64> = const { Cell::new(0) };
}

/// The generator SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let value = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        value ^ (value >> 27)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    /// Returns each number below `end` with a probability of 1 / `rare`, in order.
    fn some_below(&mut self, end: usize, rare: usize) -> Vec<u32> {
        (0..end as u32).filter(|_| self.below(rare) == 0).collect()
    }
}

/// Returns a file of random bytes. Its first accessor has a random layout, and its second one has
/// the same elements, packed.
fn any_accessor(random: &mut Random) -> (Root, Store) {
    const TYPES: [(u32, usize); 6] =
        [(5120, 1), (5121, 1), (5122, 2), (5123, 2), (5125, 4), (5126, 4)];
    let (component, size) = TYPES[random.below(6)];
    let (components, kind) = [(1, "SCALAR"), (3, "VEC3"), (4, "VEC4")][random.below(3)];
    let count = 1 + random.below(200);
    let element = components * size;
    let stride = element.next_multiple_of(4) + 4 * random.below(3);
    let mut file: Vec<u8> = (0..count * stride).map(|_| random.next() as u8).collect();
    let mut views = vec![json!({ "buffer": 0, "byteLength": file.len(), "byteStride": stride })];
    let mut accessor = json!({ "componentType": component, "type": kind, "count": count, "normalized": random.below(2) == 0 });
    let mut packed = vec![0; count * element];
    if random.below(4) > 0 {
        accessor["bufferView"] = json!(0);
        for (to, from) in packed.chunks_mut(element).zip(file.chunks(stride)) {
            to.copy_from_slice(&from[..element]);
        }
    }
    let mut plain = accessor.clone();
    let mut view = |part: &[u8]| {
        views.push(json!({ "buffer": 0, "byteOffset": file.len(), "byteLength": part.len() }));
        file.extend(part);
        views.len() - 1
    };
    let rare = 1 + random.below(20);
    let replaced = random.some_below(count, rare);
    if random.below(3) > 0 && !replaced.is_empty() {
        let values: Vec<u8> = (0..replaced.len() * element).map(|_| random.next() as u8).collect();
        for (&at, value) in replaced.iter().zip(values.chunks(element)) {
            packed[at as usize * element..][..element].copy_from_slice(value);
        }
        let indices: Vec<u8> = replaced.iter().flat_map(|at| at.to_le_bytes()).collect();
        accessor["sparse"] = json!({
            "count": replaced.len(), "values": { "bufferView": view(&values) },
            "indices": { "bufferView": view(&indices), "componentType": 5125 },
        });
    }
    plain["bufferView"] = json!(view(&packed));
    let root = json!({
        "asset": { "version": "2.0" }, "buffers": [{ "byteLength": file.len() }],
        "bufferViews": views, "accessors": [accessor, plain],
    });
    let buffers = vec![BufferBytes::InFile(0..file.len())];
    (serde_json::from_value(root).expect("a file"), Store { file, buffers })
}

/// Reads elements as floats and as integers, both as bits.
fn read<const N: usize>(
    file: &(Root, Store),
    accessor: usize,
    picks: Option<&[u32]>,
) -> [Option<Vec<[u32; N]>>; 2] {
    let file = (&file.0, &file.1);
    let mut floats = Vec::new();
    let mut integers = Vec::new();
    let is_float = for_each_floats::<N>(file.0, file.1, accessor, picks, |element| {
        floats.push(element.map(f32::to_bits))
    });
    let is_integer =
        for_each_integers::<N>(file.0, file.1, accessor, picks, |element| integers.push(element));
    [is_float.map(|()| floats), is_integer.map(|()| integers)]
}

/// Compares three ways of reading. Returns the number of picked elements.
fn compare<const N: usize>(file: &(Root, Store), picks: &[u32]) -> usize {
    let all = read::<N>(file, 1, None);
    assert_eq!(read::<N>(file, 0, None), all);
    let gather = |all: Vec<[u32; N]>| picks.iter().map(|&at| all[at as usize]).collect::<Vec<_>>();
    let picked = read::<N>(file, 0, Some(picks));
    assert_eq!(picked, all.map(|all| all.map(gather)));
    picked[0].as_ref().map_or(0, Vec::len)
}

#[test]
fn picked_elements_are_those_of_all() {
    let mut compared = 0;
    for seed in 0..3000 {
        let mut random = Random(seed);
        let file = any_accessor(&mut random);
        let rare = 1 + random.below(60);
        let picks = random.some_below(file.0.accessors[0].count.0 as usize, rare);
        compared +=
            compare::<1>(&file, &picks) + compare::<3>(&file, &picks) + compare::<4>(&file, &picks);
    }
    assert!(compared > 10_000, "only {compared}");
}

#[test]
fn primitives_that_share_vertices_read_those_that_they_use() {
    const VERTICES: usize = 2600;
    const PRIMITIVES: usize = 1000;
    let bytes: Vec<u8> =
        (0..VERTICES * 3).flat_map(|at| ((at * at % 97) as f32).to_le_bytes()).collect();
    let indices: Vec<u8> = [7u16, 1300, 2599].into_iter().flat_map(u16::to_le_bytes).collect();
    let uri = |bytes: &[u8]| {
        let text = base64::Engine::encode(&base64::prelude::BASE64_STANDARD, bytes);
        json!({ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{text}") })
    };
    // Own indices make each primitive a different one.
    let primitive = |number| json!({ "attributes": { "POSITION": 0, "NORMAL": 0, "COLOR_0": 0 }, "indices": number });
    let primitives: Vec<_> = (1..=PRIMITIVES).map(primitive).collect();
    let positions =
        json!({ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": VERTICES });
    let mut accessors = vec![positions];
    accessors.resize(
        1 + PRIMITIVES,
        json!({ "bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 3 }),
    );
    let file = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": primitives }],
        "buffers": [uri(&bytes), uri(&indices)],
        "bufferViews": [
            { "buffer": 0, "byteLength": bytes.len() }, { "buffer": 1, "byteLength": indices.len() },
        ],
        "accessors": accessors,
    });
    let before = READ.get();
    let loaded = crate::load_bytes(
        file.to_string().into_bytes(),
        None,
        &crate::LoadOptions::default(),
        &mut |_| std::ops::ControlFlow::Continue(()),
    );
    let read = READ.get() - before;
    assert_eq!(loaded.map(|loaded| loaded.scene.objects.len()), Ok(PRIMITIVES));
    // Three indices, checked and read, and three vertices with three attributes; shared data is
    // checked once.
    let most = (PRIMITIVES * 3 * 5 + VERTICES * 2) as u64;
    assert!((most / 2..=most).contains(&read), "{read} elements read, not {most} at most");
}
