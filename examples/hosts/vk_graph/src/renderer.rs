//! The host's images, buffers and graphs.

use std::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use cull::{Camera, Strategy};
use vk_graph::Graph;
use vk_graph::driver::buffer::Buffer;
use vk_graph::driver::fence::Fence;
use vk_graph::driver::image::{Image, ImageInfo};
use vk_graph::pool::hash::HashPool;
use vk_sync::AccessType;
use walk::{BoxGeometry, BoxPipelines, BoxScene, ViewConstants};

use crate::device::GraphDevice;
use crate::integration::GraphCulling;

/// The frames that may be in flight at once.
pub const FRAMES_IN_FLIGHT: u64 = 2;

/// The host's pipelines, geometry and images.
pub struct GraphRenderer {
    pub device: Arc<GraphDevice>,
    pub colour: Arc<Image>,
    pub depth: Arc<Image>,
    corners: Arc<Buffer>,
    indices: Arc<Buffer>,
    pipelines: BoxPipelines,
}

/// A frame that was submitted.
pub struct SentFrame {
    fence: Fence,
    image: Arc<Buffer>,
}

/// The outcome of a closure of the graph, which has no way to return an error.
type Recorded = Arc<Mutex<Result<(), String>>>;

impl GraphRenderer {
    /// Creates everything to draw `scene`.
    pub fn new(device: &Arc<GraphDevice>, scene: &BoxScene) -> Result<Self, Box<dyn Error>> {
        use vk::{BufferUsageFlags as B, ImageUsageFlags as U};
        let [width, height] = walk::SIZE;
        let raw = &device.raw;
        let formats = [vk::Format::R8G8B8A8_UNORM, vk::Format::D32_SFLOAT];
        let image = |format, usage| {
            let info = ImageInfo::image_2d(width, height, format, usage | U::TRANSFER_SRC);
            Image::create(raw, info).map(Arc::new)
        };
        let corners = scene.corners();
        let buffer = |usage, bytes: &[u8]| Buffer::create_from_slice(raw, usage, bytes);
        Ok(Self {
            device: device.clone(),
            colour: image(formats[0], U::COLOR_ATTACHMENT)?,
            depth: image(formats[1], U::DEPTH_STENCIL_ATTACHMENT)?,
            corners: Arc::new(buffer(B::VERTEX_BUFFER, bytemuck::cast_slice(&corners))?),
            indices: Arc::new(buffer(B::INDEX_BUFFER, bytemuck::cast_slice(&walk::INDICES))?),
            pipelines: BoxPipelines::new(raw, formats)?,
        })
    }

    /// Binds the pipeline of a bucket with the geometry of all boxes.
    pub fn bind(&self, commands: vk::CommandBuffer, bucket: u32, constants: &ViewConstants) {
        let geometry = BoxGeometry { corners: self.corners.handle, indices: self.indices.handle };
        // SAFETY: a closure of the graph records; the objects live until its frame is over.
        unsafe { self.pipelines.bind(commands, bucket, geometry, constants) };
    }

    /// Submits the graph of a frame: the engine's command, and a copy of the image.
    pub fn draw(
        &self,
        pool: &mut HashPool,
        culling: &Arc<Mutex<GraphCulling>>,
        current: u64,
        over: u64,
        camera: Camera,
        strategy: Strategy,
    ) -> Result<SentFrame, Box<dyn Error>> {
        let [width, height] = walk::SIZE;
        let zeros = vec![0; (width * height * 4) as usize];
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let image = Arc::new(Buffer::create_from_slice(&self.device.raw, usage, &zeros)?);
        let mut graph = Graph::default();
        let colour = graph.bind_resource(&self.colour);
        let depth = graph.bind_resource(&self.depth);
        let copied = graph.bind_resource(&image);
        let recorded: Recorded = Arc::new(Mutex::new(Err("was not called".to_owned())));
        let outcome = recorded.clone();
        let culling = culling.clone();
        graph
            .begin_cmd()
            .debug_name("antumbra")
            .resource_access(colour, AccessType::ColorAttachmentWrite)
            .resource_access(depth, AccessType::DepthStencilAttachmentWrite)
            .record_cmd(move |cmd| {
                let mut culling = culling.lock().unwrap_or_else(PoisonError::into_inner);
                let recorded = culling.record(cmd.handle, current, over, &camera, strategy);
                *outcome.lock().unwrap_or_else(PoisonError::into_inner) =
                    recorded.map_err(|error| error.to_string());
            })
            .end_cmd();
        graph.copy_image_to_buffer(colour, copied);
        graph
            .begin_cmd()
            .resource_access(copied, AccessType::HostRead)
            .record_cmd(|_| {})
            .end_cmd();
        let fence = graph.finalize().queue_submit(pool, self.device.queue_family, 0)?;
        recorded.lock().unwrap_or_else(PoisonError::into_inner).clone()?;
        Ok(SentFrame { fence, image })
    }

    /// Destroys the pipelines. The GPU is idle.
    pub fn destroy(self) {
        self.pipelines.destroy();
    }
}

impl SentFrame {
    /// Waits for the frame, and returns its image.
    pub fn wait(mut self) -> Result<Vec<u8>, Box<dyn Error>> {
        self.fence.wait()?;
        Ok(Buffer::mapped_slice(&self.image).to_vec())
    }
}
