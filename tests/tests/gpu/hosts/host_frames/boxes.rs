//! The objects of a host: boxes, its images, and its render passes.
#![allow(unsafe_code, reason = "a host calls Vulkan itself")]

use ash::vk;
use cull::CullView;
use gpu::{
    Commands, Device, HostImage, HostImages, ImageState, NearDepth, RenderTarget, Target, Viewport,
};
use occlusion::{BucketId, ObjectRenderer, Rendering};
use tests::host_images::OwnImage;
use tests::host_passes::OwnPasses;
use tests::numbered_boxes::NumberedBoxes;

use super::host::SIZE;

/// The objects of a host that draws boxes.
pub struct Boxes {
    pub target: Target,
    pub boxes: NumberedBoxes,
    pub passes: Option<OwnPasses>,
}

impl ObjectRenderer for Boxes {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, _view: &CullView, rendering: Rendering) -> RenderTarget {
        self.target.render_target((rendering == Rendering::First).then_some([0.0, 0.0, 0.0, 1.0]))
    }

    fn begin_rendering(
        &mut self,
        commands: &Commands,
        view: &CullView,
        rendering: Rendering,
    ) -> bool {
        let Some(passes) = &self.passes else {
            return commands.begin_rendering(self.rendering(view, rendering));
        };
        passes.begin(commands.raw(), rendering);
        commands.set_viewport(&Viewport::covering(view.origin, view.size));
        true
    }

    fn end_rendering(&mut self, commands: &Commands) {
        match &self.passes {
            None => commands.end_rendering(),
            Some(passes) => passes.end(commands.raw()),
        }
    }

    fn bind(&self, commands: &Commands, view: &CullView, _bucket: BucketId) {
        self.boxes.bind(commands, view);
    }
}

/// Returns the target over these images.
pub fn target_of(
    device: &Device,
    colour: &OwnImage,
    depth: &OwnImage,
    samples: vk::SampleCountFlags,
    near_depth: NearDepth,
) -> Target {
    use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};
    let fresh = |own: &OwnImage, stages, access| HostImage {
        image: own.image,
        view: own.view,
        format: own.format,
        usage: own.usage,
        // The use of the image by the previous frame.
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
        views: 1,
        size: SIZE,
    };
    // SAFETY: the images live until all frames are over, and have no other user in between.
    unsafe { Target::of_host(device, &images) }.unwrap()
}
