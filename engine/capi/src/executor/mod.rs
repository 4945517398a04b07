//! The executor in a host's command buffer: the host keeps its device, queue, images, pipelines and
//! draws.

pub mod device;
pub mod frame;
pub mod lists;
pub mod prices;
pub mod queue;
pub mod scene;
pub mod target;
pub mod trust;
