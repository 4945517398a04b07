//! A host that records and submits its frames itself, with our culling in between. The calls of the
//! host itself do not fail.

use std::error::Error;

use cull::{CullView, Strategy};
use gpu::{Device, FrameRing, HostImage, HostImages, ImageState, NearDepth, Purpose, Target, vk};
use occlusion::{CulledScene, DrawRequest, OcclusionState};
use tests::every_call;
use tests::host_commands::{HostCommands, Runs};
use tests::host_device::Host;
use tests::host_images::{OwnBuffer, OwnImage};
use tests::host_walk::{boxes, camera};
use tests::numbered_boxes::{NumberedBoxes, TargetBoxes, scene_of_boxes};

use super::{Outcome, Program, SIZE, Stage, adopted};

const IN_FLIGHT: usize = 2;
pub(super) const COLOUR: vk::Format = vk::Format::R8G8B8A8_UNORM;
pub(super) const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

/// The images of a host, a copy of the colours for the CPU, and its command buffers.
pub(super) struct Own<'a> {
    pub(super) host: &'a Host,
    pub(super) colour: OwnImage,
    pub(super) depth: OwnImage,
    pub(super) copy: OwnBuffer,
    pub(super) commands: HostCommands<'a>,
}

impl Program {
    /// Draws in command buffers of a host, and returns the last image.
    pub(super) fn execute(&self, stage: &Stage) -> Outcome {
        let host = Host::new(stage.driver, Purpose::Executor);
        let mut own = Own::new(&host);
        let outcome = draw_on(&mut own);
        host.wait_idle();
        own.destroy();
        every_call::forget_devices();
        host.finish();
        outcome
    }
}

fn draw_on(own: &mut Own<'_>) -> Outcome {
    let device = adopted::adopt(own.host, None)?;
    let outcome = draw_frames(own, &device);
    let finished = own.host.say_finished(&device);
    let image = outcome?;
    finished?;
    Ok(image)
}

fn draw_frames(own: &mut Own<'_>, device: &Device) -> Outcome {
    let target = own.target(device)?;
    let attachments = target.attachments();
    let mut scene = scene_of_boxes(device, &boxes()[..200], attachments, None)?;
    let mut state = scene.new_view(&target)?;
    let boxes = NumberedBoxes::new(device, scene.leaves(), attachments)?;
    let mut objects = TargetBoxes { target, boxes };
    let mut ring = FrameRing::new(device, IN_FLIGHT)?;
    for number in 0..4 {
        let drawn =
            draw_frame(own, device, number, (&mut scene, &mut state), &mut ring, &mut objects);
        own.commands.end(if drawn.is_ok() { Runs::Once } else { Runs::Never })?;
        drawn?;
    }
    own.host.wait_idle();
    Ok(own.copy.bytes(own.host))
}

fn draw_frame(
    own: &mut Own<'_>,
    device: &Device,
    number: u64,
    shown: (&mut CulledScene, &mut OcclusionState),
    ring: &mut FrameRing,
    objects: &mut TargetBoxes,
) -> Result<(), Box<dyn Error>> {
    let begun = own.commands.begin();
    // SAFETY: the command buffer is being recorded; frames up to the safe one were waited for.
    let frame = unsafe { ring.begin_in(begun.0, begun.1) }?;
    let bits = device.adapter().limits.sub_pixel_precision_bits;
    let view = CullView::new(&camera(number), SIZE, bits);
    let request = DrawRequest { strategy: Strategy::ANTUMBRA, ..DrawRequest::from(&view) };
    let mut scope = shown.0.begin(frame)?;
    scope.draw(shown.1, request, objects)?;
    scope.end()?;
    own.colour.record_copy(own.host, begun.0, None, &own.copy);
    Ok(())
}

impl<'a> Own<'a> {
    pub(super) fn new(host: &'a Host) -> Self {
        use vk::ImageUsageFlags as U;
        let one = vk::SampleCountFlags::TYPE_1;
        let usage = U::COLOR_ATTACHMENT | U::TRANSFER_SRC | U::TRANSFER_DST;
        let colour = OwnImage::new(host, SIZE, COLOUR, one, usage);
        let usage = U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_SRC;
        let depth = OwnImage::new(host, SIZE, DEPTH, one, usage);
        let copy = OwnBuffer::new(host, u64::from(SIZE[0] * SIZE[1] * 4));
        Self { host, colour, depth, copy, commands: HostCommands::new(host, IN_FLIGHT) }
    }

    fn target(&self, device: &Device) -> Result<Target, gpu::Error> {
        use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};
        let image = |own: &OwnImage, exit| HostImage {
            image: own.image,
            view: own.view,
            format: own.format,
            usage: own.usage,
            entry: ImageState {
                layout: vk::ImageLayout::UNDEFINED,
                stages: S::ALL_COMMANDS,
                access: A::MEMORY_WRITE,
            },
            exit,
        };
        let copied = ImageState {
            layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
            stages: S::ALL_TRANSFER,
            access: A::TRANSFER_READ,
        };
        let images = HostImages {
            depth: image(&self.depth, None),
            colours: &[image(&self.colour, Some(copied))],
            samples: vk::SampleCountFlags::TYPE_1,
            near_depth: NearDepth::One,
            views: 1,
            size: SIZE,
        };
        // SAFETY: the images live until all frames are over, and have no other user in between.
        unsafe { Target::of_host(device, &images) }
    }

    pub(super) fn destroy(self) {
        self.commands.destroy();
        self.colour.destroy(self.host);
        self.depth.destroy(self.host);
        self.copy.destroy(self.host);
    }
}
