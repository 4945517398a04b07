//! Exact occlusion culling for programs that draw by [wgpu], on wgpu's own Vulkan device.
//!
//! The program keeps its textures, pipelines, render passes and submits. It gives a box and indexed
//! draws per object, and gets two lists of draws per frame: what is taken as visible, and what
//! tests on the GPU reveal. The library knows by itself which frames are over.
//!
//! ```no_run
//! use antumbra_wgpu::cull::DepthConvention;
//! use antumbra_wgpu::{WgpuCulling, WgpuDevice, WgpuTarget};
//!
//! # use antumbra_wgpu::{WgpuDraws, glam::Mat4, occlusion::{CulledSceneOptions, HostObject}};
//! # type Pass = Box<dyn Fn(&[WgpuDraws]) -> wgpu::CommandBuffer>;
//! # fn run(
//! #     adapter: wgpu::Adapter, device: wgpu::DeviceDescriptor<'_>, objects: &[HostObject<'_>],
//! #     options: CulledSceneOptions<'_>, depth: &dyn Fn(&wgpu::Device) -> wgpu::Texture,
//! #     clearing: Pass, loading: Pass, matrices: Vec<Mat4>,
//! # ) -> Result<(), Box<dyn std::error::Error>> {
//! // Once; the first line takes the place of `Adapter::request_device`.
//! let gpu = WgpuDevice::open(&adapter, &device)?;
//! # let depth = depth(&gpu.device);
//! let mut target = WgpuTarget::new(&gpu, &depth, DepthConvention::Reversed)?;
//! let mut culling = WgpuCulling::new(&gpu, &target, &options)?;
//! let mut view = culling.new_view(&target)?;
//! culling.scene.add(objects, &mut Vec::new())?;
//!
//! // In each frame.
//! # for matrix in matrices {
//! let camera = target.view(matrix)?;
//! let frame = culling.encode(&mut view, &mut target, &camera)?;
//! let first = clearing(frame.visible());
//! let second = loading(frame.revealed());
//! frame.submit(&gpu.queue, [first], [second]);
//! # }
//! # Ok(())
//! # }
//! ```
//!
//! `clearing` and `loading` are the program's: both encode its render pass, of which the first
//! clears colours and depth, and the second loads them. In the pass stands, in place of the loop
//! over objects:
//!
//! ```no_run
//! # fn draw(
//! #     lists: &[antumbra_wgpu::WgpuDraws], pipelines: &[wgpu::RenderPipeline],
//! #     mut pass: wgpu::RenderPass<'_>,
//! # ) {
//! for list in lists {
//!     pass.set_pipeline(&pipelines[list.bucket.0 as usize]);
//!     // SAFETY: the draws lie within the buffers that are set; the pass is submitted as above.
//!     unsafe { list.draw(&mut pass) };
//! }
//! # }
//! ```
//!
//! # What makes the image exact
//! The image is the same as without culling, to the bit, if
//!
//! - objects do not move out of their boxes, and `matrix` is the one that the shaders use;
//! - the depth test is `Greater` or `GreaterEqual` for reversed depth, and `Less` or `LessEqual`
//!   otherwise, and opaque objects write depth;
//! - the vertex shader moves vertices to the grid of [`cull::CullView::snap_steps`], as
//!   `shaders/snap.glsl` of the engine does. Some rasterisers, such as llvmpipe, snap coverage
//!   but not depth.
//!
//! # The instance
//! Create it for [`wgpu::Backends::VULKAN`] and without
//! [`wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL`]:
//!
//! ```
//! let mut instance = wgpu::InstanceDescriptor::new_without_display_handle();
//! instance.backends = wgpu::Backends::VULKAN;
//! instance.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![allow(unsafe_code, reason = "raw handles of wgpu are given to the engine")]

mod culling;
mod device;
mod error;
mod frame;
mod frame_log;
mod target;

pub use culling::WgpuCulling;
pub use device::{WAIT_BOUND, WgpuDevice};
pub use error::Error;
pub use frame::{WgpuDraws, WgpuFrame};
pub use target::WgpuTarget;

pub use {cull, glam, gpu, occlusion, wgpu};
