//! The cost of a file's scene, compared with the limits: a short file can use a large mesh many
//! times.

use std::collections::BTreeMap;

use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Mesh, Node, Root};

use super::instancing::Instancing;
use super::meshes;
use super::numbers::vertex_count;
use crate::Limits;
use crate::element::Kind;
use crate::error::{Fault, Reason};
use crate::layout::Layout;
use crate::verdict::Verdict;

/// The vertices of a point or a segment of a line: at most two ends, or a box if it is skinned or
/// morphed.
const SPRITE_VERTICES: u64 = 2;
const BOX_VERTICES: u64 = 8;
const BOX_CORNERS: u64 = 36;

/// The counts of a scene; additions saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Cost {
    primitives: u64,
    vertices: u64,
    listed_vertices: u64,
    corners: u64,
    morph_values: u64,
}

impl Cost {
    fn add(&mut self, other: Self) {
        self.primitives = self.primitives.saturating_add(other.primitives);
        self.vertices = self.vertices.saturating_add(other.vertices);
        self.listed_vertices = self.listed_vertices.saturating_add(other.listed_vertices);
        self.corners = self.corners.saturating_add(other.corners);
        self.morph_values = self.morph_values.saturating_add(other.morph_values);
    }
}

impl Cost {
    fn times(self, count: u64) -> Self {
        let Self { primitives, vertices, listed_vertices, corners, morph_values } = self;
        Self {
            primitives: primitives.saturating_mul(count),
            vertices: vertices.saturating_mul(count),
            // The elements of accessors are read only once.
            listed_vertices,
            corners: corners.saturating_mul(count),
            morph_values: morph_values.saturating_mul(count),
        }
    }
}

/// Fails at the first shown object that exceeds a limit. The rest of the JSON was checked before.
pub(super) fn check(
    root: &Root,
    instancing: &BTreeMap<usize, Instancing>,
    limits: &Limits,
    verdict: &Verdict,
) -> Result<(), Fault> {
    let is_shown = |kind: Kind, index: usize| verdict.is_used(kind.at(index));
    let cost = |(index, mesh): (usize, &Mesh)| {
        if is_shown(Kind::Mesh, index) { cost_of(root, mesh) } else { Cost::default() }
    };
    let costs: Vec<Cost> = root.meshes.iter().enumerate().map(cost).collect();
    check_single(root, limits, verdict)?;
    let mut total = Cost::default();
    for (index, &cost) in costs.iter().enumerate() {
        total.add(Cost { primitives: 0, morph_values: 0, ..cost });
        within(&total, limits).map_err(|reason| reason.of(format!("mesh {index}")))?;
    }
    let skins = root.skins.iter().enumerate().filter(|(index, _)| is_shown(Kind::Skin, *index));
    let mut joints: u64 = skins.map(|(_, skin)| skin.joints.len() as u64).sum();
    for (index, node) in root.nodes.iter().enumerate() {
        if !is_shown(Kind::Node, index) {
            continue;
        }
        let Some(mesh) = node.mesh else { continue };
        let cost = costs.get(mesh.value()).copied().unwrap_or_default();
        let instances = instancing.get(&index).map_or(1, |instancing| instancing.count);
        total.add(of_node(root, node, cost, instances as u64));
        let skin = node.skin.and_then(|skin| root.get(skin));
        let of_skin = skin.map_or(0, |skin| skin.joints.len() as u64);
        joints = joints.saturating_add(of_skin.saturating_mul(cost.primitives));
        within(&total, limits)
            .and_then(|()| below("joints up to it", joints, limits.joints))
            .map_err(|reason| reason.of(format!("node {index}")))?;
    }
    check_keys(root, limits)
}

/// Checks each primitive individually: reading an attribute takes memory for all of its vertices,
/// even if the primitive uses few.
fn check_single(root: &Root, limits: &Limits, verdict: &Verdict) -> Result<(), Fault> {
    for (mesh_index, mesh) in root.meshes.iter().enumerate() {
        if !verdict.is_used(Kind::Mesh.at(mesh_index)) {
            continue;
        }
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let vertices = vertex_count(root, primitive).unwrap_or(0);
            below("vertices", vertices, limits.vertices)
                .map_err(|reason| reason.of(format!("mesh {mesh_index}, primitive {index}")))?;
        }
    }
    Ok(())
}

/// Returns the cost of a node: its objects, and its own meshes if it is skinned or morphed.
fn of_node(root: &Root, node: &Node, cost: Cost, instances: u64) -> Cost {
    let mesh = node.mesh.and_then(|mesh| root.get(mesh));
    let is_skinned = node.skin.is_some() || mesh.is_some_and(|mesh| meshes::target_count(mesh) > 0);
    let primitives = cost.primitives.saturating_mul(instances);
    if is_skinned {
        Cost { primitives, ..cost.times(instances) }
    } else {
        Cost { primitives, ..Cost::default() }
    }
}

fn within(total: &Cost, limits: &Limits) -> Result<(), Reason> {
    below("objects up to it", total.primitives, limits.objects)?;
    below("vertices up to it", total.vertices, limits.vertices)?;
    below("vertices in accessors up to it", total.listed_vertices, limits.listed_vertices)?;
    below("corners of triangles up to it", total.corners, limits.corners)?;
    below("numbers in morph targets and skins up to it", total.morph_values, limits.morph_values)
}

fn below(what: &str, amount: u64, limit: u64) -> Result<(), Reason> {
    if amount > limit { Err(Reason::too_large(what, amount, limit)) } else { Ok(()) }
}

fn cost_of(root: &Root, mesh: &Mesh) -> Cost {
    let mut cost = Cost::default();
    for primitive in &mesh.primitives {
        cost.add(of_primitive(root, primitive));
    }
    cost
}

fn of_primitive(root: &Root, primitive: &Primitive) -> Cost {
    let all = vertex_count(root, primitive).unwrap_or(0);
    let indices =
        primitive.indices.and_then(|indices| root.get(indices)).map(|accessor| accessor.count.0);
    let drawn = indices.unwrap_or(all);
    let used = drawn.min(all);
    let (vertices, corners) = match primitive.mode {
        Checked::Valid(Mode::Triangles) | Checked::Invalid => (used, drawn),
        Checked::Valid(Mode::TriangleStrip | Mode::TriangleFan) => (used, drawn.saturating_mul(3)),
        Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip)
            if !is_skinned_or_morphed(primitive) =>
        {
            (drawn.saturating_mul(SPRITE_VERTICES), 0)
        }
        Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) => {
            (drawn.saturating_mul(BOX_VERTICES), drawn.saturating_mul(BOX_CORNERS))
        }
    };
    // Each target moves up to three attributes of three numbers.
    let targets = primitive.targets.as_ref().map_or(0, Vec::len) as u64;
    let morph_values = vertices.saturating_mul(targets).saturating_mul(9);
    // Each set of four joints has four weights, too.
    let is_joints = |name: &&Checked<Semantic>| matches!(name, Checked::Valid(Semantic::Joints(_)));
    let sets = primitive.attributes.keys().filter(is_joints).count() as u64;
    let morph_values = morph_values.saturating_add(vertices.saturating_mul(sets.saturating_mul(8)));
    let listed_vertices = all.saturating_mul(sets.max(1));
    Cost { primitives: 1, vertices, listed_vertices, corners, morph_values }
}

/// Returns true if joints or targets may move its vertices.
fn is_skinned_or_morphed(primitive: &Primitive) -> bool {
    let has_joints = primitive.attributes.contains_key(&Checked::Valid(Semantic::Joints(0)));
    has_joints || primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty())
}

fn check_keys(root: &Root, limits: &Limits) -> Result<(), Fault> {
    let mut values: u64 = 0;
    for (animation_index, animation) in root.animations.iter().enumerate() {
        for (index, channel) in animation.channels.iter().enumerate() {
            let Some(sampler) = animation.samplers.get(channel.sampler.value()) else { continue };
            for accessor in
                [sampler.input, sampler.output].into_iter().filter_map(|at| root.get(at))
            {
                let components = Layout::of(accessor).map_or(1, |layout| layout.components as u64);
                values = values.saturating_add(accessor.count.0.saturating_mul(components));
            }
            below("numbers in keys up to it", values, limits.key_values).map_err(|reason| {
                reason.of(format!("animation {animation_index}, channel {index}"))
            })?;
        }
    }
    Ok(())
}
