//! One of two sides that share nothing: an instance, a device, a renderer, and one object of each
//! kind.

use cull::Camera;
use gpu::{
    BlockingQueryPool, Buffer, BufferSlice, CapturePipeline, CapturePipelineInfo, ComputePipeline,
    Counting, Device, DrawRange, DynamicTexture, FlagRing, Frame, FrameRing, GraphicsPipeline,
    GraphicsPipelineInfo, IndirectDraw, LeafDrawRing, LeafDraws, MemoryKind, MipGeneration,
    PredicatedRange, Predicates, QueryIndex, QueryRing, Readback, ResultSource, Reveal, Spirv,
    StorageLayout, Swapchain, Target, TextureArray, TextureArrayInfo, TextureUploads, Timeline, vk,
};
use render::{
    FrameRequest, Rect, RenderView, Renderer, RendererOptions, VisibilitySnapshot, VisibleSet,
};
use scenes::{CameraPath, GeneratedScene, PathKind};
use shaders::Shader;
use tests::Driver;
use tests::walk::SceneKind;
use tests::window_fixture::WindowStage;
use tests::x11_window::{Library, X11Window};
use tests::xvfb::Xvfb;

pub const SIZE: [u32; 2] = [64, 36];
pub const SOURCE: ResultSource = ResultSource::Queries;

/// Objects of one device. They are dropped before the stage.
pub struct Side {
    pub renderer: Renderer,
    pub view: RenderView,
    pub snapshot: VisibilitySnapshot,
    pub visible: VisibleSet,
    pub camera: Camera,
    pub swapchain: Swapchain,
    pub target: Target,
    pub image: Readback,
    pub buffer: Buffer,
    pub texture: DynamicTexture,
    pub array: TextureArray,
    pub uploads: TextureUploads,
    pub graphics: GraphicsPipeline,
    pub compute: ComputePipeline,
    pub capture: CapturePipeline,
    pub queries: QueryRing<u32>,
    pub pages: BlockingQueryPool,
    pub flags: FlagRing<u32>,
    pub leaf_draws: LeafDrawRing<u32>,
    pub predicates: Predicates,
    pub timeline: Timeline,
    pub stage: WindowStage,
}

/// Two leaves whose draws draw nothing.
pub struct EmptyDraws;

impl LeafDraws for EmptyDraws {
    fn count(&self) -> u32 {
        2
    }

    fn draw(&self, _number: u32) -> IndirectDraw {
        IndirectDraw::default()
    }

    fn draws_of(&self, leaf: u32, each: &mut dyn FnMut(u32)) {
        each(leaf);
    }
}

fn spirv(shader: Shader) -> Spirv {
    Spirv::from_bytes(shader.name, shader.spirv).unwrap()
}

fn graphics(device: &Device) -> GraphicsPipeline {
    let vertex = spirv(shaders::find("sky.vert").unwrap());
    let fragment = spirv(shaders::find("sky.frag").unwrap());
    let info = GraphicsPipelineInfo {
        fragment: Some(&fragment),
        storage: StorageLayout { push_bytes: 16, ..StorageLayout::default() },
        depth: gpu::DepthMode::Ignored,
        blend: gpu::Blend::Opaque,
        ..GraphicsPipelineInfo::of("sky", &vertex)
    };
    GraphicsPipeline::new(device, &info).unwrap()
}

fn compute(device: &Device) -> ComputePipeline {
    let storage = StorageLayout { buffers: 3, push_bytes: 12, ..StorageLayout::default() };
    ComputePipeline::new(device, "counts", &spirv(shaders::PREDICATE_COUNTS), storage).unwrap()
}

fn capture(device: &Device) -> CapturePipeline {
    let shader = |name| spirv(shaders::find(name).unwrap());
    let info = CapturePipelineInfo {
        name: "patch_capture",
        vertex: &shader("patch_capture.vert"),
        control: &shader("patch_capture.tesc"),
        evaluation: &shader("patch_capture.tese"),
        storage: StorageLayout { buffers: 3, ..StorageLayout::default() },
    };
    CapturePipeline::new(device, &info).unwrap()
}

const ARRAY: TextureArrayInfo<'_> = TextureArrayInfo {
    name: "array",
    size: [4, 4],
    layers: 1,
    format: vk::Format::R8G8B8A8_SRGB,
    wrap: [vk::SamplerAddressMode::REPEAT; 2],
    magnified: vk::Filter::LINEAR,
    minified: vk::Filter::LINEAR,
    between_levels: None,
    anisotropy: 1.0,
    mip_making: MipGeneration::Cpu,
};

impl Side {
    pub fn new(server: &Xvfb) -> Self {
        let window = X11Window::open(server, Library::Xcb, SIZE);
        let stage = WindowStage::new(Driver::Lavapipe, window);
        let device = &stage.device;
        let GeneratedScene { scene, routes } = SceneKind::City.build(60);
        let camera = CameraPath::new(PathKind::Street, &routes).unwrap().camera(3);
        let options = RendererOptions { methods: methods::all(), size: SIZE, ..Default::default() };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let visible = renderer.visible_set(&mut view, camera, Rect::whole(SIZE)).unwrap();
        let snapshot = renderer.snapshot(&mut view, renderer.view_of(&camera)).unwrap();
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::VERTEX_BUFFER
            | vk::BufferUsageFlags::INDEX_BUFFER
            | vk::BufferUsageFlags::CONDITIONAL_RENDERING_EXT
            | vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC;
        let mut target = Target::new(device, SIZE, "target").unwrap();
        let mut ring = FrameRing::new(device, 1).unwrap();
        let frame = ring.begin().unwrap();
        target.prepare(frame.commands());
        frame.commands().rendering(target.render_target(Some([0.0; 4])), |_| {});
        frame.submit(None).unwrap();
        target.submitted();
        let draws = [IndirectDraw::default(); 2];
        let mut side = Self {
            renderer,
            view,
            snapshot,
            visible,
            camera,
            swapchain: stage.swapchain(&Default::default()),
            target,
            image: Readback::new(device, SIZE).unwrap(),
            buffer: Buffer::new(device, "buffer", 4096 * 4, usage, MemoryKind::Device).unwrap(),
            texture: DynamicTexture::new(device, [4, 4], "texture").unwrap(),
            array: TextureArray::new(device, &ARRAY).unwrap(),
            uploads: TextureUploads::new(device).unwrap(),
            graphics: graphics(device),
            compute: compute(device),
            capture: capture(device),
            queries: QueryRing::new(device, 1, "queries").unwrap(),
            pages: BlockingQueryPool::new(device, 1, "pages"),
            flags: FlagRing::new(device, 1, ResultSource::Fragments, "flags"),
            leaf_draws: LeafDrawRing::new(device, 1),
            predicates: Predicates::new(device, None, &draws, 1).unwrap(),
            timeline: Timeline::new(device, "timeline").unwrap(),
            stage,
        };
        side.begin_rings(&mut ring);
        side
    }

    /// Begins the rings of a frame that is never drawn.
    fn begin_rings(&mut self, ring: &mut FrameRing) {
        let mut frame = ring.begin().unwrap();
        let ranges = [DrawRange { first: 0, count: 1 }];
        self.queries.begin(&mut frame, &[0]).unwrap();
        self.pages.begin(frame.slot());
        self.pages.take(frame.commands(), 1).unwrap();
        self.pages.scope(frame.commands(), QueryIndex(0), Counting::Some, |_| {});
        self.flags.begin(&frame, [0].into_iter()).unwrap();
        self.leaf_draws.begin(&mut frame, 0, ranges.into_iter(), &EmptyDraws).unwrap();
        self.begin_predicates(&mut frame);
    }

    /// Makes one draw depend on the first predicate of the buffer.
    pub fn begin_predicates(&mut self, frame: &mut Frame<'_>) {
        let range = DrawRange { first: 0, count: 1 };
        let decided = [PredicatedRange { result: 0, range, reveal: Reveal::Draws }].into_iter();
        self.predicates.begin(frame, SOURCE, Some(self.buffer.whole()), decided).unwrap();
    }

    pub fn device(&self) -> Device {
        self.stage.device.clone()
    }

    pub fn slice(&self) -> BufferSlice {
        self.buffer.whole()
    }

    /// Draws a frame with every object of its own, shows it, and waits for it.
    pub fn draw(&mut self) {
        let request = FrameRequest {
            visible: Some(&self.visible),
            image: Some(&self.image),
            ..FrameRequest::new(methods::IDEAL, self.camera)
        };
        self.renderer.render(&mut self.view, request).unwrap();
        self.renderer.present(&mut self.swapchain, SIZE).unwrap();
        self.renderer.wait_idle(&mut self.view).unwrap();
        assert!(self.image.rgba8().unwrap().chunks(4).any(|pixel| pixel[0] > 0));
    }

    /// Drops everything, the instance last, and checks that the layers reported nothing.
    pub fn end(self) {
        let Self { stage, .. } = self;
        stage.end();
    }
}

/// Returns the error of a frame with a mistake.
pub fn framed(
    device: &Device,
    record: impl FnOnce(&mut Frame<'_>) -> Result<(), gpu::Error>,
) -> String {
    let mut ring = FrameRing::new(device, 1).unwrap();
    let mut frame = ring.begin().unwrap();
    let recorded = record(&mut frame);
    // A call that returns its error also makes the frame fail.
    let submitted = frame.submit(None).expect_err("an error").to_string();
    recorded.map_or_else(|error| error.to_string(), |()| submitted)
}
