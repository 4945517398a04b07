//! The executor on the device and in the frames of a host.

#[cfg(feature = "shader-compiler")]
mod bare_boxes;
#[cfg(feature = "shader-compiler")]
mod buckets;
mod host_device;
#[cfg(feature = "shader-compiler")]
mod host_frames;
mod host_overlay;
mod host_quirks;
#[cfg(feature = "shader-compiler")]
mod host_scenes;
