//! The scene under construction, shared by all modules that add to it.

use std::collections::HashMap;

use animation::RigNodeId;
use cull::{Aabb, ObjectId};
use glam::Affine3A;
use scene::{Mesh, MeshId, Object, Scene, Sprites, SurfaceMesh, Surfaces, TransparentId};

use super::budget::Budget;
use super::geometry::Geometry;
use super::initial_view::InitialView;
use super::instancing;
use super::materials::{MaterialUse, Materials};
use super::nodes::Tree;
use super::numbers::keeps_areas;
use super::pack::pack;
use super::primitives::Primitive;
use super::shared::{Plan, place_shared};
use super::skinned::place_skinned;
use super::skinned_extents::SkinnedExtents;
use super::skins::Skins;
use crate::gltf_scene::{NodeAttachment, PlacedNode};
use crate::load_options::LoadOptions;
use crate::losses::Losses;
use crate::notes::Notes;
use crate::{Cause, ImportError, Source};

/// The index of no tint: white, so the material's own colour shows.
pub(super) const NO_TINT: u32 = u32::MAX;

/// The scene under construction.
pub(super) struct Assembly<'a> {
    pub(super) source: &'a Source,
    pub(super) tree: &'a Tree,
    pub(super) notes: Notes,
    pub(super) losses: Losses,
    pub(super) scene: Scene,
    pub(super) surfaces: Surfaces,
    pub(super) materials: Materials,
    pub(super) skins: Skins,
    pub(super) placements: Vec<NodeAttachment>,
    /// The node of each object of the scene.
    pub(super) object_nodes: Vec<RigNodeId>,
    pub(super) skinned_extents: SkinnedExtents,
    /// True for each node that is mirrored at some times and not at others.
    pub(super) turns: Vec<bool>,
    /// True for each skin that has such a node as a joint.
    pub(super) turning_skins: HashMap<usize, bool>,
    pub(super) budget: Budget,
    /// The value of [`LoadOptions::cut_above_triangles`](crate::LoadOptions::cut_above_triangles).
    pub(super) cut_above: Option<usize>,
    /// The finished share of the nodes, 0 to 1.
    pub(super) done: f32,
    /// The progress function, which may stop loading.
    pub(super) progress_fn: &'a mut ShareFn<'a>,
    /// The number of parts placed since the last report.
    pub(super) unreported: usize,
    /// The view that determines the size of points and lines.
    pub(super) sight: InitialView<'a>,
    /// The number of objects added by splitting transparent meshes into parts.
    pub(super) transparent_parts: usize,
}

/// The function that receives the finished share.
pub(super) type ShareFn<'a> = dyn FnMut(f32) -> Result<(), ImportError> + 'a;

/// The number of parts placed between two reports of progress.
pub(super) const PARTS_PER_REPORT: usize = 256;

impl<'a> Assembly<'a> {
    /// Returns an assembly without any placed part.
    pub(super) fn new(
        source: &'a Source,
        tree: &'a Tree,
        options: &LoadOptions,
        skinned_extents: SkinnedExtents,
        sight: InitialView<'a>,
        scene: Scene,
        progress_fn: &'a mut ShareFn<'a>,
    ) -> Self {
        Self {
            source,
            tree,
            notes: Notes::default(),
            losses: Losses::default(),
            scene,
            surfaces: Surfaces::default(),
            materials: Materials::default(),
            skins: Skins::default(),
            placements: Vec::new(),
            object_nodes: Vec::new(),
            turns: skinned_extents.turning(&tree.rig),
            turning_skins: HashMap::new(),
            skinned_extents,
            budget: Budget::new(&options.limits),
            cut_above: options.cut_above_triangles,
            done: 0.0,
            progress_fn,
            unreported: PARTS_PER_REPORT,
            sight,
            transparent_parts: 0,
        }
    }

    /// Reports progress from time to time; must be called for each placed part.
    pub(super) fn report(&mut self) -> Result<(), ImportError> {
        self.unreported += 1;
        if self.unreported < PARTS_PER_REPORT {
            return Ok(());
        }
        self.unreported = 0;
        (self.progress_fn)(self.done)
    }

    /// Returns true if clips turn the contents of a node inside out, which is noted.
    pub(super) fn may_turn(&mut self, node: RigNodeId) -> bool {
        let may_turn = self.turns.get(node.0 as usize) == Some(&true);
        if may_turn {
            self.note_turning(node);
        }
        may_turn
    }

    pub(super) fn note_turning(&mut self, node: RigNodeId) {
        let what = "clips mirror it at one time and not at another: it is seen from both sides";
        self.notes.count(what, 1, || self.tree.name(node));
    }

    /// Returns the result of converting a primitive, or `None` with a note if the primitive is
    /// broken.
    ///
    /// # Errors
    /// The error, if it refuses the file.
    pub(super) fn unbroken<T>(
        &mut self,
        made: Result<Option<T>, ImportError>,
    ) -> Result<Option<T>, ImportError> {
        made.or_else(|error| {
            let consequence = "this primitive is left out";
            let left_out = self.losses.leave_out(error.into(), consequence, &mut self.notes);
            left_out.map(|()| None).map_err(|fault| fault.in_file(&self.source.file))
        })
    }

    /// Returns a primitive of the file.
    pub(super) fn primitive(&self, mesh: usize, number: usize) -> Option<Primitive<'a>> {
        let given = self.source.document.as_json().meshes.get(mesh)?;
        Some(Primitive { source: self.source, json: given.primitives.get(number)?, mesh, number })
    }

    /// Returns a name for the mesh of a primitive.
    pub(super) fn name_of(&self, mesh: usize, number: usize) -> String {
        let given = self.source.document.as_json().meshes.get(mesh);
        let name = given.and_then(|given| given.name.clone()).filter(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| format!("mesh {mesh}"));
        match given.map(|given| given.primitives.len()) {
            Some(2..) => format!("{name}, {number}"),
            _ => name,
        }
    }

    /// Adds the contents of a node to the scene.
    pub(super) fn place(&mut self, plan: &mut Plan, node: RigNodeId) -> Result<(), ImportError> {
        let Some(mesh) = self.tree.meshes.get(node.0 as usize).copied().flatten() else {
            return Ok(());
        };
        let mesh = mesh as usize;
        let in_file = self.tree.in_file.get(node.0 as usize).copied().unwrap_or_default();
        let instances = self.source.instancing.get(&in_file).copied();
        let tree = self.tree;
        let name = || tree.name(node);
        let locals = instancing::locals(self.source, instances, &mut self.notes, name);
        for number in 0..plan.primitives(mesh) {
            let Some(primitive) = self.primitive(mesh, number) else { continue };
            let Some(kind) = plan.kind(mesh, number) else { continue };
            let skin = tree.skin(node);
            if skin.is_some() && !primitive.is_skinned() {
                let what = "its mesh has no joints, and its skin is ignored";
                self.notes.count(what, 1, || tree.name(node));
            }
            let skin = skin.filter(|_| primitive.is_skinned());
            if skin.is_some() || self.is_morphed(node, &primitive) {
                let name = self.name_of(mesh, number);
                place_skinned(self, &primitive, kind.material, name, node, skin, &locals)?;
            } else {
                place_shared(self, kind, &primitive, node, &locals)?;
            }
        }
        Ok(())
    }

    /// Returns true if morph targets change a primitive of a node at rest or while a clip plays.
    fn is_morphed(&self, node: RigNodeId, primitive: &Primitive<'_>) -> bool {
        let weights = self.tree.node(node).map(|node| node.weights.as_slice()).unwrap_or_default();
        let is_animated = self.tree.morphs.get(node.0 as usize) == Some(&true);
        !primitive.targets().is_empty()
            && (is_animated || weights.iter().any(|weight| *weight != 0.0))
    }

    /// Adds a mesh to the scene.
    pub(super) fn add_mesh(
        &mut self,
        geometry: &Geometry,
        material: &MaterialUse,
        name: String,
    ) -> MeshId {
        let (mesh, surface) = pack(geometry, name, material.id, material.base_colour);
        self.push_mesh(mesh, surface)
    }

    /// Adds a mesh of sprites to the scene.
    pub(super) fn add_sprites(
        &mut self,
        sprites: Sprites,
        material: &MaterialUse,
        name: String,
    ) -> MeshId {
        let vertices = Vec::new();
        let indices = Vec::new();
        let mesh = Mesh { name, vertices, indices, bounds: sprites.bounds(), has_backs: false };
        let surface = SurfaceMesh { vertices: Vec::new(), material: material.id };
        let mesh = self.push_mesh(mesh, surface);
        self.surfaces.sprites.push(Sprites { mesh, ..sprites });
        mesh
    }

    fn push_mesh(&mut self, mesh: Mesh, surface: SurfaceMesh) -> MeshId {
        self.scene.meshes.push(mesh);
        self.surfaces.meshes.push(surface);
        MeshId(self.scene.meshes.len() as u32 - 1)
    }

    /// Returns true if a mesh at `transform` can be visible, now or when its node has moved.
    pub(super) fn can_be_seen(&mut self, node: RigNodeId, transform: &Affine3A) -> bool {
        let tree = self.tree;
        let at_rest = !self.tree.moves(node);
        if !transform.is_finite() {
            let what = "its place is beyond all numbers, and it is left out";
            self.notes.count(what, 1, || tree.name(node));
            return false;
        }
        if at_rest && !keeps_areas(transform) {
            let what = "it is scaled to nothing, and left out";
            self.notes.count(what, 1, || tree.name(node));
            return false;
        }
        true
    }

    /// Notes that an object is left out because it is too far away or too large for a box.
    pub(super) fn leave_out_huge(&mut self, node: RigNodeId) {
        let tree = self.tree;
        let what = "it reaches beyond all numbers, and is left out";
        self.notes.count(what, 1, || tree.name(node));
    }

    /// Adds an opaque or transparent object of a node.
    pub(super) fn add_object(
        &mut self,
        node: RigNodeId,
        object: Object,
        material: &MaterialUse,
    ) -> Result<PlacedNode, ImportError> {
        let list = if material.is_transparent {
            &mut self.surfaces.transparent
        } else {
            &mut self.scene.objects
        };
        let Ok(number) = u32::try_from(list.len()) else {
            let reason = "it has more objects than can be counted".to_owned();
            return Err(self.source.error(Cause::TooLarge, "scene".to_owned(), reason));
        };
        list.push(object);
        Ok(if material.is_transparent {
            PlacedNode::Transparent(TransparentId(number))
        } else {
            self.object_nodes.push(node);
            PlacedNode::Object(ObjectId(number))
        })
    }
}

/// Returns the attachment of an object that is not skinned.
pub(super) fn rigid(node: RigNodeId, placed: PlacedNode, local: Affine3A) -> NodeAttachment {
    NodeAttachment {
        node,
        placed,
        local,
        skinned_mesh: None,
        seen_at_rest: Aabb::EMPTY,
        reach: Aabb::EMPTY,
    }
}
