//! The state of the viewer: the display and the place of each part, as a pure value.

use std::collections::{BTreeSet, HashMap};

use antumbra::ObjectId;
use antumbra::cull::{Aabb, SectionMember};
use antumbra::glam::{Affine3A, DVec3, Vec3};
use antumbra::scene::{Mesh, MeshId, Object, PreparedMesh, Scene, TessellationLevels};
use scenes::{CurvedMesh, Hinge, PartId, PartTree};
use thiserror::Error;

use crate::explode::explode;
use crate::hinge::{BadSolid, CollisionSolid, LidCollision, Turn, rotation};

/// The way in which a part is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Display {
    /// Shown with its own material.
    #[default]
    Shown,
    /// Transparent.
    Ghosted,
    /// Hidden.
    Hidden,
}

/// A lid and its hinge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lid {
    /// The group of all parts that turn.
    pub group: PartId,
    /// The hinge of the lid.
    pub hinge: Hinge,
}

/// A command that is impossible. Nothing has changed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CommandError {
    /// A name that no part and no group has.
    #[error("there is no part and no group '{0}'")]
    NoPart(String),
    /// A command about the selection while nothing is selected.
    #[error("nothing is selected: pick or select a part first, or name one")]
    NothingSelected,
    /// A model without a lid.
    #[error("this model has no lid on a hinge")]
    NoLid,
    /// A lid whose parts have been moved apart.
    #[error("the parts are apart: move them back (assemble) before the lid turns")]
    Exploded,
    /// A model with too many parts to show some of them transparent.
    #[error("parts are shown transparent in models of at most {0} parts, and this one has more")]
    TooManyToGhost(usize),
    /// Parts that cannot collide.
    #[error(transparent)]
    BadSolid(#[from] BadSolid),
}

/// A curved mesh of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvedPart {
    /// The mesh and its surface.
    pub curved: CurvedMesh,
    /// The levels of the mesh; `None` for the mesh of the loaded model.
    pub levels: Option<TessellationLevels>,
}

/// Objects that stay together in exploded views.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The objects of the body.
    pub objects: Vec<ObjectId>,
    /// The box around them.
    pub bounds: Aabb,
}

/// A model and the state in which it is shown.
pub struct Document {
    /// The scene at rest. Its objects are the parts.
    pub scene: Scene,
    /// The point of the model's file that is the scene's origin, in metres; zero after creation.
    pub origin_m: DVec3,
    /// The tree of parts and groups.
    pub parts: PartTree,
    /// The lid, if the model has one.
    pub lid: Option<Lid>,
    /// The curved meshes; empty after creation.
    pub curved: Vec<CurvedPart>,
    /// The body of each object. The objects of a body, such as the primitives of a mesh, stay
    /// together in exploded views. If empty, as after creation, each object is its own body.
    pub bodies: Vec<u32>,
    /// The part of each object.
    part_of_object: Vec<Option<PartId>>,
    displays: Vec<Display>,
    displacements: Vec<Vec3>,
    members: Vec<SectionMember>,
    turns: Vec<bool>,
    lid_rad: f32,
    selected: BTreeSet<ObjectId>,
    collision: Option<LidCollision>,
}

impl Document {
    /// Creates the state at rest: all parts are shown in their places, and nothing is selected.
    pub fn new(scene: Scene, parts: PartTree, lid: Option<Lid>) -> Self {
        let count = scene.objects.len();
        let mut part_of_object = vec![None; count];
        for (number, node) in (0..).zip(&parts.nodes) {
            let object = node.object.and_then(|object| part_of_object.get_mut(object.0 as usize));
            if let Some(part) = object {
                *part = Some(PartId(number));
            }
        }
        let mut turns = vec![false; count];
        for object in lid.iter().flat_map(|lid| parts.objects_of(lid.group)) {
            if let Some(turns) = turns.get_mut(object.0 as usize) {
                *turns = true;
            }
        }
        Self {
            displays: vec![Display::Shown; count],
            displacements: vec![Vec3::ZERO; count],
            members: vec![SectionMember::Cut; count],
            turns,
            lid_rad: lid.map_or(0.0, |lid| lid.hinge.closed_rad),
            selected: BTreeSet::new(),
            collision: None,
            curved: Vec::new(),
            bodies: Vec::new(),
            scene,
            origin_m: DVec3::ZERO,
            parts,
            lid,
            part_of_object,
        }
    }

    /// Returns the objects of the scene at rest.
    pub fn objects(&self) -> impl Iterator<Item = ObjectId> + use<> {
        (0..self.scene.objects.len() as u32).map(ObjectId)
    }

    /// Returns the way in which an object is shown.
    pub fn display(&self, object: ObjectId) -> Display {
        self.displays.get(object.0 as usize).copied().unwrap_or(Display::Hidden)
    }

    /// Returns how section planes affect an object.
    pub fn member(&self, object: ObjectId) -> SectionMember {
        self.members.get(object.0 as usize).copied().unwrap_or_default()
    }

    /// Changes how section planes affect objects.
    pub fn set_member(&mut self, objects: &[ObjectId], member: SectionMember) {
        for object in objects {
            if let Some(of) = self.members.get_mut(object.0 as usize) {
                *of = member;
            }
        }
    }

    /// Returns the current transform of an object.
    pub fn transform(&self, object: ObjectId) -> Affine3A {
        let index = object.0 as usize;
        let rest =
            self.scene.objects.get(index).map_or(Affine3A::IDENTITY, |object| object.transform);
        let turned = match &self.lid {
            Some(lid) if self.turns[index] => rotation(&lid.hinge, self.lid_rad) * rest,
            _ => rest,
        };
        let by = self.displacements.get(index).copied().unwrap_or_default();
        Affine3A { translation: turned.translation + antumbra::glam::Vec3A::from(by), ..turned }
    }

    /// Returns the box of an object in its current place.
    pub fn bounds(&self, object: ObjectId) -> Aabb {
        let of = self.scene.objects.get(object.0 as usize);
        let placed = of.map(|of| Object { transform: self.transform(object), ..*of });
        placed.and_then(|placed| self.scene.bounds_of(&placed)).unwrap_or(Aabb::EMPTY)
    }

    /// Returns the transparent objects of the scene. They are not parts: they are always shown in
    /// their places.
    pub fn transparent(&self) -> &[Object] {
        self.scene.surfaces.as_ref().map_or(&[], |surfaces| &surfaces.transparent)
    }

    /// Returns the box around everything that is shown; the origin if nothing is.
    pub fn shown_bounds(&self) -> Aabb {
        let shown = self.objects().filter(|object| self.display(*object) != Display::Hidden);
        let parts = shown.map(|object| self.bounds(object));
        let transparent = self.transparent().iter();
        let transparent = transparent.filter_map(|object| self.scene.bounds_of(object));
        let all = parts.chain(transparent).fold(Aabb::EMPTY, |all, of| all.union(&of));
        if all.min.is_finite() && all.max.is_finite() {
            return all;
        }
        Aabb { min: Vec3::ZERO, max: Vec3::ZERO }
    }

    /// Returns the mesh of an object.
    pub fn mesh(&self, object: ObjectId) -> Option<&Mesh> {
        self.scene.mesh_of(self.scene.objects.get(object.0 as usize)?)
    }

    /// Replaces a mesh of the scene and its surface.
    pub fn set_mesh(&mut self, id: MeshId, mesh: PreparedMesh) {
        let index = id.0 as usize;
        let Scene { meshes, surfaces, .. } = &mut self.scene;
        let surface = surfaces.as_mut().and_then(|surfaces| surfaces.meshes.get_mut(index));
        if let (Some(old), Some(new)) = (surface, mesh.surface()) {
            *old = new.clone();
        }
        if let Some(old) = meshes.get_mut(index) {
            *old = mesh.mesh().clone();
        }
        self.collision = None;
    }

    /// Returns the name of an object's part.
    pub fn name(&self, object: ObjectId) -> &str {
        let part = self.part_of_object.get(object.0 as usize).copied().flatten();
        part.and_then(|part| self.parts.node(part)).map_or("", |node| &node.name)
    }

    /// Returns the angle of the lid, in radians.
    pub fn lid_rad(&self) -> f32 {
        self.lid_rad
    }

    /// Returns the selected objects, in ascending order.
    pub fn selected(&self) -> impl Iterator<Item = ObjectId> {
        self.selected.iter().copied()
    }

    /// Returns true if an object is selected.
    pub fn is_selected(&self, object: ObjectId) -> bool {
        self.selected.contains(&object)
    }

    /// Returns the objects of the first part or group in the tree with this name.
    ///
    /// # Errors
    /// [`CommandError::NoPart`].
    pub fn find(&self, name: &str) -> Result<Vec<ObjectId>, CommandError> {
        let place = self.parts.nodes.iter().position(|node| node.name == name);
        let place = place.ok_or_else(|| CommandError::NoPart(name.to_owned()))?;
        Ok(self.parts.objects_of(PartId(place as u32)))
    }

    /// Returns the objects with a name, or the selected objects without a name.
    ///
    /// # Errors
    /// [`CommandError::NoPart`], [`CommandError::NothingSelected`].
    pub fn named_or_selected(&self, name: Option<&str>) -> Result<Vec<ObjectId>, CommandError> {
        match name {
            Some(name) => self.find(name),
            None if self.selected.is_empty() => Err(CommandError::NothingSelected),
            None => Ok(self.selected.iter().copied().collect()),
        }
    }

    /// Replaces the selection by these objects.
    pub fn select(&mut self, objects: impl IntoIterator<Item = ObjectId>) {
        self.selected = objects.into_iter().collect();
    }

    /// Changes the display of objects. Hidden objects are removed from the selection.
    pub fn set_display(&mut self, objects: &[ObjectId], display: Display) {
        for object in objects {
            if let Some(of) = self.displays.get_mut(object.0 as usize) {
                *of = display;
            }
            if display == Display::Hidden {
                self.selected.remove(object);
            }
        }
    }

    /// Hides everything except the selection.
    ///
    /// # Errors
    /// [`CommandError::NothingSelected`].
    pub fn isolate(&mut self) -> Result<(), CommandError> {
        if self.selected.is_empty() {
            return Err(CommandError::NothingSelected);
        }
        for (object, display) in (0..).map(ObjectId).zip(&mut self.displays) {
            *display =
                if self.selected.contains(&object) { Display::Shown } else { Display::Hidden };
        }
        Ok(())
    }

    /// Moves all shown parts apart by a gap, in metres, starting from their places in the model.
    pub fn explode(&mut self, gap_m: f32) {
        self.assemble();
        let bodies = self.shown_bodies();
        let boxes: Vec<Aabb> = bodies.iter().map(|body| body.bounds).collect();
        for (body, by) in bodies.iter().zip(explode(&boxes, gap_m)) {
            body.objects.iter().for_each(|object| self.displacements[object.0 as usize] = by);
        }
    }

    /// Returns the bodies with at least one shown object, in their current places.
    pub fn shown_bodies(&self) -> Vec<Body> {
        let mut bodies: Vec<Body> = Vec::new();
        let mut index_of_body: HashMap<u32, usize> = HashMap::new();
        for object in self.objects() {
            if self.display(object) == Display::Hidden {
                continue;
            }
            let number = self.bodies.get(object.0 as usize).copied().unwrap_or(object.0);
            let index = *index_of_body.entry(number).or_insert(bodies.len());
            if index == bodies.len() {
                bodies.push(Body { objects: Vec::new(), bounds: Aabb::EMPTY });
            }
            bodies[index].objects.push(object);
            bodies[index].bounds = bodies[index].bounds.union(&self.bounds(object));
        }
        bodies
    }

    /// Moves all parts back to their places.
    pub fn assemble(&mut self) {
        self.displacements.fill(Vec3::ZERO);
    }

    /// Turns the lid towards an angle until one of its parts touches a part that is not hidden.
    ///
    /// # Errors
    /// [`CommandError::NoLid`], [`CommandError::Exploded`], [`CommandError::BadSolid`].
    pub fn turn_lid(&mut self, to_rad: f32) -> Result<Turn, CommandError> {
        let lid = self.lid.ok_or(CommandError::NoLid)?;
        if self.displacements.iter().any(|by| *by != Vec3::ZERO) {
            return Err(CommandError::Exploded);
        }
        let mut collision = match self.collision.take() {
            Some(collision) => collision,
            None => self.lid_collision(&lid)?,
        };
        let is_there = |part: usize| self.displays[part] != Display::Hidden;
        let turn = collision.turn(self.lid_rad, to_rad, &is_there);
        self.collision = Some(collision);
        self.lid_rad = turn.angle_rad;
        Ok(turn)
    }

    fn lid_collision(&self, lid: &Lid) -> Result<LidCollision, BadSolid> {
        let solid = |object: ObjectId| {
            let of = self.scene.objects.get(object.0 as usize)?;
            let mesh = self.scene.mesh_of(of)?;
            let corner = |position: [f32; 3]| of.transform.transform_point3(position.into());
            let corners = mesh.vertices.iter().map(|vertex| corner(vertex.position)).collect();
            let triangles = mesh.indices.as_chunks::<3>().0.to_vec();
            Some(CollisionSolid { part: object.0 as usize, corners, triangles })
        };
        let turns = |object: &ObjectId| self.turns[object.0 as usize];
        let (moving, fixed): (Vec<ObjectId>, Vec<ObjectId>) = self.objects().partition(turns);
        let moving: Vec<CollisionSolid> = moving.into_iter().filter_map(solid).collect();
        let fixed: Vec<CollisionSolid> = fixed.into_iter().filter_map(solid).collect();
        LidCollision::new(lid.hinge, &moving, &fixed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transparent_objects_are_within_the_bounds() {
        let made = scenes::waffle_maker();
        let mut scene = made.scene.with_surfaces();
        let all = Document::new(scene.clone(), made.parts.clone(), None).shown_bounds();
        let surfaces = scene.surfaces.as_mut().unwrap();
        surfaces.transparent = std::mem::take(&mut scene.objects);
        let mut document = Document::new(scene, PartTree { nodes: Vec::new() }, None);
        assert_eq!(document.shown_bounds(), all, "a scene of nothing else");
        let by = Vec3::X * 9.0;
        let beside = &mut document.scene.surfaces.as_mut().unwrap().transparent[0].transform;
        beside.translation += antumbra::glam::Vec3A::from(by);
        assert!(document.shown_bounds().max.x > all.max.x + 8.0);
    }
}
