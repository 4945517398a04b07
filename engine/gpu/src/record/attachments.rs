//! The attachments that a graphics pipeline draws to: formats, samples, and the direction of depth.

use std::fmt;

use ash::vk;

use crate::core::device::Device;
use crate::core::error::Error;

/// The colour format: eight bits per channel, sRGB-encoded by the hardware.
pub(crate) const COLOUR_FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
/// The format of the colour's memory: the same bytes without encoding, so that they can be copied
/// unchanged to a window with any order of channels.
pub(crate) const COLOUR_BYTES: vk::Format = vk::Format::R8G8B8A8_UNORM;
/// The depth format: 32-bit float, reversed, so that the relative precision is the same at all
/// distances.
pub(crate) const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// The depth format with eight bits of stencil.
pub(crate) const DEPTH_AND_STENCIL_FORMAT: vk::Format = vk::Format::D32_SFLOAT_S8_UINT;

/// The depth value at the near plane. The far end of the range has the other value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NearDepth {
    /// 1 at the near plane (reversed depth): greater is nearer. The engine uses this.
    #[default]
    One,
    /// 0 at the near plane: less is nearer.
    Zero,
}

impl NearDepth {
    /// Returns the farthest depth, the value for clearing.
    pub fn far(self) -> f32 {
        match self {
            NearDepth::One => 0.0,
            NearDepth::Zero => 1.0,
        }
    }
}

/// The most colour attachments of a pipeline. Vulkan guarantees four; most devices have eight.
pub const COLOURS_MAX: usize = 8;

/// The formats of the colour attachments, in the order of their locations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ColourFormats {
    formats: [vk::Format; COLOURS_MAX],
    count: usize,
}

impl ColourFormats {
    /// Returns the first [`COLOURS_MAX`] of `formats`; an empty list for depth only.
    pub fn new(formats: &[vk::Format]) -> Self {
        let mut all = [vk::Format::UNDEFINED; COLOURS_MAX];
        let count = formats.len().min(COLOURS_MAX);
        all[..count].copy_from_slice(&formats[..count]);
        Self { formats: all, count }
    }

    /// Returns the formats.
    pub fn as_slice(&self) -> &[vk::Format] {
        &self.formats[..self.count]
    }
}

/// A render pass object of a host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HostPass {
    /// The render pass, or one that is compatible with it.
    pub render_pass: vk::RenderPass,
    /// The subpass to draw in.
    pub subpass: u32,
}

/// The attachments that pipelines are compiled for. The default is the attachments of a
/// [`Target`](crate::Target) of the engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attachments {
    /// The formats of the colours.
    pub colours: ColourFormats,
    /// The format of the depth, with or without stencil.
    pub depth: vk::Format,
    /// The number of samples per pixel of all attachments.
    pub samples: vk::SampleCountFlags,
    /// The depth value at the near plane.
    pub near_depth: NearDepth,
    /// The number of views that a rendering draws at once (multiview). Each view is drawn to the
    /// layer of its index, and the view mask has this number of lowest bits set. 1 for a plain
    /// rendering.
    pub views: u32,
    /// The render pass of a host that begins its renderings itself without dynamic rendering.
    pub pass: Option<HostPass>,
}

impl Default for Attachments {
    fn default() -> Self {
        Self {
            colours: ColourFormats::new(&[COLOUR_FORMAT]),
            depth: DEPTH_FORMAT,
            samples: vk::SampleCountFlags::TYPE_1,
            near_depth: NearDepth::One,
            views: 1,
            pass: None,
        }
    }
}

impl fmt::Display for Attachments {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { colours, depth, samples, near_depth, views, .. } = self;
        let colours = colours.as_slice();
        write!(formatter, "depth {depth:?}, near plane at {near_depth:?}, colours {colours:?}, ")?;
        write!(formatter, "samples {samples:?}, views {views}")
    }
}

/// Returns an error for a depth format without depth or a colour format without colours.
pub(crate) fn check_formats(depth: vk::Format, colours: &[vk::Format]) -> Result<(), Error> {
    let refuse = |what: String, format, needed| Err(Error::TargetFormat { what, format, needed });
    if !has_depth(depth) {
        let needed = "it takes one with depth, such as D32_SFLOAT or D24_UNORM_S8_UINT";
        return refuse("depth image".to_owned(), depth, needed);
    }
    let is_colour = |format: &vk::Format| {
        !has_depth(*format) && ![vk::Format::UNDEFINED, vk::Format::S8_UINT].contains(format)
    };
    match colours.iter().position(|format| !is_colour(format)) {
        None => Ok(()),
        Some(number) => {
            refuse(format!("colour image {number}"), colours[number], "it takes one of colours")
        }
    }
}

fn has_depth(format: vk::Format) -> bool {
    let plain = [vk::Format::D16_UNORM, vk::Format::X8_D24_UNORM_PACK32, vk::Format::D32_SFLOAT];
    plain.contains(&format) || has_stencil(format)
}

impl Attachments {
    /// Returns the stencil format; [`vk::Format::UNDEFINED`] without stencil.
    pub(crate) fn stencil(&self) -> vk::Format {
        if has_stencil(self.depth) { self.depth } else { vk::Format::UNDEFINED }
    }

    /// Returns the view mask for Vulkan: 0 for a plain rendering.
    pub(crate) fn view_mask(&self) -> u32 {
        match self.views {
            0 | 1 => 0,
            views => u32::MAX >> (u32::BITS - views.min(u32::BITS)),
        }
    }

    /// Returns an error for attachments that no pipeline of the device can draw to.
    pub(crate) fn check(&self, device: &Device) -> Result<(), Error> {
        check_formats(self.depth, self.colours.as_slice())?;
        if !device.has_format_feature(self.depth, vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT)
        {
            let what = "depth".to_owned();
            let needed = "this device cannot draw to it";
            return Err(Error::TargetFormat { what, format: self.depth, needed });
        }
        let limits = &device.adapter().limits;
        let supported = match self.colours.as_slice() {
            [] => limits.framebuffer_depth_sample_counts,
            _ => limits.framebuffer_depth_sample_counts & limits.framebuffer_color_sample_counts,
        };
        let samples = self.samples;
        if samples.as_raw().count_ones() == 1 && supported.contains(samples) {
            Ok(())
        } else {
            Err(Error::Samples { samples, supported })
        }
    }

    /// Returns true if pipelines for these attachments can draw to the attachments of a target, in
    /// any kind of rendering.
    pub fn fit(&self, target: &Self) -> bool {
        Self { pass: None, ..*self } == Self { pass: None, ..*target }
    }

    /// Returns true if depth is stored as integers, whose steps have the same size at all
    /// distances.
    pub(crate) fn has_integer_depth(&self) -> bool {
        !matches!(self.depth, vk::Format::D32_SFLOAT | vk::Format::D32_SFLOAT_S8_UINT)
    }
}

/// Returns true if a depth format includes a stencil.
pub(crate) fn has_stencil(format: vk::Format) -> bool {
    use vk::Format as F;
    matches!(format, F::D16_UNORM_S8_UINT | F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_keep_their_order_and_are_cut() {
        assert!(ColourFormats::new(&[]).as_slice().is_empty());
        let two = [vk::Format::R8_UNORM, vk::Format::R32_SFLOAT];
        assert_eq!(ColourFormats::new(&two).as_slice(), two);
        assert_eq!(ColourFormats::new(&[two[0]; 9]).as_slice().len(), COLOURS_MAX);
    }

    #[test]
    fn attachments_fit_whichever_pass_they_are_drawn_in() {
        let pass = HostPass { render_pass: vk::RenderPass::null(), subpass: 1 };
        let ours = Attachments::default();
        assert!(Attachments { pass: Some(pass), ..ours }.fit(&ours));
        let samples = vk::SampleCountFlags::TYPE_4;
        assert!(!ours.fit(&Attachments { samples, ..ours }));
        assert!(!ours.fit(&Attachments { near_depth: NearDepth::Zero, ..ours }));
        assert!(!ours.fit(&Attachments { views: 2, ..ours }));
        assert!(!ours.fit(&Attachments { colours: ColourFormats::new(&[]), ..ours }));
    }

    #[test]
    fn views_are_drawn_to_the_lowest_layers() {
        let mask = |views| Attachments { views, ..Attachments::default() }.view_mask();
        assert_eq!([0, 1, 2, 6, 32, 33].map(mask), [0, 0, 0b11, 0b11_1111, u32::MAX, u32::MAX]);
    }

    #[test]
    fn stencils_are_known() {
        let of = |depth| Attachments { depth, ..Attachments::default() }.stencil();
        assert_eq!(of(vk::Format::D24_UNORM_S8_UINT), vk::Format::D24_UNORM_S8_UINT);
        for depth in [vk::Format::D16_UNORM, vk::Format::X8_D24_UNORM_PACK32, DEPTH_FORMAT] {
            assert_eq!(of(depth), vk::Format::UNDEFINED);
        }
    }
}
