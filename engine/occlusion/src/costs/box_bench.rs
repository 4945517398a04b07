//! The bench that costs are measured on: frames of one item many times and little else.

mod recorder;
mod resets;

use std::time::Instant;

use cull::VisibilityTest;
use gpu::{
    CancellationToken, Device, FragmentChoice, FrameRing, IndirectDraw, OptionalFeature,
    PredicationMode, QueryRing, Resubmission,
};

use crate::costs::device_costs::QueryResetCosts;
use crate::error::Error;
use crate::object_renderer::ObjectRenderer;
use crate::passes::{OcclusionPasses, ProxyPass};
use crate::shader_set::ShaderSet;
pub(super) use recorder::{BoxRecorder, TestLoad};

/// The triangles of a patch. Half of them face away, as in a solid object.
pub const PATCH_TRIANGLES: u32 = 2 * 16 * 16;

/// The objects that costs are measured with.
pub struct CalibrationScene<'a> {
    /// The device whose costs are measured.
    pub device: &'a Device,
    /// The shaders that the passes were made of.
    pub shaders: &'a ShaderSet,
    /// The passes that test boxes.
    pub passes: &'a OcclusionPasses,
    /// The predication modes to measure.
    pub executors: &'a [PredicationMode],
    /// The renderer of the hidden objects.
    pub objects: &'a mut dyn ObjectRenderer,
    /// The draw of one triangle, and the draw of [`PATCH_TRIANGLES`] triangles, half of which face
    /// away.
    pub draws: [IndirectDraw; 2],
    /// Cancels the measurement; checked before each batch.
    pub cancellation: &'a CancellationToken,
}

/// The size of a box on the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxSize {
    /// A few pixels.
    Small,
    /// A quarter of the image.
    Large,
}

/// The result that decides a predicate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PredicateResult {
    /// Zero: the draw is skipped.
    Skipped,
    /// Not zero: the draw is drawn.
    Taken,
}

/// An item that a frame of a [`BoxBench`] contains many times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BenchItem {
    /// No item, but a single draw, since some drivers leave out a rendering without draws.
    Nothing,
    /// Hidden objects of a triangle each, by indirect calls with several draws each.
    Draws {
        /// The number of draws per call; one call has all of a lower number.
        per_call: u32,
    },
    /// Hidden objects of [`PATCH_TRIANGLES`] each.
    Patches,
    /// Indirect calls of a draw without instances.
    EmptyCalls,
    /// Ranges of hidden draws of a triangle each under a predicate, including the resolve of all
    /// predicates.
    Ranges {
        /// The predication mode of the ranges.
        executor: PredicationMode,
        /// The number of draws per range.
        width: u32,
        /// The result that decides each range.
        result: PredicateResult,
    },
    /// Queries without a draw, including the copy of their results.
    EmptyQueries,
    /// Hidden draws of a triangle under a query, including the copy of the results.
    QueriedDraws,
    /// Tests of hidden boxes. All tests by the compute tester share one preparation.
    Boxes(VisibilityTest, BoxSize),
    /// Tests of hidden boxes by flags that all fragments may set
    /// ([`BoxBench::compare_all_fragments`]).
    BoxesOfAllFragments(BoxSize),
    /// Tests of large boxes by flags, every fragment of which passes.
    VisibleBoxes,
    /// Preparations of the compute tester, with a test each.
    Grids,
    /// Breaks: the end of a rendering, and the begin of the next with a load of the contents. Each
    /// rendering draws a hidden triangle.
    Breaks,
    /// Resets of queries: by the CPU, if frames are submitted once, and otherwise by a command.
    Resets(Resubmission),
}

/// A bench that times items on a device.
pub struct BoxBench<'a> {
    device: Device,
    frames: FrameRing,
    has_timestamps: bool,
    reset_queries: QueryRing<()>,
    pub(super) recorder: BoxRecorder<'a>,
}

impl<'a> BoxBench<'a> {
    /// Creates a bench for at most `most` of an item per frame, and for ranges with as many draws
    /// in total.
    ///
    /// # Errors
    /// An executor that the device lacks or that cannot count this number of draws; no memory.
    pub fn new(scene: CalibrationScene<'a>, most: u32) -> Result<Self, Error> {
        let device = scene.device.clone();
        let mut frames = FrameRing::new(&device, 1)?;
        let has_timestamps = device.capabilities().has(OptionalFeature::Timestamps);
        if has_timestamps {
            frames.time_passes()?;
        }
        Ok(Self {
            reset_queries: QueryRing::new(&device, 1, "reset queries")?,
            recorder: BoxRecorder::new(scene, most.max(1))?,
            device,
            frames,
            has_timestamps,
        })
    }

    /// Compiles the pass of [`BenchItem::BoxesOfAllFragments`], on a device that normally chooses
    /// one fragment.
    ///
    /// # Errors
    /// A shader that does not compile; no memory.
    pub fn compare_all_fragments(&mut self, shaders: &ShaderSet) -> Result<(), Error> {
        if self.device.capabilities().has(OptionalFeature::RepresentativeFragments) {
            let attachments = self.recorder.passes.attachments();
            let choice = FragmentChoice::All;
            let pass = ProxyPass::of_fragments(&self.device, shaders, attachments, choice)?;
            self.recorder.all_fragments = Some(pass);
        }
        Ok(())
    }

    /// Returns true if the device supports an item.
    pub fn can(&self, item: BenchItem) -> bool {
        match item {
            BenchItem::Resets(Resubmission::Never) => {
                self.device.capabilities().has(OptionalFeature::HostQueryReset)
            }
            _ => self.recorder.can(item),
        }
    }

    /// Returns the time of a frame with `count` of an item (ns), alone on the GPU: by GPU
    /// timestamps where the device has them, otherwise the CPU time from submit to completion. For
    /// resets by the CPU it is the CPU time of the call.
    ///
    /// # Errors
    /// No memory, a failed call.
    pub fn time_ns(&mut self, item: BenchItem, count: u32) -> Result<f64, Error> {
        if let BenchItem::Resets(by) = item {
            let mut frames = resets::frames(&self.device, by)?;
            return resets::time_ns(&self.device, &mut frames, by, &mut self.reset_queries, count);
        }
        let mut frame = self.frames.begin()?;
        self.recorder.prepare(&mut frame, item, count)?;
        frame.commands().pass("cost", |commands| self.recorder.record(commands, item, count));
        let began = Instant::now();
        frame.submit(None)?;
        self.device.wait_idle()?;
        let elapsed = began.elapsed();
        if self.has_timestamps
            && let Some(time) = self.frames.begin()?.pass_times().first()
        {
            return Ok(time.gpu_ms * 1.0e6);
        }
        Ok(elapsed.as_secs_f64() * 1.0e9)
    }

    /// Measures the cost of resetting a query, by the CPU and by commands.
    pub(super) fn reset_costs(&mut self) -> Result<QueryResetCosts, Error> {
        resets::measure(&self.device, &mut self.reset_queries)
    }
}
