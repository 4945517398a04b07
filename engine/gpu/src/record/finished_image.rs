//! The image of a frame, for a host that reads it by commands of its own.

use ash::vk;

use crate::core::tick::Tick;
use crate::record::host_image::ImageState;

/// The colour image of a target, as its newest frame leaves it.
///
/// - On the queue that the engine submits to, commands that are submitted after the frame use the
///   image behind a barrier from [`FinishedImage::state`].
/// - Elsewhere they wait for [`FinishedImage::tick`] on [`FinishedImage::timeline`] before. Another
///   queue family gets the contents by a transfer of ownership.
///
/// Before the next frame is rendered to the target, the image is to be given back: in the same
/// state, by a barrier on the same queue; or by a [`Timeline`](crate::Timeline) that the next frame
/// waits for. It is the target's: what uses it is over before the target is dropped or gets another
/// size.
#[derive(Debug, Clone, Copy)]
pub struct FinishedImage {
    /// The image: eight bits per channel, which commands may sample and copy.
    pub image: vk::Image,
    /// A view of it that decodes the colours.
    pub view: vk::ImageView,
    /// The format of the view. The memory of the image has its twin without encoding,
    /// [`vk::Format::R8G8B8A8_UNORM`], of which a host can make a view too.
    pub format: vk::Format,
    /// Its size in pixels.
    pub size: [u32; 2],
    /// The layout that the frame leaves it in, with the stages and accesses that came last.
    pub state: ImageState,
    /// The semaphore that counts the device's submits; it is the device's.
    pub timeline: vk::Semaphore,
    /// The tick at which the image is finished.
    pub tick: Tick,
}
