//! The selection of an object.

use antumbra::cull::ObjectId;
use antumbra::render::Pick;

/// The object that is selected, and the pixel for the next selection.
#[derive(Debug, Default)]
pub struct Selection {
    /// The pixel to identify before the next frame.
    pub(super) pixel: Option<[u32; 2]>,
    /// The pending pick.
    pub(super) pick: Option<Pick>,
    pub(super) object: Option<ObjectId>,
    /// True if the card is to be logged when its results are read back.
    pub(super) is_new: bool,
}
