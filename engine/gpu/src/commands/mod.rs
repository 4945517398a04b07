//! Recording: the few commands the engine uses, each in one place.

mod admission;
mod draws;

use std::cell::{Cell, OnceCell};
use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;

use crate::access::{Access, LayoutChange, MemoryBarrier};
use crate::buffer::BufferSlice;
use crate::capabilities::Optional;
use crate::deletion::Recording;
use crate::device::Device;
use crate::label::LabelName;
use crate::pipeline::{ComputePipeline, GraphicsPipeline, PipelineKind};
use crate::query_pages::Counting;
use crate::query_ring::QueryIndex;
use crate::readback::Ticket;
use crate::target::{Load, RenderTarget};
use crate::texture::Texture;
use crate::texture_array::TextureArray;
use crate::timeline::Tick;
use crate::timing::PassTimer;
pub(crate) use admission::Failure;

/// A command buffer being recorded.
pub struct Commands {
    device: Device,
    raw: vk::CommandBuffer,
    recording: Recording,
    descriptors: vk::DescriptorPool,
    timer: Option<Arc<PassTimer>>,
    failed: Cell<Option<Failure>>,
    /// Learns the tick, for pictures that these commands copy.
    ticket: OnceCell<Arc<Ticket>>,
}

impl Commands {
    pub(crate) fn new(
        device: &Device,
        raw: vk::CommandBuffer,
        recording: Recording,
        descriptors: vk::DescriptorPool,
        timer: Option<Arc<PassTimer>>,
    ) -> Self {
        let device = device.clone();
        let (failed, ticket) = (Cell::new(None), OnceCell::new());
        Self { device, raw, recording, descriptors, timer, failed, ticket }
    }

    /// Goes on with the same recording in another command buffer, once this one is sent off.
    pub(crate) fn next_piece(
        &self,
        raw: vk::CommandBuffer,
        descriptors: vk::DescriptorPool,
    ) -> Self {
        Self::new(&self.device, raw, self.recording, descriptors, self.timer.clone())
    }

    pub(crate) fn raw(&self) -> vk::CommandBuffer {
        self.raw
    }

    pub(crate) fn recording(&self) -> Recording {
        self.recording
    }

    pub(crate) fn device(&self) -> &Device {
        &self.device
    }

    /// Returns what will hold the tick of these commands once they are submitted.
    pub(crate) fn ticket(&self) -> Arc<Ticket> {
        Arc::clone(self.ticket.get_or_init(Arc::default))
    }

    /// Notes that these commands were submitted.
    pub(crate) fn submitted(&self, tick: Tick) {
        if let Some(ticket) = self.ticket.get() {
            ticket.submitted(tick);
        }
    }

    /// A pass: one label for the debugger and the log, and one timestamp pair when timing is on.
    /// Not inside [`Commands::rendering`]. A pass within another one is timed with that.
    pub fn pass(&self, label: &'static str, record: impl FnOnce(&Self)) {
        let timer = self.timer.as_ref().filter(|timer| timer.begin(self, label));
        self.label(label, record);
        if let Some(timer) = timer {
            timer.end(self);
        }
    }

    /// A part of a pass: a label only.
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

    /// Orders memory. Nothing to order records nothing.
    pub fn barrier(&self, barrier: MemoryBarrier) {
        let memory = [vk::MemoryBarrier2::default()
            .src_stage_mask(barrier.from_stages)
            .src_access_mask(barrier.from_access)
            .dst_stage_mask(barrier.to_stages)
            .dst_access_mask(barrier.to_access)];
        let info = vk::DependencyInfo::default().memory_barriers(&memory);
        // SAFETY: recorded outside of rendering, as the method's callers are passes' edges.
        unsafe { self.device.raw().cmd_pipeline_barrier2(self.raw, &info) };
    }

    /// Orders images and moves them to other layouts.
    pub fn change_layouts<const N: usize>(&self, changes: [LayoutChange; N]) {
        let images = changes.map(|change| {
            vk::ImageMemoryBarrier2::default()
                .image(change.image)
                .src_stage_mask(change.barrier.from_stages)
                .src_access_mask(change.barrier.from_access)
                .dst_stage_mask(change.barrier.to_stages)
                .dst_access_mask(change.barrier.to_access)
                .old_layout(change.old_layout)
                .new_layout(change.new_layout)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .subresource_range(change.part)
        });
        let info = vk::DependencyInfo::default().image_memory_barriers(&images);
        // SAFETY: the images live at least until this frame is over.
        unsafe { self.device.raw().cmd_pipeline_barrier2(self.raw, &info) };
    }

    /// Draws to a colour and a depth image; viewport and scissor cover all of the target's area. A
    /// target of another device fails the recording, and `record` is not called.
    pub fn rendering(&self, target: RenderTarget, record: impl FnOnce(&Self)) {
        if self.admit(&target).is_err() {
            return;
        }
        let (colour_load, colour_store, colour_clear) = load_ops(target.colour_load);
        let (depth_load, depth_store, depth_clear) = load_ops(target.depth_load);
        let colour = [vk::RenderingAttachmentInfo::default()
            .image_view(target.colour)
            .image_layout(Access::Colour.layout())
            .load_op(colour_load)
            .store_op(colour_store)
            .clear_value(vk::ClearValue { color: vk::ClearColorValue { float32: colour_clear } })];
        let depth = vk::RenderingAttachmentInfo::default()
            .image_view(target.depth)
            .image_layout(Access::Depth.layout())
            .load_op(depth_load)
            .store_op(depth_store)
            .clear_value(vk::ClearValue {
                depth_stencil: vk::ClearDepthStencilValue { depth: depth_clear, stencil: 0 },
            });
        let ([x, y], [width, height]) = (target.origin, target.size);
        let area = vk::Rect2D {
            offset: vk::Offset2D { x: x as i32, y: y as i32 },
            extent: vk::Extent2D { width, height },
        };
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&colour)
            .depth_attachment(&depth);
        let viewport = vk::Viewport {
            x: x as f32,
            y: y as f32,
            width: width as f32,
            height: height as f32,
            max_depth: 1.0,
            ..Default::default()
        };
        let raw = self.device.raw();
        // SAFETY: the views live at least until this frame is over.
        unsafe {
            raw.cmd_begin_rendering(self.raw, &info);
            raw.cmd_set_viewport(self.raw, 0, &[viewport]);
            raw.cmd_set_scissor(self.raw, 0, &[area]);
        }
        record(self);
        // SAFETY: closes the rendering opened above.
        unsafe { raw.cmd_end_rendering(self.raw) };
    }

    /// Binds a graphics pipeline and the storage buffers it reads, in the order of its layout.
    pub fn bind(&self, pipeline: &GraphicsPipeline, storage: &[BufferSlice]) {
        self.bind_textured(pipeline, storage, &[]);
    }

    /// Binds a graphics pipeline, the storage buffers it reads, and the textures it samples.
    pub fn bind_textured(
        &self,
        pipeline: &GraphicsPipeline,
        storage: &[BufferSlice],
        textures: &[&Texture],
    ) {
        self.bind_kind(&pipeline.0, vk::PipelineBindPoint::GRAPHICS, storage, textures, &[]);
    }

    /// Binds a graphics pipeline, the storage buffers it reads, and the texture arrays it samples.
    pub fn bind_arrays(
        &self,
        pipeline: &GraphicsPipeline,
        storage: &[BufferSlice],
        arrays: &[&TextureArray],
    ) {
        self.bind_kind(&pipeline.0, vk::PipelineBindPoint::GRAPHICS, storage, &[], arrays);
    }

    /// Binds a compute pipeline and its storage buffers.
    pub fn bind_compute(&self, pipeline: &ComputePipeline, storage: &[BufferSlice]) {
        self.bind_kind(&pipeline.0, vk::PipelineBindPoint::COMPUTE, storage, &[], &[]);
    }

    fn bind_kind(
        &self,
        pipeline: &PipelineKind,
        point: vk::PipelineBindPoint,
        storage: &[BufferSlice],
        textures: &[&Texture],
        arrays: &[&TextureArray],
    ) {
        let are_ours = self.admit(pipeline).is_ok()
            && self.admit_all(storage)
            && self.admit_all(textures.iter().copied())
            && self.admit_all(arrays.iter().copied());
        if !are_ours {
            return;
        }
        let raw = self.device.raw();
        if storage.len() != pipeline.buffers as usize {
            self.fail(Failure::Wrong("a pipeline is bound with too many or too few buffers"));
            return;
        }
        let are_known = textures.iter().all(|texture| texture.is_known_to(self));
        if textures.len() != pipeline.textures as usize || !are_known {
            self.fail(Failure::Wrong("a pipeline is bound with textures that are not there"));
            return;
        }
        let are_filled = arrays.iter().all(|array| array.is_filled());
        if arrays.len() != pipeline.texture_arrays as usize || !are_filled {
            self.fail(Failure::Wrong("a pipeline is bound with texture arrays that are not there"));
            return;
        }
        // SAFETY: a live pipeline of the right kind.
        unsafe { raw.cmd_bind_pipeline(self.raw, point, pipeline.raw) };
        if storage.is_empty() && textures.is_empty() && arrays.is_empty() {
            return;
        }
        let layouts = [pipeline.storage];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(self.descriptors)
            .set_layouts(&layouts);
        let mut set = vk::DescriptorSet::null();
        // The function itself: ash would put the set on the heap.
        let allocate = raw.fp_v1_0().allocate_descriptor_sets;
        // SAFETY: the pool belongs to these commands, and was reset after the tick of earlier ones;
        // there is room for the one set asked for.
        let code = unsafe { allocate(raw.handle(), &raw const info, &raw mut set) };
        if code != vk::Result::SUCCESS {
            self.fail(Failure::Call("vkAllocateDescriptorSets", code));
            return;
        }
        for (binding, slice) in storage.iter().enumerate() {
            let buffers = [vk::DescriptorBufferInfo {
                buffer: slice.raw,
                offset: slice.offset_bytes,
                range: slice.size_bytes,
            }];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(binding as u32)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .buffer_info(&buffers);
            // SAFETY: the set is fresh, so no command uses it yet.
            unsafe { raw.update_descriptor_sets(&[write], &[]) };
        }
        for (binding, texture) in (storage.len() as u32..).zip(textures) {
            let images = [texture.descriptor()];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(binding)
                .descriptor_type(vk::DescriptorType::COMBINED_IMAGE_SAMPLER)
                .image_info(&images);
            // SAFETY: as above; image and sampler live at least until this frame is over.
            unsafe { raw.update_descriptor_sets(&[write], &[]) };
        }
        for (element, array) in (0..).zip(arrays) {
            let images = [array.descriptor()];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding((storage.len() + textures.len()) as u32)
                .dst_array_element(element)
                .descriptor_type(vk::DescriptorType::COMBINED_IMAGE_SAMPLER)
                .image_info(&images);
            // SAFETY: as above.
            unsafe { raw.update_descriptor_sets(&[write], &[]) };
        }
        // SAFETY: the set was made from this pipeline's layout.
        unsafe {
            raw.cmd_bind_descriptor_sets(self.raw, point, pipeline.layout, 0, &[set], &[]);
        }
    }

    /// Sets the push constants of a graphics pipeline.
    pub fn push_constants<T: Pod>(&self, pipeline: &GraphicsPipeline, constants: &T) {
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        self.push_kind(&pipeline.0, stages, constants);
    }

    /// Sets the push constants of a compute pipeline.
    pub fn push_compute_constants<T: Pod>(&self, pipeline: &ComputePipeline, constants: &T) {
        self.push_kind(&pipeline.0, vk::ShaderStageFlags::COMPUTE, constants);
    }

    fn push_kind<T: Pod>(
        &self,
        pipeline: &PipelineKind,
        stages: vk::ShaderStageFlags,
        constants: &T,
    ) {
        let bytes = bytemuck::bytes_of(constants);
        if self.admit(pipeline).is_err() {
            return;
        }
        if bytes.is_empty() || bytes.len() != pipeline.push_bytes as usize {
            self.fail(Failure::Wrong("the push constants have another size than the pipeline's"));
            return;
        }
        // SAFETY: the layout has one range of this size for these stages.
        unsafe {
            self.device.raw().cmd_push_constants(self.raw, pipeline.layout, stages, 0, bytes);
        }
    }

    /// Binds a vertex buffer and, if there is one, a buffer of 32-bit indices.
    pub fn bind_geometry(&self, vertices: BufferSlice, indices: Option<BufferSlice>) {
        if !self.admit_all([&vertices].into_iter().chain(&indices)) {
            return;
        }
        let raw = self.device.raw();
        // SAFETY: both buffers live at least until this frame is over.
        unsafe {
            let (buffers, offsets) = ([vertices.raw], [vertices.offset_bytes]);
            raw.cmd_bind_vertex_buffers(self.raw, 0, &buffers, &offsets);
            if let Some(indices) = indices {
                let offset = indices.offset_bytes;
                raw.cmd_bind_index_buffer(self.raw, indices.raw, offset, vk::IndexType::UINT32);
            }
        }
    }

    /// Binds two vertex buffers, side by side as in [`VertexLayout::beside`](crate::VertexLayout::beside),
    /// and a buffer of 32-bit indices.
    pub fn bind_geometry_beside(&self, vertices: [BufferSlice; 2], indices: BufferSlice) {
        if !self.admit_all(vertices.iter().chain([&indices])) {
            return;
        }
        let buffers = vertices.map(|slice| slice.raw);
        let offsets = vertices.map(|slice| slice.offset_bytes);
        let (raw, kind) = (self.device.raw(), vk::IndexType::UINT32);
        // SAFETY: all three buffers live at least until this frame is over.
        unsafe {
            raw.cmd_bind_vertex_buffers(self.raw, 0, &buffers, &offsets);
            raw.cmd_bind_index_buffer(self.raw, indices.raw, indices.offset_bytes, kind);
        }
    }

    /// Draws nothing outside of `size` pixels from `origin` on, within the target, until the rendering
    /// ends or this is said again.
    pub fn clip(&self, origin: [u32; 2], size: [u32; 2]) {
        let offset = vk::Offset2D { x: origin[0] as i32, y: origin[1] as i32 };
        let area = vk::Rect2D { offset, extent: vk::Extent2D { width: size[0], height: size[1] } };
        if [0, 1]
            .iter()
            .any(|side| i32::try_from(u64::from(origin[*side]) + u64::from(size[*side])).is_err())
        {
            self.fail(Failure::Wrong("a clipped area reaches beyond all pictures"));
            return;
        }
        // SAFETY: inside of rendering, where the scissor is dynamic state.
        unsafe { self.device.raw().cmd_set_scissor(self.raw, 0, &[area]) };
    }

    /// Sets every 32-bit word of `slice` to `word`: an [`crate::Access::CopyWrite`].
    pub fn fill(&self, slice: BufferSlice, word: u32) {
        let size = slice.size_bytes & !3;
        if size > 0 && self.admit(&slice).is_ok() {
            // SAFETY: the slice lies in its buffer, which is a destination of transfers; slices
            // begin at multiples of 4.
            unsafe {
                self.device.raw().cmd_fill_buffer(
                    self.raw,
                    slice.raw,
                    slice.offset_bytes,
                    size,
                    word,
                );
            }
        }
    }

    /// Copies as much as fits.
    pub fn copy_buffer(&self, from: BufferSlice, to: BufferSlice) {
        let region = vk::BufferCopy {
            src_offset: from.offset_bytes,
            dst_offset: to.offset_bytes,
            size: from.size_bytes.min(to.size_bytes),
        };
        if region.size > 0 && self.admit_all([&from, &to]) {
            // SAFETY: both slices lie in their buffers.
            unsafe { self.device.raw().cmd_copy_buffer(self.raw, from.raw, to.raw, &[region]) };
        }
    }

    /// Records what `record` draws under an occlusion query.
    pub(crate) fn query(
        &self,
        pool: vk::QueryPool,
        query: QueryIndex,
        counting: Counting,
        record: impl FnOnce(&Self),
    ) {
        let raw = self.device.raw();
        let is_precise = counting == Counting::Samples
            && self.device.capabilities().has(Optional::PreciseQueries);
        let flags = match is_precise {
            true => vk::QueryControlFlags::PRECISE,
            false => vk::QueryControlFlags::empty(),
        };
        // SAFETY: the query was reset earlier in this frame and is used once in it, the callers keep
        // count; precise ones are asked for only where the feature is on.
        unsafe { raw.cmd_begin_query(self.raw, pool, query.0, flags) };
        record(self);
        // SAFETY: closes the query opened above.
        unsafe { raw.cmd_end_query(self.raw, pool, query.0) };
    }
}

/// How a rendering begins and ends for an image, and what it is cleared to.
fn load_ops<T: Default>(load: Load<T>) -> (vk::AttachmentLoadOp, vk::AttachmentStoreOp, T) {
    use vk::{AttachmentLoadOp as L, AttachmentStoreOp as S};
    match load {
        Load::Keep => (L::LOAD, S::STORE, T::default()),
        Load::Clear(value) => (L::CLEAR, S::STORE, value),
        Load::Forget => (L::DONT_CARE, S::DONT_CARE, T::default()),
    }
}
