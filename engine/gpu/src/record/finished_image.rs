//! The image of a frame, for a host that uses it in its own commands.

use ash::vk;

use crate::core::tick::Tick;
use crate::record::host_image::ImageState;

/// The colour image of a target after its newest frame.
///
/// - On the queue that the engine submits to, commands that are submitted after the frame can use
///   the image after a barrier from [`FinishedImage::state`].
/// - On other queues they must first wait for [`FinishedImage::tick`] on
///   [`FinishedImage::timeline`]. Another queue family needs a transfer of ownership.
///
/// Before the next frame is rendered to the target, the image must be back in the same state: by a
/// barrier on the same queue, or by a [`Timeline`](crate::Timeline) that the next frame waits for.
/// The image belongs to the target: its uses must be over before the target is dropped or resized.
#[derive(Debug, Clone, Copy)]
pub struct FinishedImage {
    /// The image with eight bits per channel, which commands may sample and copy.
    pub image: vk::Image,
    /// A view of the image that decodes the colours.
    pub view: vk::ImageView,
    /// The format of the view. The memory of the image has the format without encoding,
    /// [`vk::Format::R8G8B8A8_UNORM`]; a host can also create a view with it.
    pub format: vk::Format,
    /// The size of the image in pixels.
    pub size: [u32; 2],
    /// The layout of the image after the frame, with the last stages and accesses.
    pub state: ImageState,
    /// The semaphore that counts the device's submits; it belongs to the device.
    pub timeline: vk::Semaphore,
    /// The tick at which the image is finished.
    pub tick: Tick,
}
