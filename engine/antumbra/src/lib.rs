//! A Vulkan engine that draws only visible objects, never waits for the GPU to find them, and never
//! shows a wrong pixel.
//!
//! Programs depend on this crate: it has the crates of the engine under short names, and at its
//! root the items that every program needs.
//!
//! ```no_run
//! use antumbra::{Camera, Renderer, open_scene};
//!
//! # fn main() -> antumbra::Result<()> {
//! let scene = open_scene("city.glb")?;
//! let mut renderer = Renderer::headless(&scene).size(1280, 720).build()?;
//! let mut view = renderer.new_view()?;
//! for step in 0..60_u8 {
//!     let z = -f32::from(step);
//!     renderer.render(&mut view, Camera::look_at([0.0, 1.7, z], [0.0, 1.7, z - 100.0]))?;
//! }
//! let last = renderer.finish(&mut view)?; // Waits: statistics and image.
//! println!("{} of {} objects drawn", last.drawn, last.in_frustum);
//! last.image.save_png("city.png")?;
//! # Ok(()) }
//! ```
//!
//! Pass a [`FrameRequest`] instead of the camera for another strategy, for a copy of the image, or
//! for a host's commands over the image. [`RendererOptions`] has the options of a renderer. A scene
//! needs no file: [`scene::Scene`] is plain data.
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
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod error;
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

pub use error::Error;

/// The result of a program's `main`, with any error.
pub type Result<T> = std::result::Result<T, Error>;

/// Loads a .gltf, .glb, .stl or .obj file as a scene at rest. Deviations of the file are logged as
/// warnings. [`import::load`] returns these deviations, and also the animations.
///
/// # Errors
/// The errors of [`import::load`].
#[cfg(feature = "import")]
pub fn open_scene(
    file: impl AsRef<std::path::Path>,
) -> std::result::Result<Scene, import::ImportError> {
    let mut progress = |_| std::ops::ControlFlow::Continue(());
    let options = import::LoadOptions::default();
    let loaded = import::load(file.as_ref(), &options, &mut progress)?;
    loaded.notes.iter().for_each(|note| tracing::warn!("{note}"));
    Ok(loaded.scene)
}
