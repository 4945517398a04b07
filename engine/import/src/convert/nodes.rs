//! The nodes of the shown scene, parents before children, and their transforms at rest.

use animation::{Rest, Rig, RigNode, RigNodeId, Trs};
use glam::{Affine3A, DVec3, Mat4, Quat, Vec3, Vec4};
use gltf::animation::Property;
use gltf::json;
use gltf::json::validation::Checked;

use super::near_origin;
use super::numbers::rotation;
use crate::error::quoted;
use crate::load_options::ScenePlace;
use crate::notes::Notes;
use crate::reach::shown_scene;
use crate::{Cause, ImportError, Source};

/// The nodes of the shown scene, depth first: all descendants of a node follow it.
#[derive(Debug)]
pub(super) struct Tree {
    /// The point of the file that is the scene's origin.
    pub(super) origin_m: DVec3,
    /// The nodes as a rig, parents before children.
    pub(super) rig: Rig,
    /// The index in the file of each node.
    pub(super) in_file: Vec<usize>,
    /// The mesh of each node, as an index in the file.
    pub(super) meshes: Vec<Option<u32>>,
    /// The nodes with a camera, and the camera's index in the file.
    pub(super) cameras: Vec<(RigNodeId, usize)>,
    /// The nodes with a light, and the light's index in the file.
    pub(super) lights: Vec<(RigNodeId, usize)>,
    /// The nodes with a skin, in increasing order, and the skin's index in the file.
    pub(super) skins: Vec<(RigNodeId, usize)>,
    /// The id in the rig of each node of the file, if it is in the scene.
    pub(super) ids: Vec<Option<RigNodeId>>,
    /// The world transform of each node at rest.
    pub(super) worlds: Vec<Affine3A>,
    /// True for each node that a clip moves, directly or through an ancestor.
    pub(super) moves: Vec<bool>,
    /// True for each node whose weights of morph targets a clip changes.
    pub(super) morphs: Vec<bool>,
}

impl Tree {
    /// Returns the shown scene. The nodes are taken out of the file: in large scenes they take more
    /// memory than all else.
    pub(super) fn of(
        source: &mut Source,
        place: ScenePlace,
        notes: &mut Notes,
    ) -> Result<Self, ImportError> {
        let empty = gltf::Document::from_json_without_validation(json::Root::default());
        let mut json = std::mem::replace(&mut source.document, empty).into_json();
        let (moved, morphed) = animated(&json);
        let mut all_given = std::mem::take(&mut json.nodes);
        let count = all_given.len();
        let mut nodes: Vec<RigNode> = Vec::with_capacity(count);
        let mut ids = vec![None; count];
        let mut in_file = Vec::with_capacity(count);
        let mut worlds = Vec::with_capacity(count);
        let mut meshes = Vec::with_capacity(count);
        let mut cameras = Vec::new();
        let mut lights = Vec::new();
        let mut skins = Vec::new();
        let mut moves = Vec::with_capacity(count);
        let mut morphs = Vec::with_capacity(count);
        let mut pending: Vec<(usize, Option<RigNodeId>)> =
            roots(&json, notes).into_iter().rev().map(|root| (root, None)).collect();
        while let Some((index, parent)) = pending.pop() {
            let (Some(given), Some(slot @ None)) = (all_given.get_mut(index), ids.get_mut(index))
            else {
                continue;
            };
            let id = RigNodeId(nodes.len() as u32);
            *slot = Some(id);
            let is_moved = moved.get(index).copied().unwrap_or_default();
            let rest = rest(index, given, is_moved, notes);
            let above = parent.map(|parent| parent.0 as usize);
            let world = above.and_then(|above| worlds.get(above).copied());
            worlds.push(world.unwrap_or(Affine3A::IDENTITY) * local(&rest));
            moves.push(is_moved || above.is_some_and(|above| moves.get(above) == Some(&true)));
            morphs.push(morphed.get(index).copied().unwrap_or_default());
            let name = given.name.take().unwrap_or_default();
            nodes.push(RigNode { name, parent, rest, weights: weights(&json.meshes, given) });
            in_file.push(index);
            meshes.push(given.mesh.and_then(|mesh| u32::try_from(mesh.value()).ok()));
            cameras.extend(given.camera.map(|camera| (id, camera.value())));
            skins.extend(given.skin.map(|skin| (id, skin.value())));
            let extensions = given.extensions.as_ref();
            let light = extensions.and_then(|extensions| extensions.khr_lights_punctual.as_ref());
            lights.extend(light.map(|named| (id, named.light.value())));
            let children = given.children.as_deref().unwrap_or_default();
            pending.extend(children.iter().rev().map(|child| (child.value(), Some(id))));
        }
        drop(all_given);
        source.document = gltf::Document::from_json_without_validation(json);
        let mut origin_m = DVec3::ZERO;
        if place == ScenePlace::NearOrigin && !has_moved_root(&nodes, &moves) {
            let places = worlds.iter().zip(&meshes).filter(|(_, mesh)| mesh.is_some());
            let origin = near_origin::origin_of(places.map(|(world, _)| world.translation.into()));
            near_origin::move_nodes(&mut nodes, &mut worlds, origin);
            origin_m = origin.as_dvec3();
        }
        let rig = Rig::new(nodes).map_err(|error| {
            source.error(Cause::Malformed, "nodes".to_owned(), error.to_string())
        })?;
        Ok(Self {
            origin_m,
            rig,
            in_file,
            meshes,
            cameras,
            lights,
            skins,
            ids,
            worlds,
            moves,
            morphs,
        })
    }

    /// Returns the id of a node of the file, if it is in the scene.
    pub(super) fn id_of(&self, in_file: usize) -> Option<RigNodeId> {
        self.ids.get(in_file).copied().flatten()
    }

    /// Returns the skin of a node, as an index in the file.
    pub(super) fn skin(&self, node: RigNodeId) -> Option<usize> {
        let place = self.skins.binary_search_by_key(&node.0, |(skinned, _)| skinned.0).ok()?;
        self.skins.get(place).map(|(_, skin)| *skin)
    }

    /// Returns a node's world transform at rest.
    pub(super) fn world(&self, node: RigNodeId) -> Affine3A {
        self.worlds.get(node.0 as usize).copied().unwrap_or(Affine3A::IDENTITY)
    }

    /// Returns true if a clip moves a node or one of its ancestors.
    pub(super) fn moves(&self, node: RigNodeId) -> bool {
        self.moves.get(node.0 as usize) == Some(&true)
    }

    pub(super) fn node(&self, node: RigNodeId) -> Option<&RigNode> {
        self.rig.nodes().get(node.0 as usize)
    }

    pub(super) fn name(&self, node: RigNodeId) -> String {
        let name = self.node(node).map(|node| node.name.as_str()).unwrap_or_default();
        let in_file = self.in_file.get(node.0 as usize).copied().unwrap_or_default();
        match name {
            "" => format!("node {in_file}"),
            name => format!("node {in_file} ({})", quoted(name)),
        }
    }
}

/// Returns true if a clip moves a root.
fn has_moved_root(nodes: &[RigNode], moves: &[bool]) -> bool {
    nodes.iter().zip(moves).any(|(node, moves)| node.parent.is_none() && *moves)
}

fn roots(json: &json::Root, notes: &mut Notes) -> Vec<usize> {
    let Some(chosen) = shown_scene(json) else { return Vec::new() };
    if json.scenes.len() > 1 {
        notes.say(format!("of {} scenes, only scene {chosen} is shown", json.scenes.len()));
    }
    let nodes = json.scenes.get(chosen).into_iter().flat_map(|scene| &scene.nodes);
    nodes.map(|node| node.value()).collect()
}

/// Returns, for each node of the file, true if an animation moves it, and true if one changes its
/// weights.
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

fn rest(index: usize, given: &json::Node, is_moved: bool, notes: &mut Notes) -> Rest {
    let place = || format!("node {index}");
    if let Some(matrix) = &given.matrix {
        let given = [given.translation.is_some(), given.rotation.is_some(), given.scale.is_some()];
        notes.count(
            "it has a matrix beside translation, rotation or scale, which are ignored",
            usize::from(given.contains(&true)),
            place,
        );
        let columns = Mat4::from_cols_array(matrix);
        let is_affine = columns.row(3).abs_diff_eq(Vec4::W, 1e-5);
        notes.count(
            "its matrix is not a transform: the last row is taken as 0, 0, 0, 1",
            usize::from(!is_affine),
            place,
        );
        let matrix = Affine3A::from_mat4(columns);
        if !is_moved {
            let shears = usize::from(shears(&matrix));
            notes.count("its matrix shears, and is used as it is", shears, place);
            return Rest::Matrix(matrix);
        }
        // The specification forbids this, but files do it: a clip can only animate separate parts.
        let what = "animations move it, so that its matrix is taken apart";
        notes.count(what, 1, place);
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        let rotation = super::numbers::rotation(rotation.to_array()).unwrap_or(Quat::IDENTITY);
        return Rest::Parts(Trs { translation, rotation, scale });
    }
    let rotation = given.rotation.map_or(Some(Quat::IDENTITY), |given| rotation(given.0));
    if rotation.is_none() {
        notes.count("its rotation is of length 0, and taken as none", 1, place);
    }
    let length = given.rotation.map_or(1.0, |rotation| Vec4::from_array(rotation.0).length());
    let is_off = rotation.is_some() && (length - 1.0).abs() > 1e-3;
    notes.count("its rotation is not of length 1, and is normalised", usize::from(is_off), place);
    Rest::Parts(Trs {
        translation: given.translation.map_or(Vec3::ZERO, Vec3::from_array),
        rotation: rotation.unwrap_or(Quat::IDENTITY),
        scale: given.scale.map_or(Vec3::ONE, Vec3::from_array),
    })
}

/// Returns true if the axes of a matrix are not perpendicular: it has no rotation and scale then.
fn shears(matrix: &Affine3A) -> bool {
    let [x, y, z] =
        [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.normalize_or_zero());
    [x.dot(y), y.dot(z), z.dot(x)].iter().any(|cosine| cosine.abs() > 1e-3)
}

/// Returns the transform from a node's space to its parent's, at rest.
pub(super) fn local(rest: &Rest) -> Affine3A {
    match rest {
        Rest::Matrix(matrix) => *matrix,
        Rest::Parts(Trs { translation, rotation, scale }) => {
            Affine3A::from_scale_rotation_translation(*scale, *rotation, *translation)
        }
    }
}

/// Returns the weights of a node's morph targets: its own, else its mesh's, else zeros.
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
