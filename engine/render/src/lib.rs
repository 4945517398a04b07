//! The renderer of the Antumbra engine: it draws only visible objects, never waits for the GPU to
//! find them, and never shows a wrong pixel.
//!
//! A frame is a [`cull::FramePlan`] (pure, from the crate `cull`) that the crate `occlusion`
//! executes. This crate draws the objects: it has scenes, passes, and the [`Renderer`], which runs
//! a whole frame.
//!
//! ```no_run
//! # use antumbra_render as render;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let instance = gpu::Instance::new(gpu::load_entry()?, &gpu::InstanceOptions::default())?;
//! let adapter = instance.pick_adapter(None)?;
//! let device = gpu::Device::new(&instance, &adapter, &gpu::DeviceOptions::default())?;
//!
//! let corners = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let mesh = scene::Mesh::of_triangles("triangle", &corners.map(|corner| (corner, [1.0; 3])));
//! let scene = scene::Scene::single(mesh);
//! let [forward, up] = [glam::Vec3::NEG_Z, glam::Vec3::Y];
//! let mut renderer = render::Renderer::new(&device, &scene, &render::RendererOptions::default())?;
//! let mut view = renderer.new_view()?;
//! let image = gpu::Readback::new(&device, renderer.size())?;
//! for frame in 0..100 {
//!     let eye = glam::Vec3::Z * (3.0 + frame as f32 * 0.1);
//!     let projection = cull::Projection::perspective(0.9);
//!     let camera = cull::Camera { eye, forward, up, projection, near: 0.1 };
//!     let request = render::FrameRequest {
//!         image: (frame == 99).then_some(&image),
//!         ..render::FrameRequest::new(cull::Strategy::ANTUMBRA, camera)
//!     };
//!     renderer.render(&mut view, &request)?;
//! }
//! renderer.wait_idle(&mut view)?;
//! println!("{} bytes of RGBA", image.rgba8()?.len());
//! # Ok(()) }
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod api;
mod attachment_schedule;
mod calibration_scene;
mod cost_list;
mod debug;
mod edges;
mod error;
mod executor_choice;
mod flares;
mod gpu_scene;
mod host_overlay;
mod kept_scene;
mod last_frame;
pub mod passes;
mod render_view;
mod renderer;
mod resource_errors;
mod resources;
mod rgba_image;
mod scene_renderer;
mod section;
mod self_test;
mod shading;
mod shadows;
mod tessellation;
mod update;
mod update_errors;
mod view_pass;
mod views;

#[cfg(feature = "loaded")]
pub use api::headless::HeadlessRenderer;
pub use api::lod::DetailView;
pub use calibration_scene::measure_costs;
pub use cost_list::{BoxSize, CostItem, CostListOptions, ItemCost, PredicateResult, cost_list};
pub use debug::debug_overlay::{DebugOverlay, OVERLAY_PASSES};
pub use debug::palette;
pub use debug::pointer::{Pointed, PointedSurface};
pub use debug::sample_counts::{ProxySamples, VisibleSamples};
pub use debug::visibility_snapshot::VisibilitySnapshot;
pub use debug::visible_set::VisibleSet;
pub use edges::{EdgeMode, EdgeOptions, ObjectOutline};
pub use error::Error;
pub use flares::{FlareBlock, FlareSamples, FlareState};
pub use host_overlay::HostOverlay;
pub use last_frame::LastFrame;
pub use occlusion::{
    CostModel, CullingSetup, DeviceCosts, DriverAssumption, DriverQuirks, FrameStats,
    QueryResetCosts, Rect, ShaderSet,
};
pub use passes::EdgePath;
pub use render_view::RenderView;
pub use renderer::{MAX_FRAMES_IN_FLIGHT, Renderer, RendererOptions};
pub use resource_errors::{MaterialError, MeshError, TextureError};
pub use resources::object_bounds::object_bounds;
pub use resources::spare_capacity::{SpareCapacity, TextureCapacity};
pub use rgba_image::RgbaImage;
pub use self_test::{CheckResult, SelfTest, self_test};
pub use shading::scene_degradations::SceneDegradations;
pub use shading::surfaces;
pub use shading::transparency::{
    FragmentCounts, TransparencyFallback, TransparencyMethod, TransparencyOptions,
};
pub use shadows::{LightShadow, ShadowIo, ShadowMapIo, ShadowMaskIo};
pub use tessellation::{TessellationPath, Tessellator};
pub use update::UpdateReport;
pub use update_errors::{ChangeError, LightError, PoseError, TransparentError};
pub use views::{FrameReport, FrameRequest, ViewRequest, Viewpoint, ViewsRequest};
