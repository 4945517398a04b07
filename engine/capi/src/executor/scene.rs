//! The scene of a host: objects with draws in its own pipelines.

use cull::{Aabb, DrawPhases, HierarchyError, ObjectId};
use gpu::{Attachments, Device, FrameRing, IndirectDraw, PredicationMode, Resubmission};
use occlusion::{
    BucketDraw, BucketError, BucketId, CulledScene, CulledSceneOptions, DeviceCosts, DriverQuirks,
    Error, HostObject, OcclusionState,
};

use super::device::AntumbraDevice;
use super::device_costs::AntumbraDeviceCosts;
use super::lists::{ANTUMBRA_DRAWS_BY_CALLBACK, ANTUMBRA_DRAWS_BY_LISTS, KeptLists};
use super::quirks::assumptions;
use super::target::{AntumbraAttachments, CachedTarget};
use crate::decisions::hierarchy::{AntumbraAabb, usable};
use crate::error::{AntumbraResult, Failure};
use crate::layout::{Versioned, layout, versioned};
use crate::table::{Table, handle};

/// The objects of a host on its device.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraScene {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraScene = "scene");

/// A view of a scene, with its history of earlier frames.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraView {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraView = "view");

/// Hidden draws are skipped in the device's best way, or in the cheapest way if costs are given.
pub const ANTUMBRA_PREDICATION_BEST: u32 = 0;
/// Hidden draws are skipped by conditional rendering.
pub const ANTUMBRA_PREDICATION_CONDITIONAL: u32 = 1;
/// Hidden draws are skipped by draw counts.
pub const ANTUMBRA_PREDICATION_COUNTS: u32 = 2;
/// Hidden draws are skipped by instance counts.
pub const ANTUMBRA_PREDICATION_INSTANCES: u32 = 3;
/// Compacted lists hold only draws that show: one list per bucket and round, with a draw count.
pub const ANTUMBRA_PREDICATION_COMPACTED: u32 = 4;

/// Returns the number of a predication mode in C.
pub(crate) fn predication_number(predication: PredicationMode) -> u32 {
    match predication {
        PredicationMode::Conditional => ANTUMBRA_PREDICATION_CONDITIONAL,
        PredicationMode::Counts => ANTUMBRA_PREDICATION_COUNTS,
        PredicationMode::Instances => ANTUMBRA_PREDICATION_INSTANCES,
        PredicationMode::Compacted => ANTUMBRA_PREDICATION_COMPACTED,
    }
}

/// Returns the predication mode of a number in C; `None` for the best.
fn predication(number: u32) -> Result<Option<PredicationMode>, Failure> {
    match number {
        ANTUMBRA_PREDICATION_BEST => Ok(None),
        ANTUMBRA_PREDICATION_CONDITIONAL => Ok(Some(PredicationMode::Conditional)),
        ANTUMBRA_PREDICATION_COUNTS => Ok(Some(PredicationMode::Counts)),
        ANTUMBRA_PREDICATION_INSTANCES => Ok(Some(PredicationMode::Instances)),
        ANTUMBRA_PREDICATION_COMPACTED => Ok(Some(PredicationMode::Compacted)),
        other => Err(Failure::argument(format!("there is no ANTUMBRA_PREDICATION_.. {other}"))),
    }
}

/// The host may submit a frame again before it is safe: commands reset its queries in each run.
pub const ANTUMBRA_RESUBMISSION_ALLOWED: u32 = 0;
/// The host submits each frame at most once. The CPU resets its queries if the device's
/// `hostQueryReset` is on, since some drivers wait once per query that a command resets.
pub const ANTUMBRA_RESUBMISSION_NEVER: u32 = 1;

/// The options of a scene.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraSceneDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The most frames that may have begun and are not known to be over, up to 64. Default: 2.
    pub frames_in_flight: u32,
    /// Required: the device.
    pub device: AntumbraDevice,
    /// Required: the attachments of all views.
    pub attachments: *const AntumbraAttachments,
    /// The number of buckets, up to 65536. A bucket is a pipeline in a pass, in which draws of
    /// objects are drawn together. Buckets are drawn in the order of their numbers. Default: 1.
    pub bucket_count: u32,
    /// The number of objects that fit before the scene must grow. Default: 0.
    pub object_capacity: u32,
    /// The number of draws that fit before they are uploaded again to larger buffers. Default: 0.
    pub draw_capacity: u32,
    /// An `ANTUMBRA_PREDICATION_..`. Default: `ANTUMBRA_PREDICATION_BEST`.
    pub predication: u32,
    /// An `ANTUMBRA_DRAWS_..`. Default: `ANTUMBRA_DRAWS_BY_CALLBACK`.
    pub draws: u32,
    /// An `ANTUMBRA_RESUBMISSION_..`. Default: `ANTUMBRA_RESUBMISSION_ALLOWED`.
    pub resubmission: u32,
    /// A set of `ANTUMBRA_ASSUMPTION_..` that a self-test found broken: what rests on them is not
    /// used. Default: 0, none.
    pub disabled: u32,
    /// Must be 0.
    pub reserved: u32,
    /// The measured costs of the same physical device. With them, the scene skips hidden draws in
    /// the cheapest way for `object_capacity` objects, and leaves out tests that cost more than
    /// they are expected to save. Default: 0, none: everything that may be hidden is tested.
    pub costs: AntumbraDeviceCosts,
}
layout!(AntumbraSceneDesc: struct_size, frames_in_flight, device, attachments, bucket_count,
    object_capacity, draw_capacity, predication, draws, resubmission, disabled, reserved, costs);

versioned!(AntumbraSceneDesc: 6,
    required: [attachments],
    defaults: { frames_in_flight: 2, bucket_count: 1 }
);

/// An object that is added.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntumbraObject {
    /// The box around everything that the object draws.
    pub bounds: AntumbraAabb,
    /// The index of its first draw in the array of draws.
    pub first_draw: u32,
    /// The number of its draws.
    pub draw_count: u32,
}
layout!(AntumbraObject: bounds, first_draw, draw_count);

/// A draw of an object: an indexed indirect command in a bucket.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraObjectDraw {
    /// The bucket.
    pub bucket: u32,
    /// As in `VkDrawIndexedIndirectCommand`.
    pub index_count: u32,
    /// As in `VkDrawIndexedIndirectCommand`; any number.
    pub instance_count: u32,
    /// As in `VkDrawIndexedIndirectCommand`.
    pub first_index: u32,
    /// As in `VkDrawIndexedIndirectCommand`.
    pub vertex_offset: i32,
    /// As in `VkDrawIndexedIndirectCommand`.
    pub first_instance: u32,
}
layout!(AntumbraObjectDraw: bucket, index_count, instance_count, first_index, vertex_offset,
    first_instance);

impl From<&AntumbraObjectDraw> for BucketDraw {
    fn from(object_draw: &AntumbraObjectDraw) -> Self {
        let triangles = (object_draw.index_count / 3).saturating_mul(object_draw.instance_count);
        let draw = IndirectDraw {
            index_count: object_draw.index_count,
            instance_count: object_draw.instance_count,
            first_index: object_draw.first_index,
            vertex_offset: object_draw.vertex_offset,
            first_instance: object_draw.first_instance,
        };
        Self { bucket: BucketId(object_draw.bucket), draw, triangles }
    }
}

/// The counts of the newest frame of a view whose results are known.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraViewStats {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Is 0.
    pub reserved: u32,
    /// The frame, counted from 1 in its view; 0 if none is known.
    pub frame: u64,
    /// The objects that the GPU drew.
    pub objects: u64,
    /// The objects among them that a test revealed.
    pub revealed: u64,
    /// The occlusion queries in the newest plan of the view, which may be of a later frame.
    pub queries: u64,
    /// The boxes that the newest plan tests.
    pub tests: u64,
    /// An `ANTUMBRA_PREDICATION_..`: the way that hidden draws are skipped, unless the host draws
    /// from lists.
    pub predication: u32,
    /// 1 if costs decide which boxes are tested, and by which tester; else 0.
    pub has_cost: u32,
}
layout!(AntumbraViewStats: struct_size, reserved, frame, objects, revealed, queries, tests,
    predication, has_cost);

versioned!(AntumbraViewStats: 5, required: [], defaults: {});

/// A view of a scene.
pub(crate) struct HostedView {
    /// The history, which is created for the first target.
    pub state: Option<OcclusionState>,
    pub target: CachedTarget,
    pub lists: KeptLists,
    stats: AntumbraViewStats,
}

impl HostedView {
    /// Returns the newest counts.
    pub fn stats(&mut self) -> AntumbraViewStats {
        let outcomes = self.state.iter_mut().flat_map(OcclusionState::drain_stats);
        if let Some(outcome) = outcomes.last() {
            self.stats.frame = outcome.frame.0;
            self.stats.objects = outcome.draws;
            self.stats.revealed = outcome.revealed;
        }
        self.stats.queries = self.query_count() as u64;
        if let Some(state) = &self.state {
            self.stats.tests = state.plan().tests.len() as u64;
            self.stats.has_cost = state.has_cost_model().into();
        }
        self.stats
    }

    /// Returns the number of queries in the newest plan.
    pub fn query_count(&self) -> usize {
        self.state.as_ref().map_or(0, |state| state.plan().query_count())
    }
}

/// Names the object of the caller's array that was refused.
fn of_objects(failure: Failure, refused: Option<usize>) -> Failure {
    match refused {
        Some(place) => failure.within(format_args!("objects[{place}]")),
        None => failure,
    }
}

/// Names the draw of the caller's array that was refused.
fn of_draws(error: Error, draws: &[BucketDraw]) -> Failure {
    let Error::Buckets(BucketError::Unknown { bucket, bucket_count }) = error else {
        return error.into();
    };
    let place = draws.iter().position(|draw| draw.bucket == bucket).unwrap_or_default();
    Failure::argument(format_args!(
        "draws[{place}] names bucket {}, but the scene was created with {bucket_count}: set \
         AntumbraSceneDesc::bucket_count to the number of your pipelines",
        bucket.0
    ))
}

/// A scene, its views, and its frames.
pub(crate) struct HostedScene {
    pub scene: CulledScene,
    pub frames: FrameRing,
    pub attachments: Attachments,
    /// [`DrawPhases::Two`] if the host draws from lists.
    pub draw_phases: DrawPhases,
    pub views: Table<HostedView, AntumbraView>,
    objects: Vec<ObjectId>,
}

impl HostedScene {
    pub fn new(
        device: Device,
        desc: &AntumbraSceneDesc,
        attachments: &AntumbraAttachments,
        costs: Option<&DeviceCosts>,
    ) -> Result<Self, Failure> {
        if device.has_queue() {
            let message = "the device was adopted with a queue, for a renderer: a scene needs a \
                           device that was adopted with AntumbraDeviceDesc::queue = null";
            return Err(Failure::argument(message));
        }
        let attachments = attachments.attachments()?;
        let predication = predication(desc.predication)?;
        let draw_phases = match desc.draws {
            ANTUMBRA_DRAWS_BY_CALLBACK => DrawPhases::PerRound,
            ANTUMBRA_DRAWS_BY_LISTS if attachments.pass.is_some() => {
                let message = "ANTUMBRA_DRAWS_BY_LISTS is for dynamic rendering: the tests are \
                               recorded by the library, so desc.attachments.render_pass must be null";
                return Err(Failure::argument(message));
            }
            ANTUMBRA_DRAWS_BY_LISTS => DrawPhases::Two,
            other => {
                return Err(Failure::argument(format!("there is no ANTUMBRA_DRAWS_.. {other}")));
            }
        };
        let resubmission = match desc.resubmission {
            ANTUMBRA_RESUBMISSION_ALLOWED => Resubmission::Allowed,
            ANTUMBRA_RESUBMISSION_NEVER => Resubmission::Never,
            other => {
                let message = format!("there is no ANTUMBRA_RESUBMISSION_.. {other}");
                return Err(Failure::argument(message));
            }
        };
        let frames_in_flight = desc.frames_in_flight as usize;
        let mut frames = FrameRing::new(&device, frames_in_flight)?;
        frames.set_resubmission(resubmission);
        let quirks = DriverQuirks::new(&assumptions(desc.disabled)?);
        quirks.texts().iter().for_each(|text| tracing::warn!("{text}"));
        let options = CulledSceneOptions {
            object_capacity: desc.object_capacity as usize,
            draw_capacity: desc.draw_capacity,
            bucket_count: desc.bucket_count,
            frames_in_flight,
            predication,
            draw_phases,
            quirks,
            costs,
            ..Default::default()
        };
        let scene = CulledScene::new(&device, attachments, &options)?;
        Ok(Self {
            scene,
            frames,
            attachments,
            draw_phases,
            views: Table::new(0),
            objects: Vec::new(),
        })
    }

    /// Adds objects and returns their ids.
    pub fn add(
        &mut self,
        objects: &[AntumbraObject],
        draws: &[AntumbraObjectDraw],
    ) -> Result<&[ObjectId], Failure> {
        let mut listed = Vec::new();
        let mut added = Vec::new();
        let reserved = listed.try_reserve(draws.len()).and(added.try_reserve(objects.len()));
        if reserved.is_err() {
            let message = format!("no memory to add {} objects", objects.len());
            return Err(Failure::new(AntumbraResult::NoMemory, message));
        }
        listed.extend(draws.iter().map(BucketDraw::from));
        let draws = &listed[..];
        for (number, object) in objects.iter().enumerate() {
            let first = object.first_draw as usize;
            let range = first..first.saturating_add(object.draw_count as usize);
            let draws = draws.get(range).ok_or_else(|| {
                Failure::argument(format_args!(
                    "objects[{number}] has {} draws from draw {} on, but draw_count is {}",
                    object.draw_count,
                    object.first_draw,
                    draws.len()
                ))
            })?;
            let name = format_args!("objects[{number}].bounds");
            added.push(HostObject { bounds: usable(name, object.bounds)?, draws });
        }
        self.objects.clear();
        let outcome = self.scene.add(&added, &mut self.objects);
        outcome.map_err(|error| of_draws(error, draws))?;
        Ok(&self.objects)
    }

    pub fn remove(&mut self, objects: &[u32]) -> Result<(), Failure> {
        self.objects.clear();
        self.objects.extend(objects.iter().map(|object| ObjectId(*object)));
        let hierarchy = self.scene.hierarchy();
        let missing = self.objects.iter().position(|object| !hierarchy.contains(*object));
        let outcome = self.scene.remove(&self.objects);
        outcome.map_err(|error| {
            let Error::Hierarchy(HierarchyError::UnknownObject { object }) = error else {
                return error.into();
            };
            // An object that was there is refused where it is named for the second time.
            let was_there = missing.is_none_or(|place| self.objects[place] != object);
            let places = self.objects.iter().enumerate().filter(|(_, id)| **id == object);
            let refused = places.map(|(place, _)| place).nth(usize::from(was_there));
            of_objects(error.into(), refused)
        })
    }

    pub fn move_to(&mut self, objects: &[u32], boxes: &[AntumbraAabb]) -> Result<(), Failure> {
        let boxes = boxes.iter().map(|bounds| Aabb::from(*bounds));
        let ids = objects.iter().map(|object| ObjectId(*object));
        let moved: Vec<(ObjectId, Aabb)> = ids.zip(boxes).collect();
        self.scene.move_to(&moved).map_err(|error| {
            let refused = |(id, bounds): &(ObjectId, Aabb)| match &error {
                Error::Hierarchy(HierarchyError::BadBox { object, .. }) => {
                    id == object && !bounds.is_usable()
                }
                Error::Hierarchy(HierarchyError::UnknownObject { object }) => id == object,
                _ => false,
            };
            let refused = moved.iter().position(refused);
            of_objects(error.into(), refused)
        })
    }

    pub fn set_draws(&mut self, object: u32, draws: &[AntumbraObjectDraw]) -> Result<(), Failure> {
        let draws: Vec<BucketDraw> = draws.iter().map(BucketDraw::from).collect();
        let outcome = self.scene.set_draws(ObjectId(object), &draws);
        outcome.map_err(|error| of_draws(error, &draws))
    }

    /// Creates a view without a history.
    pub fn add_view(&self) -> Result<AntumbraView, Failure> {
        let target = CachedTarget::default();
        let predication = predication_number(self.scene.culling_setup().predication);
        let stats = AntumbraViewStats { predication, ..AntumbraViewStats::INIT };
        let lists = KeptLists::default();
        self.views.insert(HostedView { state: None, target, lists, stats })
    }
}
