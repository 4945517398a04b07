//! The host's own renderer of boxes: pipelines, textures, buffers and submits of wgpu.

use std::error::Error;
use std::sync::Arc;

use antumbra_wgpu::{WgpuDevice, WgpuDraws};
use walk::{BoxScene, ViewConstants};

/// The frames that may be in flight at once.
pub const FRAMES_IN_FLIGHT: usize = 2;

const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const VERTICES: [wgpu::VertexAttribute; 2] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];

/// The host's pipelines, geometry and textures.
pub struct WgpuRenderer {
    pub gpu: Arc<WgpuDevice>,
    pub depth: wgpu::Texture,
    depth_view: wgpu::TextureView,
    colour: wgpu::Texture,
    corners: wgpu::Buffer,
    indices: wgpu::Buffer,
    buckets: Vec<wgpu::RenderPipeline>,
}

/// A frame that was submitted.
pub struct SentImage {
    pub submission: wgpu::SubmissionIndex,
    pub image: wgpu::Buffer,
}

impl WgpuRenderer {
    /// Creates everything to draw `scene`.
    pub fn new(gpu: &Arc<WgpuDevice>, scene: &BoxScene) -> Self {
        let device = &gpu.device;
        let [width, height] = walk::SIZE;
        let texture = |format| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        };
        let buffer = |contents: &[u8], usage| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: contents.len() as u64,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            gpu.queue.write_buffer(&buffer, 0, contents);
            buffer
        };
        let corners = scene.corners();
        let depth = texture(DEPTH);
        Self {
            depth_view: depth.create_view(&Default::default()),
            depth,
            colour: texture(COLOUR),
            corners: buffer(bytemuck::cast_slice(&corners), wgpu::BufferUsages::VERTEX),
            indices: buffer(bytemuck::cast_slice(&walk::INDICES), wgpu::BufferUsages::INDEX),
            buckets: pipelines(device),
            gpu: gpu.clone(),
        }
    }

    /// Encodes a render pass: the first of a frame clears, the second keeps what is there, and is
    /// followed by the copy of the image.
    pub fn encode(
        &self,
        draws: &[WgpuDraws],
        constants: &ViewConstants,
        copied: Option<&wgpu::Buffer>,
    ) -> wgpu::CommandBuffer {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let is_second = copied.is_some();
        let colour_view = self.colour.create_view(&Default::default());
        let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let colour = wgpu::RenderPassColorAttachment {
            view: &colour_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: if is_second { wgpu::LoadOp::Load } else { clear },
                store: wgpu::StoreOp::Store,
            },
        };
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth_view,
            depth_ops: Some(wgpu::Operations {
                load: if is_second { wgpu::LoadOp::Load } else { wgpu::LoadOp::Clear(0.0) },
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(colour)],
            depth_stencil_attachment: Some(depth),
            ..Default::default()
        });
        pass.set_vertex_buffer(0, self.corners.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        for list in draws {
            pass.set_pipeline(&self.buckets[list.bucket.0 as usize]);
            pass.set_immediates(0, bytemuck::bytes_of(constants));
            // SAFETY: every draw is a whole box, and an instance of its own. Visible draws go to
            // the first pass, revealed draws to the second.
            unsafe { list.draw(&mut pass) };
        }
        drop(pass);
        if let Some(copied) = copied {
            let [width, height] = walk::SIZE;
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * 4),
                rows_per_image: None,
            };
            encoder.copy_texture_to_buffer(
                self.colour.as_image_copy(),
                wgpu::TexelCopyBufferInfo { buffer: copied, layout },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
        }
        encoder.finish()
    }

    /// Creates the buffer that the image of a frame is copied to.
    pub fn new_image(&self) -> wgpu::Buffer {
        let [width, height] = walk::SIZE;
        self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(width * height * 4),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        })
    }

    /// Waits for a frame, and returns its image.
    pub fn wait(&self, frame: SentImage) -> Result<Vec<u8>, Box<dyn Error>> {
        let SentImage { submission, image } = frame;
        image.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        let submission_index = Some(submission);
        self.gpu.device.poll(wgpu::PollType::Wait { submission_index, timeout: None })?;
        let bytes = image.slice(..).get_mapped_range()?.to_vec();
        Ok(bytes)
    }
}

/// Creates the pipeline of each bucket.
fn pipelines(device: &wgpu::Device) -> Vec<wgpu::RenderPipeline> {
    let module = |code: &[u8]| {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::SpirV(bytemuck::pod_collect_to_vec::<u8, u32>(code).into()),
        })
    };
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[],
        immediate_size: size_of::<ViewConstants>() as u32,
    });
    let vertex = module(walk::BOX_VERT);
    let pipeline = |fragment: &&[u8]| {
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &vertex,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: 24,
                    step_mode: wgpu::VertexStepMode::Instance,
                    attributes: &VERTICES,
                })],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module(fragment),
                entry_point: None,
                compilation_options: Default::default(),
                targets: &[Some(COLOUR.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    };
    walk::FRAGMENTS.iter().map(pipeline).collect()
}
