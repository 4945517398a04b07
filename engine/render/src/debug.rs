//! Insight into the renderer: overlays, snapshots, and answers about what is visible.

pub(crate) mod debug_overlay;
pub(crate) mod depth_complexity;
pub(crate) mod outline;
pub mod palette;
pub(crate) mod pointer;
pub(crate) mod sample_counts;
pub(crate) mod settled_counts;
pub(crate) mod top_down;
pub(crate) mod visibility_snapshot;
pub(crate) mod visible_set;
