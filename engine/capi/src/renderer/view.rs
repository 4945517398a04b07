//! The views of a renderer, each with a history of its own, and their counts.

use std::collections::VecDeque;

use cull::FrameId;
use render::{FrameRequest, RenderView, Renderer};

use crate::decisions::plan::tester_number;
use crate::error::Failure;
use crate::executor::scene::predication_number;
use crate::layout::{Versioned, layout, versioned};
use crate::table::handle;

/// A view of a renderer, with its history of earlier frames.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraRendererView {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraRendererView = "view of a renderer");

/// The counts of the newest frame of a view whose results are known, and the state of uploads.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraRendererStats {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// 1 while meshes are being uploaded, whose objects are not drawn yet; else 0.
    pub is_uploading: u32,
    /// The frame, counted from 1; 0 if none is known.
    pub frame: u64,
    /// The objects of the scene in that frame.
    pub total: u64,
    /// The objects among them that the GPU drew.
    pub drawn: u64,
    /// The objects among the drawn ones that a test revealed.
    pub revealed: u64,
    /// The boxes that were tested.
    pub tests: u64,
    /// An `ANTUMBRA_PREDICATION_..`: the way that hidden draws are skipped. With
    /// `ANTUMBRA_COST_MODEL_MEASURED` it is the cheapest one, else the device's usual one.
    pub predication: u32,
    /// An `ANTUMBRA_TESTER_..`: the tester that was expected to cost least.
    pub tester: u32,
}
layout!(AntumbraRendererStats: struct_size, is_uploading, frame, total, drawn, revealed, tests,
    predication, tester);

versioned!(AntumbraRendererStats: 7, required: [], defaults: {});

/// The counts of a frame that are known when it is submitted.
struct SubmittedFrame {
    frame: FrameId,
    total: u64,
    tests: u64,
}

/// A view of a renderer, with its frames.
pub(crate) struct HostedView {
    view: RenderView,
    /// The frames whose results are not known yet.
    submitted: VecDeque<SubmittedFrame>,
    stats: AntumbraRendererStats,
}

impl HostedView {
    pub fn new(renderer: &Renderer) -> Result<Self, Failure> {
        let view = renderer.new_view()?;
        Ok(Self { view, submitted: VecDeque::new(), stats: AntumbraRendererStats::INIT })
    }

    /// Renders a frame and submits it.
    pub fn render(
        &mut self,
        renderer: &mut Renderer,
        request: FrameRequest<'_>,
    ) -> Result<(), Failure> {
        let report = renderer.render(&mut self.view, request)?;
        let hierarchy = renderer.hierarchy();
        let total = hierarchy.leaf_objects().len() - hierarchy.free_leaves();
        self.submitted.push_back(SubmittedFrame {
            frame: self.view.plan().frame,
            total: total as u64,
            tests: u64::from(report.tests),
        });
        self.drain_stats();
        Ok(())
    }

    /// Waits until all frames are over, and returns the image of the newest one, which shows this
    /// view: four bytes per pixel.
    pub fn finish(&mut self, renderer: &mut Renderer) -> Result<Vec<u8>, Failure> {
        Ok(renderer.finish(&mut self.view)?.image.pixels)
    }

    /// Waits until all frames are over, and reads the results of this view.
    pub fn wait(&mut self, renderer: &mut Renderer) -> Result<(), Failure> {
        Ok(renderer.wait_idle(&mut self.view)?)
    }

    /// Forgets the frames of a lost device, which have no results.
    pub fn forget_frames(&mut self) {
        self.submitted.clear();
    }

    /// Returns the newest counts.
    pub fn stats(&mut self, renderer: &Renderer) -> AntumbraRendererStats {
        self.drain_stats();
        AntumbraRendererStats {
            is_uploading: u32::from(renderer.is_uploading()),
            predication: predication_number(renderer.predication()),
            tester: tester_number(renderer.cheapest_tester()),
            ..self.stats
        }
    }

    fn drain_stats(&mut self) {
        for outcome in self.view.drain_stats() {
            // Frames before it whose results are lost have no outcome.
            while self.submitted.front().is_some_and(|first| first.frame < outcome.frame) {
                self.submitted.pop_front();
            }
            let is_it = |submitted_frame: &&SubmittedFrame| submitted_frame.frame == outcome.frame;
            let Some(newest) = self.submitted.front().filter(is_it) else { continue };
            self.stats.frame = outcome.frame.0;
            self.stats.drawn = outcome.draws;
            self.stats.revealed = outcome.revealed;
            (self.stats.total, self.stats.tests) = (newest.total, newest.tests);
        }
    }
}
