//! The selection of an object.

use antumbra::ObjectId;
use antumbra::cull::FrameId;

/// A search for the object at a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    pub(super) pixel: [u32; 2],
    /// The newest frame of the view when it began: later ones answer.
    pub(super) after: FrameId,
}

/// The object that is selected, and the pixel for the next selection.
#[derive(Debug, Default)]
pub struct Selection {
    /// The pixel to identify before the next frame.
    pub(super) pixel: Option<[u32; 2]>,
    /// The search that is on its way.
    pub(super) search: Option<Search>,
    pub(super) object: Option<ObjectId>,
    /// True if the card is to be logged when its results are read back.
    pub(super) is_new: bool,
}
