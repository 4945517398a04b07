//! Checks of the values in buffers that are indices: sparse indices, indices of primitives, joints.

use std::collections::HashMap;

use gltf::Semantic;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::mesh::Primitive;
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Root};

use super::numbers::vertex_count;
use crate::element::Kind;
use crate::elements::{self, Store};
use crate::error::{At, Fault, Reason};
use crate::verdict::Verdict;

/// Checks the values that are used. The JSON was checked before.
pub(crate) fn indices_and_joints(
    root: &Root,
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
    let (known, followed) = (HashMap::new(), HashMap::new());
    let mut greatest = Greatest { root, store, known, followed };
    let mut joints_of_meshes = Vec::with_capacity(root.meshes.len());
    for (mesh_index, mesh) in root.meshes.iter().enumerate() {
        let mut joints = None;
        if !verdict.is_required(Kind::Mesh.at(mesh_index)) {
            joints_of_meshes.push(joints);
            continue;
        }
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            greatest
                .check_indices(primitive)
                .at(|| format!("mesh {mesh_index}, primitive {index}, indices"))?;
            joints = joints.max(greatest.joint(primitive));
        }
        joints_of_meshes.push(joints);
    }
    check_skinned(&mut greatest, &joints_of_meshes, verdict)
}

fn check_sparse(root: &Root, store: &Store, sparse: &Sparse, count: u64) -> Result<(), Reason> {
    let mut last = None;
    for index in elements::sparse_indices(root, store, sparse) {
        if u64::from(index) >= count {
            let text = format!("element {index} is replaced, but there are {count}");
            return Err(Reason::malformed(text));
        }
        if last.is_some_and(|last| last >= index) {
            return Err(Reason::malformed("they do not increase"));
        }
        last = Some(index);
    }
    Ok(())
}

/// Checks that vertices follow joints that are there. A joint without weight may be any (3.7.3.3
/// asks for 0).
fn check_skinned(
    greatest: &mut Greatest<'_>,
    joints_of_meshes: &[Option<u32>],
    verdict: &Verdict,
) -> Result<(), Fault> {
    let root = greatest.root;
    let mut weighed: HashMap<usize, Option<u32>> = HashMap::new();
    let nodes = root.nodes.iter().enumerate();
    for (index, node) in nodes.filter(|(index, _)| verdict.is_required(Kind::Node.at(*index))) {
        let (Some(mesh), Some(skin)) = (node.mesh, node.skin) else { continue };
        let joints = root.get(skin).map_or(0, |skin| skin.joints.len());
        let is_beyond = |joint: &u32| *joint as usize >= joints;
        let named = joints_of_meshes.get(mesh.value()).copied().flatten();
        if named.filter(is_beyond).is_none() {
            continue;
        }
        let followed = *weighed.entry(mesh.value()).or_insert_with(|| {
            let primitives = root.get(mesh).map_or(&[][..], |mesh| mesh.primitives.as_slice());
            primitives.iter().filter_map(|primitive| greatest.followed_joint(primitive)).max()
        });
        if let Some(joint) = followed.filter(is_beyond) {
            let (mesh, skin) = (mesh.value(), skin.value());
            let text =
                format!("mesh {mesh} hangs on joint {joint}, but skin {skin} has {joints} joints");
            return Err(Reason::malformed(text).of(format!("node {index}")));
        }
    }
    Ok(())
}

/// The greatest values of accessors, each found once even if many primitives share it.
struct Greatest<'a> {
    root: &'a Root,
    store: &'a Store,
    known: HashMap<usize, u32>,
    /// The greatest joints with a weight, by the accessors of joints and weights.
    followed: HashMap<[usize; 2], Option<u32>>,
}

impl Greatest<'_> {
    fn of<const N: usize>(&mut self, accessor: Index<Accessor>) -> u32 {
        let (root, store) = (self.root, self.store);
        *self.known.entry(accessor.value()).or_insert_with(|| {
            let mut greatest = 0;
            elements::for_each_integers::<N>((root, store), accessor.value(), None, |values| {
                greatest = values.into_iter().fold(greatest, u32::max);
            });
            greatest
        })
    }

    fn check_indices(&mut self, primitive: &Primitive) -> Result<(), Reason> {
        let vertices = vertex_count(self.root, primitive);
        let (Some(indices), Some(vertices)) = (primitive.indices, vertices) else {
            return Ok(());
        };
        let greatest = self.of::<1>(indices);
        if u64::from(greatest) < vertices {
            return Ok(());
        }
        Err(Reason::malformed(format!("vertex {greatest} does not exist, there are {vertices}")))
    }

    fn joint(&mut self, primitive: &Primitive) -> Option<u32> {
        let joints = primitive.attributes.iter().filter_map(|(semantic, &accessor)| {
            matches!(semantic, Checked::Valid(Semantic::Joints(_))).then_some(accessor)
        });
        joints.map(|accessor| self.of::<4>(accessor)).max()
    }

    /// Returns the greatest joint that a vertex follows by some weight.
    fn followed_joint(&mut self, primitive: &Primitive) -> Option<u32> {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic));
        let set =
            |set| Some([attribute(Semantic::Joints(set))?, attribute(Semantic::Weights(set))?]);
        let sets = (0..).map_while(set).map(|set| set.map(|accessor| accessor.value()));
        let (root, store) = (self.root, self.store);
        let greatest = |[joints, weights]: [usize; 2]| {
            let mut has_weight: Vec<u8> = Vec::new();
            elements::for_each_floats::<4>((root, store), weights, None, |weights| {
                let bits = (0..4).zip(weights).filter(|(_, weight)| *weight > 0.0);
                has_weight.push(bits.map(|(place, _)| 1 << place).sum());
            })?;
            let (mut vertices, mut greatest) = (has_weight.iter(), None);
            elements::for_each_integers::<4>((root, store), joints, None, |joints| {
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
