//! Recording: commands, pipelines, barriers, targets, frames and their times.

pub(crate) mod access;
pub(crate) mod api;
pub(crate) mod attachments;
pub(crate) mod commands;
pub(crate) mod finished_image;
pub(crate) mod frame_slot;
pub(crate) mod frame_stamps;
pub(crate) mod frames;
pub(crate) mod graphics_state;
pub(crate) mod host_image;
pub(crate) mod indirect;
pub(crate) mod label;
pub(crate) mod multisampling;
pub(crate) mod overlay_image;
pub(crate) mod pipeline;
pub(crate) mod pools;
pub(crate) mod render_target;
pub(crate) mod resubmission;
pub(crate) mod sample_count;
pub(crate) mod shader;
pub(crate) mod stencil_target;
pub(crate) mod target;
pub(crate) mod target_image;
pub(crate) mod ticket;
pub(crate) mod timing;
pub(crate) mod viewport;
