//! The images of a view of a host in C, and the renderings that the host begins itself.

use ash::vk;
use capi::executor::lists::ANTUMBRA_DRAWS_BY_LISTS;
use capi::executor::target::{AntumbraImage, AntumbraImageState};
use occlusion::Rendering;
use tests::host_device::Host;
use tests::host_images::{OwnBuffer, OwnImage};
use tests::host_passes::OwnPasses;
use tests::host_scene::RenderingOwner;

use super::{FrameOptions, SIZE};

/// The format of the colours.
pub const COLOUR: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Colour and depth. Destroyed by [`ViewImages::destroy`].
pub struct ViewImages {
    colour: OwnImage,
    depth: OwnImage,
    resolved: Option<OwnImage>,
    /// The host's render passes, if it begins its renderings.
    pub passes: Option<OwnPasses>,
}

impl ViewImages {
    pub fn new(host: &Host, options: &FrameOptions) -> Self {
        use vk::ImageUsageFlags as U;
        let samples = options.samples;
        let one = vk::SampleCountFlags::TYPE_1;
        let usage = U::COLOR_ATTACHMENT | U::TRANSFER_SRC | U::TRANSFER_DST;
        let colour = OwnImage::new(host, SIZE, COLOUR, samples, usage);
        let resolved = (samples != one).then(|| OwnImage::new(host, SIZE, COLOUR, one, usage));
        let sampled = if samples == one { U::TRANSFER_SRC } else { U::empty() };
        let usage = U::DEPTH_STENCIL_ATTACHMENT | sampled;
        let depth = OwnImage::new(host, SIZE, options.depth, samples, usage);
        let passes = (options.renderings == RenderingOwner::Host)
            .then(|| OwnPasses::new(host, &colour, &depth, samples, SIZE));
        Self { colour, depth, resolved, passes }
    }

    /// Returns colour and depth in C. On entry they are fresh or contain draws of the host; on exit
    /// the colour is copied or drawn to.
    pub fn described(&self, draws: u32) -> [AntumbraImage; 2] {
        use vk::ImageLayout as L;
        let any = |layout| AntumbraImageState {
            layout,
            reserved: 0,
            stages: vk::PipelineStageFlags2::ALL_COMMANDS,
            access: vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE,
        };
        let copied = AntumbraImageState {
            layout: L::TRANSFER_SRC_OPTIMAL,
            reserved: 0,
            stages: vk::PipelineStageFlags2::ALL_TRANSFER,
            access: vk::AccessFlags2::TRANSFER_READ,
        };
        let (colour, depth) = match draws {
            ANTUMBRA_DRAWS_BY_LISTS => {
                let depth = any(L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
                ([any(L::COLOR_ATTACHMENT_OPTIMAL); 2], [depth; 2])
            }
            _ => ([any(L::UNDEFINED), copied], [any(L::UNDEFINED); 2]),
        };
        [(&self.colour, colour), (&self.depth, depth)].map(|(own, [entry, exit])| AntumbraImage {
            image: own.image,
            view: own.view,
            format: own.format,
            usage: own.usage,
            entry,
            exit,
        })
    }

    /// Changes both images from any layout to attachments.
    pub fn prepare(&self, host: &Host, commands: vk::CommandBuffer) {
        use vk::ImageLayout as L;
        self.change(host, commands, &self.colour, L::UNDEFINED, L::COLOR_ATTACHMENT_OPTIMAL);
        let attached = L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        self.change(host, commands, &self.depth, L::UNDEFINED, attached);
    }

    /// Changes the colour from an attachment to a transfer source.
    pub fn restore(&self, host: &Host, commands: vk::CommandBuffer) {
        use vk::ImageLayout as L;
        let layouts = [L::COLOR_ATTACHMENT_OPTIMAL, L::TRANSFER_SRC_OPTIMAL];
        self.change(host, commands, &self.colour, layouts[0], layouts[1]);
    }

    /// Begins a rendering, by a render pass of the host if it has one, otherwise by dynamic
    /// rendering.
    pub fn begin(&self, host: &Host, commands: vk::CommandBuffer, rendering: Rendering) {
        if let Some(passes) = &self.passes {
            return passes.begin(commands, rendering);
        }
        let load = match rendering {
            Rendering::First => vk::AttachmentLoadOp::CLEAR,
            Rendering::Next => vk::AttachmentLoadOp::LOAD,
        };
        let attachment = |own: &OwnImage, image_layout| {
            vk::RenderingAttachmentInfo::default()
                .image_view(own.view)
                .image_layout(image_layout)
                .load_op(load)
                .store_op(vk::AttachmentStoreOp::STORE)
        };
        use vk::ImageLayout as L;
        let colours = [attachment(&self.colour, L::COLOR_ATTACHMENT_OPTIMAL)];
        let depth = attachment(&self.depth, L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
        let mut info = vk::RenderingInfo::default()
            .render_area(area())
            .layer_count(1)
            .color_attachments(&colours)
            .depth_attachment(&depth);
        if has_stencil(self.depth.format) {
            info = info.stencil_attachment(&depth);
        }
        // SAFETY: the host's own images, in these layouts.
        unsafe { host.device.cmd_begin_rendering(commands, &info) };
    }

    /// Ends the rendering.
    pub fn end(&self, host: &Host, commands: vk::CommandBuffer) {
        match &self.passes {
            Some(passes) => passes.end(commands),
            // SAFETY: the rendering was begun.
            None => unsafe { host.device.cmd_end_rendering(commands) },
        }
    }

    /// Records the copy of the colour.
    pub fn copy(&self, host: &Host, commands: vk::CommandBuffer, to: &OwnBuffer) {
        self.colour.record_copy(host, commands, self.resolved.as_ref(), to);
    }

    /// Destroys the images. The GPU must not use them any more.
    pub fn destroy(self, host: &Host) {
        self.passes.into_iter().for_each(OwnPasses::destroy);
        [self.colour, self.depth]
            .into_iter()
            .chain(self.resolved)
            .for_each(|image| image.destroy(host));
    }

    fn change(
        &self,
        host: &Host,
        commands: vk::CommandBuffer,
        image: &OwnImage,
        old: vk::ImageLayout,
        new: vk::ImageLayout,
    ) {
        let aspect_mask = match image.format {
            COLOUR => vk::ImageAspectFlags::COLOR,
            depth if has_stencil(depth) => {
                vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL
            }
            _ => vk::ImageAspectFlags::DEPTH,
        };
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let access = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
        let barriers = [vk::ImageMemoryBarrier2::default()
            .image(image.image)
            .old_layout(old)
            .new_layout(new)
            .src_stage_mask(all)
            .src_access_mask(access)
            .dst_stage_mask(all)
            .dst_access_mask(access)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask,
                level_count: 1,
                layer_count: 1,
                ..Default::default()
            })];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the host's own image, in a command buffer that is being recorded.
        unsafe { host.device.cmd_pipeline_barrier2(commands, &info) };
    }
}

/// Returns the whole of the images.
pub fn area() -> vk::Rect2D {
    let [width, height] = SIZE;
    vk::Rect2D { extent: vk::Extent2D { width, height }, ..Default::default() }
}

/// Returns true for a depth with a stencil.
pub fn has_stencil(format: vk::Format) -> bool {
    matches!(format, vk::Format::D24_UNORM_S8_UINT | vk::Format::D32_SFLOAT_S8_UINT)
}
