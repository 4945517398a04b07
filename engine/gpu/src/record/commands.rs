//! Recording: the commands that the engine uses, each in one place.

use std::cell::{Cell, OnceCell, RefCell};
use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;

use crate::core::deletion::RecordingId;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::ownership::OfDevice;
use crate::core::pending_uploads::PendingUpload;
use crate::core::tick::Tick;
use crate::memory::buffer::BufferSlice;
use crate::record::access::{Access, LayoutChange, MemoryBarrier};
use crate::record::attachments::COLOURS_MAX;
use crate::record::descriptor_pools::DescriptorPools;
use crate::record::label::LabelName;
use crate::record::render_target::{AttachmentStore, Load, RenderTarget};
use crate::record::resubmission::Resubmission;
use crate::record::ticket::Ticket;
use crate::record::timing::PassTimer;
use crate::record::viewport::Viewport;

/// The reason why a recording cannot be submitted.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Failure {
    /// A failed call.
    Call(&'static str, vk::Result),
    /// An invalid command.
    Wrong(&'static str),
    /// An object of another device.
    Foreign(&'static str),
}

/// A command buffer being recorded.
pub struct Commands {
    device: Device,
    raw: vk::CommandBuffer,
    recording: RecordingId,
    descriptors: RefCell<DescriptorPools>,
    timer: Option<Arc<PassTimer>>,
    resubmission: Resubmission,
    failed: Cell<Option<Failure>>,
    /// The labels of the passes of the recording, for a report on a lost device.
    passes: RefCell<Vec<&'static str>>,
    /// The ticket that gets the tick, for images that these commands copy.
    ticket: OnceCell<Arc<Ticket>>,
}

impl Commands {
    pub(crate) fn new(
        device: &Device,
        raw: vk::CommandBuffer,
        recording: RecordingId,
        descriptors: DescriptorPools,
    ) -> Self {
        Self {
            device: device.clone(),
            raw,
            recording,
            descriptors: RefCell::new(descriptors),
            timer: None,
            resubmission: Resubmission::Never,
            failed: Cell::new(None),
            passes: RefCell::default(),
            ticket: OnceCell::new(),
        }
    }

    /// Starts another recording in `raw`. The tick of the previous recording must be over.
    pub(crate) fn restart(
        &mut self,
        raw: vk::CommandBuffer,
        recording: RecordingId,
        timer: Option<Arc<PassTimer>>,
        resubmission: Resubmission,
    ) -> Result<(), Error> {
        self.descriptors.get_mut().reset()?;
        self.passes.get_mut().clear();
        self.recording = recording;
        self.timer = timer;
        self.resubmission = resubmission;
        self.next_piece(raw);
        Ok(())
    }

    /// Continues the same recording in another command buffer, after the present one was submitted.
    pub(crate) fn next_piece(&mut self, raw: vk::CommandBuffer) {
        self.raw = raw;
        self.failed = Cell::new(None);
        self.ticket = OnceCell::new();
    }

    /// Returns the resubmission rule of the commands: if they are submitted once or several times.
    pub(crate) fn resubmission(&self) -> Resubmission {
        self.resubmission
    }

    /// Returns the command buffer, for a host that records its own commands in a callback between
    /// the engine's commands.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.raw
    }

    /// Allocates a descriptor set for these commands.
    pub(crate) fn allocate_set(
        &self,
        layout: vk::DescriptorSetLayout,
    ) -> Result<vk::DescriptorSet, Error> {
        self.descriptors.borrow_mut().allocate(layout)
    }

    /// Returns the labels of the passes so far.
    pub(crate) fn passes(&self) -> Vec<&'static str> {
        self.passes.borrow().clone()
    }

    /// Returns the identity of the recording, which all pieces of a frame share.
    pub fn recording(&self) -> RecordingId {
        self.recording
    }

    pub(crate) fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the ticket that gets the tick of these commands when they are submitted.
    pub(crate) fn ticket(&self) -> Arc<Ticket> {
        Arc::clone(self.ticket.get_or_init(Arc::default))
    }

    /// Notes that these commands were submitted.
    pub(crate) fn submitted(&self, tick: Tick) {
        if let Some(ticket) = self.ticket.get() {
            ticket.submitted(tick);
        }
    }

    /// Returns the first failure of the recording, which [`crate::Frame::submit`] reports.
    pub(crate) fn check(&self) -> Result<(), Error> {
        match self.failed.get() {
            None => Ok(()),
            Some(Failure::Call(call, code)) => Err(code).called(call),
            Some(Failure::Wrong(what)) => Err(Error::WrongCommands(what)),
            Some(Failure::Foreign(thing)) => Err(foreign(thing)),
        }
    }

    /// Checks that `thing` is of the same device. Otherwise the recording fails, and no command
    /// with this object may be recorded. Every command that takes handles calls this.
    pub(crate) fn check_owner<T: OfDevice>(&self, thing: &T) -> Result<(), Error> {
        if thing.device_id() == self.device.id() {
            return Ok(());
        }
        self.fail(Failure::Foreign(T::KIND));
        Err(foreign(T::KIND))
    }

    /// Calls [`Commands::check_owner`] for several objects of one type, and returns true if all are
    /// of the same device.
    pub(crate) fn check_owners<'a, T: OfDevice + 'a>(
        &self,
        things: impl IntoIterator<Item = &'a T>,
    ) -> bool {
        things.into_iter().all(|thing| self.check_owner(thing).is_ok())
    }

    /// Makes [`Commands::check`] fail. Only the first failure is kept, because others may follow
    /// from it.
    pub(crate) fn fail(&self, failure: Failure) {
        if self.is_sound() {
            self.failed.set(Some(failure));
        }
    }

    /// Returns true if nothing has failed. After a failed binding nothing may be drawn with it, and
    /// [`Commands::check`] prevents the submit of the recording.
    pub(crate) fn is_sound(&self) -> bool {
        self.failed.get().is_none()
    }

    /// Records a pass, with a label for debuggers and logs and, if timing is on, with a pair of
    /// timestamps. Must be called outside of [`Commands::rendering`]. A pass within another pass is
    /// timed as part of it.
    pub fn pass(&self, label: &'static str, record: impl FnOnce(&Self)) {
        self.passes.borrow_mut().push(label);
        let timer = self.timer.as_ref().filter(|timer| timer.begin(self.raw, label));
        self.label(label, record);
        if let Some(timer) = timer {
            timer.end(self.raw);
        }
    }

    /// Records a part of a pass with only a label.
    pub fn label(&self, label: &'static str, record: impl FnOnce(&Self)) {
        let debug = self.device.debug();
        if let Some(debug) = debug {
            let mut place = LabelName::default();
            let info = vk::DebugUtilsLabelEXT::default().label_name(place.hold(label));
            // SAFETY: the command buffer is being recorded, here and in the rest of this file.
            unsafe { debug.cmd_begin_debug_utils_label(self.raw, &info) };
        }
        record(self);
        if let Some(debug) = debug {
            // SAFETY: closes the label opened above.
            unsafe { debug.cmd_end_debug_utils_label(self.raw) };
        }
    }

    /// Records a memory barrier.
    pub fn barrier(&self, barrier: MemoryBarrier) {
        let memory = [vk::MemoryBarrier2::default()
            .src_stage_mask(barrier.from_stages)
            .src_access_mask(barrier.from_access)
            .dst_stage_mask(barrier.to_stages)
            .dst_access_mask(barrier.to_access)];
        let info = vk::DependencyInfo::default().memory_barriers(&memory);
        // SAFETY: recorded outside of rendering, because callers record it at the edges of passes.
        unsafe { self.device.raw().cmd_pipeline_barrier2(self.raw, &info) };
    }

    /// Records image barriers that change layouts, at most for the images of one target.
    pub(crate) fn change_layouts(&self, changes: impl IntoIterator<Item = LayoutChange>) {
        let mut images = [vk::ImageMemoryBarrier2::default(); COLOURS_MAX + 1];
        let mut count = 0;
        for (image, change) in images.iter_mut().zip(changes) {
            *image = vk::ImageMemoryBarrier2::default()
                .image(change.image)
                .src_stage_mask(change.barrier.from_stages)
                .src_access_mask(change.barrier.from_access)
                .dst_stage_mask(change.barrier.to_stages)
                .dst_access_mask(change.barrier.to_access)
                .old_layout(change.old_layout)
                .new_layout(change.new_layout)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .subresource_range(change.part);
            count += 1;
        }
        if count == 0 {
            return;
        }
        let info = vk::DependencyInfo::default().image_memory_barriers(&images[..count]);
        // SAFETY: the images live at least until this frame is over.
        unsafe { self.device.raw().cmd_pipeline_barrier2(self.raw, &info) };
    }

    /// Begins a rendering to the images of a target, calls `record` and ends the rendering.
    /// Viewport and scissor cover the whole area. With a target of another device the recording
    /// fails, and `record` is not called.
    pub fn rendering(&self, target: RenderTarget, record: impl FnOnce(&Self)) {
        if self.begin_rendering(target) {
            record(self);
            self.end_rendering();
        }
    }

    /// Begins a rendering to the images of a target, until [`Commands::end_rendering`]. With a
    /// target of another device it returns false, and the recording fails.
    pub fn begin_rendering(&self, target: RenderTarget) -> bool {
        if self.check_owner(&target).is_err() {
            return false;
        }
        let (colour_load, colour_clear) = load_op(target.colour_load);
        let (depth_load, depth_clear) = load_op(target.depth_load);
        let [colour_store, depth_store] = [target.colour_store, target.depth_store].map(store_op);
        let mut colours = target.colours.map(|view| {
            vk::RenderingAttachmentInfo::default()
                .image_view(view)
                .image_layout(Access::Colour.layout())
                .load_op(colour_load)
                .store_op(colour_store)
                .clear_value(vk::ClearValue {
                    color: vk::ClearColorValue { float32: colour_clear },
                })
        });
        let depth = vk::RenderingAttachmentInfo::default()
            .image_view(target.depth)
            .image_layout(Access::Depth.layout())
            .load_op(depth_load)
            .store_op(depth_store)
            .clear_value(vk::ClearValue {
                depth_stencil: vk::ClearDepthStencilValue { depth: depth_clear, stencil: 0 },
            });
        if target.average != vk::ImageView::null() {
            let [first, ..] = &mut colours;
            *first = first
                .resolve_mode(vk::ResolveModeFlags::AVERAGE)
                .resolve_image_view(target.average)
                .resolve_image_layout(Access::Colour.layout());
        }
        let area = Viewport::covering(target.origin, target.size);
        let mut info = vk::RenderingInfo::default()
            .render_area(area.scissor())
            .layer_count(1)
            .view_mask(target.view_mask)
            .color_attachments(colours.get(..target.colour_count).unwrap_or(&colours))
            .depth_attachment(&depth);
        if target.has_stencil {
            info = info.stencil_attachment(&depth);
        }
        // SAFETY: the views live at least until this frame is over.
        unsafe { self.device.raw().cmd_begin_rendering(self.raw, &info) };
        self.set_viewport(&area);
        true
    }

    /// Ends the rendering that [`Commands::begin_rendering`] began.
    pub fn end_rendering(&self) {
        // SAFETY: closes the rendering that the caller opened.
        unsafe { self.device.raw().cmd_end_rendering(self.raw) };
    }

    /// Sets viewport and scissor for the pipelines bound from now on.
    pub fn set_viewport(&self, viewport: &Viewport) {
        let raw = self.device.raw();
        // SAFETY: the command buffer is being recorded; both are dynamic states of all pipelines.
        unsafe {
            raw.cmd_set_viewport(self.raw, 0, &[viewport.raw()]);
            raw.cmd_set_scissor(self.raw, 0, &[viewport.scissor()]);
        }
    }

    /// Clips drawing to an area of `size` pixels at `origin` within the target, until the rendering
    /// ends or until the next call.
    pub fn clip(&self, origin: [u32; 2], size: [u32; 2]) {
        let offset = vk::Offset2D { x: origin[0] as i32, y: origin[1] as i32 };
        let area = vk::Rect2D { offset, extent: vk::Extent2D { width: size[0], height: size[1] } };
        if [0, 1]
            .iter()
            .any(|side| i32::try_from(u64::from(origin[*side]) + u64::from(size[*side])).is_err())
        {
            self.fail(Failure::Wrong("a clipped area reaches beyond all images"));
            return;
        }
        // SAFETY: inside of rendering, where the scissor is dynamic state.
        unsafe { self.device.raw().cmd_set_scissor(self.raw, 0, &[area]) };
    }

    /// Clears the depth of an area of `size` pixels at `origin` within the target to `depth`,
    /// inside of a rendering. Predicates apply to it as to draws.
    pub fn clear_depth(&self, origin: [u32; 2], size: [u32; 2], depth: f32) {
        let attachment = vk::ClearAttachment {
            aspect_mask: vk::ImageAspectFlags::DEPTH,
            color_attachment: 0,
            clear_value: vk::ClearValue {
                depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 },
            },
        };
        let rect = Viewport::covering(origin, size).scissor();
        let rect = vk::ClearRect { rect, base_array_layer: 0, layer_count: 1 };
        // SAFETY: inside of rendering; the caller's area lies within the target.
        unsafe { self.device.raw().cmd_clear_attachments(self.raw, &[attachment], &[rect]) };
    }

    /// Clears the stencil of an area of `size` pixels at `origin` within the target to 0, inside of
    /// a rendering. Predicates apply to it as to draws.
    pub fn clear_stencil(&self, origin: [u32; 2], size: [u32; 2]) {
        let attachment = vk::ClearAttachment {
            aspect_mask: vk::ImageAspectFlags::STENCIL,
            color_attachment: 0,
            clear_value: vk::ClearValue::default(),
        };
        let rect = Viewport::covering(origin, size).scissor();
        let rect = vk::ClearRect { rect, base_array_layer: 0, layer_count: 1 };
        // SAFETY: inside of rendering; the caller's area lies within the target.
        unsafe { self.device.raw().cmd_clear_attachments(self.raw, &[attachment], &[rect]) };
    }

    /// Sets every 32-bit value of `slice` to `value`, with [`crate::Access::CopyWrite`].
    pub fn fill(&self, slice: BufferSlice, value: u32) {
        let size = slice.size_bytes & !3;
        if size > 0 && self.check_owner(&slice).is_ok() {
            // SAFETY: the slice lies in its buffer, which is a transfer destination; slices begin
            // at multiples of 4.
            unsafe {
                self.device.raw().cmd_fill_buffer(
                    self.raw,
                    slice.raw,
                    slice.offset_bytes,
                    size,
                    value,
                );
            }
        }
    }

    /// Writes a value to the beginning of `slice`, with [`crate::Access::CopyWrite`]. Does nothing
    /// if the slice is too small.
    pub(crate) fn write<T: Pod>(&self, slice: BufferSlice, value: &T) {
        let bytes = bytemuck::bytes_of(value);
        let fits = bytes.len() as u64 <= slice.size_bytes && bytes.len().is_multiple_of(4);
        if fits && self.check_owner(&slice).is_ok() {
            // SAFETY: the bytes lie in the buffer, a transfer destination; there are few, and
            // slices begin at multiples of 4.
            unsafe {
                let raw = self.device.raw();
                raw.cmd_update_buffer(self.raw, slice.raw, slice.offset_bytes, bytes);
            }
        }
    }

    /// Copies the first contents of a buffer from its staging buffer.
    pub(crate) fn copy_pending(&self, upload: &PendingUpload) {
        let region = vk::BufferCopy { size: upload.size_bytes, ..Default::default() };
        // SAFETY: both buffers are of this device and have this size; the source is retired only
        // after the copy is executed, and the destination lives while its token does.
        unsafe {
            self.device.raw().cmd_copy_buffer(self.raw, upload.from, upload.to, &[region]);
        }
    }

    /// Copies the contents of `from` to `to`, cut to the shorter of the two.
    pub fn copy_buffer(&self, from: BufferSlice, to: BufferSlice) {
        let region = vk::BufferCopy {
            src_offset: from.offset_bytes,
            dst_offset: to.offset_bytes,
            size: from.size_bytes.min(to.size_bytes),
        };
        if region.size > 0 && self.check_owners([&from, &to]) {
            // SAFETY: both slices lie in their buffers.
            unsafe { self.device.raw().cmd_copy_buffer(self.raw, from.raw, to.raw, &[region]) };
        }
    }
}

fn foreign(thing: &'static str) -> Error {
    Error::Foreign { thing, user: "commands (`Commands`)", owner: "Device" }
}

/// Returns the load operation of an image, and its clear value.
fn load_op<T: Default>(load: Load<T>) -> (vk::AttachmentLoadOp, T) {
    match load {
        Load::Keep => (vk::AttachmentLoadOp::LOAD, T::default()),
        Load::Clear(value) => (vk::AttachmentLoadOp::CLEAR, value),
        Load::Forget => (vk::AttachmentLoadOp::DONT_CARE, T::default()),
    }
}

fn store_op(store: AttachmentStore) -> vk::AttachmentStoreOp {
    match store {
        AttachmentStore::Keep => vk::AttachmentStoreOp::STORE,
        AttachmentStore::Forget => vk::AttachmentStoreOp::DONT_CARE,
        AttachmentStore::Unchanged => vk::AttachmentStoreOp::NONE,
    }
}
