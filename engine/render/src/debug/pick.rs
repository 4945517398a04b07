//! Finds the object that owns a pixel, without a wait: a frame of that one pixel is drawn, and read
//! when it is over.

use cull::{LeafIndex, ObjectId};
use gpu::Tick;

use crate::view_state::RendererId;

/// A pick that is on its way to the GPU. A newer one replaces it.
#[derive(Debug, Clone)]
pub struct Pick {
    /// The tick of its result; `None` if the boxes must do.
    pub(crate) tick: Option<Tick>,
    /// Leaves whose boxes the ray of the pixel meets, nearest first, and their objects.
    pub(crate) candidates: Vec<(LeafIndex, ObjectId)>,
    /// The renderer of the pick.
    pub(crate) renderer: RendererId,
}
