//! The renderer of a host, its frames and their images.

use std::collections::VecDeque;

use cull::FrameId;
use gpu::{Device, FinishedImage, vk};
use render::{FrameRequest, RenderView, Renderer, RendererOptions, Viewpoint};
use scene::{Mesh, MeshId, PreparedMesh, Scene, SceneError};
use shadows::{ShadowMethod, ShadowOptions};

use crate::decisions::camera::AntumbraCamera;
use crate::decisions::culler::strategy;
use crate::decisions::plan::tester_number;
use crate::error::Failure;
use crate::executor::scene::predication_number;
use crate::executor::target::AntumbraImageState;
use crate::layout::{Versioned, layout, versioned};
use crate::renderer::description::surface_of;
use crate::table::handle;

/// A renderer: a scene on a host's device, and one view of it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraRenderer {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraRenderer = "renderer");

/// A frame to be rendered.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraRenderDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// An `ANTUMBRA_STRATEGY_..`, which may change in each frame: all strategies draw the same
    /// image. The exception is objects that lie in one plane in a renderer without shadows: which
    /// of them shows depends on the order of draws there. With `AntumbraRendererDesc::shadows`,
    /// whatever its method, depth is drawn first and no order shows. Default:
    /// `ANTUMBRA_STRATEGY_ANTUMBRA`.
    pub strategy: u32,
    /// Required: the camera, with reversed depth. Its `sub_pixel_bits` are ignored.
    pub camera: *const AntumbraCamera,
}
layout!(AntumbraRenderDesc: struct_size, strategy, camera);

versioned!(AntumbraRenderDesc: 3, required: [camera], defaults: {});

/// The image of the newest frame. The renderer owns the image, until the renderer is resized or
/// destroyed.
///
/// Commands that are submitted to the same queue after the frame use the image after a barrier from
/// `state`. Commands on other queues first wait for `value` of the semaphore `timeline`. Before the
/// next frame is rendered, a barrier on the queue of the renderer must return the image to `state`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraFinishedImage {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The format of the view, which decodes the colours. Views of the image can also have
    /// `VK_FORMAT_R8G8B8A8_UNORM`.
    pub format: vk::Format,
    /// The image, of 8 bits per channel, which may be sampled and copied.
    pub image: vk::Image,
    /// A view of the image.
    pub view: vk::ImageView,
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// The state in which the frame leaves the image.
    pub state: AntumbraImageState,
    /// The timeline semaphore of the device, which the library owns.
    pub timeline: vk::Semaphore,
    /// The value of the semaphore at which the image is finished.
    pub value: u64,
}
layout!(AntumbraFinishedImage: struct_size, format, image, view, width, height, state, timeline,
    value);

versioned!(AntumbraFinishedImage: 9, required: [], defaults: {});

impl From<FinishedImage> for AntumbraFinishedImage {
    fn from(image: FinishedImage) -> Self {
        let FinishedImage { image, view, format, size: [width, height], state, timeline, tick } =
            image;
        let state = AntumbraImageState {
            layout: state.layout,
            reserved: 0,
            stages: state.stages,
            access: state.access,
        };
        let struct_size = size_of::<Self>() as u32;
        Self { struct_size, format, image, view, width, height, state, timeline, value: tick.0 }
    }
}

/// The counts of the newest frame whose results are known, and the state of uploads.
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

/// A renderer with its view.
pub(crate) struct HostedRenderer {
    pub renderer: Renderer,
    /// True if its scene has surfaces, on which shadows can fall.
    has_surfaces: bool,
    view: RenderView,
    /// The frames whose results are not known yet.
    submitted: VecDeque<SubmittedFrame>,
    stats: AntumbraRendererStats,
}

impl HostedRenderer {
    /// Refuses a device that a renderer cannot submit to.
    pub fn check_device(device: &Device) -> Result<(), Failure> {
        if device.has_queue() {
            return Ok(());
        }
        let message = "desc.device was adopted without a queue, and this submits: name \
                       one in AntumbraDeviceDesc::queue";
        Err(Failure::argument(message))
    }

    pub fn new(device: &Device, scene: &Scene, options: &RendererOptions) -> Result<Self, Failure> {
        let renderer = Renderer::new(device, scene, options)?;
        let view = renderer.new_view()?;
        let stats = AntumbraRendererStats::INIT;
        let has_surfaces = scene.surfaces.is_some();
        Ok(Self { renderer, has_surfaces, view, submitted: VecDeque::new(), stats })
    }

    /// Continues on another device. After an error nothing has changed.
    pub fn recover(&mut self, device: &Device) -> Result<(), Failure> {
        if !self.renderer.keeps_scene() {
            return Err(Failure::argument(
                "the renderer does not keep its scene: create it with \
                 AntumbraRendererDesc::keeps_scene, or create another one on this device",
            ));
        }
        tracing::warn!("a renderer continues on another device; {}", self.renderer.loss_report());
        self.renderer.recover(device)?;
        // Frames of the lost device have no results.
        self.submitted.clear();
        Ok(())
    }

    /// Renders a frame and submits it.
    pub fn render(
        &mut self,
        desc: &AntumbraRenderDesc,
        camera: &AntumbraCamera,
    ) -> Result<(), Failure> {
        let [width, height] = self.renderer.size();
        if [camera.width, camera.height] != [width, height] {
            return Err(Failure::argument(format_args!(
                "desc.camera is for an image of {}x{} pixels, and the renderer has one of {width}x\
                 {height}: call antumbra_renderer_resize",
                camera.width, camera.height
            )));
        }
        let viewpoint = Viewpoint::Matrix(camera.projection()?);
        let request = FrameRequest::new(strategy(desc.strategy)?, viewpoint);
        let report = self.renderer.render(&mut self.view, request)?;
        let hierarchy = self.renderer.hierarchy();
        let total = hierarchy.leaf_objects().len() - hierarchy.free_leaves();
        self.submitted.push_back(SubmittedFrame {
            frame: self.view.plan().frame,
            total: total as u64,
            tests: u64::from(report.tests),
        });
        self.drain_stats();
        Ok(())
    }

    /// Checks and adds meshes.
    pub fn add_meshes(&mut self, meshes: Vec<Mesh>) -> Result<Vec<MeshId>, Failure> {
        let prepare = |mesh: Mesh| {
            let surface = if self.has_surfaces { surface_of(&mesh) } else { None };
            match surface {
                Some(surface) => PreparedMesh::with_surface(mesh, surface, Vec::new()),
                None => PreparedMesh::new(mesh),
            }
        };
        let prepared: Result<Vec<PreparedMesh>, SceneError> =
            meshes.into_iter().map(prepare).collect();
        Ok(self.renderer.add_meshes(prepared.map_err(Failure::argument)?)?)
    }

    /// Draws shadows by other options from now on.
    pub fn set_shadows(&mut self, options: ShadowOptions) -> Result<(), Failure> {
        if !self.has_surfaces && options.method != ShadowMethod::Off {
            return Err(Failure::argument(
                "the renderer was created without desc.shadows, so that nothing in it can have \
                 shadows: create it with an AntumbraShadowDesc, of ANTUMBRA_SHADOWS_OFF at first",
            ));
        }
        Ok(self.renderer.set_shadows(options)?)
    }

    /// Waits until all frames are over.
    pub fn wait(&mut self) -> Result<(), Failure> {
        Ok(self.renderer.wait_idle(&mut self.view)?)
    }

    /// Returns the newest counts.
    pub fn stats(&mut self) -> AntumbraRendererStats {
        self.drain_stats();
        let is_uploading = u32::from(self.renderer.is_uploading());
        AntumbraRendererStats {
            is_uploading,
            predication: predication_number(self.renderer.predication()),
            tester: tester_number(self.renderer.cheapest_tester()),
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
