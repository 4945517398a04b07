//! The costs of tests and draws on a device: costs measured when a renderer is created, and the
//! times of frames, which correct them.

pub(crate) mod calibration;
pub(crate) mod device_costs;
pub(crate) mod frame_times;
pub(crate) mod sent_frames;
pub(crate) mod skipped_ranges;
