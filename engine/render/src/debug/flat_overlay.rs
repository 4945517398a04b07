//! The flat overlay of every image: text, graphs and other shapes laid out in pixels.

use gpu::{Device, DynamicTexture, Frame, Target};

use crate::error::Error;
use crate::passes::{FlatDraw, FlatIo, FlatPass, FlatVertex};
use crate::view_scopes::{ViewScope, ViewScopes};

/// The labels of the pass that writes the atlas, and of the drawing one.
pub(crate) const GLYPHS: &str = "HUD glyphs";
pub(crate) const OVERLAY: &str = "HUD";

/// Flat triangles over the scene, and the atlas that they are textured from. The program lays them
/// out again whenever they change ([`FlatOverlay::clear`], [`FlatOverlay::add`]); they are drawn
/// over every frame.
pub struct FlatOverlay {
    device: Device,
    atlas: Option<DynamicTexture>,
    /// Pieces of the atlas that the GPU does not have yet, and their pixels one after the other.
    patches: Vec<Patch>,
    pixels: Vec<[u8; 4]>,
    vertices: Vec<FlatVertex>,
    indices: Vec<u32>,
    draws: Vec<FlatDraw>,
}

#[derive(Debug, Clone, Copy)]
struct Patch {
    origin: [u32; 2],
    size: [u32; 2],
}

impl FlatOverlay {
    pub(crate) fn new(device: &Device) -> Self {
        Self {
            device: device.clone(),
            atlas: None,
            patches: Vec::new(),
            pixels: Vec::new(),
            vertices: Vec::new(),
            indices: Vec::new(),
            draws: Vec::new(),
        }
    }

    /// Begins another atlas of `size` pixels, all of them transparent.
    ///
    /// # Errors
    /// A size of 0 or beyond the device's limits; no memory.
    pub fn begin_atlas(&mut self, size: [u32; 2]) -> Result<(), Error> {
        self.atlas = Some(DynamicTexture::new(&self.device, size, "flat atlas")?);
        self.patches.clear();
        self.pixels.clear();
        Ok(())
    }

    /// Writes a piece of the atlas: sRGB-encoded colours multiplied by alpha, and alpha, rows from
    /// the top. Frames on their way still use the former contents.
    ///
    /// # Errors
    /// [`Error::Atlas`] if the piece is not within the atlas, or the number of pixels does not fit.
    pub fn write_atlas(
        &mut self,
        origin: [u32; 2],
        size: [u32; 2],
        pixels: impl ExactSizeIterator<Item = [u8; 4]>,
    ) -> Result<(), Error> {
        let atlas = self.atlas.as_ref().map_or([0, 0], DynamicTexture::size);
        let fits =
            |side: usize| u64::from(origin[side]) + u64::from(size[side]) <= u64::from(atlas[side]);
        let count = u64::from(size[0]) * u64::from(size[1]);
        if count == 0 || count != pixels.len() as u64 || !fits(0) || !fits(1) {
            return Err(Error::Atlas { origin, size, pixels: pixels.len(), atlas });
        }
        self.patches.push(Patch { origin, size });
        self.pixels.extend(pixels);
        Ok(())
    }

    /// Removes all triangles; the atlas stays.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.indices.clear();
        self.draws.clear();
    }

    /// Adds triangles over all that was added before, cut to `size` pixels from `origin` on.
    /// `indices` are into `vertices`, three per triangle; a triangle with an index out of range is
    /// left out.
    pub fn add(
        &mut self,
        origin: [u32; 2],
        size: [u32; 2],
        vertices: &[FlatVertex],
        indices: &[u32],
    ) {
        let (base, first) = (self.vertices.len() as u32, self.indices.len() as u32);
        let is_there = |index: &u32| (*index as usize) < vertices.len();
        let (triangles, _) = indices.as_chunks::<3>();
        for triangle in triangles.iter().filter(|triangle| triangle.iter().all(is_there)) {
            self.indices.extend(triangle.iter().map(|index| base + index));
        }
        let indices = first..self.indices.len() as u32;
        if !indices.is_empty() {
            self.vertices.extend_from_slice(vertices);
            self.draws.push(FlatDraw { origin, size, indices });
        }
    }

    /// Draws the overlay over the contents of `target`.
    pub(crate) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        pass: &FlatPass,
        (target, scopes): (&mut Target, Option<ViewScopes>),
    ) -> Result<(), Error> {
        let Some(atlas) = &mut self.atlas else { return Ok(()) };
        let mut rest = self.pixels.as_slice();
        for patch in &self.patches {
            let count = patch.size[0] as usize * patch.size[1] as usize;
            let Some((pixels, later)) = rest.split_at_checked(count) else { break };
            rest = later;
            let pixels = frame.uploads().push(pixels)?;
            frame.commands().pass(GLYPHS, |commands| {
                atlas.write(commands, patch.origin, patch.size, pixels);
            });
        }
        if self.draws.is_empty() {
            return Ok(());
        }
        atlas.prepare(frame.commands());
        let vertices = frame.uploads().push(&self.vertices)?;
        let indices = frame.uploads().push(&self.indices)?;
        let size = target.size();
        let io = FlatIo { vertices, indices, atlas };
        let commands = frame.commands();
        target.prepare(commands);
        let mut drawn_to = target.render_target(None);
        if let Some(scopes) = scopes {
            drawn_to = scopes.limit(ViewScope::FlatOverlay, drawn_to);
            if scopes.averages(ViewScope::FlatOverlay) {
                drawn_to = target.resolved_by(commands, drawn_to);
            }
        }
        commands.pass(OVERLAY, |commands| {
            commands.rendering(drawn_to, |commands| {
                pass.record(commands, &io, &self.draws, size);
            });
        });
        Ok(())
    }

    /// Returns true if it draws anything.
    pub(crate) fn has_draws(&self) -> bool {
        self.atlas.is_some() && !self.draws.is_empty()
    }

    /// Notes that the frame recorded last was submitted: the GPU has the atlas.
    pub(crate) fn submitted(&mut self) {
        self.patches.clear();
        self.pixels.clear();
        if let Some(atlas) = &mut self.atlas {
            atlas.submitted();
        }
    }
}
