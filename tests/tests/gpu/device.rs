//! The GPU layer: attachments, query pools, frame loop, calibration.

mod attachments;
mod blocking_query_pool;
mod calibration;
mod frame_loop;
mod gpu_layer;
mod list_draws;
