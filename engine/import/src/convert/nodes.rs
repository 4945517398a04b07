//! Nodes: those of one scene of the file, parents before children, and where they are at rest.

use animation::{Node, NodeId, Rest, Rig, Trs};
use glam::{Affine3A, Mat4, Quat, Vec3};
use gltf::animation::Property;
use gltf::json;
use gltf::json::validation::Checked;

use super::notes::Notes;
use super::numbers::rotation;
use crate::error::quoted;
use crate::{Cause, ImportError, Source};

/// The nodes of the scene that is shown: depth first, so that all that is below a node follows it.
#[derive(Debug)]
pub(super) struct Tree {
    /// The nodes.
    pub(super) rig: Rig,
    /// For each of them, its number in the file.
    pub(super) in_file: Vec<usize>,
    /// For each of them, the mesh of the file that it has.
    pub(super) meshes: Vec<Option<u32>>,
    /// Those that have a camera of the file, and which.
    pub(super) cameras: Vec<(NodeId, usize)>,
    /// Those that have a light of the file, and which.
    pub(super) lights: Vec<(NodeId, usize)>,
    /// For each node of the file, what it is here, if it is.
    pub(super) ids: Vec<Option<NodeId>>,
    /// For each of them, where it is in the world at rest.
    pub(super) worlds: Vec<Affine3A>,
    /// For each of them, whether a clip moves it or what it hangs on.
    pub(super) moves: Vec<bool>,
    /// For each of them, whether a clip changes its morph targets' weights.
    pub(super) morphs: Vec<bool>,
}

impl Tree {
    /// The scene that the file says, else its first one, else all nodes without a parent. The names of its
    /// nodes are taken out of the file.
    ///
    /// # Errors
    /// Nodes that are their own ancestors.
    pub(super) fn of(source: &mut Source, notes: &mut Notes) -> Result<Self, ImportError> {
        let empty = gltf::Document::from_json_without_validation(json::Root::default());
        let mut json = std::mem::replace(&mut source.document, empty).into_json();
        let (moved, morphed) = animated(&json);
        let count = json.nodes.len();
        let mut nodes: Vec<Node> = Vec::with_capacity(count);
        let mut ids = vec![None; count];
        let (mut in_file, mut worlds) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut meshes = Vec::with_capacity(count);
        let (mut cameras, mut lights) = (Vec::new(), Vec::new());
        let (mut moves, mut morphs) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut pending: Vec<(usize, Option<NodeId>)> =
            roots(&json, notes).into_iter().rev().map(|root| (root, None)).collect();
        while let Some((index, parent)) = pending.pop() {
            let (Some(given), Some(slot @ None)) = (json.nodes.get_mut(index), ids.get_mut(index))
            else {
                continue;
            };
            let id = NodeId(nodes.len() as u32);
            *slot = Some(id);
            let is_moved = moved.get(index).copied().unwrap_or_default();
            let rest = rest(given, is_moved, notes);
            let above = parent.map(|parent| parent.0 as usize);
            let world = above.and_then(|above| worlds.get(above).copied());
            worlds.push(world.unwrap_or(Affine3A::IDENTITY) * local(&rest));
            moves.push(is_moved || above.is_some_and(|above| moves.get(above) == Some(&true)));
            morphs.push(morphed.get(index).copied().unwrap_or_default());
            let name = given.name.take().unwrap_or_default();
            nodes.push(Node { name, parent, rest, weights: weights(&json.meshes, given) });
            in_file.push(index);
            meshes.push(given.mesh.and_then(|mesh| u32::try_from(mesh.value()).ok()));
            cameras.extend(given.camera.map(|camera| (id, camera.value())));
            let extensions = given.extensions.as_ref();
            let light = extensions.and_then(|it| it.khr_lights_punctual.as_ref());
            lights.extend(light.map(|named| (id, named.light.value())));
            let children = given.children.as_deref().unwrap_or_default();
            pending.extend(children.iter().rev().map(|child| (child.value(), Some(id))));
        }
        source.document = gltf::Document::from_json_without_validation(json);
        let rig = rig_of(nodes, source)?;
        Ok(Self { rig, in_file, meshes, cameras, lights, ids, worlds, moves, morphs })
    }

    /// What a node of the file is here, if it is.
    pub(super) fn id_of(&self, in_file: usize) -> Option<NodeId> {
        self.ids.get(in_file).copied().flatten()
    }

    /// Where a node is in the world at rest.
    pub(super) fn world(&self, node: NodeId) -> Affine3A {
        self.worlds.get(node.0 as usize).copied().unwrap_or(Affine3A::IDENTITY)
    }

    /// Whether a clip moves a node or what it hangs on.
    pub(super) fn moves(&self, node: NodeId) -> bool {
        self.moves.get(node.0 as usize) == Some(&true)
    }

    /// A node.
    pub(super) fn node(&self, node: NodeId) -> Option<&Node> {
        self.rig.nodes().get(node.0 as usize)
    }

    /// What people call a node.
    pub(super) fn name(&self, node: NodeId) -> String {
        let name = self.node(node).map(|node| node.name.as_str()).unwrap_or_default();
        let in_file = self.in_file.get(node.0 as usize).copied().unwrap_or_default();
        match name {
            "" => format!("node {in_file}"),
            name => format!("node {in_file} ({})", quoted(name)),
        }
    }
}

fn rig_of(nodes: Vec<Node>, source: &Source) -> Result<Rig, ImportError> {
    Rig::new(nodes)
        .map_err(|error| source.error(Cause::Malformed, "nodes".to_owned(), error.to_string()))
}

fn roots(json: &json::Root, notes: &mut Notes) -> Vec<usize> {
    let chosen = json.scene.map_or(0, |scene| scene.value());
    if let Some(scene) = json.scenes.get(chosen) {
        if json.scenes.len() > 1 {
            notes.say(format!("of {} scenes, only scene {chosen} is shown", json.scenes.len()));
        }
        return scene.nodes.iter().map(json::Index::value).collect();
    }
    let mut is_child = vec![false; json.nodes.len()];
    for child in json.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    (0..json.nodes.len()).filter(|node| is_child.get(*node) == Some(&false)).collect()
}

/// For each node of the file, whether an animation moves it, and whether one changes its weights.
fn animated(json: &json::Root) -> (Vec<bool>, Vec<bool>) {
    let mut moved = vec![false; json.nodes.len()];
    let mut morphed = vec![false; json.nodes.len()];
    for channel in json.animations.iter().flat_map(|animation| &animation.channels) {
        let list = match channel.target.path {
            Checked::Valid(Property::MorphTargetWeights) => &mut morphed,
            Checked::Valid(_) => &mut moved,
            Checked::Invalid => continue,
        };
        if let Some(is_animated) = list.get_mut(channel.target.node.value()) {
            *is_animated = true;
        }
    }
    (moved, morphed)
}

fn rest(given: &json::Node, is_moved: bool, notes: &mut Notes) -> Rest {
    if let Some(matrix) = &given.matrix {
        let matrix = Affine3A::from_mat4(Mat4::from_cols_array(matrix));
        if !is_moved {
            return Rest::Matrix(matrix);
        }
        // The specification forbids it, files do it: a clip can move parts only.
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        let rotation = super::numbers::rotation(rotation.to_array()).unwrap_or(Quat::IDENTITY);
        return Rest::Parts(Trs { translation, rotation, scale });
    }
    let rotation = given.rotation.map_or(Some(Quat::IDENTITY), |given| rotation(given.0));
    if rotation.is_none() {
        notes.count("rotations of length 0, taken as none", 1, || {
            format!("node {}", quoted(given.name.as_deref().unwrap_or_default()))
        });
    }
    Rest::Parts(Trs {
        translation: given.translation.map_or(Vec3::ZERO, Vec3::from_array),
        rotation: rotation.unwrap_or(Quat::IDENTITY),
        scale: given.scale.map_or(Vec3::ONE, Vec3::from_array),
    })
}

/// From a node's space to its parent's, at rest.
pub(super) fn local(rest: &Rest) -> Affine3A {
    match rest {
        Rest::Matrix(matrix) => *matrix,
        Rest::Parts(Trs { translation, rotation, scale }) => {
            Affine3A::from_scale_rotation_translation(*scale, *rotation, *translation)
        }
    }
}

/// The weights of a node's morph targets: its own, else its mesh's, else zeros.
fn weights(meshes: &[json::Mesh], given: &json::Node) -> Vec<f32> {
    let Some(mesh) = given.mesh.and_then(|mesh| meshes.get(mesh.value())) else {
        return Vec::new();
    };
    let targets = mesh.primitives.first().and_then(|primitive| primitive.targets.as_ref());
    let count = targets.map_or(0, Vec::len);
    let mut weights = given.weights.clone().or_else(|| mesh.weights.clone()).unwrap_or_default();
    weights.resize(count, 0.0);
    weights
}
