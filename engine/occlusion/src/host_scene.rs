//! The scene of a host: objects with draws in the host's own pipelines, which come, go and move in
//! bulk.

use cull::{
    Aabb, CullConfig, Culler, DrawPhases, Hierarchy, HierarchyError, LeafRange, ObjectId,
    SkippedWork,
};
use gpu::{Device, Frame, Target, Tick};

use crate::costs::device_costs::{ChoiceRequest, CullingSetup, DeviceCosts};
use crate::error::Error;
use crate::executor::PlanExecutor;
use crate::leaf_table::{BucketDraw, BucketTableInfo, LeafTable};
use crate::occlusion_state::OcclusionState;
use crate::passes::OcclusionPasses;

/// An object of a host.
#[derive(Clone, Copy, Debug)]
pub struct HostObject<'a> {
    /// The box around all that it draws.
    pub bounds: Aabb,
    /// Its draws, in any order; the executor draws bucket after bucket.
    pub draws: &'a [BucketDraw],
}

/// The objects of a host: a hierarchy over their boxes, and the executor with their draws. Changes
/// reach the GPU with the next frame that [uploads](HostScene::upload) them; nothing waits.
pub struct HostScene {
    device: Device,
    frames_in_flight: usize,
    hierarchy: Hierarchy,
    executor: PlanExecutor,
    choice: CullingSetup,
    /// The ranges of a change; kept to allocate nothing.
    reordered: Vec<LeafRange>,
}

impl HostScene {
    /// Creates a scene with room for `object_capacity` objects; more room is made as objects come.
    /// Without costs everything that may be hidden is tested, and the way that hidden draws are
    /// skipped is the device's usual one, if none is wanted. It is another one in either case where
    /// the driver cannot be [trusted](OcclusionPasses::with_quirks) with that.
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`] for a way to skip draws that the device lacks;
    /// [`gpu::Error::TooLarge`] and [`Error::Hierarchy`] for more than there can be; no memory; a
    /// failed call.
    pub fn new(
        device: &Device,
        passes: OcclusionPasses,
        object_capacity: usize,
        draws: BucketTableInfo,
    ) -> Result<Self, Error> {
        Self::by(device, passes, draws, object_capacity, None)
    }

    /// Creates the same, and decides by the [measured](crate::measure) costs of the device: about
    /// the way that hidden draws are skipped, for as many objects as there is room for, and in each
    /// frame of its [views](HostScene::new_view) about what is tested, and by which tester.
    ///
    /// A device that was adopted without a queue cannot be measured, since nothing submits there.
    /// Before its first frame, measure the same device adopted with a queue. Costs of tests are
    /// those with the way that is taken; where a host draws from lists, they are those of lists
    /// with [`PredicationMode::Compacted`](gpu::PredicationMode::Compacted).
    ///
    /// # Errors
    /// Those of [`HostScene::new`].
    pub fn with_costs(
        device: &Device,
        passes: OcclusionPasses,
        object_capacity: usize,
        draws: BucketTableInfo,
        device_costs: &DeviceCosts,
    ) -> Result<Self, Error> {
        Self::by(device, passes, draws, object_capacity, Some(device_costs))
    }

    fn by(
        device: &Device,
        passes: OcclusionPasses,
        draws: BucketTableInfo,
        object_capacity: usize,
        device_costs: Option<&DeviceCosts>,
    ) -> Result<Self, Error> {
        check_memory(object_capacity)?;
        let hierarchy = Hierarchy::build(&vec![Aabb::EMPTY; object_capacity])?;
        let cells_draws = u64::from(draws.cell_capacity());
        let executors =
            passes.quirks().usable_executors(device, draws.predication, cells_draws, 0)?;
        let leaves = (object_capacity as u32).max(draws.draw_capacity);
        let work = SkippedWork::of_leaves(leaves).in_buckets(draws.bucket_count);
        let request = ChoiceRequest { executors: &executors, work };
        let choice = match device_costs {
            Some(device_costs) => CullingSetup::of_costs(&request, device_costs),
            None => CullingSetup::usual(&request, None),
        };
        let frames_in_flight = draws.frames_in_flight;
        let draws = BucketTableInfo { predication: Some(choice.predication), ..draws };
        let leaves = LeafTable::bucketed(device, &hierarchy, draws)?;
        Ok(Self {
            device: device.clone(),
            frames_in_flight,
            hierarchy,
            executor: PlanExecutor { passes, leaves },
            choice,
            reordered: Vec::new(),
        })
    }

    /// Creates a view that knows nothing yet, drawn to `target` in these phases. It weighs tests by
    /// the costs of the scene, if there are any, and by the triangles per draw that it has now.
    /// Frames of a host are not timed, so that nothing corrects the costs.
    ///
    /// # Errors
    /// A failed call.
    pub fn new_view(
        &self,
        target: &Target,
        config: CullConfig,
        draw_phases: DrawPhases,
    ) -> Result<OcclusionState, Error> {
        let Self { device, hierarchy, executor, .. } = self;
        let testers = executor.testers(device, target, draw_phases);
        let mut culler = Culler::with_testers(config, testers);
        self.choice.steer(&mut culler, executor.leaves.scene_costs(hierarchy));
        OcclusionState::new(device, hierarchy, &executor.leaves, self.frames_in_flight, culler)
    }

    /// Returns what was decided about the device and the scene when it was made: the way that
    /// hidden draws are skipped, and by which costs.
    pub fn culling_setup(&self) -> &CullingSetup {
        &self.choice
    }

    /// Returns the hierarchy over the boxes.
    pub fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    /// Returns the executor of plans.
    pub fn executor(&self) -> &PlanExecutor {
        &self.executor
    }

    /// Returns what the execution of a plan needs.
    pub fn parts_mut(&mut self) -> (&Hierarchy, &mut PlanExecutor) {
        (&self.hierarchy, &mut self.executor)
    }

    /// Adds objects, and their ids, in the same order, to `added`. An id may have belonged to an
    /// object that is gone. Where there are as many as there were before, the hierarchy is built
    /// again; else the time depends on their number alone, unless there is no room for them. Then
    /// room is made for a sixteenth more than all, and the next frame uploads everything to larger
    /// buffers. A large scene should be created with its capacity.
    ///
    /// # Errors
    /// [`BucketError::Unknown`](crate::BucketError::Unknown); [`Error::Hierarchy`] for the first
    /// bad box, by its place in `objects`, or more objects than a hierarchy holds. Nothing is
    /// changed then.
    pub fn add(
        &mut self,
        objects: &[HostObject<'_>],
        added: &mut Vec<ObjectId>,
    ) -> Result<(), Error> {
        let leaves = &self.executor.leaves;
        objects.iter().try_for_each(|object| leaves.check_draws(object.draws))?;
        let boxes: Vec<Aabb> = objects.iter().map(|object| object.bounds).collect();
        check_memory(boxes.len())?;
        let first = added.len();
        self.reordered.clear();
        self.hierarchy.insert_all(&boxes, added, &mut self.reordered)?;
        self.executor.leaves.reorder(&self.hierarchy, &self.reordered)?;
        let placed = added[first..].iter().zip(objects);
        let draws =
            placed.filter_map(|(id, placed)| Some((self.hierarchy.leaf_of(*id)?, placed.draws)));
        self.executor.leaves.set_draws(&draws.collect::<Vec<_>>())
    }

    /// Takes objects out.
    ///
    /// # Errors
    /// [`Error::Hierarchy`] for the first that is not there, and those before it are gone.
    pub fn remove(&mut self, objects: &[ObjectId]) -> Result<(), Error> {
        let mut gone = Vec::with_capacity(objects.len());
        let outcome = objects.iter().try_for_each(|object| {
            self.hierarchy.remove(*object)?;
            gone.extend(self.hierarchy.leaf_of(*object).map(|leaf| (leaf, &[][..])));
            Ok(())
        });
        // Those before a bad one are gone.
        self.executor.leaves.set_draws(&gone)?;
        outcome
    }

    /// Moves objects: sets their boxes. Their draws stay as they are; where they read the objects'
    /// new places is the host's concern.
    ///
    /// # Errors
    /// [`Error::Hierarchy`] for the first object that cannot be moved; those before it have been.
    pub fn move_to(&mut self, moved: &[(ObjectId, Aabb)]) -> Result<(), Error> {
        let outcome = self.hierarchy.refit(moved.iter().copied());
        // Those before a bad one have moved: a leaf is marked once too often rather than not at
        // all.
        let leaves = moved.iter().filter_map(|(object, _)| self.hierarchy.leaf_of(*object));
        leaves.for_each(|leaf| self.executor.leaves.mark_moved(leaf));
        Ok(outcome?)
    }

    /// Replaces the draws of an object.
    ///
    /// # Errors
    /// [`Error::Hierarchy`] for an object that is not there; those of [`LeafTable::set_draws`].
    pub fn set_draws(&mut self, object: ObjectId, draws: &[BucketDraw]) -> Result<(), Error> {
        match self.hierarchy.leaf_of(object).filter(|_| self.hierarchy.contains(object)) {
            Some(leaf) => self.executor.leaves.set_draws(&[(leaf, draws)]),
            None => Err(HierarchyError::UnknownObject { object }.into()),
        }
    }

    /// Records the upload of all changes since the last frame, before anything of `frame` reads
    /// them, and mends the hierarchy where moving has worn it. Once per frame. Changes stay marked
    /// until a frame that was [submitted](HostScene::submitted) is known to have run. Where more
    /// objects came than there was room for, the buffers are replaced.
    ///
    /// # Errors
    /// [`gpu::Error::TooLarge`] for more draws than the device takes; no memory, a failed call.
    /// Nothing is lost: plans are [refused](Error::NotUploaded) in this frame, and the next upload
    /// tries again.
    pub fn upload(&mut self, frame: &mut Frame<'_>) -> Result<(), Error> {
        self.reordered.clear();
        self.hierarchy.rebuild_subtrees(&mut self.reordered);
        let PlanExecutor { passes, leaves } = &mut self.executor;
        leaves.reorder(&self.hierarchy, &self.reordered)?;
        leaves.begin()?;
        leaves.upload(frame, &self.hierarchy, &passes.scatter, None)
    }

    /// Notes that the frame of the last [`HostScene::upload`] was submitted.
    pub fn submitted(&mut self, tick: Tick) {
        self.executor.leaves.submitted(tick);
    }
}

/// The most memory that an object with a draw takes on the CPU, while the scene is built.
const BYTES_PER_OBJECT: usize = 640;

/// Refuses more objects than there is memory for.
///
/// # Errors
/// More than a hierarchy holds; no memory.
fn check_memory(count: usize) -> Result<(), HierarchyError> {
    Hierarchy::check_capacity(count)?;
    // All at once, and given back: an allocation that fails half-way would end the program.
    let size_bytes = count.saturating_mul(BYTES_PER_OBJECT);
    let asked = Vec::<u8>::new().try_reserve_exact(size_bytes);
    asked.map_err(|_| HierarchyError::NoMemory { count, size_bytes })
}
