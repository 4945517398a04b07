//! Transparent objects. They are drawn back to front over the finished image, where they can be
//! hidden but do not hide others ([`TransparentList`]); or in any order, with sorted fragments.

use std::collections::HashMap;

use cull::{Aabb, Containment, CullView, Frustum, PlaneMask, Rays};
use glam::Affine3A;
use gpu::{BufferSlice, Commands, Device, Frame, IndirectDraw};
use occlusion::{BucketDraw, CulledScene, OcclusionPasses, TransparentList};
use scene::{ENCLOSING, Light, Mesh, Object, Scene, TransparentId, signed_volume};

use crate::error::Error;
use crate::passes::{SurfaceIo, SurfacePass};
use crate::resources::geometry::{Geometry, bounds_in_world};
use crate::shading::fragments::Fragments;

/// The transparent objects of a scene.
pub(crate) struct Transparent {
    objects: Vec<TransparentObject>,
    /// The draws of the view being recorded.
    list: TransparentList,
    /// The objects in the frustum of the view being recorded, from the farthest on.
    sorted: Vec<SortedObject>,
    /// The vertex shader's data of the view being recorded, if it has any.
    instances: Option<BufferSlice>,
    /// The effects of section planes on each instance: all are cut.
    states: Option<BufferSlice>,
    /// The fragments of the objects, if they are sorted.
    pub(crate) fragments: Option<Fragments>,
}

pub(crate) struct TransparentObject {
    pub(crate) object: Object,
    /// The box in the object's own space.
    pub(crate) own_bounds: Aabb,
    pub(crate) bounds: Aabb,
    /// The direction of its faces, in the object's own space.
    faces: Faces,
}

/// The direction in which the triangles of a mesh face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Faces {
    /// Away from the middle, all around: the visible faces are on the near side.
    Out,
    /// Towards the middle: the visible faces are on the far side.
    In,
    /// Neither outwards nor inwards.
    Along,
}

impl Faces {
    fn of(mesh: &Mesh) -> Self {
        let place = |index: &u32| Some(mesh.vertices.get(*index as usize)?.position.into());
        let triangles = mesh.indices.as_chunks::<3>().0.iter();
        let triangles = triangles.filter_map(|[a, b, c]| Some([place(a)?, place(b)?, place(c)?]));
        match signed_volume(&mesh.bounds, triangles) {
            part if part >= ENCLOSING => Self::Out,
            part if part <= -ENCLOSING => Self::In,
            _ => Self::Along,
        }
    }

    /// Returns the direction under a transform. A reflection swaps inside and outside.
    fn under(self, transform: &Affine3A) -> Self {
        let is_mirrored = transform.matrix3.determinant() < 0.0;
        match self {
            Self::Out if is_mirrored => Self::In,
            Self::In if is_mirrored => Self::Out,
            same => same,
        }
    }
}

/// Returns the sorting distance of an object. The contents of a glass come after its far side and
/// before its near side.
fn depth_m(bounds: &Aabb, rays: &Rays, faces: Faces) -> f32 {
    let towards = rays.towards(bounds.centre());
    let distance_m = towards.dot(bounds.centre() - rays.origin);
    let reach_m = towards.abs().dot(bounds.half_extent());
    match faces {
        Faces::Out => distance_m - reach_m,
        Faces::In => distance_m + reach_m,
        Faces::Along => distance_m,
    }
}

/// An object of a view.
#[derive(Clone, Copy)]
struct SortedObject {
    number: usize,
    depth_m: f32,
}

impl Transparent {
    /// Creates the buffers of the transparent objects of a scene; `None` if there are none.
    pub(crate) fn new(
        device: &Device,
        scene: &Scene,
        fragments: Option<Fragments>,
    ) -> Result<Option<Self>, Error> {
        let transparent = scene.surfaces.iter().flat_map(|surfaces| &surfaces.transparent);
        let mut known = HashMap::new();
        let object = |object: &Object| {
            let mesh = scene.mesh_of(object)?;
            let own_bounds = mesh.bounds;
            let bounds = bounds_in_world(&own_bounds, &object.transform)?;
            let faces = *known.entry(object.mesh).or_insert_with(|| Faces::of(mesh));
            Some(TransparentObject { object: *object, own_bounds, bounds, faces })
        };
        let objects: Vec<TransparentObject> = transparent.filter_map(object).collect();
        if objects.is_empty() {
            return Ok(None);
        }
        Ok(Some(Self {
            objects,
            list: TransparentList::new(device)?,
            sorted: Vec::new(),
            instances: None,
            states: None,
            fragments,
        }))
    }

    /// Returns the box around all objects.
    pub(crate) fn bounds(&self) -> Aabb {
        self.objects.iter().fold(Aabb::EMPTY, |around, object| around.union(&object.bounds))
    }

    /// Finds the objects in the frustum of a view and sorts them from the farthest on. The distance
    /// is taken to the middle of the box, or for an enclosing object to the visible side of its
    /// box. Equally far objects are in the order of the scene.
    fn sort(&mut self, view: &CullView) {
        self.sorted.clear();
        for (number, object) in self.objects.iter().enumerate() {
            let bounds = &object.bounds;
            let (place, _) = view.frustum.classify(bounds, PlaneMask::ALL);
            if place == Containment::Outside || view.cuts_away(bounds) {
                continue;
            }
            let depth_m = depth_m(bounds, &view.rays, object.faces.under(&object.object.transform));
            self.sorted.push(SortedObject { number, depth_m });
        }
        self.sorted.sort_unstable_by(|a, b| {
            let farther = b.depth_m.total_cmp(&a.depth_m);
            farther.then(a.number.cmp(&b.number))
        });
    }

    /// Writes the sorted objects into the memory of a frame.
    fn write(
        &mut self,
        frame: &mut Frame<'_>,
        geometry: &Geometry,
        passes: &OcclusionPasses,
        view: &CullView,
        tests: bool,
    ) -> Result<(), Error> {
        let Self { sorted, objects, list, .. } = self;
        list.clear();
        self.instances = None;
        if sorted.is_empty() {
            return Ok(());
        }
        for (place, sorted) in (0..).zip(sorted.iter()) {
            let TransparentObject { object, bounds, .. } = &objects[sorted.number];
            let draw = geometry.mesh_draw(object.mesh);
            let draw = IndirectDraw { first_instance: place, instance_count: 1, ..draw };
            list.push(view, tests.then_some(*bounds), &[BucketDraw { draw, ..Default::default() }]);
        }
        let instances = sorted.iter().map(|sorted| {
            let id = TransparentId(sorted.number as u32);
            geometry.transparent_instance(id, &objects[sorted.number].object)
        });
        self.instances = Some(frame.uploads().push_iter(instances)?);
        self.states = if view.section.is_empty() {
            None
        } else {
            Some(frame.uploads().push(&vec![0_u32; sorted.len().div_ceil(2)])?)
        };
        Ok(list.write(frame, passes)?)
    }

    pub(crate) fn transform(&self, id: TransparentId) -> Option<Affine3A> {
        self.objects.get(id.0 as usize).map(|transparent| transparent.object.transform)
    }

    /// Gathers the objects of a view for the draws of its frame. Returns the number in its frustum.
    pub(crate) fn gather(
        &mut self,
        frame: &mut Frame<'_>,
        geometry: &Geometry,
        passes: &OcclusionPasses,
        view: &CullView,
        tests: bool,
    ) -> Result<u32, Error> {
        self.sort(view);
        self.write(frame, geometry, passes, view, tests)?;
        if let Some(fragments) = self.fragments.as_mut().filter(|_| !self.list.is_empty()) {
            fragments.begin_view(frame, view)?;
        }
        Ok(self.sorted.len() as u32)
    }

    /// Gives each object the place and the box that it has in `lost`, transparent objects of the
    /// same scene.
    pub(crate) fn restore(&mut self, lost: &Self) {
        for (object, lost) in self.objects.iter_mut().zip(&lost.objects) {
            object.object = lost.object;
            object.own_bounds = lost.own_bounds;
            object.bounds = lost.bounds;
        }
    }

    /// Changes an object and returns its box, if it exists.
    pub(crate) fn change(
        &mut self,
        id: TransparentId,
        change: impl FnOnce(&mut TransparentObject),
    ) -> Option<Aabb> {
        let object = self.objects.get_mut(id.0 as usize)?;
        change(object);
        Some(object.bounds)
    }

    pub(crate) fn get(&self, id: TransparentId) -> Option<&TransparentObject> {
        self.objects.get(id.0 as usize)
    }

    /// Returns the objects that meet a frustum, in the order of the scene.
    pub(crate) fn in_frustum<'a>(
        &'a self,
        frustum: &'a Frustum,
    ) -> impl Iterator<Item = (TransparentId, &'a Object)> {
        let objects = (0..).map(TransparentId).zip(&self.objects);
        let is_in = |object: &TransparentObject| {
            frustum.classify(&object.bounds, PlaneMask::ALL).0 != Containment::Outside
        };
        let objects = objects.filter(move |(_, object)| is_in(object));
        objects.map(|(id, object)| (id, &object.object))
    }

    /// Returns the draws of the view being recorded.
    pub(crate) fn list(&self) -> &TransparentList {
        &self.list
    }

    /// Draws the objects of the view to the current attachments.
    pub(crate) fn draw(
        &self,
        pass: &SurfacePass,
        scene: &CulledScene,
        commands: &Commands,
        surfaces: SurfaceIo<'_>,
        view: &CullView,
        light: &Light,
    ) {
        self.draw_bound(scene, commands, surfaces, &|commands, surfaces| {
            pass.bind(commands, surfaces, view, light);
        });
    }

    /// Draws the objects of the view with the pass and buffers that `bind` binds.
    pub(crate) fn draw_bound(
        &self,
        scene: &CulledScene,
        commands: &Commands,
        surfaces: SurfaceIo<'_>,
        bind: &dyn Fn(&Commands, &SurfaceIo<'_>),
    ) {
        let Some(instances) = self.instances else { return };
        let section = surfaces.section.zip(self.states);
        let section = section.map(|(section, states)| section.of_states(states));
        let surfaces = SurfaceIo { instances, section, ..surfaces };
        self.list.draw(scene.leaves().predicates(), commands, &|commands, _| {
            bind(commands, &surfaces);
        });
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_glass_in_a_glass_is_drawn_between_its_sides() {
        let outer = Vec3::splat(2.0);
        let inner = Vec3::splat(0.5);
        let camera = cull::Camera {
            eye: Vec3::new(9.0, 3.0, -4.0),
            forward: Vec3::NEG_X,
            up: Vec3::Y,
            projection: cull::Projection::perspective(1.0),
            near: 0.1,
        };
        let rays = CullView::new(&camera, [64, 64], 8).rays;
        for middle in [Vec3::ZERO, Vec3::new(1.2, -0.7, 0.9)] {
            let around = |half: Vec3| {
                Aabb::new(middle * half.y.min(1.0) - half, middle * half.y.min(1.0) + half)
            };
            let depth = |half, faces| depth_m(&around(half), &rays, faces);
            let order = [
                depth(outer, Faces::In),
                depth(inner, Faces::In),
                depth(inner, Faces::Along),
                depth(inner, Faces::Out),
                depth(outer, Faces::Out),
            ];
            assert!(order.is_sorted_by(|farther, nearer| farther > nearer), "{order:?}");
        }
        let mirror = Affine3A::from_scale(Vec3::new(1.0, -1.0, 1.0));
        assert_eq!(Faces::Out.under(&mirror), Faces::In);
        assert_eq!(Faces::Along.under(&mirror), Faces::Along);
    }
}
