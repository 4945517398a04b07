//! A scene on a device of wgpu, and the encoding of its frames.

use std::collections::VecDeque;
use std::sync::Arc;

use cull::DrawPhases;
use gpu::{FrameRing, Resubmission, Tick, vk};
use occlusion::{CulledScene, CulledSceneOptions, DrawRequest, OcclusionState};
use wgpu::hal::api::Vulkan;

use crate::device::{DeviceParts, WgpuDevice};
use crate::error::Error;
use crate::frame::WgpuFrame;
use crate::frame_log::FrameGuard;
use crate::target::WgpuTarget;

/// The objects of a program, culled for render passes of wgpu.
pub struct WgpuCulling {
    /// The scene: objects are added, moved and removed here, between frames.
    pub scene: CulledScene,
    ring: FrameRing,
    /// The newest frames, one per slot of the ring.
    recent: VecDeque<Tick>,
    // Dropped last, when nothing is left that frames may use.
    parts: Arc<DeviceParts>,
}

impl WgpuCulling {
    /// Creates an empty scene for targets with the format and samples of `target`.
    /// `draw_phases` of the options is ignored: draws are listed in two phases.
    ///
    /// # Errors
    /// [`Error::NoDepth`] for a target of another device; [`Error::Occlusion`] for options beyond
    /// the limits, a failed call.
    pub fn new(
        device: &WgpuDevice,
        target: &WgpuTarget,
        options: &CulledSceneOptions<'_>,
    ) -> Result<Self, Error> {
        let parts = Arc::clone(&device.shared);
        if !target.is_of(&parts) {
            return Err(Error::NoDepth);
        }
        let options = CulledSceneOptions { draw_phases: DrawPhases::Two, ..options.clone() };
        let scene = CulledScene::new(&parts.gpu, target.attachments(), &options)?;
        let mut ring = FrameRing::new(&parts.gpu, options.frames_in_flight)?;
        // wgpu submits a command buffer once.
        ring.set_resubmission(Resubmission::Never);
        Ok(Self { scene, ring, recent: VecDeque::new(), parts })
    }

    /// Returns a new view: the history of one camera. Each view has a frame of its own, so count
    /// the frames of all views in [`CulledSceneOptions::frames_in_flight`].
    ///
    /// # Errors
    /// [`Error::Occlusion`]: a failed call.
    pub fn new_view(&self, target: &WgpuTarget) -> Result<OcclusionState, Error> {
        Ok(self.scene.new_view(&target.target)?)
    }

    /// Encodes a frame of a view: uploads changes, reads the answers of frames that are over, plans
    /// and records the tests. Waits for at most [`WAIT_BOUND`](crate::WAIT_BOUND) if all frames in
    /// flight are still in use.
    ///
    /// # Errors
    /// [`Error::FramesHeld`] if as many frames as may be in flight were encoded but not submitted;
    /// [`Error::Wait`], [`Error::NoDepth`], [`Error::NoCommands`]; [`Error::Occlusion`] for a view
    /// or a target that does not fit. The frame is given up, and the next one uploads what it would
    /// have uploaded.
    pub fn encode<'v>(
        &mut self,
        view: &mut OcclusionState,
        target: &mut WgpuTarget,
        request: impl Into<DrawRequest<'v>>,
    ) -> Result<WgpuFrame, Error> {
        if !target.is_of(&self.parts) {
            return Err(Error::NoDepth);
        }
        self.make_room()?;
        let before = self.transition(&target.depth);
        let mut encoder = self.new_encoder("antumbra tests");
        // SAFETY: only the engine's commands are recorded into this encoder, and wgpu ends it.
        let guard = unsafe {
            encoder.as_hal_mut::<Vulkan, _, _>(|raw| {
                let commands = raw.ok_or(Error::NoCommands)?.raw_handle();
                self.record(commands, view, target, request.into())
            })
        }?;
        let depth = target.depth.clone();
        let depth_view = target.view.clone();
        let part = guard.clone();
        // Dropped with the command buffer if that is never submitted.
        encoder.on_submitted_work_done(move || drop((depth, depth_view, part)));
        let tests = [before, encoder.finish()];
        let lists = [view.visible_lists(), view.revealed_lists()];
        Ok(WgpuFrame::new(&self.parts, tests, lists, guard))
    }

    /// Reads the answers of all frames that are over. [`WgpuCulling::encode`] does this too; call
    /// it after [`WgpuDevice::finish`] to know the last frames.
    ///
    /// # Errors
    /// [`Error::Gpu`]: the device is lost.
    pub fn collect(&self, view: &mut OcclusionState) -> Result<(), Error> {
        view.collect(self.parts.gpu.completed()?, &self.scene);
        Ok(())
    }

    /// Waits until the frame that used the next slot of the ring is over.
    fn make_room(&mut self) -> Result<(), Error> {
        while self.recent.len() >= self.ring.frames_in_flight() {
            let Some(oldest) = self.recent.front() else { break };
            self.parts.wait_for(*oldest)?;
            self.recent.pop_front();
        }
        Ok(())
    }

    /// Encodes the state that the tests expect of the depth. wgpu keeps the texture for them, and
    /// refuses the submit if it was destroyed.
    fn transition(&self, depth: &wgpu::Texture) -> wgpu::CommandBuffer {
        let mut encoder = self.new_encoder("antumbra depth");
        let state = wgpu::TextureUses::DEPTH_STENCIL_WRITE;
        let drawn = wgpu::wgt::TextureTransition { texture: depth, selector: None, state };
        encoder.transition_resources(std::iter::empty(), std::iter::once(drawn));
        encoder.finish()
    }

    fn new_encoder(&self, label: &str) -> wgpu::CommandEncoder {
        let described = wgpu::CommandEncoderDescriptor { label: Some(label) };
        self.parts.device.create_command_encoder(&described)
    }

    /// Records the uploads and the tests of a frame.
    fn record(
        &mut self,
        commands: vk::CommandBuffer,
        view: &mut OcclusionState,
        target: &mut WgpuTarget,
        request: DrawRequest<'_>,
    ) -> Result<FrameGuard, Error> {
        // Held while its handles are recorded: nobody destroys the texture meanwhile.
        // SAFETY: the handle is not destroyed.
        let _depth = unsafe { target.depth.as_hal::<Vulkan>() }.ok_or(Error::NoDepth)?;
        // Held until the frame has begun, so that numbers rise over all scenes of the device.
        let mut frames = self.parts.log.lock();
        let numbers = frames.begin();
        // SAFETY: the command buffer is wgpu's own for this device, is being recorded, and is
        // dropped if this fails. The log knows which frames are over or will never be submitted,
        // and wgpu submits a command buffer once.
        let frame = unsafe { self.ring.begin_in(commands, numbers) }?;
        let guard = self.parts.log.guard(&mut frames);
        drop(frames);
        self.recent.push_back(numbers.current);
        let mut scope = self.scene.begin(frame)?;
        let planned = scope.plan(view, request)?;
        scope.list(planned)?.record(&mut scope, &mut target.target)?;
        scope.end()?;
        Ok(guard)
    }
}
