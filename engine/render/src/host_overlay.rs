//! The place in a frame where a host draws over the finished image, as user interfaces do.

use gpu::{Commands, OverlayImage, Uploads};

use crate::error::Error;

/// The label of the pass.
pub(crate) const HOST_OVERLAY: &str = "host overlay";

/// A host's commands over finished images, of a frame that is requested with it
/// ([`FrameRequest::overlay`](crate::FrameRequest::overlay)).
///
/// They are recorded behind everything that the renderer draws and behind the average of samples,
/// and before the image is copied or presented.
/// [`FrameRequest::scene_image`](crate::FrameRequest::scene_image) is copied before. A frame
/// without an overlay has no command for it. A failure ends the frame: it is not submitted.
///
/// Requests share it, so what it changes is in a `Cell` or a `RefCell` of its own.
pub trait HostOverlay {
    /// Uploads what the commands read into memory of the frame, right before they are recorded.
    ///
    /// # Errors
    /// No memory, or [`Error::Overlay`].
    fn upload(&self, uploads: &mut Uploads) -> Result<(), Error> {
        let _nothing = uploads;
        Ok(())
    }

    /// Records the commands, outside of a rendering, by those of `commands` or by Vulkan's own
    /// into [`Commands::raw`]. They draw over `image`, find it in [`OverlayImage::state`] and leave
    /// it there. What they use lives until the frame is over.
    ///
    /// # Errors
    /// [`Error::Overlay`] of the host, or those of the engine's calls.
    fn record(&self, commands: &Commands, image: &OverlayImage) -> Result<(), Error>;

    /// Notes that the frame whose commands were recorded last was submitted. A frame that failed
    /// never is.
    fn submitted(&self) {}
}
