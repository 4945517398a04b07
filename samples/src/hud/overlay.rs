//! Draws the HUD over the images of a renderer. Only here do the programs call Vulkan, because the
//! crate that draws egui's triangles does.
//!
//! The letters are in a texture of the engine, which frames write without waiting. The buffers
//! belong to the engine, too: they are freed when no frame uses them.

use std::cell::RefCell;

use antumbra::gpu::{
    Buffer, BufferSlice, Commands, Device, DynamicTexture, MAX_FRAMES_IN_FLIGHT, MemoryKind,
    OverlayImage, TextureSet, Uploads,
};
use antumbra::render::{self, HostOverlay};
use ash::vk;
use egui::epaint::{ImageData, ImageDelta, Primitive};
use egui::{ClippedPrimitive, TextureId};
use egui_ash_renderer::allocator::Allocator;
use egui_ash_renderer::{
    DynamicRendering, Options, RenderMode, Renderer, RendererError, RendererResult,
};

use super::HudFrame;

/// The HUD over images of one device. It draws its current frame until it receives another one.
pub struct HudOverlay {
    device: Device,
    state: RefCell<State>,
}

/// The triangles to draw, and the objects that draw them.
#[derive(Default)]
struct State {
    primitives: Vec<ClippedPrimitive>,
    /// The pixels per point.
    scale: f32,
    letters: Option<Letters>,
    /// Pieces of the texture of letters that no submitted frame has written yet, and the place of
    /// their pixels in this frame.
    pieces: Vec<Piece>,
    uploaded: Vec<BufferSlice>,
    renderer: Option<Renderer<Buffers>>,
}

/// The texture of letters, and its descriptor set.
struct Letters {
    texture: DynamicTexture,
    set: TextureSet,
    /// The texture's id in the triangles, once the renderer has assigned one.
    id: Option<TextureId>,
    /// The whole texture, for another device.
    whole: Piece,
}

impl Letters {
    fn new(device: &Device, whole: Piece) -> Result<Self, render::Error> {
        let texture = DynamicTexture::new(device, whole.size, "HUD letters")?;
        let set = TextureSet::new(device, &texture, "HUD letters")?;
        Ok(Self { texture, set, id: None, whole })
    }
}

/// A rectangle of the texture of letters.
#[derive(Clone)]
struct Piece {
    origin: [u32; 2],
    size: [u32; 2],
    pixels: Vec<[u8; 4]>,
}

impl Piece {
    /// Copies a piece into this one, which contains it.
    fn copy(&mut self, piece: &Piece) {
        let [width, _] = self.size.map(|side| side as usize);
        let [x, y] = piece.origin.map(|place| place as usize);
        let row_length = piece.size[0].max(1) as usize;
        for (row, pixels) in piece.pixels.chunks(row_length).enumerate() {
            let begin = (y + row) * width + x;
            if let Some(there) = self.pixels.get_mut(begin..begin + pixels.len()) {
                there.copy_from_slice(pixels);
            }
        }
    }
}

impl HudOverlay {
    /// Creates an overlay that draws nothing.
    pub fn new(device: &Device) -> Self {
        Self { device: device.clone(), state: RefCell::default() }
    }

    /// Creates an overlay on another device that draws the same.
    ///
    /// # Errors
    /// Not enough device memory for the letters.
    pub fn on(&self, device: &Device) -> Result<Self, render::Error> {
        let other = self.state.borrow();
        let mut state =
            State { primitives: other.primitives.clone(), scale: other.scale, ..State::default() };
        if let Some(letters) = &other.letters {
            state.pieces.push(letters.whole.clone());
            state.letters = Some(Letters::new(device, letters.whole.clone())?);
        }
        Ok(Self { device: device.clone(), state: RefCell::new(state) })
    }

    /// Returns the overlay for a frame request, unless there is nothing to draw.
    pub fn shown(&self) -> Option<&dyn HostOverlay> {
        let is_empty = self.state.borrow().primitives.is_empty();
        (!is_empty).then_some(self as &dyn HostOverlay)
    }

    /// Draws `frame` from now on.
    ///
    /// # Errors
    /// Not enough device memory for the letters.
    pub fn show(&self, frame: HudFrame) -> Result<(), render::Error> {
        let HudFrame { primitives, mut textures, scale, .. } = frame;
        let mut state = self.state.borrow_mut();
        for delta in textures.set.values().flatten() {
            state.take(&self.device, delta)?;
        }
        textures.clear();
        state.primitives = primitives;
        state.primitives.retain(|part| match &part.primitive {
            Primitive::Mesh(mesh) => !mesh.is_empty(),
            Primitive::Callback(_) => false,
        });
        state.scale = scale;
        Ok(())
    }
}

impl State {
    /// Adds a piece of the texture of letters, or replaces the whole texture.
    fn take(&mut self, device: &Device, delta: &ImageDelta) -> Result<(), render::Error> {
        let ImageData::Color(image) = &delta.image;
        let size = image.size.map(|side| side as u32);
        let origin = delta.pos.unwrap_or_default().map(|side| side as u32);
        let pixels = image.pixels.iter().map(egui::Color32::to_array).collect();
        let piece = Piece { origin, size, pixels };
        if let (Some(letters), Some(_)) = (&mut self.letters, delta.pos) {
            letters.whole.copy(&piece);
        }
        if delta.pos.is_none() {
            let old = self.letters.replace(Letters::new(device, piece.clone())?);
            let old = old.and_then(|old| old.id);
            if let (Some(renderer), Some(id)) = (&mut self.renderer, old) {
                renderer.remove_user_texture(id);
            }
            self.pieces.clear();
        }
        self.pieces.push(piece);
        Ok(())
    }
}

impl HostOverlay for HudOverlay {
    fn upload(&self, uploads: &mut Uploads) -> Result<(), render::Error> {
        let state = &mut *self.state.borrow_mut();
        state.uploaded.clear();
        for piece in &state.pieces {
            state.uploaded.push(uploads.push(&piece.pixels)?);
        }
        Ok(())
    }

    fn record(&self, commands: &Commands, image: &OverlayImage) -> Result<(), render::Error> {
        let state = &mut *self.state.borrow_mut();
        let Some(letters) = &mut state.letters else { return Ok(()) };
        for (piece, pixels) in state.pieces.iter().zip(&state.uploaded) {
            letters.texture.write(commands, piece.origin, piece.size, *pixels);
        }
        letters.texture.prepare(commands);
        let renderer = match &mut state.renderer {
            Some(renderer) => renderer,
            none => none.insert(new_renderer(&self.device, image.format)?),
        };
        let id = *letters.id.get_or_insert_with(|| renderer.add_user_texture(letters.set.raw()));
        for part in &mut state.primitives {
            if let Primitive::Mesh(mesh) = &mut part.primitive {
                mesh.texture_id = id;
            }
        }
        let [width, height] = image.size;
        let mut drawn = Ok(());
        commands.rendering(image.render_target(), |commands| {
            let size = vk::Extent2D { width, height };
            drawn = renderer.cmd_draw(commands.raw(), size, state.scale, &state.primitives);
        });
        drawn.map_err(failed)
    }

    fn submitted(&self) {
        let state = &mut *self.state.borrow_mut();
        state.pieces.clear();
        if let Some(letters) = &mut state.letters {
            letters.texture.submitted();
        }
    }
}

impl Drop for HudOverlay {
    /// Destroys the pipeline when the GPU has finished with it. If that cannot be determined, it
    /// leaks.
    fn drop(&mut self) {
        let renderer = self.state.get_mut().renderer.take();
        // A lost device has no pending work.
        if renderer.is_some()
            && let Err(error) = self.device.wait_idle()
            && !error.is_device_lost()
        {
            tracing::error!("the HUD is left as it is: {error}");
            std::mem::forget(renderer);
        }
    }
}

/// Creates the renderer of triangles. It cycles through as many buffers as frames may be in flight,
/// so it never writes a buffer that one of them reads.
fn new_renderer(device: &Device, format: vk::Format) -> Result<Renderer<Buffers>, render::Error> {
    let rendering = DynamicRendering {
        color_attachment_format: format,
        depth_attachment_format: None,
        stencil_attachment_format: None,
    };
    let options = Options {
        in_flight_frames: MAX_FRAMES_IN_FLIGHT,
        srgb_framebuffer: true,
        ..Options::default()
    };
    let buffers = Buffers(device.clone());
    let mode = RenderMode::DynamicRendering(rendering);
    Renderer::with_allocator(buffers, device.raw().clone(), mode, options).map_err(failed)
}

fn failed(error: RendererError) -> render::Error {
    render::Error::Overlay(Box::new(error))
}

/// Buffers of the engine for the renderer of triangles. A dropped buffer stays until no frame uses
/// it.
struct Buffers(Device);

impl Allocator for Buffers {
    type Allocation = Buffer;

    fn create_buffer(
        &mut self,
        _: &ash::Device,
        size: usize,
        usage: vk::BufferUsageFlags,
    ) -> RendererResult<(vk::Buffer, Buffer)> {
        let buffer = Buffer::new(&self.0, "HUD", size as u64, usage, MemoryKind::Upload);
        let buffer = buffer.map_err(|error| RendererError::Allocator(error.to_string()))?;
        Ok((buffer.whole().raw(), buffer))
    }

    fn create_image(
        &mut self,
        _: &ash::Device,
        _: u32,
        _: u32,
    ) -> RendererResult<(vk::Image, Buffer)> {
        Err(RendererError::Allocator("the engine makes the texture of letters".to_owned()))
    }

    fn destroy_buffer(&mut self, _: &ash::Device, _: vk::Buffer, _: Buffer) -> RendererResult<()> {
        Ok(())
    }

    fn destroy_image(&mut self, _: &ash::Device, _: vk::Image, _: Buffer) -> RendererResult<()> {
        Ok(())
    }

    fn update_buffer<T: Copy>(
        &mut self,
        _: &ash::Device,
        buffer: &mut Buffer,
        data: &[T],
    ) -> RendererResult<()> {
        buffer.write(data);
        Ok(())
    }
}
