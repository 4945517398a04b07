//! Render pass objects of a host with colour and depth: one that clears, and one that keeps the
//! contents.

use ash::vk;
use gpu::{Attachments, HostPass};

use crate::host_device::Host;
use crate::host_images::OwnImage;

/// The render passes of a host and their framebuffer. Destroyed by [`OwnPasses::destroy`].
pub struct OwnPasses {
    device: ash::Device,
    passes: [vk::RenderPass; 2],
    framebuffer: vk::Framebuffer,
    size: [u32; 2],
}

impl OwnPasses {
    /// Creates passes for images with this number of samples.
    pub fn new(
        host: &Host,
        colour: &OwnImage,
        depth: &OwnImage,
        samples: vk::SampleCountFlags,
        size: [u32; 2],
    ) -> Self {
        use vk::{AttachmentLoadOp as L, ImageLayout};
        let passes = [L::CLEAR, L::LOAD].map(|load| {
            let attachment = |format, layout| {
                vk::AttachmentDescription::default()
                    .format(format)
                    .samples(samples)
                    .load_op(load)
                    .store_op(vk::AttachmentStoreOp::STORE)
                    .initial_layout(layout)
                    .final_layout(layout)
            };
            let layouts = [
                ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
                ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
            ];
            let all = [attachment(colour.format, layouts[0]), attachment(depth.format, layouts[1])];
            let colours = [vk::AttachmentReference { attachment: 0, layout: layouts[0] }];
            let depth = vk::AttachmentReference { attachment: 1, layout: layouts[1] };
            let subpasses = [vk::SubpassDescription::default()
                .color_attachments(&colours)
                .depth_stencil_attachment(&depth)];
            let info = vk::RenderPassCreateInfo::default().attachments(&all).subpasses(&subpasses);
            // SAFETY: a plain render pass.
            unsafe { host.device.create_render_pass(&info, None) }.unwrap()
        });
        let views = [colour.view, depth.view];
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(passes[0])
            .attachments(&views)
            .width(size[0])
            .height(size[1])
            .layers(1);
        // SAFETY: the views fit the pass.
        let framebuffer = unsafe { host.device.create_framebuffer(&info, None) }.unwrap();
        Self { device: host.device.clone(), passes, framebuffer, size }
    }

    /// Returns these attachments with the passes as their render passes.
    pub fn attachments(&self, attachments: Attachments) -> Attachments {
        let pass = HostPass { render_pass: self.raw(), subpass: 0 };
        Attachments { pass: Some(pass), ..attachments }
    }

    /// Returns the pass that clears; pipelines of one fit the other.
    pub fn raw(&self) -> vk::RenderPass {
        self.passes[0]
    }

    /// Begins the pass that clears (to opaque black and depth 0), or the pass that keeps the
    /// contents.
    pub fn begin(&self, commands: vk::CommandBuffer, rendering: occlusion::Rendering) {
        let clear = [
            vk::ClearValue { color: vk::ClearColorValue { float32: [0.0, 0.0, 0.0, 1.0] } },
            vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue::default() },
        ];
        let [width, height] = self.size;
        let area = vk::Rect2D { extent: vk::Extent2D { width, height }, ..Default::default() };
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(self.passes[usize::from(rendering == occlusion::Rendering::Next)])
            .framebuffer(self.framebuffer)
            .render_area(area)
            .clear_values(&clear);
        // SAFETY: the host's own objects, in a command buffer that is being recorded.
        unsafe {
            self.device.cmd_begin_render_pass(commands, &info, vk::SubpassContents::INLINE);
        }
    }

    /// Ends the pass.
    pub fn end(&self, commands: vk::CommandBuffer) {
        // SAFETY: closes what was opened.
        unsafe { self.device.cmd_end_render_pass(commands) };
    }

    /// Destroys the passes. The GPU must not use them any more.
    pub fn destroy(self) {
        // SAFETY: created by this host, and no longer used, as the caller promises.
        unsafe {
            self.device.destroy_framebuffer(self.framebuffer, None);
            self.passes.iter().for_each(|pass| self.device.destroy_render_pass(*pass, None));
        }
    }
}
