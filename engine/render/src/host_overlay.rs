//! A host's commands over the finished image, for a user interface for example.

use gpu::{Commands, OverlayImage, Uploads};

use crate::error::Error;

/// The label of the pass.
pub(crate) const HOST_OVERLAY: &str = "host overlay";

/// A host's commands over finished images. A frame records them if its request has them
/// ([`FrameRequest::overlay`](crate::FrameRequest::overlay)).
///
/// They are recorded after everything that the renderer draws and after samples are averaged, and
/// before the image is copied or presented.
/// [`FrameRequest::scene_image`](crate::FrameRequest::scene_image) is copied before them. A frame
/// without an overlay has no command for it. An error of the overlay ends the frame without a
/// submit.
///
/// Requests borrow the overlay, so keep mutable state in a `Cell` or a `RefCell`.
pub trait HostOverlay {
    /// Uploads data for the commands into memory of the frame, right before they are recorded.
    ///
    /// # Errors
    /// No memory, or [`Error::Overlay`].
    fn upload(&self, uploads: &mut Uploads) -> Result<(), Error> {
        let _nothing = uploads;
        Ok(())
    }

    /// Records the commands outside of a rendering, by `commands` or by Vulkan's own functions into
    /// [`Commands::raw`]. They draw over `image`, which is in [`OverlayImage::state`] before and
    /// must be in it afterwards. Everything that they use must live until the frame is over.
    ///
    /// # Errors
    /// [`Error::Overlay`] of the host, or the errors of the engine's calls.
    fn record(&self, commands: &Commands, image: &OverlayImage) -> Result<(), Error>;

    /// Notes that the frame whose commands were recorded last was submitted. It is not called for a
    /// frame that failed.
    fn submitted(&self) {}
}
