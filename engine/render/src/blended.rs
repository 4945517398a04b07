//! Blended objects: drawn back to front over the finished picture, where they are only ever hidden and
//! never hide.
//!
//! ```text
//! surfaces    after all opaque surfaces and the sky: boxes of the blended objects in the frustum, in one
//!             draw; a fragment that passes the finished depth switches on the draw of its object
//! blended     their draws, the farthest first, in one call
//! ```
//!
//! A box that no sample of shows stands for an object that no sample of shows either: leaving it out
//! changes nothing, and those that are drawn are drawn in the same order whatever is left out.

use cull::{Aabb, Containment, PlaneMask, Strategy, View};
use glam::Affine3A;
use gpu::{
    Access, BOX_VERTICES, Buffer, BufferSlice, Commands, Device, Frame, IndirectDraw,
    MemoryBarrier, Parts, Place, vk,
};

use crate::error::Error;
use crate::frame_passes::FramePasses;
use crate::geometry::{Geometry, bounds_in_world};
use crate::passes::{LeafBoxIo, ProxyBox, SurfaceIo, SurfaceKind, SurfacePass};
use crate::renderer::Renderer;
use crate::scene::{BlendedId, Object, Scene};
use crate::shaders::ShaderSet;
use crate::surfaces::SurfaceResources;

/// The blended objects of a scene.
pub(crate) struct Blended {
    pub(crate) pass: SurfacePass,
    objects: Vec<BlendedObject>,
    /// What fragments switch on, and the list of it, which nobody reads.
    parts: [Buffer; 2],
    /// Those in the frustum of the view being recorded, the farthest first.
    sorted: Vec<Placed>,
    /// What the view being recorded draws, if any.
    view: Option<BlendedIo>,
}

struct BlendedObject {
    object: Object,
    /// In its own space.
    own_bounds: Aabb,
    bounds: Aabb,
}

/// An object of a view.
#[derive(Clone, Copy)]
struct Placed {
    number: usize,
    distance_squared: f32,
    test: Test,
}

/// Whether an object is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Test {
    /// Only if its box shows.
    Box,
    /// Whatever hides it.
    None,
}

/// One view's blended objects in the memory of its frame, in the order in which they are drawn.
#[derive(Clone, Copy)]
struct BlendedIo {
    instances: BufferSlice,
    draws: BufferSlice,
    /// The boxes that are tested, if any are.
    boxes: Option<BufferSlice>,
    count: u32,
}

const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

impl Blended {
    /// What the blended objects of a scene need; `None` without any.
    ///
    /// # Errors
    /// No memory, a failed call.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        scene: &Scene,
        resources: Option<&SurfaceResources>,
    ) -> Result<Option<Self>, Error> {
        let blended = scene.surfaces.iter().flat_map(|surfaces| &surfaces.blended);
        let object = |object: &Object| {
            let own_bounds = scene.mesh_of(object)?.bounds;
            let bounds = bounds_in_world(&own_bounds, &object.transform)?;
            Some(BlendedObject { object: *object, own_bounds, bounds })
        };
        let objects: Vec<BlendedObject> = blended.filter_map(object).collect();
        let Some(resources) = resources.filter(|_| !objects.is_empty()) else { return Ok(None) };
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let indirect = storage | vk::BufferUsageFlags::INDIRECT_BUFFER;
        let draw_bytes = objects.len() as u64 * DRAW_BYTES;
        let list_bytes = (gpu::LISTED_DRAWS as u64 + 1) * 4;
        Ok(Some(Self {
            pass: Self::pass(device, shaders, resources)?,
            objects,
            parts: [
                Buffer::new(device, "blended draws", draw_bytes, indirect, Place::Device)?,
                Buffer::new(device, "blended list", list_bytes, storage, Place::Device)?,
            ],
            sorted: Vec::new(),
            view: None,
        }))
    }

    /// Compiles the pass.
    ///
    /// # Errors
    /// A failed call.
    pub(crate) fn pass(
        device: &Device,
        shaders: &ShaderSet,
        resources: &SurfaceResources,
    ) -> Result<SurfacePass, Error> {
        SurfacePass::new(device, shaders, SurfaceKind::Blended, resources)
    }

    /// Finds those in the frustum of a view and sorts them: the farthest first, by the middle of their
    /// boxes; of those that are equally far the first of the scene.
    fn sort(&mut self, view: &View, test: Test) {
        self.sorted.clear();
        for (number, object) in self.objects.iter().enumerate() {
            let bounds = &object.bounds;
            if view.frustum.classify(bounds, PlaneMask::ALL).0 == Containment::Outside {
                continue;
            }
            let distance_squared = (bounds.centre() - view.eye).length_squared();
            let can_be_tested = test == Test::Box && view.margin.proxy(bounds).is_some();
            let test = if can_be_tested { Test::Box } else { Test::None };
            self.sorted.push(Placed { number, distance_squared, test });
        }
        self.sorted.sort_unstable_by(|a, b| {
            let farther = b.distance_squared.total_cmp(&a.distance_squared);
            farther.then(a.number.cmp(&b.number))
        });
    }

    /// Writes what was sorted into the memory of a frame.
    fn write(&mut self, frame: &mut Frame<'_>, geometry: &Geometry) -> Result<(), Error> {
        self.view = None;
        if self.sorted.is_empty() {
            return Ok(());
        }
        let Self { sorted, objects, .. } = self;
        let placed = || sorted.iter().map(|placed| (placed, &objects[placed.number]));
        let uploads = frame.uploads();
        let instances = uploads.push_iter(placed().map(|(placed, blended)| {
            geometry.blended_instance(BlendedId(placed.number as u32), &blended.object)
        }))?;
        let draws = placed().enumerate().map(|(place, (placed, blended))| IndirectDraw {
            first_instance: place as u32,
            instance_count: u32::from(placed.test == Test::None),
            ..geometry.mesh_draw(blended.object.mesh)
        });
        let draws = uploads.push_iter(draws)?;
        let is_any_tested = sorted.iter().any(|placed| placed.test == Test::Box);
        let boxes = is_any_tested.then(|| {
            uploads.push_iter(placed().map(|(placed, blended)| match placed.test {
                Test::Box => ProxyBox::from(blended.bounds),
                Test::None => ProxyBox::from(Aabb::EMPTY),
            }))
        });
        let count = sorted.len() as u32;
        self.view = Some(BlendedIo { instances, draws, boxes: boxes.transpose()?, count });
        Ok(())
    }

    /// The draws of the view, as they are on the GPU once their boxes were tested.
    fn draws(&self, io: &BlendedIo) -> BufferSlice {
        let draws = match io.boxes {
            Some(_) => self.parts[0].whole(),
            None => io.draws,
        };
        draws.part(0, u64::from(io.count) * DRAW_BYTES)
    }
}

impl FramePasses {
    /// Gathers the blended objects of a view, which [`FramePasses::shade`] draws. Answers how many are in
    /// its frustum.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn gather_blended(
        &mut self,
        frame: &mut Frame<'_>,
        view: &View,
        strategy: Strategy,
    ) -> Result<u32, Error> {
        let Some(blended) = &mut self.blended else { return Ok(0) };
        let tests = strategy != Strategy::Frustum && self.leaf_boxes.is_some();
        blended.sort(view, if tests { Test::Box } else { Test::None });
        blended.write(frame, &self.geometry)?;
        Ok(blended.sorted.len() as u32)
    }

    /// Before the rendering that tests the boxes: none of what they decide about is drawn.
    pub(crate) fn prepare_blended(&self, commands: &Commands) {
        let Some((blended, io)) = self.tested_blended() else { return };
        let [draws, list] = &blended.parts;
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
    pub(crate) fn test_blended(&self, commands: &Commands, view: &View) {
        let (Some((blended, io)), Some(pass)) = (self.tested_blended(), &self.leaf_boxes) else {
            return;
        };
        let Some(boxes) = io.boxes else { return };
        let [draws, list] = &blended.parts;
        commands.label("blended boxes", |commands| {
            let parts = Parts { draws: draws.whole(), list: list.whole() };
            pass.bind(commands, &LeafBoxIo { boxes, parts }, view);
            commands.draw_instances(BOX_VERTICES, 0..io.count);
        });
    }

    /// Draws the blended objects over the finished picture of a view, in a rendering of their own.
    pub(crate) fn record_blended(&mut self, commands: &Commands, view: &View) {
        if self.blended.as_ref().is_none_or(|blended| blended.view.is_none()) {
            return;
        }
        if self.tested_blended().is_some() {
            let switched_on = [Access::IndirectRead, Access::FragmentWrite];
            commands.barrier(MemoryBarrier::between(&[Access::FragmentWrite], &switched_on));
        }
        self.target.prepare(commands);
        commands.pass("blended", |commands| {
            let target = self.target_of(view, None);
            commands.rendering(target, |commands| self.draw_blended(commands, view));
        });
    }

    /// Draws the blended objects of a view to what is being rendered to.
    pub(crate) fn draw_blended(&self, commands: &Commands, view: &View) {
        let io = self.blended.as_ref().and_then(|it| Some((it, it.view.as_ref()?)));
        let (Some((blended, io)), Some(surfaces)) = (io, self.surface_io()) else { return };
        let surfaces = SurfaceIo { instances: io.instances, ..surfaces };
        blended.pass.bind(commands, &surfaces, view, &self.light);
        self.predicates.draw_after_counted(commands, blended.draws(io));
    }

    fn tested_blended(&self) -> Option<(&Blended, &BlendedIo)> {
        let blended = self.blended.as_ref()?;
        let io = blended.view.as_ref().filter(|io| io.boxes.is_some())?;
        Some((blended, io))
    }
}

impl Renderer {
    /// Moves a blended object, and gives it another box in its own space, if there is one. The next frame
    /// shows it.
    ///
    /// # Errors
    /// [`Error::Blended`]: the scene has no such object, or it cannot be there. Nothing has changed then.
    pub fn move_blended(
        &mut self,
        blended: BlendedId,
        transform: Affine3A,
        bounds: Option<Aabb>,
    ) -> Result<(), Error> {
        let refuse = |reason| Error::Blended { blended, reason };
        let objects = self.passes.blended.as_mut().map(|blended| &mut blended.objects);
        let object = objects.and_then(|objects| objects.get_mut(blended.0 as usize));
        let object = object.ok_or(refuse("the scene has no such blended object"))?;
        let own_bounds = bounds.unwrap_or(object.own_bounds);
        let is_usable = own_bounds.is_usable();
        let bounds = bounds_in_world(&own_bounds, &transform).filter(|_| is_usable);
        let bounds = bounds.ok_or(refuse(
            "its box or its transform is nowhere: check both for infinities, NaN and a box inside out",
        ))?;
        object.object.transform = transform;
        (object.own_bounds, object.bounds) = (own_bounds, bounds);
        if let Some(surfaces) = &mut self.passes.geometry.surfaces {
            surfaces.move_blended(blended, &bounds)?;
        }
        Ok(())
    }
}
