//! A thin Vulkan 1.3 executor: it knows devices, memory, frames, passes, queries and predicates, and no scene.
//!
//! All the `unsafe` of the engine lives here. The types are thin on purpose: they own one Vulkan
//! thing each, give it a debug name, free it when the GPU is done with it, and leave deciding to
//! the caller. What is worth reading first:
//!
//! - [`FrameRing`]: N frames in flight, the waits of a frame loop.
//! - [`QueryRing`]: occlusion queries whose answers come home through mapped memory, tagged with
//!   whatever the caller wants back, without a blocking call.
//! - [`QueryPages`]: queries of a frame that is sent off in pieces and reads its answers in between.
//! - [`Predicates`]: draws that the GPU skips by itself, with conditional rendering or without.
//! - [`Swapchain`]: pictures in a window, whatever becomes of the window.
//! - [`Access`]: named accesses, from which every barrier of the engine is computed.
//!
//! ```no_run
//! # use antumbra_gpu as gpu;
//! # fn main() -> Result<(), gpu::Error> {
//! # #[cfg(feature = "loaded")] {
//! let instance = gpu::Instance::new(gpu::load_entry()?, &gpu::InstanceOptions::default())?;
//! let adapter = instance.pick_adapter(None)?;
//! let device = gpu::Device::new(&instance, &adapter, &gpu::DeviceOptions::default())?;
//! let mut frames = gpu::FrameRing::new(&device, 2)?;
//! let mut queries = gpu::QueryRing::<&str>::new(&device, 2, "doc")?;
//! for _ in 0..8 {
//!     let mut frame = frames.begin()?; // waits for this slot's frame of two frames ago, for nothing else
//!     queries.collect(device.completed()?, |tag, samples| println!("{tag}: {samples} samples"));
//!     queries.begin(&mut frame, &["nothing drawn"])?;
//!     let commands = frame.commands();
//!     queries.scope(commands, gpu::QueryIndex(0), |_| {});
//!     queries.resolve(commands, 0..1);
//!     queries.read_back(commands);
//!     let tick = frame.submit(None)?;
//!     queries.submitted(tick);
//! }
//! # } Ok(()) }
//! ```

mod access;
mod adapter;
mod buffer;
mod capabilities;
mod clocks;
mod commands;
mod deletion;
mod device;
#[cfg(feature = "loaded")]
mod display_link;
mod error;
mod flag_ring;
mod frames;
mod image;
mod instance;
mod label;
#[cfg(feature = "loaded")]
mod open;
mod open_device;
mod ownership;
mod part_draws;
mod pipeline;
mod pipeline_cache;
mod predicates;
mod present_mode;
mod query_pages;
mod query_ring;
mod readback;
mod recorded;
mod resample;
mod shader;
mod surface;
mod swapchain;
mod target;
mod texture;
mod texture_array;
mod timeline;
mod timing;
mod transfer;
mod turns;
mod upload;
mod validation;
mod window_system;
#[cfg(feature = "loaded")]
mod xcb;

pub use access::{Access, LayoutChange, MemoryBarrier};
pub use adapter::Adapter;
pub use ash::{Entry, vk};
pub use buffer::{Buffer, BufferSlice, Place};
pub use capabilities::{Capabilities, Optional, Required};
pub use clocks::Clocks;
pub use commands::Commands;
pub use device::{Device, DeviceOptions, WaitCounts};
#[cfg(feature = "loaded")]
pub use display_link::DisplayLink;
pub use error::Error;
pub use flag_ring::FlagRing;
pub use frames::{Frame, FrameRing, SlotIndex};
#[cfg(feature = "loaded")]
pub use instance::load_entry;
pub use instance::{Instance, InstanceOptions, Validation};
#[cfg(feature = "loaded")]
pub use open::open;
pub use ownership::{OfDevice, OwnerId};
pub use part_draws::{LISTED_DRAWS, PartDraws, Parts, SwitchedOn};
pub use pipeline::{
    Blend, ComputePipeline, DepthMode, GraphicsPipeline, GraphicsPipelineInfo, Polygon,
    StorageLayout, VertexLayout,
};
pub use predicates::{
    BOX_VERTICES, DrawRange, IndirectDraw, Predicated, Predicates, Predication, Reveal, WordSource,
};
pub use present_mode::{Fallback, PresentMode};
pub use query_pages::{Counting, QueryPages};
pub use query_ring::{QueryIndex, QueryRing};
pub use raw_window_handle;
pub use readback::{Pixels, Readback};
pub use resample::resampled;
pub use shader::Spirv;
#[cfg(feature = "shader-compiler")]
pub use shader::compile;
pub use surface::{Surface, Window};
pub use swapchain::{
    Acquired, NotShown, PresentId, PresentTiming, Presented, Shown, Swapchain, SwapchainOptions,
    WindowImage,
};
pub use target::{COLOUR_FORMAT, DEPTH_FORMAT, Load, RenderTarget, Target};
pub use texture::Texture;
pub use texture_array::{MipMaking, TextureArray, TextureArrayInfo, TextureUploads};
pub use timeline::{Tick, Timeline};
pub use timing::{FrameTime, PassTime};
pub use upload::Uploads;
pub use validation::{Message, ValidationLog};
pub use window_system::WindowSystem;
