//! The selection of an object.

use antumbra::ObjectId;
use antumbra::cull::FrameId;

/// A search for the object at a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    pub(super) pixel: [u32; 2],
    /// The newest frame of the view when the search began: later frames answer it.
    pub(super) after: FrameId,
}

/// The selected object, and the pixel of the next selection.
#[derive(Debug, Default)]
pub struct Selection {
    /// The pixel to identify before the next frame.
    pub(super) pixel: Option<[u32; 2]>,
    /// The pending search.
    pub(super) search: Option<Search>,
    pub(super) object: Option<ObjectId>,
    /// True if the card must be logged when its results are read back.
    pub(super) is_new: bool,
}
