//! The renderer of a host, its frames and their images.

use std::mem::MaybeUninit;

use cull::ObjectId;
use gpu::{Device, FinishedImage, vk};
use render::{FrameRequest, LightShadow, Renderer, RendererOptions, Viewpoint};
use scene::{
    LightId, MaterialId, Mesh, MeshId, ObjectChange, PreparedMesh, SceneError, SurfaceMesh,
};
use shadows::{ShadowMethod, ShadowOptions};

use crate::decisions::camera::AntumbraCamera;
use crate::decisions::culler::strategy;
use crate::error::Failure;
use crate::executor::target::AntumbraImageState;
#[cfg(feature = "import")]
use crate::layout::Versioned;
use crate::layout::{layout, versioned};
use crate::renderer::description::{SceneKeeping, surface_of};
#[cfg(feature = "import")]
use crate::renderer::playback::Playback;
use crate::renderer::scene_begin::SceneBegin;
use crate::renderer::view::{AntumbraRendererStats, AntumbraRendererView, HostedView};
use crate::table::{Handle, Shared, Table, handle};

/// A renderer: a scene on a device, and views of it.
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
    /// The view whose history the frame uses and continues. A camera that is elsewhere needs
    /// another view: `antumbra_renderer_view_create`. Default: 0, the renderer's own view.
    pub view: AntumbraRendererView,
}
layout!(AntumbraRenderDesc: struct_size, strategy, camera, view);

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

/// A renderer with its views.
pub(crate) struct HostedRenderer {
    pub renderer: Renderer,
    /// The material of meshes that are added, if its scene has surfaces, on which shadows can fall.
    added_material: Option<MaterialId>,
    /// The clips and cameras of its file, if it was created from one.
    #[cfg(feature = "import")]
    playback: Option<Playback>,
    own_view: HostedView,
    pub views: Table<HostedView, AntumbraRendererView>,
    /// The view that the newest frame shows, even if it was destroyed since; `None` for the own
    /// one.
    shown: Option<Shared<HostedView>>,
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

    /// Creates a renderer of a scene at rest.
    pub fn new(
        device: &Device,
        begin: SceneBegin,
        options: &RendererOptions,
        keeping: SceneKeeping,
    ) -> Result<Self, Failure> {
        let mut renderer = Renderer::new(device, &begin.scene, options)?;
        if keeping == SceneKeeping::Kept {
            renderer.keep_scene(begin.scene)?;
        }
        let own_view = HostedView::new(&renderer)?;
        #[cfg_attr(not(feature = "import"), expect(unused_mut, reason = "nothing is posed"))]
        let mut new = Self {
            renderer,
            added_material: begin.added_material,
            #[cfg(feature = "import")]
            playback: begin.playback,
            own_view,
            views: Table::new(0),
            shown: None,
        };
        // Skinned meshes have no pose before.
        #[cfg(feature = "import")]
        if new.playback.is_some() {
            new.advance(0.0)?;
        }
        Ok(new)
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
        let views = self.views.all();
        let mut views = views.iter().map(Shared::write).collect::<Result<Vec<_>, _>>()?;
        self.renderer.recover(device)?;
        self.own_view.forget_frames();
        views.iter_mut().for_each(|view| view.forget_frames());
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
        if desc.view.id() == 0 {
            self.own_view.render(&mut self.renderer, request)?;
            self.shown = None;
            return Ok(());
        }
        let view = self.views.find(desc.view)?;
        view.write()?.render(&mut self.renderer, request)?;
        self.shown = Some(view);
        Ok(())
    }

    /// Waits until all frames are over, and writes the newest image.
    pub fn read_image(&mut self, rgba: &mut [MaybeUninit<u8>]) -> Result<(), Failure> {
        let [width, height] = self.renderer.size();
        let byte_count = width as usize * height as usize * 4;
        if rgba.len() != byte_count {
            return Err(Failure::argument(format_args!(
                "byte_count is {}, and the image of {width}x{height} pixels has {byte_count} bytes",
                rgba.len()
            )));
        }
        let pixels = match &self.shown {
            None => self.own_view.finish(&mut self.renderer)?,
            Some(view) => view.write()?.finish(&mut self.renderer)?,
        };
        rgba.write_copy_of_slice(&pixels);
        Ok(())
    }

    /// Adds a view without history.
    pub fn add_view(&mut self) -> Result<AntumbraRendererView, Failure> {
        self.views.insert(HostedView::new(&self.renderer)?)
    }

    /// Removes objects. Clips of a file do not move them any more.
    pub fn remove_objects(&mut self, objects: &[ObjectId]) -> Result<(), Failure> {
        let removal = |object: &ObjectId| ObjectChange::Remove { object: *object };
        self.renderer.update(&objects.iter().map(removal).collect::<Vec<_>>())?;
        #[cfg(feature = "import")]
        if let Some(playback) = &mut self.playback {
            playback.removed.extend(objects);
        }
        Ok(())
    }

    /// Checks and adds meshes.
    pub fn add_meshes(&mut self, meshes: Vec<Mesh>) -> Result<Vec<MeshId>, Failure> {
        let prepare = |mesh: Mesh| {
            let material = self.added_material;
            let surface =
                material.and_then(|material| Some(SurfaceMesh { material, ..surface_of(&mesh)? }));
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
        if options.method != ShadowMethod::Off {
            self.check_surfaces()?;
        }
        Ok(self.renderer.set_shadows(options)?)
    }

    /// Sets the shadow of one light; `None` restores the options of all lights.
    pub fn set_light_shadow(
        &mut self,
        light: LightId,
        shadow: Option<LightShadow>,
    ) -> Result<(), Failure> {
        self.check_surfaces()?;
        Ok(self.renderer.set_light_shadow(light, shadow)?)
    }

    fn check_surfaces(&self) -> Result<(), Failure> {
        if self.added_material.is_some() {
            return Ok(());
        }
        Err(Failure::argument(
            "the renderer was created without desc.shadows, so that nothing in it can have \
             shadows: create it with an AntumbraShadowDesc, of ANTUMBRA_SHADOWS_OFF at first",
        ))
    }

    /// Waits until all frames are over.
    pub fn wait(&mut self) -> Result<(), Failure> {
        self.own_view.wait(&mut self.renderer)?;
        self.views.all().iter().try_for_each(|view| view.write()?.wait(&mut self.renderer))
    }

    /// Returns the newest counts of a view.
    pub fn view_stats(
        &mut self,
        view: AntumbraRendererView,
    ) -> Result<AntumbraRendererStats, Failure> {
        let view = self.views.find(view)?;
        let mut view = view.write()?;
        Ok(view.stats(&self.renderer))
    }

    /// Returns the newest counts of the own view.
    pub fn stats(&mut self) -> AntumbraRendererStats {
        self.own_view.stats(&self.renderer)
    }
}

/// The clips and cameras of a file.
#[cfg(feature = "import")]
impl HostedRenderer {
    /// Brings the scene to a time.
    pub fn advance(&mut self, seconds: f64) -> Result<(), Failure> {
        let Self { renderer, playback, .. } = self;
        let playback = playback.as_mut().ok_or_else(no_file)?;
        renderer.apply(&*playback.changes(seconds)?)?;
        Ok(())
    }

    /// Returns the clips of the file.
    pub fn playback(&mut self) -> Result<&mut Playback, Failure> {
        self.playback.as_mut().ok_or_else(no_file)
    }

    /// Returns a camera of the file at the time of the last advance.
    pub fn camera(&self, index: u32) -> Result<AntumbraCamera, Failure> {
        let playback = self.playback.as_ref().ok_or_else(no_file)?;
        let [width, height] = self.renderer.size();
        let camera = playback.camera(index, [width, height])?;
        Ok(AntumbraCamera {
            sub_pixel_bits: self.renderer.device().adapter().limits.sub_pixel_precision_bits,
            clip_from_world: self.renderer.view_of(&camera).view_proj.to_cols_array(),
            width,
            height,
            ..AntumbraCamera::INIT
        })
    }
}

/// Returns the refusal of a call that needs a file.
#[cfg(feature = "import")]
fn no_file() -> Failure {
    Failure::argument(
        "the renderer was created from meshes, and has no clips and cameras: name a file in \
         AntumbraRendererDesc::scene_file",
    )
}
