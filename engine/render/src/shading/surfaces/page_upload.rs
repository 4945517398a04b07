//! Texture pages on the GPU. A separate image is a page with one layer.

use gpu::{
    CancellationToken, Device, MipGeneration, TextureArray, TextureArrayInfo, TextureUploads, vk,
};
use scene::limits::{MAX_LAYERS, MAX_PAGES};
use scene::{Encoding, Filter, Image, Sampler, Surfaces, Texels, Wrap};

use crate::error::Error;
use crate::resources::limits;
use crate::resources::spare_capacity::TextureCapacity;
use crate::shading::surfaces::pages::{Page, PagePlan};
use crate::shading::surfaces::surface_options::SurfaceOptions;

/// Plans the page of each image. No image has more than `max_side` texels per side.
pub(super) fn plan(
    device: &Device,
    surfaces: &Surfaces,
    rooms: &[TextureCapacity],
    max_side: u32,
) -> Result<PagePlan, Error> {
    let limits = &device.adapter().limits;
    let max_side = max_side.min(limits.max_image_dimension2_d);
    let max_layers = limits.max_image_array_layers;
    limits::check(
        "kinds of textures that may come",
        rooms.len() as u64,
        MAX_PAGES as u64 - 1,
        "keep room for fewer sizes and samplers",
    )?;
    for room in rooms {
        let layers = u64::from(max_layers.min(MAX_LAYERS));
        const FEWER: &str = "keep room for fewer, or twice for textures of this kind";
        limits::check("textures of one kind", room.layers.into(), layers, FEWER)?;
    }
    let max_pages = MAX_PAGES - rooms.len();
    let mut plan = PagePlan::new(surfaces, max_side, max_layers, max_pages);
    if plan.pages.len() > max_pages {
        let most = max_pages as u64 * u64::from(max_layers.min(MAX_LAYERS));
        let wanted = plan.pages.iter().map(|page| page.layers.len() as u64).sum();
        return Err(Error::SceneTooLarge {
            what: "images, colours and numbers apart",
            wanted,
            limit: most,
            instead: "join small images to larger ones",
        });
    }
    plan.add_room(rooms);
    Ok(plan)
}

/// The part of sampling that is the same for all textures.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampling {
    anisotropy: f32,
    mip_making: MipGeneration,
}

impl Sampling {
    /// Returns the sampling that `options` request, or the best of the device.
    pub(super) fn of(device: &Device, options: &SurfaceOptions) -> Self {
        let is_cpu = device.adapter().kind == vk::PhysicalDeviceType::CPU;
        let anisotropy = options.anisotropy.unwrap_or(if is_cpu { 1.0 } else { 8.0 });
        // Scenes contain mip maps only for compressed blocks.
        let mip_making = match options.mip_making {
            MipGeneration::Given(_) => MipGeneration::Cpu,
            made => made,
        };
        Self { anisotropy, mip_making }
    }

    /// Returns the size of all pages of a plan.
    pub(super) fn size_bytes(self, plan: &PagePlan) -> u64 {
        plan.pages.iter().map(|page| self.array_info("", page).size_bytes()).sum()
    }

    /// Returns the description of a page's array.
    pub(super) fn array_info<'a>(self, name: &'a str, page: &Page) -> TextureArrayInfo<'a> {
        let filter = |filter: Filter| match filter {
            Filter::Nearest => vk::Filter::NEAREST,
            Filter::Linear => vk::Filter::LINEAR,
        };
        let wrap = |wrap: Wrap| match wrap {
            Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
            Wrap::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
            Wrap::Clamp => vk::SamplerAddressMode::CLAMP_TO_EDGE,
        };
        let between = |filter: Filter| match filter {
            Filter::Nearest => vk::SamplerMipmapMode::NEAREST,
            Filter::Linear => vk::SamplerMipmapMode::LINEAR,
        };
        TextureArrayInfo {
            name,
            size: page.size,
            layers: page.layers.len() as u32 + page.spare,
            format: format_of(page),
            wrap: page.sampler.wrap.map(wrap),
            magnified: filter(page.sampler.magnified),
            minified: filter(page.sampler.minified),
            between_levels: page.sampler.between_levels.map(between),
            anisotropy: self.anisotropy,
            mip_making: match page.blocks {
                Some(blocks) => MipGeneration::Given(blocks.levels),
                None => self.mip_making,
            },
        }
    }
}

/// Creates and fills the pages. `create` creates an array.
pub(super) fn upload_pages(
    device: &Device,
    surfaces: &Surfaces,
    plan: &PagePlan,
    sampling: Sampling,
    cancellation: &CancellationToken,
    mut create: impl FnMut(&TextureArrayInfo<'_>) -> Result<TextureArray, gpu::Error>,
) -> Result<Vec<TextureArray>, Error> {
    let mut uploads = TextureUploads::new(device)?.cancelled_by(cancellation.clone());
    let mut pages = Vec::with_capacity(plan.pages.len().max(1));
    for (number, page) in plan.pages.iter().enumerate() {
        let name = format!("texture page {number}");
        let mut array = create(&sampling.array_info(&name, page))?;
        for (layer, image) in (0..).zip(&page.layers) {
            let Some(image) = surfaces.images.get(image.0 as usize) else { continue };
            // Checked before the image is unpacked or resampled.
            cancellation.check()?;
            upload_image(&mut uploads, &mut array, layer, image, page)?;
        }
        let used = page.layers.len() as u32;
        uploads.reserve(&mut array, used..used + page.spare)?;
        pages.push(array);
    }
    Ok(pages)
}

/// Fills a layer of a page with an image, which is unpacked and resampled if necessary.
fn upload_image(
    uploads: &mut TextureUploads,
    array: &mut TextureArray,
    layer: u32,
    image: &Image,
    page: &Page,
) -> Result<(), Error> {
    if let (Some(blocks), Texels::Blocks { levels, .. }) = (page.blocks, &image.texels) {
        let [first, count] = [blocks.first_level, blocks.levels].map(|level| level as usize);
        let levels = levels.get(first..first + count).unwrap_or_default();
        return Ok(uploads.write_levels(array, layer, levels)?);
    }
    if let Texels::Blocks { .. } = image.texels {
        limits::check_unpacking(image.size)?;
    }
    let rgba8 = image.rgba8();
    if image.size == page.size {
        return Ok(uploads.write(array, layer, &rgba8)?);
    }
    // Rows of the new width as numbers, and the pixels of the page.
    let [width, rows] = [page.size[0], image.size[1] + page.size[1]].map(|side| side as usize);
    let wanted = width.saturating_mul(rows);
    limits::check_memory("an image at the size of others", wanted, size_of::<[f32; 4]>())?;
    let format = format_of(page);
    Ok(uploads.write(array, layer, &gpu::resampled(&rgba8, image.size, page.size, format))?)
}

/// Creates and fills the pages of passes that sample pages; one white texel if there are none.
pub(super) fn upload_all_pages(
    device: &Device,
    surfaces: &Surfaces,
    plan: &PagePlan,
    sampling: Sampling,
    cancellation: &CancellationToken,
) -> Result<Vec<TextureArray>, Error> {
    let create = |info: &TextureArrayInfo<'_>| TextureArray::new(device, info);
    let mut pages = upload_pages(device, surfaces, plan, sampling, cancellation, create)?;
    if pages.is_empty() {
        let sampler = Sampler { between_levels: None, ..Sampler::default() };
        let white = Page {
            size: [1, 1],
            encoding: Encoding::Linear,
            sampler,
            layers: Vec::new(),
            spare: 1,
            blocks: None,
        };
        let plain = Sampling { anisotropy: 1.0, mip_making: MipGeneration::Blits };
        let mut array = create(&plain.array_info("no texture", &white))?;
        TextureUploads::new(device)?.write(&mut array, 0, &[255; 4])?;
        pages.push(array);
    }
    Ok(pages)
}

fn format_of(page: &Page) -> vk::Format {
    match (page.blocks, page.encoding) {
        (Some(blocks), encoding) => blocks.vulkan_format(encoding),
        (None, Encoding::Srgb) => vk::Format::R8G8B8A8_SRGB,
        (None, Encoding::Linear) => vk::Format::R8G8B8A8_UNORM,
    }
}
