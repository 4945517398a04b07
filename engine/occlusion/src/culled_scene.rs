//! The scene as the culler and the GPU hold it: one hierarchy over the boxes of all objects, the
//! draws of each leaf, and the passes that test boxes.

mod api;

use cull::{
    Aabb, CullConfig, DrawPhases, Hierarchy, HierarchyError, LeafRange, ObjectId, QueryShares,
    SkippedWork, VisibilityTestSupport,
};
use gpu::{Attachments, Device, Frame, FrameRingId, PredicationMode, Target, Tick};

use crate::costs::device_costs::{ChoiceRequest, CullingSetup, DeviceCosts};
use crate::error::Error;
use crate::leaf_table::{BucketDraw, BucketTableInfo, LeafTable, LeafTableInfo, MeshDrawId};
use crate::passes::{ComputeTest, OcclusionPasses};
use crate::quirks::DriverQuirks;
use crate::shader_set::ShaderSet;

/// An object of a host.
#[derive(Clone, Copy, Debug)]
pub struct HostObject<'a> {
    /// The box around everything that it draws.
    pub bounds: Aabb,
    /// Its draws, in any order; they are recorded bucket after bucket.
    pub draws: &'a [BucketDraw],
}

/// The options of a [`CulledScene`].
#[derive(Clone, Debug)]
pub struct CulledSceneOptions<'a> {
    /// The initial room for objects.
    pub object_capacity: usize,
    /// The initial room for draws.
    pub draw_capacity: u32,
    /// The number of buckets, one per pipeline of the owner: at most
    /// [`MAX_BUCKETS`](crate::MAX_BUCKETS).
    pub bucket_count: u32,
    /// The number of frames that may be in flight at once.
    pub frames_in_flight: usize,
    /// The predication mode. `None` takes the mode that costs least, or without costs the device's
    /// usual mode. A mode that `quirks` disable is replaced.
    pub predication: Option<PredicationMode>,
    /// [`DrawPhases::Two`] for a host that draws from [lists](crate::FrameScope::list).
    pub draw_phases: DrawPhases,
    /// The configuration of the cullers of all views.
    pub cull_config: CullConfig,
    /// The parts of the driver that must not be used.
    pub quirks: DriverQuirks,
    /// The [measured](crate::measure) costs of the device. They decide about the predication mode
    /// for the initial room, and in each frame about the boxes to test and the tester of each box.
    /// Without costs, everything that may be hidden is tested.
    ///
    /// A device that was adopted without a queue cannot be measured, since the engine cannot submit
    /// to it: adopt the same device with a queue first, and measure there. Where a host draws from
    /// lists, the costs of skipped draws are the costs of
    /// [`PredicationMode::Compacted`](gpu::PredicationMode::Compacted).
    pub costs: Option<&'a DeviceCosts>,
}

impl Default for CulledSceneOptions<'_> {
    /// Returns the options of a small scene with one bucket and two frames in flight.
    fn default() -> Self {
        Self {
            object_capacity: 1024,
            draw_capacity: 1024,
            bucket_count: 1,
            frames_in_flight: 2,
            predication: None,
            draw_phases: DrawPhases::PerRound,
            cull_config: CullConfig::default(),
            quirks: DriverQuirks::default(),
            costs: None,
        }
    }
}

/// The scene as the culler and the GPU hold it. All its views share the hierarchy over the boxes,
/// the table of draws, the passes that test boxes, and the predication mode.
///
/// A host [adds](CulledScene::add), moves and removes objects. Each object has any number of draws,
/// in pipelines of the host. The host records [frames](CulledScene::begin) of the scene. Changes
/// reach the GPU with the next frame; nothing waits.
pub struct CulledScene {
    pub(crate) device: Device,
    pub(crate) hierarchy: Hierarchy,
    pub(crate) passes: OcclusionPasses,
    pub(crate) leaves: LeafTable,
    frames_in_flight: usize,
    setup: CullingSetup,
    pub(crate) cull_config: CullConfig,
    pub(crate) draw_phases: DrawPhases,
    pub(crate) query_shares: QueryShares,
    /// The ring of its frames, once there is one: its slots are the slots of the views.
    pub(crate) ring: Option<FrameRingId>,
    /// The ranges of a change; kept to allocate nothing in the steady state.
    reordered: Vec<LeafRange>,
}

/// The parts of a scene whose owner keeps them consistent: it changes the hierarchy, marks the
/// leaves that changed, and uploads them.
pub struct ScenePartsMut<'a> {
    /// The hierarchy over the boxes.
    pub hierarchy: &'a mut Hierarchy,
    /// The draws of each leaf.
    pub leaves: &'a mut LeafTable,
    /// The passes that test boxes.
    pub passes: &'a mut OcclusionPasses,
}

impl CulledScene {
    /// Creates a scene without objects and compiles the passes that test boxes. Its views are drawn
    /// to targets with these attachments. The buffers grow when more objects or draws come than
    /// they have room for.
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`] for a predication mode that the device lacks, or for several
    /// views at once without multiview; [`gpu::Error::TooLarge`] and [`Error::Hierarchy`] for too
    /// many objects or draws; no memory; a failed call.
    pub fn new(
        device: &Device,
        attachments: Attachments,
        options: &CulledSceneOptions<'_>,
    ) -> Result<Self, Error> {
        let CulledSceneOptions { bucket_count, object_capacity, draw_capacity, .. } = *options;
        check_memory(object_capacity)?;
        let shaders = ShaderSet::embedded()?;
        let passes =
            OcclusionPasses::with_quirks(device, &shaders, attachments, options.quirks.clone())?;
        let hierarchy = Hierarchy::build(&vec![Aabb::EMPTY; object_capacity])?;
        let draws = BucketTableInfo {
            bucket_count,
            draw_capacity,
            predication: options.predication,
            frames_in_flight: options.frames_in_flight,
        };
        let cells_draws = u64::from(draws.cell_capacity());
        let executors =
            passes.quirks().usable_executors(device, draws.predication, cells_draws, 0)?;
        let leaves = (object_capacity as u32).max(draw_capacity);
        let work = SkippedWork::of_leaves(leaves).in_buckets(bucket_count);
        let request = ChoiceRequest { executors: &executors, work };
        let setup = match options.costs {
            Some(costs) => CullingSetup::of_costs(&request, costs),
            None => CullingSetup::usual(&request, None),
        };
        let draws = BucketTableInfo { predication: Some(setup.predication), ..draws };
        let leaves = LeafTable::bucketed(device, &hierarchy, draws)?;
        let frames_in_flight = options.frames_in_flight;
        let scene = Self::of_parts(device, hierarchy, leaves, passes, setup, frames_in_flight);
        let CulledSceneOptions { cull_config, draw_phases, .. } = *options;
        Ok(Self { cull_config, draw_phases, ..scene })
    }

    /// Creates a scene with one mesh per object from a hierarchy. `draw_of` returns the mesh of an
    /// object. The owner keeps the hierarchy and the draws [consistent](CulledScene::parts_mut).
    /// Everything that may be hidden is tested until [`CulledScene::with_setup`] sets costs.
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`] for a predication mode that the device lacks;
    /// [`gpu::Error::TooLarge`] for more objects than the device takes; no memory; a failed call.
    pub fn of_meshes(
        device: &Device,
        passes: OcclusionPasses,
        hierarchy: Hierarchy,
        meshes: LeafTableInfo,
        draw_of: impl Fn(ObjectId) -> MeshDrawId,
    ) -> Result<Self, Error> {
        let leaves = hierarchy.leaf_objects().len() as u32;
        let executors =
            passes.quirks().usable_executors(device, meshes.predication, leaves.into(), 0)?;
        let work = SkippedWork::of_leaves(leaves);
        let setup = CullingSetup::usual(&ChoiceRequest { executors: &executors, work }, None);
        let frames_in_flight = meshes.frames_in_flight;
        let meshes = LeafTableInfo { predication: Some(setup.predication), ..meshes };
        let leaves = LeafTable::new(device, &hierarchy, meshes, draw_of)?;
        Ok(Self::of_parts(device, hierarchy, leaves, passes, setup, frames_in_flight))
    }

    /// Sets the decisions of `setup`, which the predication mode of the scene was chosen by.
    #[must_use]
    pub fn with_setup(self, setup: CullingSetup) -> Self {
        Self { setup, ..self }
    }

    fn of_parts(
        device: &Device,
        hierarchy: Hierarchy,
        leaves: LeafTable,
        passes: OcclusionPasses,
        setup: CullingSetup,
        frames_in_flight: usize,
    ) -> Self {
        Self {
            device: device.clone(),
            hierarchy,
            passes,
            leaves,
            frames_in_flight,
            setup,
            cull_config: CullConfig::default(),
            draw_phases: DrawPhases::PerRound,
            query_shares: QueryShares::default(),
            ring: None,
            reordered: Vec::new(),
        }
    }

    /// Returns the visibility tests that plans may use, for views that are drawn to `target` in
    /// these phases. These are the tests that the device supports and that the driver can be
    /// [trusted](OcclusionPasses::with_quirks) with. There are none if the predication mode cannot
    /// be trusted.
    pub fn testers(&self, target: &Target, draw_phases: DrawPhases) -> VisibilityTestSupport {
        let own = self.leaves.predicates.predication();
        let executors: &[PredicationMode] = match draw_phases {
            DrawPhases::PerRound => &[own],
            // The host draws compacted lists. Where their commands are not counted, the unused ones
            // have no instances. Boxes of leaves are drawn from the table.
            DrawPhases::Two => &[own, PredicationMode::Compacted, PredicationMode::Instances],
        };
        let offered = self.passes.testers(&self.device, target);
        let offered = VisibilityTestSupport { draw_phases, ..offered };
        let quirks = self.passes.quirks();
        executors.iter().fold(offered, |offered, executor| quirks.testers(offered, *executor))
    }

    /// Refuses a change of the target's size that takes away a visibility test: the plans of
    /// existing views may use every test that was available when the view was created.
    ///
    /// # Errors
    /// A size that is too large for a test.
    pub fn check_resize(&self, from: [u32; 2], to: [u32; 2]) -> Result<(), Error> {
        match ComputeTest::check(&self.device, from) {
            Ok(()) => ComputeTest::check(&self.device, to),
            Err(_) => Ok(()),
        }
    }

    /// Returns the device of the scene.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the hierarchy over the boxes.
    pub fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    /// Returns the draws of each leaf.
    pub fn leaves(&self) -> &LeafTable {
        &self.leaves
    }

    /// Returns the passes that test boxes.
    pub fn passes(&self) -> &OcclusionPasses {
        &self.passes
    }

    /// Returns the parts of a scene [of meshes](CulledScene::of_meshes), whose owner keeps them in
    /// step: a change of the hierarchy marks the leaves that changed. Not for scenes with buckets,
    /// which do so in [`CulledScene::add`] and the calls beside it.
    pub fn parts_mut(&mut self) -> ScenePartsMut<'_> {
        ScenePartsMut {
            hierarchy: &mut self.hierarchy,
            leaves: &mut self.leaves,
            passes: &mut self.passes,
        }
    }

    /// Returns the number of frames that may be in flight at once.
    pub fn frames_in_flight(&self) -> usize {
        self.frames_in_flight
    }

    /// Changes the number of frames that may be in flight at once, for frames of another ring.
    /// Views follow with their next plan.
    pub fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        self.ring = None;
        self.frames_in_flight = frames_in_flight;
        self.leaves.set_frames_in_flight(frames_in_flight);
    }

    /// Returns the decisions that were made at creation: the predication mode, and the costs behind
    /// it.
    pub fn culling_setup(&self) -> &CullingSetup {
        &self.setup
    }

    /// Adds objects, and appends their ids to `added` in the same order. An id may have belonged to
    /// an object that was removed. If the number of objects at least doubles, the hierarchy is
    /// built again; otherwise the time depends only on the number of new objects, unless there is
    /// no room for them. Then room is made for a sixteenth more than all objects, and the next
    /// frame uploads everything to larger buffers. Create a large scene with its capacity.
    ///
    /// # Errors
    /// [`BucketError::Unknown`](crate::BucketError::Unknown); [`Error::Hierarchy`] for the first
    /// bad box, by its index in `objects`, or for more objects than a hierarchy holds. Nothing has
    /// changed then.
    pub fn add(
        &mut self,
        objects: &[HostObject<'_>],
        added: &mut Vec<ObjectId>,
    ) -> Result<(), Error> {
        let leaves = &self.leaves;
        objects.iter().try_for_each(|object| leaves.check_draws(object.draws))?;
        let boxes: Vec<Aabb> = objects.iter().map(|object| object.bounds).collect();
        check_memory(boxes.len())?;
        let first = added.len();
        self.reordered.clear();
        self.hierarchy.insert_all(&boxes, added, &mut self.reordered)?;
        self.leaves.reorder(&self.hierarchy, &self.reordered)?;
        let placed = added[first..].iter().zip(objects);
        let draws =
            placed.filter_map(|(id, placed)| Some((self.hierarchy.leaf_of(*id)?, placed.draws)));
        self.leaves.set_draws(&draws.collect::<Vec<_>>())
    }

    /// Removes objects.
    ///
    /// # Errors
    /// [`Error::Hierarchy`] for the first object that is not in the scene; the objects before it
    /// are removed. [`BucketError::OneDrawPerLeaf`](crate::BucketError::OneDrawPerLeaf).
    pub fn remove(&mut self, objects: &[ObjectId]) -> Result<(), Error> {
        self.leaves.check_draws(&[])?;
        let mut gone = Vec::with_capacity(objects.len());
        let outcome = objects.iter().try_for_each(|object| {
            self.hierarchy.remove(*object)?;
            gone.extend(self.hierarchy.leaf_of(*object).map(|leaf| (leaf, &[][..])));
            Ok(())
        });
        // The objects before a bad one are removed.
        self.leaves.set_draws(&gone)?;
        outcome
    }

    /// Sets the boxes of objects that move. Their draws stay as they are: the host updates the
    /// transforms that they read.
    ///
    /// # Errors
    /// [`Error::Hierarchy`] for the first object that cannot be moved; the objects before it have
    /// moved.
    pub fn move_to(&mut self, moved: &[(ObjectId, Aabb)]) -> Result<(), Error> {
        let outcome = self.hierarchy.refit(moved.iter().copied());
        // The objects before a bad one have moved. Marking a leaf that did not change does no harm.
        let leaves = moved.iter().filter_map(|(object, _)| self.hierarchy.leaf_of(*object));
        leaves.for_each(|leaf| self.leaves.mark_moved(leaf));
        Ok(outcome?)
    }

    /// Replaces the draws of an object.
    ///
    /// # Errors
    /// [`Error::Hierarchy`] for an object that is not in the scene; the errors of
    /// [`LeafTable::set_draws`].
    pub fn set_draws(&mut self, object: ObjectId, draws: &[BucketDraw]) -> Result<(), Error> {
        match self.hierarchy.leaf_of(object).filter(|_| self.hierarchy.contains(object)) {
            Some(leaf) => self.leaves.set_draws(&[(leaf, draws)]),
            None => Err(HierarchyError::UnknownObject { object }.into()),
        }
    }

    /// Records the upload of all changes since the last frame, before anything of `frame` reads
    /// them, and rebuilds subtrees that movement has degraded. Changes stay marked until a frame
    /// that was [submitted](CulledScene::submitted) is known to have run. The buffers are replaced
    /// where more objects came than they had room for. After an error nothing is lost: the next
    /// upload tries again.
    pub(crate) fn upload(&mut self, frame: &mut Frame<'_>) -> Result<(), Error> {
        if !self.leaves.has_one_draw_per_leaf() {
            self.reordered.clear();
            self.hierarchy.rebuild_subtrees(&mut self.reordered);
            self.leaves.reorder(&self.hierarchy, &self.reordered)?;
        }
        self.leaves.begin()?;
        self.leaves.upload(frame, &self.hierarchy, &self.passes.scatter, None)
    }

    /// Notes that the frame of the last upload was submitted.
    pub fn submitted(&mut self, tick: Tick) {
        self.leaves.submitted(tick);
    }
}

/// The most CPU memory that an object with a draw takes while the scene is built.
const BYTES_PER_OBJECT: usize = 640;

/// Refuses more objects than a hierarchy holds or than there is memory for.
fn check_memory(count: usize) -> Result<(), HierarchyError> {
    Hierarchy::check_capacity(count)?;
    // Reserves all memory at once and frees it: a failure half-way through would end the program.
    let size_bytes = count.saturating_mul(BYTES_PER_OBJECT);
    let asked = Vec::<u8>::new().try_reserve_exact(size_bytes);
    asked.map_err(|_| HierarchyError::NoMemory { count, size_bytes })
}
