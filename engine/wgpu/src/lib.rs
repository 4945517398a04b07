//! Exact occlusion culling for programs that draw by [wgpu], on wgpu's own Vulkan device.
//!
//! The program keeps its device, its textures, pipelines, render passes and submits. It gives boxes
//! and indexed indirect draws, and gets two lists of draws per frame: what is taken as visible, and
//! what tests on the GPU reveal. The image is the same as without culling, to the bit, if the
//! vertex shader moves its vertices to the grid of [`cull::CullView::snap_steps`].
//!
//! ```no_run
//! use antumbra_wgpu::{Error, WgpuCulling, WgpuDevice, WgpuTarget};
//! use antumbra_wgpu::{cull::DepthConvention, glam::Mat4, occlusion::*};
//!
//! # fn draw(
//! #     adapter: &wgpu::Adapter, depth: &wgpu::Texture, objects: &[HostObject<'_>], matrix: Mat4,
//! #     pipelines: &[wgpu::RenderPipeline],
//! #     pass: impl Fn(&mut dyn FnMut(&mut wgpu::RenderPass<'_>)) -> wgpu::CommandBuffer,
//! # ) -> Result<(), Error> {
//! // Once. The device takes the place of `Adapter::request_device`.
//! let gpu = WgpuDevice::open(adapter, &wgpu::DeviceDescriptor::default())?;
//! # let depth = &gpu.device.create_texture(&depth_descriptor());
//! let mut target = WgpuTarget::new(&gpu, depth, DepthConvention::Reversed)?;
//! let mut culling = WgpuCulling::new(&gpu, &target, &CulledSceneOptions::default())?;
//! let mut view = culling.new_view(&target)?;
//! culling.scene.add(objects, &mut Vec::new()).map_err(Error::Occlusion)?;
//!
//! // Per frame: `pass` encodes a render pass and calls back to draw in it.
//! let frame = culling.encode(&mut view, &mut target, &target.view(matrix)?)?;
//! # Ok(())
//! # }
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
