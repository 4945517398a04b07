//! The costs of tests and draws on a device: measured when a renderer is created, and corrected by
//! the times of frames.

pub(crate) mod box_bench;
pub(crate) mod calibration;
pub(crate) mod device_costs;
pub(crate) mod frame_times;
pub(crate) mod sent_frames;
pub(crate) mod skipped_ranges;
