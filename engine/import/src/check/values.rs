//! Checks of values in buffers that are indices: sparse indices, indices of primitives, and joints.

use std::collections::HashMap;

use gltf::Semantic;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::mesh::Primitive;
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Root};

use scene::counted;

use super::numbers::vertex_count;
use crate::element::Kind;
use crate::elements::{self, Store};
use crate::error::{At, Fault, Reason, there_are};
use crate::leave_out;
use crate::verdict::Verdict;

/// Checks the used values. Parts with invalid values are left out of the shown scene.
pub(crate) fn indices_and_joints(
    root: &mut Root,
    store: &Store,
    verdict: &mut Verdict,
) -> Result<(), Fault> {
    for (index, accessor) in root.accessors.iter().enumerate() {
        let element = Kind::Accessor.at(index);
        if let Some(sparse) = accessor.sparse.as_ref().filter(|_| verdict.is_kept(root, element)) {
            let checked = check_sparse(root, store, sparse, accessor.count.0)
                .at(|| format!("accessor {index}, sparse indices"));
            verdict.judge(element, checked)?;
        }
    }
    leave_out::dependants(root, verdict)?;
    let primitives = check_indices(root, store, verdict)?;
    for &[mesh, number] in &primitives {
        let mesh = root.meshes.get_mut(mesh);
        let primitive = mesh.and_then(|mesh| mesh.primitives.get_mut(number));
        primitive.into_iter().for_each(leave_out::empty_primitive);
    }
    let nodes = check_skinned(root, store, verdict)?;
    for &node in &nodes {
        verdict.remove_mesh(node, root);
    }
    if !primitives.is_empty() || !nodes.is_empty() {
        verdict.follow_again(root);
    }
    Ok(())
}

/// Checks the indices of primitives. Returns the primitives that are left out, with their meshes.
fn check_indices(
    root: &Root,
    store: &Store,
    verdict: &mut Verdict,
) -> Result<Vec<[usize; 2]>, Fault> {
    let mut greatest = Greatest::of_file(root, store);
    let mut beyond = Vec::new();
    let meshes = root.meshes.iter().enumerate();
    for (mesh_index, mesh) in meshes {
        if !verdict.is_used(Kind::Mesh.at(mesh_index)) {
            continue;
        }
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let Some(found) = greatest.vertex_beyond(primitive) else { continue };
            let object = format!("mesh {mesh_index}, primitive {index}, indices");
            match found {
                Beyond::Restart(reason) => {
                    verdict.repair(reason.of(object), RESTARTS)?;
                }
                Beyond::Vertex(reason) => {
                    verdict.leave_out(reason.of(object), "this primitive is left out")?;
                    beyond.push([mesh_index, index]);
                }
            }
        }
    }
    Ok(beyond)
}

/// The consequence of indices that restart a primitive.
const RESTARTS: &str = "read as the value that begins a new strip, which glTF does not allow";

fn check_sparse(root: &Root, store: &Store, sparse: &Sparse, count: u64) -> Result<(), Reason> {
    let mut last = None;
    for index in elements::sparse_indices(root, store, sparse) {
        if u64::from(index) >= count {
            let text = format!("element {index} is replaced, but {}", there_are(count));
            return Err(Reason::malformed(text));
        }
        if last.is_some_and(|last| last >= index) {
            return Err(Reason::malformed("they do not increase"));
        }
        last = Some(index);
    }
    Ok(())
}

/// Checks that vertices follow existing joints. A joint with weight 0 may have any index (3.7.3.3
/// requires 0). Returns the nodes whose meshes are left out.
fn check_skinned(root: &Root, store: &Store, verdict: &mut Verdict) -> Result<Vec<usize>, Fault> {
    let mut greatest = Greatest::of_file(root, store);
    let mut named: HashMap<usize, Option<u32>> = HashMap::new();
    let mut followed: HashMap<usize, Option<u32>> = HashMap::new();
    let mut beyond = Vec::new();
    let nodes = root.nodes.iter().enumerate();
    for (index, node) in nodes {
        let is_shown = verdict.is_used(Kind::Node.at(index));
        let (Some(mesh), Some(skin), true) = (node.mesh, node.skin, is_shown) else { continue };
        let joints = root.get(skin).map_or(0, |skin| skin.joints.len());
        let is_beyond = |joint: &u32| *joint as usize >= joints;
        let primitives = root.get(mesh).map_or(&[][..], |mesh| mesh.primitives.as_slice());
        let named = *named.entry(mesh.value()).or_insert_with(|| {
            primitives.iter().filter_map(|primitive| greatest.joint(primitive)).max()
        });
        if named.filter(is_beyond).is_none() {
            continue;
        }
        let followed = *followed.entry(mesh.value()).or_insert_with(|| {
            primitives.iter().filter_map(|primitive| greatest.followed_joint(primitive)).max()
        });
        if let Some(joint) = followed.filter(is_beyond) {
            let joints = counted(joints, "joint", "joints");
            let mesh = mesh.value();
            let skin = skin.value();
            let text = format!("mesh {mesh} hangs on joint {joint}, but skin {skin} has {joints}");
            let fault = Reason::malformed(text).of(format!("node {index}"));
            verdict.leave_out(fault, "its mesh is left out")?;
            beyond.push(index);
        }
    }
    Ok(beyond)
}

/// An index of a primitive beyond its vertices.
enum Beyond {
    /// The greatest value of the type, at which graphics APIs begin a new strip.
    Restart(Reason),
    /// Any other value.
    Vertex(Reason),
}

/// The greatest values of accessors, each computed once even if many primitives share it.
struct Greatest<'a> {
    root: &'a Root,
    store: &'a Store,
    known: HashMap<usize, u32>,
    /// The greatest indices except those that restart a primitive.
    without_restarts: HashMap<usize, Option<u32>>,
    /// The greatest joints with a weight above 0, by the accessors of joints and weights.
    followed: HashMap<[usize; 2], Option<u32>>,
}

impl<'a> Greatest<'a> {
    fn of_file(root: &'a Root, store: &'a Store) -> Self {
        Self {
            root,
            store,
            known: HashMap::new(),
            without_restarts: HashMap::new(),
            followed: HashMap::new(),
        }
    }

    fn of<const N: usize>(&mut self, accessor: Index<Accessor>) -> u32 {
        let root = self.root;
        let store = self.store;
        *self.known.entry(accessor.value()).or_insert_with(|| {
            let mut greatest = 0;
            elements::for_each_integers::<N>(root, store, accessor.value(), None, |values| {
                greatest = values.into_iter().fold(greatest, u32::max);
            });
            greatest
        })
    }

    /// Returns an index of a primitive beyond its vertices, if there is one.
    fn vertex_beyond(&mut self, primitive: &Primitive) -> Option<Beyond> {
        let vertices = vertex_count(self.root, primitive)?;
        let indices = primitive.indices?;
        let is_beyond = |vertex: u32| u64::from(vertex) >= vertices;
        let greatest = self.of::<1>(indices);
        if !is_beyond(greatest) {
            return None;
        }
        let reason = |vertex: u32| {
            let text = format!("vertex {vertex} does not exist, {}", there_are(vertices));
            Reason::malformed(text)
        };
        let restart = self.root.get(indices).and_then(elements::restart_index);
        if restart != Some(greatest) {
            return Some(Beyond::Vertex(reason(greatest)));
        }
        let root = self.root;
        let store = self.store;
        let other = *self.without_restarts.entry(indices.value()).or_insert_with(|| {
            let mut other = None;
            elements::for_each_integers::<1>(root, store, indices.value(), None, |[index]| {
                other = other.max(Some(index).filter(|index| *index != greatest));
            });
            other
        });
        Some(match other.filter(|other| is_beyond(*other)) {
            Some(other) => Beyond::Vertex(reason(other)),
            None => Beyond::Restart(reason(greatest)),
        })
    }

    fn joint(&mut self, primitive: &Primitive) -> Option<u32> {
        let joints = primitive.attributes.iter().filter_map(|(semantic, &accessor)| {
            matches!(semantic, Checked::Valid(Semantic::Joints(_))).then_some(accessor)
        });
        joints.map(|accessor| self.of::<4>(accessor)).max()
    }

    /// Returns the greatest joint that a vertex follows with a weight above 0.
    fn followed_joint(&mut self, primitive: &Primitive) -> Option<u32> {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic));
        let set =
            |set| Some([attribute(Semantic::Joints(set))?, attribute(Semantic::Weights(set))?]);
        let sets = (0..).map_while(set).map(|set| set.map(|accessor| accessor.value()));
        let root = self.root;
        let store = self.store;
        let greatest = |[joints, weights]: [usize; 2]| {
            let mut has_weight: Vec<u8> = Vec::new();
            elements::for_each_floats::<4>(root, store, weights, None, |weights| {
                let bits = (0..4).zip(weights).filter(|(_, weight)| *weight > 0.0);
                has_weight.push(bits.map(|(place, _)| 1 << place).sum());
            })?;
            let mut vertices = has_weight.iter();
            let mut greatest = None;
            elements::for_each_integers::<4>(root, store, joints, None, |joints| {
                let bits = vertices.next().copied().unwrap_or_default();
                let followed = (0..4).zip(joints).filter(|(place, _)| bits & 1 << place != 0);
                greatest = greatest.max(followed.map(|(_, joint)| joint).max());
            })?;
            greatest
        };
        let of_set = |set| *self.followed.entry(set).or_insert_with(|| greatest(set));
        sets.map(of_set).max().flatten()
    }
}
