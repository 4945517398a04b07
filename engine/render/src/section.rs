//! Section planes: the objects that they cut, and the caps that close them.
//!
//! ```text
//! once per frame   objects whose box a plane meets -> what each plane does to each of them
//! per view         planes in the view's image, caps of what is cut open -> drawn first of all
//! ```

mod caps;
mod meshes;
mod reading;

use std::collections::HashMap;

use cull::{
    CullView, Hierarchy, LeafIndex, NodeId, ObjectId, SectionMode, SectionPlane, SectionPlanes,
};
use glam::DVec3;
use gpu::{BufferSlice, Frame};
use occlusion::MeshDrawId;
use scene::Shell;

use crate::error::Error;
use crate::passes::{CapDraw, CapRow, SectionIo, SectionRow};
use crate::resources::geometry::Geometry;
use meshes::Extent;
pub(crate) use meshes::SectionMeshes;
pub(crate) use reading::read_meshes;

/// The state of an object that all planes keep.
const KEPT: u16 = (1 << SectionPlanes::MAX) - 1;
/// The bit for objects whose triangles show their backs.
const BACKS: u16 = 1 << (2 * SectionPlanes::MAX);

/// The share of an object's size within which a plane only touches it. It bounds the rounding of
/// single precision in the object's vertices, scale and rotation.
const TOUCHING: f64 = 8.0 * f32::EPSILON as f64;

/// The relative rounding of the coordinates of an object's position: half a unit in the last place,
/// and a little more.
const PLACE_ROUNDING: f64 = 0.51 * f32::EPSILON as f64;

/// The effect of a plane on an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PlaneEffect {
    Keeps,
    Removes,
    Cuts,
}

impl PlaneEffect {
    fn of(extent: &Extent) -> Self {
        let touching_m = extent.size_m * TOUCHING + extent.place_m * PLACE_ROUNDING;
        match extent {
            _ if extent.low_m >= -touching_m => Self::Keeps,
            _ if extent.high_m <= touching_m => Self::Removes,
            _ => Self::Cuts,
        }
    }
}

/// An object that planes meet.
#[derive(Clone, Copy, Debug)]
struct MetObject {
    object: ObjectId,
    leaf: LeafIndex,
    state: u16,
    /// A bit for each plane that cuts it.
    cuts: u8,
    draw: MeshDrawId,
    shell: Shell,
}

/// The extent of an object along a normal, known from an earlier frame.
#[derive(Clone, Copy)]
struct KnownExtent {
    rows: [[f32; 4]; 3],
    normal: DVec3,
    mesh: u32,
    /// The extent for a plane through the origin.
    extent: Option<Extent>,
}

/// The section planes of a renderer.
#[derive(Default)]
pub(crate) struct Section {
    pub(crate) planes: SectionPlanes,
    met: Vec<MetObject>,
    states: Vec<u16>,
    known: HashMap<(ObjectId, usize), KnownExtent>,
    stack: Vec<NodeId>,
    /// The states in the frame being recorded.
    uploaded_states: Option<BufferSlice>,
    /// The planes of the view being recorded.
    io: Option<SectionIo>,
    /// The caps of the view being recorded.
    cap_rows: Vec<CapRow>,
    pub(crate) cap_draws: Vec<CapDraw>,
    pub(crate) uploaded_caps: Option<BufferSlice>,
}

impl Section {
    /// Forgets the known extents of objects.
    pub(crate) fn forget(&mut self) {
        self.known.clear();
    }

    /// Returns the planes of the view being recorded.
    pub(crate) fn io(&self) -> Option<SectionIo> {
        self.io
    }

    /// Returns the planes of another view in the current frame, if there are any.
    pub(crate) fn io_of(
        &self,
        frame: &mut Frame<'_>,
        view: &CullView,
    ) -> Result<Option<SectionIo>, Error> {
        let Some(states) = self.uploaded_states else { return Ok(None) };
        let planes = frame.uploads().push(&[SectionRow::of(view)])?;
        Ok(Some(SectionIo { planes, states }))
    }

    /// Begins a frame: finds the effects of planes on objects and uploads them.
    pub(crate) fn begin_frame(
        &mut self,
        frame: &mut Frame<'_>,
        geometry: &Geometry,
        hierarchy: &Hierarchy,
    ) -> Result<(), Error> {
        self.uploaded_states = None;
        self.end_view();
        let Some(meshes) = &geometry.section_meshes else { return Ok(()) };
        self.find_met(hierarchy, geometry, meshes);
        let leaves = hierarchy.leaf_objects().len();
        self.states.clear();
        self.states.resize(leaves.next_multiple_of(2).max(2), 0);
        let section = self.planes;
        if hierarchy.root().is_some_and(|root| section.meets(&hierarchy.bounds(root))) {
            // Openings show the inside of shells, even of shells that no plane meets.
            for (state, object) in self.states.iter_mut().zip(hierarchy.leaf_objects()) {
                if meshes.shell(geometry.draw_of(*object)) == Shell::Open {
                    *state = BACKS;
                }
            }
        }
        for met in &self.met {
            if let Some(state) = self.states.get_mut(met.leaf.0 as usize) {
                *state |= met.state;
            }
        }
        for leaf in hierarchy.whole_leaves() {
            if let Some(state) = self.states.get_mut(leaf.0 as usize) {
                *state = KEPT;
            }
        }
        self.uploaded_states = Some(frame.uploads().push(&self.states)?);
        Ok(())
    }

    /// Begins a view: uploads its planes and its caps.
    pub(crate) fn begin_view(
        &mut self,
        frame: &mut Frame<'_>,
        geometry: &Geometry,
        hierarchy: &Hierarchy,
        view: &CullView,
    ) -> Result<(), Error> {
        self.end_view();
        self.io = self.io_of(frame, view)?;
        if self.io.is_none() {
            return Ok(());
        }
        caps::plan_caps(self, geometry, hierarchy, view);
        if !self.cap_draws.is_empty() {
            self.uploaded_caps = Some(frame.uploads().push(&self.cap_rows)?);
        }
        Ok(())
    }

    /// Ends a view, whose planes are not used any more.
    fn end_view(&mut self) {
        self.io = None;
        self.uploaded_caps = None;
        self.cap_draws.clear();
        self.cap_rows.clear();
    }

    /// Finds the objects that planes meet, and the effects of the planes on them.
    fn find_met(&mut self, hierarchy: &Hierarchy, geometry: &Geometry, meshes: &SectionMeshes) {
        self.met.clear();
        let mut stack = std::mem::take(&mut self.stack);
        let section = self.planes;
        stack.extend(hierarchy.root().filter(|_| !section.is_empty()));
        while let Some(node) = stack.pop() {
            let bounds = hierarchy.bounds(node);
            if bounds.is_empty() || !section.meets(&bounds) {
                continue;
            }
            if let Some(children) = hierarchy.children(node) {
                stack.extend(children);
                continue;
            }
            let leaf = hierarchy.leaves(node).first;
            if let Some(object) = hierarchy.leaf_objects().get(leaf.0 as usize)
                && !hierarchy.has_whole(node)
            {
                self.meet(geometry, meshes, *object, leaf);
            }
        }
        self.stack = stack;
        // A rebuild of the hierarchy does not change this order. Of two caps at the same place, the
        // first is drawn.
        self.met.sort_unstable_by_key(|met| met.object);
    }

    fn meet(
        &mut self,
        geometry: &Geometry,
        meshes: &SectionMeshes,
        object: ObjectId,
        leaf: LeafIndex,
    ) {
        let section = self.planes;
        let draw = geometry.draw_of(object);
        let mut met =
            MetObject { object, leaf, state: 0, cuts: 0, draw, shell: meshes.shell(draw) };
        for number in 0..section.planes().len() {
            match self.effect(geometry, meshes, object, number) {
                PlaneEffect::Keeps => met.state |= 1 << number,
                PlaneEffect::Removes => met.state |= 1 << (number + SectionPlanes::MAX),
                PlaneEffect::Cuts => met.cuts |= 1 << number,
            }
        }
        self.met.push(met);
    }

    fn effect(
        &mut self,
        geometry: &Geometry,
        meshes: &SectionMeshes,
        object: ObjectId,
        number: usize,
    ) -> PlaneEffect {
        let Some(mesh) = geometry.mesh_of(object) else { return PlaneEffect::Cuts };
        let Some(instance) = geometry.instance(object) else { return PlaneEffect::Cuts };
        let section = self.planes;
        let Some(plane) = section.planes().get(number) else { return PlaneEffect::Cuts };
        let normal = plane.normal();
        let known = self.known.get(&(object, number));
        let known = known.filter(|known| {
            known.rows == instance.rows && known.normal == normal && known.mesh == mesh.0
        });
        let extent = match known {
            Some(known) => known.extent,
            None => {
                let through_origin = SectionPlane::new(normal, 0.0).ok();
                let extent = through_origin.and_then(|plane| meshes.extent(mesh, instance, &plane));
                let known = KnownExtent { rows: instance.rows, normal, mesh: mesh.0, extent };
                self.known.insert((object, number), known);
                extent
            }
        };
        let at = |extent: Extent| Extent {
            low_m: extent.low_m + plane.offset_m(),
            high_m: extent.high_m + plane.offset_m(),
            ..extent
        };
        extent.map(at).map_or(PlaneEffect::Cuts, |extent| PlaneEffect::of(&extent))
    }

    /// Returns the planes whose caps of an object are visible: planes that cut it where the other
    /// planes leave something.
    fn caps_of(&self, met: &MetObject) -> u8 {
        let keeps = met.state & KEPT;
        let removes = met.state >> SectionPlanes::MAX & KEPT;
        let is_decided = match self.planes.mode() {
            SectionMode::Intersection => removes != 0,
            SectionMode::Union => keeps != 0,
        };
        if is_decided || met.shell == Shell::Open { 0 } else { met.cuts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_that_touches_keeps_or_removes_all() {
        let at =
            |low_m, high_m| PlaneEffect::of(&Extent { low_m, high_m, size_m: 1.0, place_m: 0.0 });
        assert_eq!(at(0.0, 1.0), PlaneEffect::Keeps);
        assert_eq!(at(-1.0e-7, 1.0), PlaneEffect::Keeps);
        assert_eq!(at(-1.0, 1.0e-7), PlaneEffect::Removes);
        assert_eq!(at(-1.0, 1.0e-4), PlaneEffect::Cuts);
        assert_eq!(at(-0.5, 0.5), PlaneEffect::Cuts);
        // In single precision, 7.7 m is 7.699_999_8 m.
        let placed = Extent { low_m: -1.9e-7, high_m: 0.02, size_m: 0.01, place_m: 7.7 };
        assert_eq!(PlaneEffect::of(&placed), PlaneEffect::Keeps);
    }
}
