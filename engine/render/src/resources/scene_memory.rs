//! The memory that a scene needs on a device, and the size of textures with which it fits: planned
//! before it is uploaded, and lowered when memory is short all the same.

use gpu::Device;
use scene::{Scene, SurfaceVertex, Surfaces, Vertex};

use crate::error::Error;
use crate::resources::instance::Instance;
use crate::shading::surfaces::{SMALL_PAGES_BYTES, SurfaceOptions, SurfaceTextures};

/// The fewest texels per side that textures are made smaller to.
const LEAST_SIDE: u32 = 64;

/// The highest number of texels per side of a scene's textures. Larger images are halved until they
/// fit, so that the largest ones lose their top mip maps first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct TextureLimit {
    side: u32,
    /// The side of the largest image.
    largest: u32,
}

impl TextureLimit {
    /// Returns the highest limit with which textures take at most `room_bytes`; the lowest one if
    /// none does. `size_bytes` returns the size of all textures whose sides are limited.
    fn within(room_bytes: u64, largest: u32, size_bytes: impl Fn(u32) -> u64) -> Self {
        let mut limit = Self { side: largest, largest };
        while size_bytes(limit.side) > room_bytes
            && let Some(smaller) = limit.smaller()
        {
            limit = smaller;
        }
        limit
    }

    /// Returns the limit by which the largest textures lose a mip map; `None` for the lowest one.
    fn smaller(self) -> Option<Self> {
        let side = self.side / 2;
        (side >= LEAST_SIDE).then_some(Self { side, ..self })
    }

    fn is_reduced(self) -> bool {
        self.side < self.largest
    }
}

/// The memory for a scene.
pub(crate) struct SceneMemory<'a> {
    device: &'a Device,
    surfaces: Option<&'a Surfaces>,
    options: &'a SurfaceOptions,
    geometry_bytes: u64,
    /// The memory that was left before the scene.
    left_bytes: u64,
    limit: TextureLimit,
}

impl<'a> SceneMemory<'a> {
    /// Plans the textures of a scene with a number of leaves for the memory that a device has left.
    pub(crate) fn plan(
        device: &'a Device,
        scene: &'a Scene,
        leaves: usize,
        options: &'a SurfaceOptions,
    ) -> Self {
        let surfaces = scene.surfaces.as_ref();
        let images = surfaces.map_or(&[][..], |surfaces| &surfaces.images);
        let largest = images.iter().flat_map(|image| image.size).max().unwrap_or(0);
        let largest = largest.min(device.adapter().limits.max_image_dimension2_d);
        let mut plan = Self {
            device,
            surfaces,
            options,
            geometry_bytes: geometry_bytes(scene, leaves),
            left_bytes: device.memory_use().left_bytes(),
            limit: TextureLimit { side: largest, largest },
        };
        let room_bytes = room_bytes(plan.left_bytes, plan.geometry_bytes);
        if surfaces.is_some_and(|surfaces| bound_bytes(surfaces) > room_bytes) {
            plan.limit = TextureLimit::within(room_bytes, largest, |side| plan.texture_bytes(side));
        }
        plan
    }

    /// Returns the options for the upload.
    pub(crate) fn surface_options(&self) -> SurfaceOptions {
        SurfaceOptions { max_texture_side: self.limit.side, ..self.options.clone() }
    }

    /// Lets the largest textures lose a mip map, after memory was short. Waits until the memory of
    /// what was uploaded is free.
    ///
    /// # Errors
    /// [`Error::SceneMemory`] if no texture can become smaller; a failed wait.
    pub(crate) fn reduce(&mut self, short: gpu::Error) -> Result<(), Error> {
        let Some(smaller) = self.limit.smaller() else { return Err(self.refused(short)) };
        tracing::debug!("textures become smaller: {short}");
        self.limit = smaller;
        Ok(self.device.wait_idle()?)
    }

    /// Logs by how much the textures of an uploaded scene are smaller.
    pub(crate) fn report(&self) {
        if self.limit.is_reduced() {
            let TextureLimit { side, largest } = self.limit;
            tracing::warn!(
                "no memory for textures in full size: they have at most {side} texels per side \
                 instead of {largest}, and take {} MiB instead of {} MiB; {} MiB were left for the \
                 scene",
                mib(self.texture_bytes(side)),
                mib(self.texture_bytes(largest)),
                mib(self.left_bytes),
            );
        }
    }

    fn refused(&self, source: gpu::Error) -> Error {
        let texture_bytes = self.texture_bytes(self.limit.side);
        Error::SceneMemory {
            needed_mib: mib(self.geometry_bytes.saturating_add(texture_bytes)),
            left_mib: mib(self.left_bytes),
            texture_side: self.limit.side,
            source: Box::new(source),
        }
    }

    /// Returns the size of the textures if none has more than `side` texels per side.
    fn texture_bytes(&self, side: u32) -> u64 {
        let size =
            |surfaces| SurfaceTextures::size_bytes(self.device, surfaces, self.options, side);
        self.surfaces.map_or(0, size)
    }
}

fn mib(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}

/// Returns the memory that textures may take if `left_bytes` are left. An eighth is kept for what
/// frames need. Meshes count twice, since they are copied from other memory.
fn room_bytes(left_bytes: u64, geometry_bytes: u64) -> u64 {
    (left_bytes - left_bytes / 8).saturating_sub(geometry_bytes.saturating_mul(2))
}

/// Returns about the size of the meshes and instances of a scene.
fn geometry_bytes(scene: &Scene, leaves: usize) -> u64 {
    let surface = if scene.surfaces.is_some() { size_of::<SurfaceVertex>() } else { 0 };
    let of_meshes = scene.meshes.iter().fold(0, |bytes: usize, mesh| {
        let vertices = mesh.vertices.len().saturating_mul(size_of::<Vertex>() + surface);
        let indices = mesh.indices.len().saturating_mul(size_of::<u32>());
        bytes.saturating_add(vertices).saturating_add(indices)
    });
    of_meshes.saturating_add(leaves.saturating_mul(size_of::<Instance>())) as u64
}

/// Returns a size that the textures do not exceed, without a plan of them. Pages take at most twice
/// the memory of their images; mip maps add a third.
fn bound_bytes(surfaces: &Surfaces) -> u64 {
    let images = surfaces.textures.iter().filter_map(|t| surfaces.images.get(t.image.0 as usize));
    let texels = images.fold(0_u64, |texels, image| {
        let [width, height] = image.size.map(u64::from);
        texels.saturating_add(width * height)
    });
    texels.saturating_mul(4 * 2 * 4 / 3 + 1).max(SMALL_PAGES_BYTES)
}

#[cfg(test)]
mod tests {
    use scene::{Encoding, Image, ImageId, Sampler, Texture};

    use super::*;

    const MIB: u64 = 1 << 20;

    /// Returns the size of square textures with all their mip maps, as `TextureLimit` reduces them.
    fn size_bytes(sides: &[u32], most: u32) -> u64 {
        let bytes = |mut side: u32| {
            while side > most {
                side /= 2;
            }
            u64::from(side).pow(2) * 4 * 4 / 3
        };
        sides.iter().map(|side| bytes(*side)).sum()
    }

    #[test]
    fn the_largest_textures_lose_mip_maps_first() {
        let sides = [4096, 1024, 512, 512];
        let side = |room_mib: u64| {
            TextureLimit::within(room_mib * MIB, 4096, |most| size_bytes(&sides, most)).side
        };
        assert_eq!(side(100), 4096, "93.3 MiB fit");
        assert_eq!(side(90), 2048, "only the largest is smaller");
        assert_eq!(side(20), 1024);
        assert_eq!(side(6), 512);
        assert_eq!(side(2), 256);
        assert_eq!(side(1), 128);
        assert_eq!(side(0), 64, "the bound");
    }

    #[test]
    fn textures_keep_at_least_the_bound() {
        let limit = TextureLimit { side: 127, largest: 127 };
        assert_eq!(limit.smaller(), None);
        let limit = TextureLimit { side: 128, largest: 128 };
        let smaller = limit.smaller().unwrap();
        assert!(smaller.side == 64 && smaller.is_reduced() && !limit.is_reduced());
        assert_eq!(smaller.smaller(), None);
    }

    #[test]
    fn frames_and_copies_of_meshes_keep_their_room() {
        assert_eq!(room_bytes(800, 100), 500);
        assert_eq!(room_bytes(800, 400), 0);
        assert_eq!(room_bytes(0, 0), 0);
        assert!(room_bytes(u64::MAX, u64::MAX) == 0 && room_bytes(u64::MAX, 0) > 1 << 60);
    }

    #[test]
    fn the_bound_of_textures_needs_no_plan() {
        let image = ImageId(0);
        let texture = Texture { image, encoding: Encoding::Srgb, sampler: Sampler::default() };
        let surfaces = Surfaces {
            images: vec![Image::of_rgba8("", [4096, 4096], Vec::new())],
            textures: vec![texture; 3],
            ..Surfaces::default()
        };
        assert!(bound_bytes(&surfaces) > 2 * 3 * size_bytes(&[4096], 4096));
        assert_eq!(bound_bytes(&Surfaces::default()), SMALL_PAGES_BYTES);
    }
}
