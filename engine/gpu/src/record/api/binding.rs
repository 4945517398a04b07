//! Recording of the inputs of draws: pipelines, buffers, textures, constants.

use ash::vk;
use bytemuck::Pod;

use crate::core::error::Error;
use crate::memory::buffer::BufferSlice;
use crate::memory::instance_numbers::{NUMBER_BINDING, instance_numbers};
use crate::memory::sampled_texture::SampledTexture;
use crate::memory::texture_array::TextureArray;
use crate::memory::texture_table::TextureTable;
use crate::record::commands::{Commands, Failure};
use crate::record::pipeline::{ComputePipeline, GraphicsPipeline, PipelineKind};

/// The texture arrays that draws sample.
#[derive(Clone, Copy)]
pub enum SampledArrays<'a> {
    /// The arrays of the pipeline's last binding, in the number that it declares
    /// ([`StorageLayout::texture_arrays`](crate::StorageLayout::texture_arrays)).
    Few(&'a [&'a TextureArray]),
    /// The textures of a table, for pipelines that were created with [a
    /// table](crate::GraphicsPipelineInfo::table).
    Table(&'a TextureTable),
}

impl SampledArrays<'_> {
    /// No texture arrays.
    pub const NONE: Self = Self::Few(&[]);

    /// Returns the arrays that have a descriptor each.
    fn few(&self) -> &[&TextureArray] {
        match self {
            Self::Few(few) => few,
            Self::Table(_) => &[],
        }
    }

    fn table(&self) -> Option<&TextureTable> {
        match self {
            Self::Few(_) => None,
            Self::Table(table) => Some(table),
        }
    }
}

impl Commands {
    /// Binds a graphics pipeline and the storage buffers that it reads, in the order of its layout.
    pub fn bind(&self, pipeline: &GraphicsPipeline, storage: &[BufferSlice]) {
        self.bind_sampled(pipeline, storage, &[], SampledArrays::NONE);
    }

    /// Binds a graphics pipeline with the storage buffers that it reads, and the textures and
    /// texture arrays that it samples.
    pub fn bind_sampled(
        &self,
        pipeline: &GraphicsPipeline,
        storage: &[BufferSlice],
        textures: &[SampledTexture<'_>],
        arrays: SampledArrays<'_>,
    ) {
        self.bind_kind(&pipeline.0, vk::PipelineBindPoint::GRAPHICS, storage, textures, arrays);
    }

    /// Binds another graphics pipeline and keeps the bound buffers, constants and geometry. Both
    /// pipelines must have the same [layout](crate::StorageLayout), without textures.
    pub fn switch(&self, pipeline: &GraphicsPipeline) {
        if self.check_owner(&pipeline.0).is_ok() {
            // SAFETY: a live pipeline; the bindings stay valid, since pipelines with equal layouts
            // are compatible.
            unsafe {
                let point = vk::PipelineBindPoint::GRAPHICS;
                self.device().raw().cmd_bind_pipeline(self.raw(), point, pipeline.0.raw);
            }
        }
    }

    /// Binds a compute pipeline and its storage buffers.
    pub fn bind_compute(&self, pipeline: &ComputePipeline, storage: &[BufferSlice]) {
        self.bind_kind(
            &pipeline.0,
            vk::PipelineBindPoint::COMPUTE,
            storage,
            &[],
            SampledArrays::NONE,
        );
    }

    /// Binds a compute pipeline with its storage buffers and the textures that it samples.
    pub(crate) fn bind_compute_sampled(
        &self,
        pipeline: &ComputePipeline,
        storage: &[BufferSlice],
        textures: &[SampledTexture<'_>],
    ) {
        self.bind_kind(
            &pipeline.0,
            vk::PipelineBindPoint::COMPUTE,
            storage,
            textures,
            SampledArrays::NONE,
        );
    }

    pub(super) fn bind_kind(
        &self,
        pipeline: &PipelineKind,
        point: vk::PipelineBindPoint,
        storage: &[BufferSlice],
        textures: &[SampledTexture<'_>],
        arrays: SampledArrays<'_>,
    ) {
        if !self.check_binding_owners(pipeline, storage, textures, arrays) {
            return;
        }
        let raw = self.device().raw();
        // SAFETY: a live pipeline of the right kind.
        unsafe { raw.cmd_bind_pipeline(self.raw(), point, pipeline.raw) };
        if pipeline.instance_bytes > 0 {
            self.bind_numbers(pipeline, storage);
        }
        if let Some(table) = arrays.table() {
            // SAFETY: the set was created for such a layout; it lives at least until this frame is
            // over.
            unsafe {
                raw.cmd_bind_descriptor_sets(
                    self.raw(),
                    point,
                    pipeline.layout,
                    1,
                    &[table.set],
                    &[],
                );
            }
        }
        let arrays = arrays.few();
        if storage.is_empty() && textures.is_empty() && arrays.is_empty() {
            return;
        }
        let set = match self.allocate_set(pipeline.storage) {
            Ok(set) => set,
            Err(error) => return self.fail_call(&error),
        };
        self.write_descriptors(set, storage, textures, arrays);
        // SAFETY: the set was made from this pipeline's layout.
        unsafe {
            raw.cmd_bind_descriptor_sets(self.raw(), point, pipeline.layout, 0, &[set], &[]);
        }
    }

    fn fail_call(&self, error: &Error) {
        self.fail(match *error {
            Error::Vulkan { call, code } => Failure::Call(call, code),
            _ => Failure::Call("vkAllocateMemory", vk::Result::ERROR_OUT_OF_DEVICE_MEMORY),
        });
    }

    /// Binds the instance indices, one for each instance that fits into the first storage buffer.
    fn bind_numbers(&self, pipeline: &PipelineKind, storage: &[BufferSlice]) {
        let bytes = storage.first().map_or(0, |instances| instances.size_bytes);
        let count = bytes / u64::from(pipeline.instance_bytes.max(1));
        let numbers = match instance_numbers(self.device(), count) {
            Ok(numbers) => numbers,
            Err(error) => return self.fail_call(&error),
        };
        let raw = self.device().raw();
        // SAFETY: the buffer lives at least until this frame is over, even if a larger one replaces
        // it. It has an index for each instance that the shader may read with it.
        unsafe { raw.cmd_bind_vertex_buffers(self.raw(), NUMBER_BINDING, &[numbers], &[0]) };
    }

    /// Returns true if all objects are of this device, and the pipeline has this number of bindings
    /// of each kind. Notes a failure otherwise.
    fn check_binding_owners(
        &self,
        pipeline: &PipelineKind,
        storage: &[BufferSlice],
        textures: &[SampledTexture<'_>],
        arrays: SampledArrays<'_>,
    ) -> bool {
        let are_ours = self.check_owner(pipeline).is_ok()
            && self.check_owners(storage)
            && self.check_owners(textures)
            && self.check_owners(arrays.few().iter().copied())
            && self.check_owners(arrays.table());
        if !are_ours {
            return false;
        }
        if storage.len() != pipeline.buffers as usize {
            self.fail(Failure::Wrong("a pipeline is bound with too many or too few buffers"));
            return false;
        }
        let are_known = textures.iter().all(|texture| texture.contents.is_known_to(self));
        if textures.len() != pipeline.textures as usize || !are_known {
            self.fail(Failure::Wrong("a pipeline is bound with textures that are not there"));
            return false;
        }
        let few = arrays.few();
        let are_filled = few.iter().all(|array| array.is_filled());
        let has_table = arrays.table().is_some();
        if few.len() != pipeline.texture_arrays as usize
            || has_table != pipeline.has_table
            || !are_filled
        {
            self.fail(Failure::Wrong("a pipeline is bound with texture arrays that are not there"));
            return false;
        }
        true
    }

    /// Writes a new set: storage buffers, then textures, then one binding of all arrays.
    fn write_descriptors(
        &self,
        set: vk::DescriptorSet,
        storage: &[BufferSlice],
        textures: &[SampledTexture<'_>],
        arrays: &[&TextureArray],
    ) {
        let raw = self.device().raw();
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
            // SAFETY: the set is new, so no command uses it yet.
            unsafe { raw.update_descriptor_sets(&[write], &[]) };
        }
        for (binding, texture) in (storage.len() as u32..).zip(textures) {
            let images = [texture.descriptor];
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
    }

    /// Sets the push constants of a graphics pipeline.
    pub fn push_constants<T: Pod>(&self, pipeline: &GraphicsPipeline, constants: &T) {
        self.push_kind(&pipeline.0, constants);
    }

    /// Sets the push constants of a compute pipeline.
    pub fn push_compute_constants<T: Pod>(&self, pipeline: &ComputePipeline, constants: &T) {
        self.push_kind(&pipeline.0, constants);
    }

    fn push_kind<T: Pod>(&self, pipeline: &PipelineKind, constants: &T) {
        let bytes = bytemuck::bytes_of(constants);
        if self.check_owner(pipeline).is_err() {
            return;
        }
        if bytes.is_empty() || bytes.len() != pipeline.push_bytes as usize {
            self.fail(Failure::Wrong("the push constants have another size than the pipeline's"));
            return;
        }
        let stages = pipeline.stages;
        // SAFETY: the layout has one range of this size for these stages.
        unsafe {
            self.device().raw().cmd_push_constants(self.raw(), pipeline.layout, stages, 0, bytes);
        }
    }

    /// Binds a vertex buffer and, if there is one, a buffer of 32-bit indices.
    pub fn bind_geometry(&self, vertices: BufferSlice, indices: Option<BufferSlice>) {
        if !self.check_owners([&vertices].into_iter().chain(&indices)) {
            return;
        }
        let raw = self.device().raw();
        // SAFETY: both buffers live at least until this frame is over.
        unsafe {
            let buffers = [vertices.raw];
            let offsets = [vertices.offset_bytes];
            raw.cmd_bind_vertex_buffers(self.raw(), 0, &buffers, &offsets);
            if let Some(indices) = indices {
                let offset = indices.offset_bytes;
                raw.cmd_bind_index_buffer(self.raw(), indices.raw, offset, vk::IndexType::UINT32);
            }
        }
    }

    /// Binds two parallel vertex buffers, as declared by
    /// [`VertexLayout::beside`](crate::VertexLayout::beside), and a buffer of 32-bit indices.
    pub fn bind_geometry_beside(&self, vertices: [BufferSlice; 2], indices: BufferSlice) {
        if !self.check_owners(vertices.iter().chain([&indices])) {
            return;
        }
        let buffers = vertices.map(|slice| slice.raw);
        let offsets = vertices.map(|slice| slice.offset_bytes);
        let raw = self.device().raw();
        let kind = vk::IndexType::UINT32;
        // SAFETY: all three buffers live at least until this frame is over.
        unsafe {
            raw.cmd_bind_vertex_buffers(self.raw(), 0, &buffers, &offsets);
            raw.cmd_bind_index_buffer(self.raw(), indices.raw, indices.offset_bytes, kind);
        }
    }
}
