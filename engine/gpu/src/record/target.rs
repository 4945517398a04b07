//! A target: the depth and the colours to draw to, created by the engine or by a host.

use ash::vk;

use crate::core::deletion::RecordingId;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::ownership::of_device;
use crate::core::tick::Tick;
use crate::memory::image::ImageFormats;
use crate::record::access::Access;
use crate::record::attachments::{
    Attachments, COLOUR_BYTES, COLOUR_FORMAT, COLOURS_MAX, ColourFormats, DEPTH_AND_STENCIL_FORMAT,
    DEPTH_FORMAT, check_formats,
};
use crate::record::commands::Commands;
use crate::record::finished_image::FinishedImage;
use crate::record::host_image::{HostImages, ImageState, check_usages};
use crate::record::multisampling::Multisampling;
use crate::record::render_target::{AttachmentStore, Load, RenderTarget};
use crate::record::sample_count::SampleCount;
use crate::record::target_image::TargetImage;

/// The usage of the finished image: it is shown and read, and a host may sample it.
const FINISHED_USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::COLOR_ATTACHMENT.as_raw()
        | vk::ImageUsageFlags::TRANSFER_SRC.as_raw()
        | vk::ImageUsageFlags::SAMPLED.as_raw(),
);

/// A depth image and colour images of one size: one colour of the engine, or the colours of a host.
pub struct Target {
    pub(super) device: Device,
    pub(super) colours: Vec<TargetImage>,
    pub(super) depth: TargetImage,
    pub(super) size: [u32; 2],
    pub(super) attachments: Attachments,
    /// The averages of the samples, if the engine's images have several samples per pixel.
    pub(super) multisampling: Option<Multisampling>,
    /// True if the depth can be copied to a buffer of floats.
    pub(super) can_copy_depth: bool,
    // The recording that uses the images. It may never be submitted, so the next recording must not
    // depend on the contents and layouts that it leaves.
    pub(super) recording: Option<RecordingId>,
    submitted: Option<Tick>,
}

of_device!(Target: "a target (`Target`)");

impl Target {
    /// Checks that a device supports targets with this size and number of samples.
    ///
    /// # Errors
    /// The errors of [`Target::multisampled`], except for missing memory.
    pub fn check(device: &Device, size: [u32; 2], samples: SampleCount) -> Result<(), Error> {
        check_size(device, size)?;
        if samples == SampleCount::One {
            return Ok(());
        }
        Attachments { samples: samples.flags(), ..Attachments::default() }.check(device)?;
        let supported = device.adapter().limits.sampled_image_depth_sample_counts;
        if supported.contains(samples.flags()) {
            Ok(())
        } else {
            Err(Error::Samples { samples: samples.flags(), supported })
        }
    }

    /// Creates a target of `size` pixels.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a side that is 0 or beyond the device's limits; no memory.
    pub fn new(device: &Device, size: [u32; 2], name: &str) -> Result<Self, Error> {
        Self::layered(device, size, 1, name)
    }

    /// Creates a target of `size` pixels for views that are drawn at once, each to its layer.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a side that is 0 or beyond the device's limits, and for more views
    /// than [`VIEWS_MAX`]; no memory.
    pub fn layered(device: &Device, size: [u32; 2], views: u32, name: &str) -> Result<Self, Error> {
        check_size(device, size)?;
        check_views(views)?;
        let depth_usage =
            vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let colour = vk::ImageAspectFlags::COLOR;
        let colour_formats = ImageFormats { memory: COLOUR_BYTES, view: COLOUR_FORMAT };
        let depth = vk::ImageAspectFlags::DEPTH;
        let image = |what, formats, usage, aspect| {
            let name = format!("{name} {what}");
            TargetImage::new(device, &name, size, views, formats, usage, aspect)
        };
        Ok(Self {
            device: device.clone(),
            colours: vec![image("colour", colour_formats, FINISHED_USAGE, colour)?],
            depth: image("depth", ImageFormats::same(DEPTH_FORMAT), depth_usage, depth)?,
            size,
            attachments: Attachments { views, ..Attachments::default() },
            multisampling: None,
            can_copy_depth: views == 1,
            recording: None,
            submitted: None,
        })
    }

    /// Creates a target of `size` pixels with a number of samples per pixel. Draws show in the
    /// finished image once the samples were [resolved](Target::resolve).
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a side that is 0 or beyond the device's limits; [`Error::Samples`]
    /// if the device cannot draw this number of samples or cannot read their depths; no memory.
    pub fn multisampled(
        device: &Device,
        size: [u32; 2],
        samples: SampleCount,
        name: &str,
    ) -> Result<Self, Error> {
        if samples == SampleCount::One {
            return Self::new(device, size, name);
        }
        Self::check(device, size, samples)?;
        let attachments = Attachments { samples: samples.flags(), ..Attachments::default() };
        let image = |what, format, usage, aspect| {
            let name = format!("{name} {what} samples");

            TargetImage::multisampled(device, &name, size, samples, format, usage, aspect)
        };
        // Samples are averaged at the end of a rendering, unless something is drawn over the
        // finished image.
        let colour_usage =
            vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSIENT_ATTACHMENT;
        let depth_usage =
            vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let colour = vk::ImageAspectFlags::COLOR;
        let depth = vk::ImageAspectFlags::DEPTH;

        Ok(Self {
            device: device.clone(),
            colours: vec![image("colour", COLOUR_FORMAT, colour_usage, colour)?],
            depth: image("depth", DEPTH_FORMAT, depth_usage, depth)?,
            size,
            attachments,
            multisampling: Some(Multisampling::new(device, size, samples, FINISHED_USAGE, name)?),
            can_copy_depth: true,
            recording: None,
            submitted: None,
        })
    }

    /// Creates a target like [`Target::multisampled`], with any number of samples, and with a
    /// stencil. The depth values are the same as without a stencil.
    ///
    /// # Errors
    /// The errors of [`Target::multisampled`]; [`Error::TargetFormat`] if the device cannot draw to
    /// 32-bit float depth with a stencil.
    pub fn with_stencil(
        device: &Device,
        size: [u32; 2],
        samples: SampleCount,
        name: &str,
    ) -> Result<Self, Error> {
        let target = Self::multisampled(device, size, samples, name)?;
        let attachments = Attachments { depth: DEPTH_AND_STENCIL_FORMAT, ..target.attachments };
        attachments.check(device)?;
        let name = format!("{name} depth and stencil");
        let aspect = vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL;
        let attached = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        let depth = match samples {
            SampleCount::One => {
                let usage = attached | vk::ImageUsageFlags::TRANSFER_SRC;
                let formats = ImageFormats::same(DEPTH_AND_STENCIL_FORMAT);
                TargetImage::new(device, &name, size, 1, formats, usage, aspect)?
            }
            _ => {
                let usage = attached | vk::ImageUsageFlags::SAMPLED;
                let format = DEPTH_AND_STENCIL_FORMAT;
                TargetImage::multisampled(device, &name, size, samples, format, usage, aspect)?
                    .with_depth_view(device, format)?
            }
        };
        Ok(Self { depth, attachments, ..target })
    }

    /// Returns true if the target has a stencil.
    pub fn has_stencil(&self) -> bool {
        self.attachments.stencil() != vk::Format::UNDEFINED
    }

    /// Creates a target from images of a host. No Vulkan object is created: make one target for
    /// each set of images that the host uses in turn, or a new one per frame.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a side that is 0 or beyond the device's limits, for more colours
    /// than [`COLOURS_MAX`] or more views than [`VIEWS_MAX`]; [`Error::TargetFormat`] for a depth
    /// image without depth, or a colour image that has depth or no format; [`Error::TargetUsage`]
    /// for an image that was not created as such an attachment.
    ///
    /// # Safety
    /// The images and views are of `device`, as described, and live until the last frame that uses
    /// the target is over. When the commands of a frame execute, each image is in its entry state,
    /// and no other commands use it until they are over.
    pub unsafe fn of_host(device: &Device, images: &HostImages<'_>) -> Result<Self, Error> {
        check_size(device, images.size)?;
        check_views(images.views)?;
        if images.colours.len() > COLOURS_MAX {
            return Err(Error::TooLarge {
                what: "the number of colour images of a target".to_owned(),
                wanted: images.colours.len() as u64,
                limit: COLOURS_MAX as u64,
            });
        }
        let mut formats = [vk::Format::UNDEFINED; COLOURS_MAX];
        for (format, image) in formats.iter_mut().zip(images.colours) {
            *format = image.format;
        }
        let formats = formats.get(..images.colours.len()).unwrap_or_default();
        check_formats(images.depth.format, formats)?;
        check_usages(images)?;
        let can_copy_depth = images.depth.format == DEPTH_FORMAT
            && images.samples == vk::SampleCountFlags::TYPE_1
            && images.views == 1
            && images.depth.usage.contains(vk::ImageUsageFlags::TRANSFER_SRC);
        let colour = |image| TargetImage::of_host(image, images.views, Access::Colour);
        Ok(Self {
            device: device.clone(),
            colours: images.colours.iter().map(colour).collect(),
            depth: TargetImage::of_host(&images.depth, images.views, Access::Depth),
            size: images.size,
            attachments: Attachments {
                colours: ColourFormats::new(formats),
                depth: images.depth.format,
                samples: images.samples,
                near_depth: images.near_depth,
                views: images.views,
                pass: None,
            },
            multisampling: None,
            can_copy_depth,
            recording: None,
            submitted: None,
        })
    }

    /// Returns the size in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the attachments that pipelines must be compiled for.
    pub fn attachments(&self) -> Attachments {
        self.attachments
    }

    /// Returns true if [`Target::copy_depth_to`] can copy. The depth of the engine's own targets
    /// can be copied with one view; the depth of a host must also be [`vk::Format::D32_SFLOAT`]
    /// with one sample and a transfer source.
    pub fn can_copy_depth(&self) -> bool {
        self.can_copy_depth
    }

    /// Returns the image that is shown and read: with several samples, the image of averages.
    fn finished_colour(&self) -> Option<&TargetImage> {
        match &self.multisampling {
            Some(multisampling) => Some(&multisampling.average),
            None => self.colours.first(),
        }
    }

    /// Returns the finished colour image and its last access.
    pub(crate) fn colour(&self) -> Option<(vk::Image, Access)> {
        self.finished_colour().map(|colour| (colour.raw, colour.access))
    }

    /// Returns true if draws show in the finished image only after [`Target::resolve`].
    pub fn needs_resolve(&self) -> bool {
        self.multisampling.as_ref().is_some_and(|multisampling| !multisampling.is_resolved)
    }

    /// Prepares all images to be drawn to, after any earlier access. This is also needed between
    /// two renderings, because dynamic rendering does not order them. The contents of the engine's
    /// own images are only valid within one frame: the first rendering must clear them. Commands of
    /// another device fail.
    pub fn prepare(&mut self, commands: &Commands) {
        if let Some(multisampling) = &mut self.multisampling {
            multisampling.is_resolved = false;
        }
        self.prepare_tests(commands);
    }

    /// Prepares all images like [`Target::prepare`], for a rendering that draws no colours.
    /// Averaged samples stay averaged and are not read again.
    pub fn prepare_tests(&mut self, commands: &Commands) {
        if commands.check_owner(self).is_err() {
            return;
        }
        self.submitted = None;
        let is_first = self.recording.replace(commands.recording()) != Some(commands.recording());
        let change = |image: &mut TargetImage, to| {
            if is_first {
                image.first_change(&[to, Access::CopyRead], to)
            } else {
                image.change(to)
            }
        };
        let depth = change(&mut self.depth, Access::Depth);
        let colours = self.colours.iter_mut().map(|image| change(image, Access::Colour));
        commands.change_layouts(std::iter::once(depth).chain(colours));
    }

    /// Changes the images of a host to the states that it expects. Must be the last use of the
    /// target in a frame.
    pub fn restore(&mut self, commands: &Commands) {
        if self.recording != Some(commands.recording()) || commands.check_owner(self).is_err() {
            return;
        }
        let images = std::iter::once(&mut self.depth).chain(&mut self.colours);
        commands.change_layouts(images.filter_map(TargetImage::last_change));
        self.recording = None;
    }

    /// Returns the images to draw to. With `clear` they start with this colour and the farthest
    /// depth, otherwise with their contents.
    pub fn render_target(&self, clear: Option<[f32; 4]>) -> RenderTarget {
        let far = self.attachments.near_depth.far();
        let mut colours = [vk::ImageView::null(); COLOURS_MAX];
        for (view, image) in colours.iter_mut().zip(&self.colours) {
            *view = image.view;
        }
        RenderTarget {
            device: self.device.id(),
            colours,
            colour_count: self.colours.len(),
            depth: self.depth.view,
            average: vk::ImageView::null(),
            has_stencil: self.has_stencil(),
            view_mask: self.attachments.view_mask(),
            origin: [0, 0],
            size: self.size,
            colour_load: clear.map_or(Load::Keep, Load::Clear),
            depth_load: clear.map_or(Load::Keep, |_| Load::Clear(far)),
            colour_store: AttachmentStore::Keep,
            depth_store: AttachmentStore::Keep,
        }
    }
}

impl Target {
    /// Notes that the last frame that drew was submitted, so that its image can be shown.
    pub fn submitted(&mut self) {
        self.submitted = self.recording.map(|_| self.device.submitted());
    }

    /// Returns true if a submitted frame draws an image.
    pub(crate) fn has_frame(&self) -> bool {
        self.submitted.is_some()
    }

    /// Returns the colour image of the newest frame, for a host that uses it in its own commands.
    ///
    /// # Errors
    /// [`Error::NoImage`] if there is no image, or none since a frame failed; [`Error::NoQueue`] on
    /// a device without a queue.
    pub fn finished(&self) -> Result<FinishedImage, Error> {
        let timeline = self.device.timeline_semaphore()?;
        let formats = self.attachments.colours.as_slice();
        let (Some(tick), Some(colour), [format, ..]) =
            (self.submitted, self.finished_colour(), formats)
        else {
            return Err(Error::NoImage);
        };
        Ok(FinishedImage {
            image: colour.raw,
            view: colour.view,
            format: *format,
            size: self.size,
            state: ImageState::during(colour.access),
            timeline,
            tick,
        })
    }
}

/// The most views that are drawn at once. Every device with multiview supports this number (the
/// least `maxMultiviewViewCount`).
pub const VIEWS_MAX: u32 = 6;

/// Returns an error for no views, or for more than every device with multiview supports.
fn check_views(views: u32) -> Result<(), Error> {
    if (1..=VIEWS_MAX).contains(&views) {
        Ok(())
    } else {
        Err(Error::TooLarge {
            what: "the number of views that are drawn at once".to_owned(),
            wanted: views.into(),
            limit: VIEWS_MAX.into(),
        })
    }
}

/// Returns an error for a side that is 0 or beyond the limits of the device.
pub(super) fn check_size(device: &Device, size: [u32; 2]) -> Result<(), Error> {
    let limits = &device.adapter().limits;
    let largest = limits
        .max_image_dimension2_d
        .min(limits.max_framebuffer_width)
        .min(limits.max_framebuffer_height)
        .min(limits.max_viewport_dimensions[0])
        .min(limits.max_viewport_dimensions[1]);
    for (side, what) in size.into_iter().zip(["the width of the image", "the height of the image"])
    {
        if side == 0 || side > largest {
            return Err(Error::TooLarge {
                what: what.to_owned(),
                wanted: side.into(),
                limit: largest.into(),
            });
        }
    }
    Ok(())
}
