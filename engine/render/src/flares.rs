//! Lens flares ("Efficient Occlusion Culling", GPU Gems, 29.8). The visible share of a light is
//! counted without a wait, and decides about the brightness of its flare.
//!
//! ```text
//! block    a square of pixels at the light's place and depth, larger where it is nearer
//! count    its samples in the image, and those where the finished depth is not nearer
//! transmittance     what transparent objects in front let through at each of its pixels
//! history  the counts of the frame N frames ago, N being in flight: the brightness of this frame
//! sprites  the glow and the ghosts, added to the finished image
//! ```
//!
//! The counts are counts of the finished depth, which is the same under every exact strategy. A
//! frame uses the counts of exactly N frames ago, even if younger counts have arrived. So the image
//! depends neither on culling nor on the time that the GPU takes.

mod block;
mod counts;
mod history;
mod record;
mod sprites;

pub use block::FlareBlock;
pub(crate) use counts::FlareCounts;
pub use history::{FlareSamples, FlareState};
pub(crate) use record::record_flares;
