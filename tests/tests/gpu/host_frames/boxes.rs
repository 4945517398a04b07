//! The objects of a host: boxes, its images, and its render passes.
#![allow(unsafe_code, reason = "a host calls Vulkan itself")]

use ash::vk;
use cull::View;
use gpu::{
    Attachments, Commands, Device, HostImage, HostImages, HostPass, ImageState, NearDepth,
    RenderTarget, Target,
};
use occlusion::{BucketId, LeafTable, ObjectPass, ObjectRenderer, Rendering};
use tests::host_device::Host;
use tests::host_images::OwnImage;
use tests::numbered_boxes::NumberedBoxes;

use super::host::SIZE;

/// The objects of a host that draws boxes.
pub struct Boxes {
    pub target: Target,
    device: ash::Device,
    boxes: NumberedBoxes,
    pub passes: Option<[vk::RenderPass; 2]>,
    pub framebuffer: vk::Framebuffer,
}

impl ObjectRenderer for Boxes {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, _view: &View, rendering: Rendering) -> RenderTarget {
        self.target.render_target((rendering == Rendering::First).then_some([0.0, 0.0, 0.0, 1.0]))
    }

    fn begin_rendering(&mut self, commands: &Commands, view: &View, rendering: Rendering) -> bool {
        let Some(passes) = self.passes else {
            return commands.begin_rendering(self.rendering(view, rendering));
        };
        let clear = [
            vk::ClearValue { color: vk::ClearColorValue { float32: [0.0, 0.0, 0.0, 1.0] } },
            vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue::default() },
        ];
        let area = vk::Rect2D {
            extent: vk::Extent2D { width: SIZE[0], height: SIZE[1] },
            ..Default::default()
        };
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(passes[usize::from(rendering == Rendering::Next)])
            .framebuffer(self.framebuffer)
            .render_area(area)
            .clear_values(&clear);
        // SAFETY: the host's own objects, between the commands of the engine.
        unsafe {
            let inline = vk::SubpassContents::INLINE;
            self.device.cmd_begin_render_pass(commands.raw(), &info, inline);
        }
        commands.set_viewport(&self.viewport(view));
        true
    }

    fn end_rendering(&mut self, commands: &Commands) {
        match self.passes {
            None => commands.end_rendering(),
            // SAFETY: closes what was opened above.
            Some(_) => unsafe { self.device.cmd_end_render_pass(commands.raw()) },
        }
    }

    fn bind(&self, commands: &Commands, view: &View, _bucket: BucketId, _pass: ObjectPass) {
        self.boxes.bind(commands, view);
    }
}

impl Boxes {
    /// Returns the attachments of the host's renderings.
    pub fn attachments(&self) -> Attachments {
        let pass = self.passes.map(|[first, _]| HostPass { render_pass: first, subpass: 0 });
        Attachments { pass, ..self.target.attachments() }
    }

    /// Draws in render passes of the host from now on: one that clears, and one that keeps.
    pub fn take_passes(&mut self, host: &Host, device: &Device, [colour, depth]: [&OwnImage; 2]) {
        let samples = self.target.attachments().samples;
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
            .width(SIZE[0])
            .height(SIZE[1])
            .layers(1);
        // SAFETY: the views fit the pass.
        self.framebuffer = unsafe { host.device.create_framebuffer(&info, None) }.unwrap();
        self.passes = Some(passes);
        self.boxes.take_attachments(device, self.attachments());
    }
}

/// Returns the owner of the boxes, who draws to these images.
pub fn boxes_of(
    host: &Host,
    device: &Device,
    (colour, depth, samples, near_depth): (&OwnImage, &OwnImage, vk::SampleCountFlags, NearDepth),
    leaves: &LeafTable,
) -> Boxes {
    use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};
    let fresh = |own: &OwnImage, stages, access| HostImage {
        image: own.image,
        view: own.view,
        format: own.format,
        usage: own.usage,
        // What the frame before did with it.
        entry: ImageState { layout: vk::ImageLayout::UNDEFINED, stages, access },
        exit: None,
    };
    let copied = ImageState {
        layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
        stages: S::ALL_TRANSFER,
        access: A::TRANSFER_READ,
    };
    let writes = ImageState::depth_attachment();
    let drawn = S::COLOR_ATTACHMENT_OUTPUT | S::ALL_TRANSFER;
    let images = HostImages {
        depth: fresh(depth, writes.stages | S::ALL_TRANSFER, writes.access),
        colours: &[HostImage {
            exit: Some(copied),
            ..fresh(colour, drawn, A::COLOR_ATTACHMENT_WRITE)
        }],
        samples,
        near_depth,
        size: SIZE,
    };
    // SAFETY: the images live until all frames are over, and nothing else uses them in between.
    let target = unsafe { Target::of_host(device, &images) }.unwrap();
    Boxes {
        boxes: NumberedBoxes::new(device, leaves, target.attachments()),
        target,
        device: host.device.clone(),
        passes: None,
        framebuffer: vk::Framebuffer::null(),
    }
}
