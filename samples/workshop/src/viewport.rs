//! The document on the GPU: follows its state, draws it, and finds the part under a pixel.

use std::sync::Arc;

use antumbra::cull::{CullView, FrameId, SectionPlanes, Strategy};
use antumbra::glam::Affine3A;
use antumbra::gpu::{Device, Readback, SampleCount};
use antumbra::occlusion::Rect;
use antumbra::render::{
    DebugOverlay, EdgeMode, EdgeOptions, Error, HostOverlay, ObjectOutline, PointedSurface,
    SpareCapacity, TransparencyOptions,
};
use antumbra::scene::{
    MeshId, Object, ObjectChange, PreparedMesh, SceneUpdate, TransparentId, TransparentMove,
};
use antumbra::{Camera, FrameRequest, ObjectId, RenderView, Renderer, RendererOptions};
use bench::options::FrameSize;
use bench::transparency::{FragmentsReport, TransparencyReport};

use crate::document::{CommandError, Display, Document};
use crate::ghosts::{NOWHERE, add_ghosts};
use crate::script::Pixel;

/// The colour of the outline of the selection.
const SELECTED_COLOUR: [f32; 3] = [1.0, 0.35, 0.0];

/// The colour of the outline of the hovered object.
const HOVERED_COLOUR: [f32; 3] = [0.05, 0.45, 1.0];

/// The width of both outlines, in pixels.
const OUTLINE_PIXELS: f32 = 2.0;

/// The number of frames after which a view's results have been read back.
const FRAMES_BEFORE_OVERLAY: u32 = 4;

/// The spare capacity for tessellated parts.
const CURVED_ROOM: SpareCapacity = SpareCapacity {
    meshes: 2,
    vertices: 1 << 17,
    indices: 1 << 19,
    lights: 0,
    directional_lights: 0,
    levels: 0,
    materials: 0,
    textures: Vec::new(),
};

/// The state of an object in the renderer.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Placed {
    /// The id in the renderer; `None` while the object is not shown opaque.
    object: Option<ObjectId>,
    display: Display,
    transform: Affine3A,
}

/// The options of a viewport.
#[derive(Clone, Debug)]
pub struct ViewportOptions {
    /// The size of images in pixels.
    pub size: FrameSize,
    /// The samples per pixel.
    pub samples: SampleCount,
    /// The method of transparent parts.
    pub transparency: TransparencyOptions,
    /// True if the scene is kept in memory, for [`ModelViewport::recover`].
    pub keeps_scene: bool,
}

/// A document on the GPU.
pub struct ModelViewport {
    renderer: Renderer,
    view: RenderView,
    /// The view whose history serves [`ModelViewport::visible`].
    counting: RenderView,
    /// The objects of the document, in their order.
    placed: Vec<Placed>,
    /// The renderer's mesh for each mesh of the document.
    meshes: Vec<MeshId>,
    /// The transparent object of the first part, which the others follow in order; or the reason
    /// why parts cannot be shown transparent.
    first_ghost: Result<TransparentId, CommandError>,
    /// The objects whose visible samples are counted, by their ids in the document.
    watched: Vec<ObjectId>,
    /// The newest frame whose objects may have had other ids. Answers about it and earlier frames
    /// are ignored, since they could name other objects.
    renumbered: Option<FrameId>,
}

/// A pixel, and the object of the document that a frame showed there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointedPixel {
    /// The frame of the view.
    pub frame: FrameId,
    /// The pixel.
    pub pixel: Pixel,
    /// The object and its point; `None` for the background.
    pub surface: Option<PointedSurface>,
}

/// An object of the document, and its visibility in the newest frame with results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SeenObject {
    /// The object.
    pub object: ObjectId,
    /// True if it was visible.
    pub is_visible: bool,
}

impl ModelViewport {
    /// Uploads a document at rest.
    ///
    /// # Errors
    /// A scene or size beyond the device's limits, no memory, a failed call.
    pub fn new(
        device: &Device,
        document: &Document,
        options: &ViewportOptions,
    ) -> Result<Self, Error> {
        let ViewportOptions { size, samples, transparency, keeps_scene } = options.clone();
        let mut scene = document.scene.clone().with_surfaces();
        let first_ghost = add_ghosts(&mut scene);
        let spare = if document.curved.is_empty() { SpareCapacity::default() } else { CURVED_ROOM };
        let options = RendererOptions {
            size: [size.width, size.height],
            samples,
            transparency,
            spare,
            ..RendererOptions::default()
        };
        let mut renderer = Renderer::new(device, &scene, &options)?;
        if keeps_scene {
            renderer.keep_scene(Arc::new(scene))?;
        }
        let placed = |object: ObjectId| Placed {
            object: Some(object),
            display: Display::Shown,
            transform: document.scene.objects[object.0 as usize].transform,
        };
        Ok(Self {
            view: renderer.new_view()?,
            counting: renderer.new_view()?,
            placed: document.objects().map(placed).collect(),
            meshes: (0..document.scene.meshes.len() as u32).map(MeshId).collect(),
            renderer,
            first_ghost,
            watched: Vec::new(),
            renumbered: None,
        })
    }

    /// Checks that parts can be shown transparent.
    ///
    /// # Errors
    /// [`CommandError::TooManyToGhost`].
    pub fn check_ghosts(&self) -> Result<(), CommandError> {
        self.first_ghost.clone().map(|_| ())
    }

    /// Returns the device.
    pub fn device(&self) -> &Device {
        self.renderer.device()
    }

    /// Returns the view of a camera.
    pub fn view_of(&self, camera: &Camera) -> CullView {
        self.renderer.view_of(camera)
    }

    /// Returns the method of transparency, if fragments were requested.
    pub fn transparency(&self) -> Option<TransparencyReport> {
        TransparencyReport::of(&self.renderer)
    }

    /// Returns the fragments of transparent parts in the newest image, if fragments are sorted.
    pub fn fragments(&self) -> Option<FragmentsReport> {
        FragmentsReport::most(std::iter::once(self.renderer.fragment_counts()))
    }

    /// Continues on another device after the loss of the present one.
    ///
    /// # Errors
    /// A viewport that does not keep its scene; a device that does not take it, or fails. The
    /// viewport is as before then.
    pub fn recover(&mut self, device: &Device) -> Result<(), Error> {
        self.renderer.recover(device)
    }

    /// Applies the changes of the document.
    ///
    /// # Errors
    /// No memory, a failed call. Nothing is applied then, and the next call applies it.
    pub fn follow(&mut self, document: &Document) -> Result<(), Error> {
        let mut update = SceneUpdate::default();
        let mut added = Vec::new();
        let mut wanted = self.placed.clone();
        for (index, placed) in wanted.iter_mut().enumerate() {
            let id = ObjectId(index as u32);
            let display = document.display(id);
            let transform = document.transform(id);
            if (display, transform) == (placed.display, placed.transform) {
                continue;
            }
            match (placed.object, display) {
                (Some(object), Display::Shown) => {
                    update.objects.push(ObjectChange::Move { object, transform });
                }
                (Some(object), _) => {
                    update.objects.push(ObjectChange::Remove { object });
                    placed.object = None;
                }
                (None, Display::Shown) => {
                    let object = document.scene.objects[index];
                    let mesh = self.meshes[object.mesh.0 as usize];
                    let object = Object { mesh, transform, ..object };
                    update.objects.push(ObjectChange::Add { object });
                    added.push(index);
                }
                (None, _) => {}
            }
            if let Ok(first_ghost) = &self.first_ghost
                && (display, placed.display) != (Display::Shown, Display::Shown)
            {
                let is_ghosted = display == Display::Ghosted;
                let transform = if is_ghosted { transform } else { NOWHERE };
                let transparent = TransparentId(first_ghost.0 + index as u32);
                update.transparent.push(TransparentMove { transparent, transform });
            }
            placed.display = display;
            placed.transform = transform;
        }
        let is_renumbering = |change: &ObjectChange| !matches!(change, ObjectChange::Move { .. });
        if update.objects.iter().any(is_renumbering) {
            self.renumber();
        }
        let report = self.renderer.apply(&update)?;
        self.placed = wanted;
        for (index, object) in added.into_iter().zip(report.added) {
            self.placed[index].object = Some(object);
        }
        for (index, placed) in self.placed.iter().enumerate() {
            // A reused id starts as affected by section planes.
            if let Some(object) = placed.object {
                self.renderer.set_section_member(object, document.member(ObjectId(index as u32)));
            }
        }
        Ok(())
    }

    /// Returns the renderer, to present its image.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Changes the size of images.
    ///
    /// # Errors
    /// A size that the device does not support; no memory.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<(), Error> {
        self.renderer.resize(size)
    }

    /// Draws a frame with the host's overlay on top.
    ///
    /// # Errors
    /// No memory, a lost device, a frame that takes too long.
    pub fn draw(
        &mut self,
        camera: &Camera,
        overlay: Option<&dyn HostOverlay>,
    ) -> Result<(), Error> {
        let request = FrameRequest::new(Strategy::ANTUMBRA, camera);
        self.renderer.render(&mut self.view, FrameRequest { overlay, ..request }).map(|_| ())
    }

    /// Finds the object at a pixel in each frame from now on; `None` ends this.
    ///
    /// # Errors
    /// A device whose fragment shaders cannot write to buffers.
    pub fn point_at(&mut self, pixel: Option<Pixel>) -> Result<(), Error> {
        self.view.point_at(pixel.map(|Pixel { x, y }| [x, y]))
    }

    /// Returns the newest frame.
    pub fn frame(&self) -> FrameId {
        self.view.plan().frame
    }

    /// Returns the answer of the newest completed frame. Never waits.
    pub fn pointed(&self) -> Option<PointedPixel> {
        let is_known = |frame: FrameId| self.renumbered.is_none_or(|last| frame > last);
        let pointed = self.view.pointed().filter(|pointed| is_known(pointed.frame))?;
        let [x, y] = pointed.pixel;
        let surface = pointed.surface.and_then(|surface| {
            let object = self.document_object(surface.object)?;
            Some(PointedSurface { object, ..surface })
        });
        Some(PointedPixel { frame: pointed.frame, pixel: Pixel { x, y }, surface })
    }

    /// Counts the visible samples of exactly these objects from now on, if the device supports it.
    pub fn watch(&mut self, objects: &[ObjectId]) {
        if self.watched == objects {
            return;
        }
        self.watched = objects.to_vec();
        let placed = objects.iter().filter_map(|object| self.placed.get(object.0 as usize));
        let known: Vec<ObjectId> = placed.filter_map(|placed| placed.object).collect();
        // Without support, nothing is known about them.
        let _is_counting = self.view.watch(&known).is_ok();
    }

    /// Returns the known visibility of each watched object. It is of an older frame, since this
    /// never waits.
    pub fn seen(&self) -> impl Iterator<Item = SeenObject> {
        self.view.visible_samples().iter().filter_map(|count| {
            let object = self.document_object(count.object)?;
            Some(SeenObject { object, is_visible: count.samples > 0 })
        })
    }

    /// Returns the number of objects drawn in the newest frame with results, if there are new
    /// results since the last call.
    pub fn take_drawn(&mut self) -> Option<u64> {
        self.view.drain_stats().next_back().map(|outcome| outcome.draws)
    }

    /// Draws a frame, waits for it, and returns its image: rows of RGBA from the top.
    ///
    /// # Errors
    /// The errors of [`ModelViewport::draw`].
    pub fn image(&mut self, camera: &Camera) -> Result<Vec<u8>, Error> {
        if self.overlay().has_depth_complexity {
            // The overlay shows known visible objects, from the results of earlier frames.
            for _ in 0..FRAMES_BEFORE_OVERLAY {
                self.draw(camera, None)?;
            }
        }
        let request = FrameRequest::new(Strategy::ANTUMBRA, camera);
        let image = Readback::new(self.renderer.device(), self.renderer.size())?;
        let request = FrameRequest { image: Some(&image), ..request };
        self.renderer.render(&mut self.view, request)?;
        self.renderer.wait_idle(&mut self.view)?;
        Ok(image.rgba8()?.to_vec())
    }

    /// Draws a frame, waits for it, and returns the surface at a pixel, with the object of the
    /// document.
    ///
    /// # Errors
    /// A device whose fragment shaders cannot write to buffers; the errors of
    /// [`ModelViewport::draw`].
    pub fn pick(&mut self, camera: &Camera, at: Pixel) -> Result<Option<PointedSurface>, Error> {
        self.view.point_at(Some([at.x, at.y]))?;
        self.draw(camera, None)?;
        self.view.point_at(None)?;
        self.renderer.wait_idle(&mut self.view)?;
        Ok(self.pointed().and_then(|pointed| pointed.surface))
    }

    /// Returns the opaque objects that own a pixel, in ascending order. Waits for the GPU.
    ///
    /// # Errors
    /// A device whose fragment shaders cannot write to buffers; no memory, a lost device.
    pub fn visible(&mut self, camera: &Camera) -> Result<Vec<ObjectId>, Error> {
        let area = Rect::whole(self.renderer.size());
        let set = self.renderer.visible_set(&mut self.counting, camera, area)?;
        let objects = self.renderer.hierarchy().leaf_objects();
        let seen = set.leaves().iter().filter_map(|leaf| objects.get(leaf.0 as usize));
        let mut seen: Vec<ObjectId> =
            seen.filter_map(|object| self.document_object(*object)).collect();
        seen.sort_unstable();
        Ok(seen)
    }

    /// Outlines the selection and the object below the pointer.
    ///
    /// # Errors
    /// A failed call.
    pub fn outline(
        &mut self,
        selected: impl Iterator<Item = ObjectId>,
        hovered: Option<ObjectId>,
    ) -> Result<(), Error> {
        let known = |object: ObjectId| self.placed.get(object.0 as usize)?.object;
        let outline = |objects: Vec<ObjectId>, colour| ObjectOutline {
            objects,
            colour,
            width_pixels: OUTLINE_PIXELS,
        };
        let mut outlines = vec![
            outline(selected.filter_map(known).collect(), SELECTED_COLOUR),
            outline(hovered.and_then(known).into_iter().collect(), HOVERED_COLOUR),
        ];
        outlines.retain(|outline| !outline.objects.is_empty());
        if self.renderer.outlined() == outlines {
            return Ok(());
        }
        self.renderer.set_outlined(&outlines)
    }

    /// Replaces a mesh of the document. Its objects are shown again at the next
    /// [`ModelViewport::follow`] after its upload.
    pub(crate) fn set_mesh(
        &mut self,
        document: &Document,
        id: MeshId,
        mesh: PreparedMesh,
    ) -> Result<(), Error> {
        let added = self.renderer.add_meshes(vec![mesh])?;
        let mut update = SceneUpdate::default();
        for (placed, object) in self.placed.iter_mut().zip(&document.scene.objects) {
            if object.mesh == id
                && let Some(object) = placed.object.take()
            {
                update.objects.push(ObjectChange::Remove { object });
                placed.display = Display::Hidden;
            }
        }
        self.renumber();
        self.renderer.apply(&update)?;
        for (old, new) in self.meshes.get_mut(id.0 as usize).into_iter().zip(added) {
            let removed = std::mem::replace(old, new);
            self.renderer.remove_meshes(&[removed])?;
        }
        Ok(())
    }

    /// Draws frames until all meshes are uploaded.
    ///
    /// # Errors
    /// The errors of [`ModelViewport::draw`].
    pub fn await_uploads(&mut self, camera: &Camera) -> Result<(), Error> {
        while self.renderer.is_uploading() {
            self.draw(camera, None)?;
        }
        // The last uploaded mesh is drawn from the next frame on.
        self.draw(camera, None)
    }

    /// Cuts all objects by planes from the next frame on.
    ///
    /// # Errors
    /// A device that cannot; no memory, a failed call.
    pub fn set_section(&mut self, planes: SectionPlanes) -> Result<(), Error> {
        self.renderer.set_section(planes)
    }

    /// Returns the planes that cut objects.
    pub fn section(&self) -> SectionPlanes {
        *self.renderer.section()
    }

    /// Draws edges from the next frame on.
    ///
    /// # Errors
    /// No memory, a failed call.
    pub fn set_edges(&mut self, mode: EdgeMode) -> Result<(), Error> {
        self.renderer.set_edges(EdgeOptions { mode, ..EdgeOptions::default() })
    }

    /// Draws a debug overlay from the next frame on.
    ///
    /// # Errors
    /// A device that cannot; a failed call.
    pub fn set_overlay(&mut self, overlay: DebugOverlay) -> Result<(), Error> {
        self.renderer.set_debug_overlay(overlay)
    }

    /// Returns the debug overlay.
    pub fn overlay(&self) -> DebugOverlay {
        self.renderer.debug_overlay()
    }

    /// Forgets the answers of earlier frames about objects whose ids may now belong to other
    /// objects.
    fn renumber(&mut self) {
        self.watched.clear();
        self.renumbered = Some(self.frame());
    }

    /// Returns the object of the document that has this id in the renderer.
    fn document_object(&self, id: ObjectId) -> Option<ObjectId> {
        let is_it = |placed: &Placed| placed.object == Some(id);
        // Most objects have kept their ids.
        if self.placed.get(id.0 as usize).is_some_and(is_it) {
            return Some(id);
        }
        self.placed.iter().position(is_it).map(|index| ObjectId(index as u32))
    }
}
