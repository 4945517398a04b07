//! A Vulkan engine that draws only what can be seen, never waits for the GPU to find out, and never
//! shows a wrong pixel.
//!
//! This crate is the one that programs depend on: the crates of the engine under their short names,
//! and at its root the items that every program needs.
//!
//! ```no_run
//! use antumbra::scene::{Mesh, Scene};
//! use antumbra::{Camera, FrameRequest, Readback, Renderer, Strategy};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let device = antumbra::open()?;
//! let red = [0.8, 0.1, 0.1];
//! let corners = [([-1.0, -1.0, 0.0], red), ([1.0, -1.0, 0.0], red), ([0.0, 1.0, 0.0], red)];
//! let scene = Scene::single(Mesh::of_triangles("triangle", &corners));
//! let mut renderer = Renderer::new(&device, &scene, &Default::default())?;
//! let mut view = renderer.new_view()?;
//! let image = Readback::new(&device, renderer.size())?;
//!
//! let camera = Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]);
//! let request = FrameRequest::new(Strategy::ANTUMBRA, camera);
//! renderer.render(&mut view, &FrameRequest { image: Some(&image), ..request })?;
//! renderer.wait_idle(&mut view)?;
//! println!("{} bytes of RGBA", image.rgba8()?.len());
//! # Ok(()) }
//! ```
//!
//! | module | contents |
//! |---|---|
//! | [`scene`] | meshes, materials, objects, lights, and their changes |
//! | [`render`] | the renderer: frames, views, updates, their explanations |
//! | [`occlusion`] | the executor of the culler's plans, for programs that draw objects |
//! | `methods` | the methods of the literature, with the feature `methods` |
//! | [`shadows`] | the options of shadows, and their decisions as pure values |
//! | [`gpu`] | devices, windows, images |
//! | [`cull`] | cameras, strategies, the hierarchy; decisions as pure values |
//! | `import`, `animation` | glTF files and their clips, with the feature `import` |
//! | `pacing` | the start times of frames, with the feature `pacing` |
#![forbid(unsafe_code)]

#[cfg(doctest)]
mod pages;

#[cfg(feature = "import")]
pub use animation;
pub use cull;
pub use glam;
pub use gpu;
#[cfg(feature = "import")]
pub use import;
#[cfg(feature = "methods")]
pub use methods;
pub use occlusion;
#[cfg(feature = "pacing")]
pub use pacing;
pub use render;
pub use scene;
pub use shadows;

pub use cull::{Camera, ObjectId, Projection, Strategy};
#[cfg(feature = "window")]
pub use gpu::Swapchain;
#[cfg(feature = "loaded")]
pub use gpu::open;
#[cfg(all(feature = "loaded", feature = "window"))]
pub use gpu::open_with_window;
pub use gpu::{Device, Readback};
pub use render::{FrameRequest, RenderView, Renderer, RendererOptions};
pub use scene::{Scene, SceneUpdate};
