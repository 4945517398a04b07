//! The selection of an object.

use antumbra::ObjectId;
use antumbra::cull::FrameId;

/// The object that is selected, and the pixel for the next selection.
#[derive(Debug, Default)]
pub struct Selection {
    /// The pixel to identify before the next frame.
    pub(super) pixel: Option<[u32; 2]>,
    /// The newest frame when the pointer began to look for it.
    pub(super) asked_after: Option<FrameId>,
    pub(super) object: Option<ObjectId>,
    /// True if the card is to be logged when its results are read back.
    pub(super) is_new: bool,
}
