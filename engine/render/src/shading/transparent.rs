//! Transparent objects: drawn back to front over the finished image, where they can be hidden but
//! hide nothing.
//!
//! ```text
//! surfaces    after all opaque surfaces and the sky: boxes of the transparent objects in the
//!             frustum, in one draw; a fragment that passes the finished depth switches on the
//!             draw of its object
//! transparent their draws, the farthest first, in one call
//! ```
//!
//! A box without a visible sample holds an object without one: leaving it out changes nothing, and
//! the order of the others stays the same.

use std::collections::HashMap;

use cull::{Aabb, Containment, PlaneMask, Rays, View};
use glam::Affine3A;
use gpu::{
    Access, BOX_VERTICES, Buffer, BufferSlice, Commands, Device, Frame, IndirectDraw,
    LeafDrawBuffers, MemoryBarrier, MemoryKind, vk,
};
use occlusion::{LeafBoxIo, PlanExecutor, ProxyBox};
use scene::{ENCLOSING, Light, Mesh, Object, Scene, TransparentId, outwardness};

use crate::error::Error;
use crate::passes::{SurfaceIo, SurfacePass};
use crate::resources::geometry::{Geometry, bounds_in_world};

/// The transparent objects of a scene.
pub(crate) struct Transparent {
    objects: Vec<TransparentObject>,
    /// The draws that fragments switch on, and their list. Nothing reads the list.
    leaf_draws: [Buffer; 2],
    /// The objects in the frustum of the view being recorded, the farthest first.
    sorted: Vec<SortedObject>,
    /// The draws of the view being recorded, if any.
    view: Option<TransparentIo>,
}

pub(crate) struct TransparentObject {
    pub(crate) object: Object,
    /// The box in its own space.
    pub(crate) own_bounds: Aabb,
    pub(crate) bounds: Aabb,
    /// The direction of its faces, in its own space.
    faces: Faces,
}

/// The direction in which the triangles of a mesh face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Faces {
    /// Away from its middle, all around: the visible ones are on the near side.
    Out,
    /// Towards its middle: the visible ones are on the far side.
    In,
    /// Neither of these.
    Along,
}

impl Faces {
    fn of(mesh: &Mesh) -> Self {
        let place = |index: &u32| Some(mesh.vertices.get(*index as usize)?.position.into());
        let triangles = mesh.indices.as_chunks::<3>().0.iter();
        let triangles = triangles.filter_map(|[a, b, c]| Some([place(a)?, place(b)?, place(c)?]));
        match outwardness(&mesh.bounds, triangles) {
            part if part >= ENCLOSING => Self::Out,
            part if part <= -ENCLOSING => Self::In,
            _ => Self::Along,
        }
    }

    /// Returns the direction under a transform: mirroring swaps inside and outside.
    fn under(self, transform: &Affine3A) -> Self {
        let is_mirrored = transform.matrix3.determinant() < 0.0;
        match self {
            Self::Out if is_mirrored => Self::In,
            Self::In if is_mirrored => Self::Out,
            same => same,
        }
    }
}

/// Returns the sorting distance of something: the contents of a glass come after its far side and
/// before its near one.
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
    test: Test,
}

/// The test that decides if an object is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Test {
    /// The test of its box.
    Box,
    /// No test: it is always drawn.
    None,
}

/// One view's transparent objects in the memory of its frame, in the order in which they are drawn.
#[derive(Clone, Copy)]
struct TransparentIo {
    instances: BufferSlice,
    draws: BufferSlice,
    /// The boxes that are tested, if any are.
    boxes: Option<BufferSlice>,
    count: u32,
}

const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

impl Transparent {
    /// Creates the buffers of the transparent objects of a scene; `None` without any.
    ///
    /// # Errors
    /// No memory, a failed call.
    pub(crate) fn new(device: &Device, scene: &Scene) -> Result<Option<Self>, Error> {
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
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let indirect = storage | vk::BufferUsageFlags::INDIRECT_BUFFER;
        let draw_bytes = objects.len() as u64 * DRAW_BYTES;
        let list_bytes = (gpu::LISTED_LEAVES as u64 + 1) * 4;
        Ok(Some(Self {
            objects,
            leaf_draws: [
                Buffer::new(device, "transparent draws", draw_bytes, indirect, MemoryKind::Device)?,
                Buffer::new(device, "transparent list", list_bytes, storage, MemoryKind::Device)?,
            ],
            sorted: Vec::new(),
            view: None,
        }))
    }

    /// Finds the objects in the frustum of a view and sorts them: the farthest first, by the middle
    /// of their boxes, or by the visible side of the box of an object that encloses something; of
    /// equally far ones the first of the scene.
    fn sort(&mut self, view: &View, test: Test) {
        self.sorted.clear();
        for (number, object) in self.objects.iter().enumerate() {
            let bounds = &object.bounds;
            if view.frustum.classify(bounds, PlaneMask::ALL).0 == Containment::Outside {
                continue;
            }
            let depth_m = depth_m(bounds, &view.rays, object.faces.under(&object.object.transform));
            let can_be_tested = test == Test::Box && view.margin.proxy(bounds).is_some();
            let test = if can_be_tested { Test::Box } else { Test::None };
            self.sorted.push(SortedObject { number, depth_m, test });
        }
        self.sorted.sort_unstable_by(|a, b| {
            let farther = b.depth_m.total_cmp(&a.depth_m);
            farther.then(a.number.cmp(&b.number))
        });
    }

    /// Writes the sorted objects into the memory of a frame.
    fn write(&mut self, frame: &mut Frame<'_>, geometry: &Geometry) -> Result<(), Error> {
        self.view = None;
        if self.sorted.is_empty() {
            return Ok(());
        }
        let Self { sorted, objects, .. } = self;
        let in_order = || sorted.iter().map(|it| (it, &objects[it.number]));
        let uploads = frame.uploads();
        let instances = uploads.push_iter(in_order().map(|(sorted, transparent)| {
            geometry.transparent_instance(TransparentId(sorted.number as u32), &transparent.object)
        }))?;
        let draws = in_order().enumerate().map(|(place, (sorted, transparent))| IndirectDraw {
            first_instance: place as u32,
            instance_count: u32::from(sorted.test == Test::None),
            ..geometry.mesh_draw(transparent.object.mesh)
        });
        let draws = uploads.push_iter(draws)?;
        let is_any_tested = sorted.iter().any(|it| it.test == Test::Box);
        let boxes = is_any_tested.then(|| {
            uploads.push_iter(in_order().map(|(sorted, transparent)| match sorted.test {
                Test::Box => ProxyBox::from(transparent.bounds),
                Test::None => ProxyBox::from(Aabb::EMPTY),
            }))
        });
        let count = sorted.len() as u32;
        self.view = Some(TransparentIo { instances, draws, boxes: boxes.transpose()?, count });
        Ok(())
    }

    /// Returns the transform of an object.
    pub(crate) fn transform(&self, id: TransparentId) -> Option<Affine3A> {
        self.objects.get(id.0 as usize).map(|transparent| transparent.object.transform)
    }

    /// Returns the draws of the view, as they are on the GPU once their boxes were tested.
    fn draws(&self, io: &TransparentIo) -> BufferSlice {
        let draws = match io.boxes {
            Some(_) => self.leaf_draws[0].whole(),
            None => io.draws,
        };
        draws.part(0, u64::from(io.count) * DRAW_BYTES)
    }

    /// Gathers the objects of a view for the draws of its frame. Returns the number in its frustum.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn gather(
        &mut self,
        frame: &mut Frame<'_>,
        geometry: &Geometry,
        (view, tests): (&View, bool),
    ) -> Result<u32, Error> {
        self.sort(view, if tests { Test::Box } else { Test::None });
        self.write(frame, geometry)?;
        Ok(self.sorted.len() as u32)
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

    /// Returns an object.
    pub(crate) fn get(&self, id: TransparentId) -> Option<&TransparentObject> {
        self.objects.get(id.0 as usize)
    }

    /// Returns true if the view being recorded has any.
    pub(crate) fn is_any(&self) -> bool {
        self.view.is_some()
    }

    /// Records, before the boxes are tested, the clear of the draws that they decide about.
    pub(crate) fn prepare(&self, commands: &Commands) {
        let Some(io) = self.tested() else { return };
        let [draws, list] = &self.leaf_draws;
        let between = MemoryBarrier::between;
        // The view or frame before may still draw and note.
        let before = [Access::IndirectRead, Access::FragmentWrite];
        commands.barrier(between(&before, &[Access::CopyWrite]));
        commands.copy_buffer(io.draws, draws.whole());
        commands.fill(list.whole().part(0, 4), 0);
        let after = [Access::IndirectRead, Access::FragmentWrite];
        commands.barrier(between(&[Access::CopyWrite], &after));
    }

    /// Tests the boxes against the finished depth, which is being rendered to.
    pub(crate) fn test(&self, executor: &PlanExecutor, commands: &Commands, view: &View) {
        let (Some(io), Some(pass)) = (self.tested(), &executor.passes.leaf_boxes) else { return };
        let Some(boxes) = io.boxes else { return };
        let [draws, list] = &self.leaf_draws;
        commands.label("transparent boxes", |commands| {
            let leaf_draws = LeafDrawBuffers { draws: draws.whole(), list: list.whole() };
            pass.bind(commands, &LeafBoxIo { boxes, leaf_draws, links: None }, view);
            commands.draw_instances(BOX_VERTICES, 0..io.count);
        });
    }

    /// Records the barrier from the tests of the boxes to the draws, outside of rendering.
    pub(crate) fn decide(&self, commands: &Commands) {
        if self.tested().is_some() {
            let enabled = [Access::IndirectRead, Access::FragmentWrite];
            commands.barrier(MemoryBarrier::between(&[Access::FragmentWrite], &enabled));
        }
    }

    /// Draws the objects of the view to the current attachments.
    pub(crate) fn draw(
        &self,
        (pass, executor): (&SurfacePass, &PlanExecutor),
        commands: &Commands,
        surfaces: SurfaceIo<'_>,
        (view, light): (&View, &Light),
    ) {
        let Some(io) = &self.view else { return };
        let surfaces = SurfaceIo { instances: io.instances, ..surfaces };
        pass.bind(commands, &surfaces, view, light);
        executor.leaves.predicates().draw_after_counted(commands, self.draws(io));
    }

    fn tested(&self) -> Option<&TransparentIo> {
        self.view.as_ref().filter(|io| io.boxes.is_some())
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_glass_in_a_glass_is_drawn_between_its_sides() {
        let (outer, inner) = (Vec3::splat(2.0), Vec3::splat(0.5));
        let camera = cull::Camera {
            eye: Vec3::new(9.0, 3.0, -4.0),
            forward: Vec3::NEG_X,
            up: Vec3::Y,
            projection: cull::Projection::perspective(1.0),
            near: 0.1,
        };
        let rays = View::new(&camera, [64, 64], 8).rays;
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
