//! A thin Vulkan 1.3 executor: devices, memory, frames, passes, queries and predicates, without any
//! knowledge of scenes.
//!
//! All `unsafe` code of the engine is in this crate, except for the boundary to C. The types are
//! thin on purpose: each owns one Vulkan object, gives it a debug name and frees it when the GPU is
//! done with it. Decisions are left to the caller. Start reading here:
//!
//! - [`FrameRing`]: N frames in flight, and the waits of a frame loop.
//! - [`QueryRing`]: occlusion queries whose results are read back through mapped memory without a
//!   blocking call, each with the caller's tag.
//! - [`BlockingQueryPool`]: queries of a frame that is submitted in pieces, with results read
//!   between the pieces.
//! - [`Predicates`]: draws that the GPU skips, with conditional rendering or without.
//! - [`Swapchain`]: frames in a window, also while the window is resized, hidden or closed.
//! - [`Access`]: named accesses, from which all barriers of the engine are computed.
//!
//! A host with a device of its own creates the device from [`Requirements`] and lends it to the
//! engine ([`Device::adopt`]).
//!
//! [`Device`] and all objects made from it can be sent to other threads. Several threads at once
//! can use `Device`, [`Buffer`]s, [`Timeline`]s, [`Readback`]s, pipelines and [`TextureUploads`].
//! One frame is recorded by one thread.
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
//!     // waits for this frame slot's work of two frames ago, for nothing else
//!     let mut frame = frames.begin()?;
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

#![allow(unsafe_code, reason = "Vulkan is called here")]
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
// Some methods are only used for presenting.
#![cfg_attr(not(feature = "window"), allow(dead_code))]

mod api;
mod core;
mod memory;
#[cfg(feature = "window")]
mod present;
mod query;
mod record;

pub use crate::api::clocks::Clocks;
#[cfg(feature = "loaded")]
pub use crate::api::open::open;
#[cfg(all(feature = "loaded", feature = "window"))]
pub use crate::api::open::open_with_window;
pub use crate::core::adapter::Adapter;
pub use crate::core::cancellation::CancellationToken;
pub use crate::core::capabilities::{Capabilities, OptionalFeature, Purpose, RequiredFeature};
pub use crate::core::deletion::RecordingId;
pub use crate::core::device::{Device, WaitCounts};
pub use crate::core::error::Error;
pub use crate::core::features::{FeatureStructures, Features};
pub use crate::core::frames_in_flight::MAX_FRAMES_IN_FLIGHT;
pub use crate::core::host_device::{HostDevice, HostQueue};
#[cfg(feature = "loaded")]
pub use crate::core::instance::load_entry;
pub use crate::core::instance::{Instance, InstanceOptions, Validation};
pub use crate::core::loss_report::{DeviceFault, LossReport, UnfinishedFrame};
pub use crate::core::open_device::DeviceOptions;
pub use crate::core::ownership::{OfDevice, OwnerId};
pub use crate::core::queue_lock::HostQueueLock;
pub use crate::core::requirements::Requirements;
pub use crate::core::tick::Tick;
pub use crate::core::timeline::{Timeline, TimelineWait};
pub use crate::core::validation::{Message, ValidationLog};
pub use crate::core::window_system::WindowSystem;
pub use crate::memory::buffer::{Buffer, BufferSlice, MemoryKind};
pub use crate::memory::depth_layers::{DepthLayers, DepthTile};
pub use crate::memory::dynamic_texture::DynamicTexture;
pub use crate::memory::instance_numbers::NUMBER_LOCATION;
pub use crate::memory::memory_error::{MemoryError, MemoryFailure};
pub use crate::memory::memory_use::MemoryUse;
pub use crate::memory::readback::{Pixels, Readback};
pub use crate::memory::resample::resampled;
pub use crate::memory::sampled_texture::SampledTexture;
pub use crate::memory::texture_array::{MipGeneration, TextureArray, TextureArrayInfo};
pub use crate::memory::texture_set::TextureSet;
pub use crate::memory::texture_table::{TextureNumber, TextureTable};
pub use crate::memory::texture_uploads::TextureUploads;
pub use crate::memory::upload::Uploads;
pub use crate::memory::volume_texture::{VolumeTexels, VolumeTexture};
#[cfg(all(feature = "loaded", feature = "window"))]
pub use crate::present::display_link::DisplayLink;
#[cfg(feature = "window")]
pub use crate::present::present_mode::{Fallback, PresentMode};
#[cfg(feature = "window")]
pub use crate::present::surface::{Surface, Window};
#[cfg(feature = "window")]
pub use crate::present::swapchain::{
    Acquired, PresentId, PresentResult, PresentSkipped, PresentTiming, Presented, Swapchain,
    SwapchainOptions, WindowImage,
};
pub use crate::query::blocking_query_pool::BlockingQueryPool;
pub use crate::query::flag_ring::FlagRing;
pub use crate::query::leaf_draw_ring::{
    EnabledLeaves, LISTED_LEAVES, LeafDrawBuffers, LeafDrawRing, LeafDraws,
};
pub use crate::query::occlusion_pool::{Counting, QueryIndex};
pub use crate::query::predicates::{
    BOX_VERTICES, LINKED, Predicate, PredicatedRange, Predicates, PredicationMode, ResultSource,
    Reveal,
};
pub use crate::query::query_ring::QueryRing;
pub use crate::record::access::{Access, MemoryBarrier};
pub use crate::record::api::binding::SampledArrays;
pub use crate::record::api::textures::TextureRows;
pub use crate::record::attachments::{
    Attachments, COLOURS_MAX, ColourFormats, HostPass, NearDepth,
};
pub use crate::record::capture_pipeline::{CapturePipeline, CapturePipelineInfo};
pub use crate::record::commands::Commands;
pub use crate::record::finished_image::FinishedImage;
pub use crate::record::frames::{Frame, FrameNumbers, FrameRing, FrameRingId, SlotIndex};
pub use crate::record::host_image::{HostImage, HostImages, ImageState};
pub use crate::record::indirect::{DrawLink, DrawRange, IndirectDraw, UnindexedDraw};
pub use crate::record::overlay_image::OverlayImage;
pub use crate::record::pipeline::{
    Blend, ComputePipeline, DepthMode, DepthRange, FragmentChoice, GraphicsPipeline,
    GraphicsPipelineInfo, Polygon, StencilMode, StorageLayout, VertexLayout,
};
pub use crate::record::render_target::{AttachmentStore, Load, RenderTarget};
pub use crate::record::resubmission::Resubmission;
pub use crate::record::sample_count::SampleCount;
#[cfg(feature = "shader-compiler")]
pub use crate::record::shader::compile;
pub use crate::record::shader::{SpecializationConstant, Spirv};
pub use crate::record::stencil_target::StencilTarget;
pub use crate::record::target::{Target, VIEWS_MAX};
pub use crate::record::timing::{FrameTime, PassTime};
pub use crate::record::viewport::Viewport;
pub use ash::{self, Entry, vk};
#[cfg(feature = "window")]
pub use raw_window_handle;
