//! The images of a host that a view is drawn to.

use std::fmt::Display;

use gpu::{
    Attachments, COLOURS_MAX, ColourFormats, Device, HostImage, HostImages, HostPass, ImageState,
    NearDepth, Target, vk,
};

use super::frame::ViewPlace;
use crate::decisions::camera::{ANTUMBRA_DEPTH_REVERSED, ANTUMBRA_DEPTH_STANDARD};
use crate::error::Failure;
use crate::layout::{layout, versioned};
use crate::pointers::slice;

/// The most colour images of a view.
pub const ANTUMBRA_COLOURS_MAX: usize = 8;

/// The state of an image where its use changes between another user and the executor.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraImageState {
    /// The layout, which is not checked. `VK_IMAGE_LAYOUT_UNDEFINED` on entry discards the
    /// contents; on exit it leaves the image in its layout as an attachment.
    pub layout: vk::ImageLayout,
    /// Must be 0.
    pub reserved: u32,
    /// The stages of the other user that access the image.
    pub stages: vk::PipelineStageFlags2,
    /// The accesses of these stages.
    pub access: vk::AccessFlags2,
}
layout!(AntumbraImageState: layout, reserved, stages, access);

impl AntumbraImageState {
    fn state(&self) -> ImageState {
        ImageState { layout: self.layout, stages: self.stages, access: self.access }
    }
}

/// An image of the host that is drawn to: its first level and layer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraImage {
    /// The image.
    pub image: vk::Image,
    /// A 2D view of the image with all aspects of the format.
    pub view: vk::ImageView,
    /// The format of the view.
    pub format: vk::Format,
    /// The usage that the image was created with: `VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT` at
    /// least for a depth, `VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT` for a colour.
    /// `VK_IMAGE_USAGE_TRANSFER_SRC_BIT` of a depth image allows tests by compute shaders.
    pub usage: vk::ImageUsageFlags,
    /// The state before the first command of the executor.
    pub entry: AntumbraImageState,
    /// The state after the last command of the executor.
    pub exit: AntumbraImageState,
}
layout!(AntumbraImage: image, view, format, usage, entry, exit);

impl AntumbraImage {
    fn host_image(&self) -> HostImage {
        let Self { image, view, format, usage, entry, exit } = *self;
        let exit = (exit.layout != vk::ImageLayout::UNDEFINED).then(|| exit.state());
        HostImage { image, view, format, usage, entry: entry.state(), exit }
    }
}

/// The images of a view in a frame.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraTargetDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The number of colour images: the number of the scene's colour attachments, or 0 if the host
    /// begins its renderings itself. Default: 0.
    pub colour_count: u32,
    /// Required: the depth.
    pub depth: AntumbraImage,
    /// The colours. Default: null, with a `colour_count` of 0.
    pub colours: *const AntumbraImage,
    /// Required: width of all images (pixels). The library cannot check that the images are that
    /// large.
    pub width: u32,
    /// Required: height of all images (pixels), as the width.
    pub height: u32,
}
layout!(AntumbraTargetDesc: struct_size, colour_count, depth, colours, width, height);

versioned!(AntumbraTargetDesc: 6, required: [width, height], defaults: {});

/// The attachments that all views of a scene are drawn to.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraAttachments {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Required: the format of the depth.
    pub depth_format: vk::Format,
    /// Samples per pixel of all attachments. Default: `VK_SAMPLE_COUNT_1_BIT`.
    pub samples: vk::SampleCountFlags,
    /// The direction in which depths grow: an `ANTUMBRA_DEPTH_..`, the same as in cameras. Default:
    /// `ANTUMBRA_DEPTH_REVERSED`.
    pub depth: u32,
    /// The number of colour attachments, up to `ANTUMBRA_COLOURS_MAX`. Default: 0.
    pub colour_count: u32,
    /// The subpass of `render_pass` that is drawn in. Default: 0.
    pub subpass: u32,
    /// The formats of the colours, in the order of their locations. The first `colour_count` of
    /// them must be set. Default: `VK_FORMAT_UNDEFINED`, for the others.
    pub colour_formats: [vk::Format; ANTUMBRA_COLOURS_MAX],
    /// The render pass of a host that begins its renderings itself. Default: `VK_NULL_HANDLE`, for
    /// dynamic rendering.
    pub render_pass: vk::RenderPass,
}
layout!(AntumbraAttachments: struct_size, depth_format, samples, depth, colour_count, subpass,
    colour_formats, render_pass);

versioned!(AntumbraAttachments: 7,
    required: [depth_format],
    defaults: { samples: vk::SampleCountFlags::TYPE_1 }
);

impl AntumbraAttachments {
    /// Returns the attachments as the executor takes them.
    pub(crate) fn attachments(&self) -> Result<Attachments, Failure> {
        let colours = self.colour_formats.get(..self.colour_count as usize).ok_or_else(|| {
            let max = ANTUMBRA_COLOURS_MAX.min(COLOURS_MAX);
            Failure::argument(format_args!("attachments.colour_count is more than {max}"))
        })?;
        let has_pass = self.render_pass != vk::RenderPass::null();
        if !has_pass && self.subpass != 0 {
            let message = "attachments.subpass is set, and attachments.render_pass is null";
            return Err(Failure::argument(message));
        }
        Ok(Attachments {
            colours: ColourFormats::new(colours),
            depth: self.depth_format,
            samples: self.samples,
            near_depth: near_depth(self.depth)?,
            views: 1,
            pass: has_pass
                .then_some(HostPass { render_pass: self.render_pass, subpass: self.subpass }),
        })
    }
}

/// Returns the direction of depths by its number in C.
pub(crate) fn near_depth(depth: u32) -> Result<NearDepth, Failure> {
    match depth {
        ANTUMBRA_DEPTH_REVERSED => Ok(NearDepth::One),
        ANTUMBRA_DEPTH_STANDARD => Ok(NearDepth::Zero),
        _ => Err(Failure::argument(format_args!("there is no ANTUMBRA_DEPTH_.. {depth}"))),
    }
}

/// The target of a view, which is created again only if the host's images change.
#[derive(Default)]
pub(crate) struct CachedTarget {
    depth: Option<AntumbraImage>,
    colours: Vec<AntumbraImage>,
    size: [u32; 2],
    target: Option<Target>,
}

impl CachedTarget {
    /// Returns the target of the view at `place` of a frame.
    ///
    /// # Safety
    /// As [`Target::of_host`]; the colours are an array as the rules of the interface say.
    pub unsafe fn update(
        &mut self,
        place: ViewPlace,
        device: &Device,
        desc: &AntumbraTargetDesc,
        attachments: &Attachments,
    ) -> Result<&mut Target, Failure> {
        let name = format_args!("{place}.target.colours");
        // SAFETY: the caller's promise.
        let colours = unsafe { slice(name, desc.colours, desc.colour_count as usize) }?;
        let size = [desc.width, desc.height];
        if self.depth != Some(desc.depth) || self.colours != colours || self.size != size {
            check_images(place, desc, colours, attachments)?;
            self.target = None;
            self.colours.clear();
            self.colours.extend_from_slice(colours);
            (self.depth, self.size) = (Some(desc.depth), size);
        }
        if self.target.is_none() {
            let all: Vec<HostImage> = colours.iter().map(AntumbraImage::host_image).collect();
            let images = HostImages {
                depth: desc.depth.host_image(),
                colours: &all,
                samples: attachments.samples,
                near_depth: attachments.near_depth,
                views: attachments.views,
                size,
            };
            // SAFETY: the caller's promise.
            let target = unsafe { Target::of_host(device, &images) };
            self.target =
                Some(target.map_err(|error| {
                    Failure::from(error).within(format_args!("{place}.target"))
                })?);
        }
        self.target.as_mut().ok_or_else(|| Failure::argument("there is no target"))
    }
}

/// Refuses images that are null, or have other formats than the scene's attachments.
fn check_images(
    place: ViewPlace,
    desc: &AntumbraTargetDesc,
    colours: &[AntumbraImage],
    attachments: &Attachments,
) -> Result<(), Failure> {
    let wanted = attachments.colours.as_slice();
    let has_none = attachments.pass.is_some() && colours.is_empty();
    if !has_none && colours.len() != wanted.len() {
        return Err(Failure::argument(format_args!(
            "{place}.target.colour_count is {}, but the scene was made for {} colours",
            colours.len(),
            wanted.len()
        )));
    }
    check_image(format_args!("{place}.target.depth"), &desc.depth, attachments.depth)?;
    for (number, (colour, wanted)) in colours.iter().zip(wanted).enumerate() {
        check_image(format_args!("{place}.target.colours[{number}]"), colour, *wanted)?;
    }
    Ok(())
}

/// Refuses an image that is null, or has another format than `wanted`.
fn check_image(
    name: impl Display,
    image: &AntumbraImage,
    wanted: vk::Format,
) -> Result<(), Failure> {
    if image.image == vk::Image::null() {
        return Err(Failure::null(format_args!("{name}.image")));
    }
    if image.view == vk::ImageView::null() {
        return Err(Failure::null(format_args!("{name}.view")));
    }
    if image.format != wanted {
        return Err(Failure::argument(format_args!(
            "{name} has the format {:?}, but the scene was made for {wanted:?}",
            image.format
        )));
    }
    Ok(())
}
