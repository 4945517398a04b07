//! The foundation of all other modules: instance, adapter, device, ticks, deletion, ownership of
//! handles.

pub(crate) mod adapter;
pub(crate) mod address_space;
pub(crate) mod cancellation;
pub(crate) mod capabilities;
pub(crate) mod clock;
pub(crate) mod debug_name;
pub(crate) mod deletion;
pub(crate) mod device;
pub(crate) mod device_shared;
pub(crate) mod error;
pub(crate) mod executions;
pub(crate) mod extensions;
pub(crate) mod features;
pub(crate) mod frames_in_flight;
pub(crate) mod host_callbacks;
pub(crate) mod host_device;
pub(crate) mod instance;
pub(crate) mod loss_report;
pub(crate) mod number_buffer;
pub(crate) mod offer;
pub(crate) mod open_device;
pub(crate) mod order;
pub(crate) mod ownership;
pub(crate) mod pending_uploads;
pub(crate) mod pipeline_cache;
pub(crate) mod queue_lock;
pub(crate) mod requirements;
pub(crate) mod tick;
pub(crate) mod timeline;
pub(crate) mod validation;
pub(crate) mod window_system;
#[cfg(all(feature = "loaded", feature = "window"))]
pub(crate) mod xcb;
