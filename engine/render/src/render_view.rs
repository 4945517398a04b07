//! A view of a renderer's scene: its visibility history, and its counts of samples.

use std::sync::atomic::{AtomicU64, Ordering};

use cull::{Corrections, CullView, FramePlan, ObjectId};
use gpu::Tick;
use occlusion::{CulledScene, FrameStats, OcclusionState};

use crate::debug::pointer::{Pointed, Pointer, check_pointer};
use crate::debug::sample_counts::{COUNTING, SampleCounts, VisibleSamples, check_counts};
use crate::error::Error;
use crate::flares::{FlareCounts, FlareState};

/// The identity of a renderer. Objects that were made by one renderer do not fit another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct RendererId(u64);

impl RendererId {
    /// Creates an identity that no other renderer of the process has.
    pub(crate) fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// The number of devices that a renderer lost before its present one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct DeviceGeneration(u32);

impl DeviceGeneration {
    pub(crate) fn next(self) -> Self {
        Self(self.0.wrapping_add(1))
    }
}

/// A view of a scene with its own visibility history. A scene may have several views.
pub struct RenderView {
    pub(crate) renderer: RendererId,
    /// The device on which the rings of the view lie.
    pub(crate) generation: DeviceGeneration,
    pub(crate) visibility: OcclusionState,
    /// The viewpoint of the newest frame.
    pub(crate) seen_from: Option<CullView>,
    /// The tick of the newest frame that shows the view.
    pub(crate) shown_tick: Option<Tick>,
    pub(crate) counts: SampleCounts,
    pub(crate) pointer: Pointer,
    pub(crate) flares: FlareCounts,
}

impl RenderView {
    pub(crate) fn new(
        renderer: RendererId,
        generation: DeviceGeneration,
        visibility: OcclusionState,
    ) -> Self {
        Self {
            renderer,
            generation,
            visibility,
            seen_from: None,
            shown_tick: None,
            counts: SampleCounts::default(),
            pointer: Pointer::default(),
            flares: FlareCounts::default(),
        }
    }

    /// Begins anew on another device, without history. What the view watches stays the same; the
    /// answers of the lost device are never read.
    pub(crate) fn follow_device(
        &mut self,
        generation: DeviceGeneration,
        visibility: OcclusionState,
    ) {
        self.generation = generation;
        self.visibility = visibility;
        self.seen_from = None;
        self.shown_tick = None;
        self.counts.follow_device();
        self.pointer.follow_device();
        self.flares.follow_device();
    }

    /// Returns the plan of the newest frame.
    pub fn plan(&self) -> &FramePlan {
        self.visibility.plan()
    }

    /// Forgets the history; the next frame starts like the first. Call it after a change that makes
    /// the history worthless, such as a jump to another place.
    pub fn reset(&mut self) {
        self.visibility.reset();
        self.counts.forget_settled(self.visibility.plan().frame);
        self.flares.reset();
    }

    /// Takes the outcomes of the frames whose results were read since the last call, at most the
    /// latest 1024.
    pub fn drain_stats(&mut self) -> std::collections::vec_deque::Drain<'_, FrameStats> {
        self.visibility.drain_stats()
    }

    /// Returns the outcome of the newest frame whose results were read, even if it was already
    /// [taken](RenderView::drain_stats).
    pub fn newest_stats(&self) -> Option<FrameStats> {
        self.visibility.newest_stats()
    }

    /// Returns the corrections that this view's cost model makes; `None` without a cost model.
    pub fn corrections(&self) -> Option<Corrections> {
        self.visibility.corrections()
    }

    /// Counts the visible samples of exactly these objects in every frame from now on. An id that
    /// no object has is ignored until an object gets it. Costs two or three small draws per object
    /// and frame; an empty list costs nothing.
    ///
    /// # Errors
    /// A device that cannot count
    /// ([`Renderer::supports_counts`](crate::Renderer::supports_counts)).
    pub fn watch(&mut self, objects: &[ObjectId]) -> Result<(), Error> {
        if !objects.is_empty() {
            check_counts(self.visibility.device(), COUNTING)?;
        }
        self.counts.watch(objects);
        Ok(())
    }

    /// Returns the newest count of each watched object that has been counted, ascending by object.
    /// The count of a removed object is dropped, even if a new object has its id.
    pub fn visible_samples(&self) -> &[VisibleSamples] {
        self.counts.newest()
    }

    /// Finds, in every frame from now on, the opaque object at a pixel of the view's part of the
    /// image, counted from the upper left corner; `None` ends this. Costs a draw of the objects
    /// whose box meets the pixel, clipped to that pixel; nothing waits. Transparent objects and the
    /// background are not found. With several samples per pixel, it finds the object that owns the
    /// first sample.
    ///
    /// # Errors
    /// A device whose fragment shaders cannot write to buffers
    /// ([`gpu::OptionalFeature::FragmentStores`]).
    pub fn point_at(&mut self, pixel: Option<[u32; 2]>) -> Result<(), Error> {
        if pixel.is_some() {
            check_pointer(self.visibility.device())?;
        }
        self.pointer.point_at(pixel);
        Ok(())
    }

    /// Returns the object under the pointer, as shown by the newest frame whose answer has been
    /// read; `None` before the first answer.
    pub fn pointed(&self) -> Option<&Pointed> {
        self.pointer.newest()
    }

    /// Returns the state of each flare in the newest frame, in the order of
    /// [`Renderer::set_flares`](crate::Renderer::set_flares).
    pub fn flares(&self) -> &[FlareState] {
        self.flares.states()
    }

    /// Reads every available result and updates the history. Never waits.
    pub(crate) fn collect(&mut self, completed: Tick, scene: &CulledScene) {
        self.visibility.collect(completed, scene);
        self.counts.collect(completed, scene.hierarchy(), self.visibility.plan().frame);
        self.pointer.collect(completed);
        self.flares.collect(completed);
    }

    /// Creates the rings again if the number of frames in flight has changed.
    pub(crate) fn follow_frames_in_flight(
        &mut self,
        scene: &CulledScene,
    ) -> Result<(), occlusion::Error> {
        if self.visibility.frames_in_flight() != scene.frames_in_flight() {
            self.visibility.follow_frames_in_flight(scene)?;
            self.counts.forget_ring();
            self.pointer.forget_ring();
            self.flares.forget_ring();
        }
        Ok(())
    }

    /// Notes that the newest frame was submitted.
    pub(crate) fn submitted(
        &mut self,
        tick: Tick,
        scene: &CulledScene,
        timed_views: Option<usize>,
    ) {
        self.shown_tick = Some(tick);
        self.visibility.submitted(tick, scene, timed_views);
        let now = self.visibility.plan().frame;
        let slots = self.visibility.frames_in_flight();
        self.counts.submitted(tick, now, slots);
        self.pointer.submitted(tick);
        self.flares.submitted(tick);
    }
}
