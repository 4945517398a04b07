//! Coherent occlusion culling as pure values: decides what to draw and what to test.
//!
//! A [`Culler`] turns the results of earlier frames into a [`FramePlan`]: leaves to draw at once,
//! and a *frontier* of proxies to test, each with the contiguous range of leaves to draw in the
//! same frame if a sample of it shows. The answers arrive frames later, or never, and only affect
//! the cost of later plans, not the image: an object with a visible pixel is either drawn at once,
//! or it lies under a proxy that is tested in the same frame. The method follows Bittner and
//! Wimmer's coherent hierarchical culling ("Hardware Occlusion Queries Made Useful", GPU Gems 2,
//! chapter 6), with predicates on the GPU in place of waiting on the CPU.
//!
//! The crate does not use Vulkan, does not read a clock, and does not allocate in a steady frame.
//! Equal inputs make equal plans.
//!
//! - [`Hierarchy`]: the tree over the objects' boxes. Every subtree is one range of leaves.
//! - [`CullView`]: the matrix and the volumes of one camera and image. [`Margin`] makes proxies
//!   large enough, and its documentation has the proof.
//! - [`Culler::plan`] and [`Culler::ingest`]: the loop, once per frame.
//! - [`QueryShares`]: the loop for several views with histories of their own, on one budget.
//! - [`LearnedCosts`]: leaves out tests that cost more than they save, by the costs of a
//!   [`CostTable`].
//! - [`BlockingCuller`]: the methods of the literature that wait for results within the frame, for
//!   comparison.
//! - [`CullConfig`]: the constants that matter. They change costs, never the image.
//!
//! # Example
//!
//! A wall with a hundred objects behind it. In this example a closure replaces the GPU: only the
//! wall shows.
//!
//! ```
//! use antumbra_cull::{
//!     Aabb, Answer, Camera, CullConfig, CullView, Culler, FramePlan, Hierarchy, Projection,
//!     Strategy,
//! };
//! use glam::Vec3;
//!
//! let wall = Aabb::new(Vec3::new(-20.0, -20.0, -6.0), Vec3::new(20.0, 20.0, -5.0));
//! let behind = (0..100).map(|n| {
//!     let corner = Vec3::new((n % 10) as f32 - 5.0, 0.0, -8.0 - (n / 10) as f32);
//!     Aabb::new(corner, corner + 0.5)
//! });
//! let boxes: Vec<Aabb> = std::iter::once(wall).chain(behind).collect();
//! let hierarchy = Hierarchy::build(&boxes)?;
//! let camera = Camera {
//!     eye: Vec3::ZERO,
//!     forward: Vec3::NEG_Z,
//!     up: Vec3::Y,
//!     projection: Projection::perspective(1.0),
//!     near: 0.1,
//! };
//! let view = CullView::new(&camera, [1280, 720], 8);
//!
//! let mut culler = Culler::new(CullConfig::default());
//! let mut plan = FramePlan::default();
//! let mut answers: Vec<Answer> = Vec::new();
//! let shows = |node| hierarchy.bounds(node).max.z > -7.0;
//! for _ in 0..100 {
//!     culler.ingest(&hierarchy, answers.drain(..));
//!     culler.plan(&hierarchy, Strategy::ANTUMBRA, &view, 1_000, &mut plan);
//!     // The GPU draws `draws` and `queried_draws`, then tests and draws round by round.
//!     let tested = plan.tests.iter().map(|test| test.tag);
//!     let queried = plan.queried_draws.iter().map(|(_, tag)| *tag);
//!     answers.extend(tested.chain(queried).map(|tag| Answer {
//!         tag,
//!         samples: u32::from(shows(tag.node)),
//!     }));
//! }
//! // The wall is drawn; all that is hidden costs a handful of queries and no draw.
//! assert_eq!(plan.draws.len() + plan.queried_draws.len(), 1);
//! assert!(plan.tests.len() < 10);
//! assert_eq!(plan.tests.iter().map(|test| test.leaves.count).sum::<u32>(), 100);
//! # Ok::<(), antumbra_cull::HierarchyError>(())
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod blocking;
mod cost;
mod culler;
mod geom;
mod hierarchy;
mod history;
mod ids;
mod plan;
mod rng;
pub mod trigonometry;
mod view_check;

pub use blocking::{
    Batch, BatchDraw, BatchTest, BatchedOptions, BlockingCuller, BlockingFrame, BlockingKind,
    BlockingStats, ChcOptions, FirstPass, LeafTest, NextAction, TestAnswer, TestToken,
};
pub use cost::contents::FrameContents;
pub use cost::corrections::Corrections;
pub use cost::learned_costs::LearnedCosts;
pub use cost::predication_costs::{MeasuredSkip, PredicationCosts, SkipTimes, SkippedWork};
pub use cost::table::{BadCost, CostTable, SceneCosts};
pub use culler::Culler;
pub use geom::bounds::{Aabb, MAX_COORDINATE};
pub use geom::box_shadow_volumes::{BoxShadowVolumes, LightReach, VolumeLength};
pub use geom::camera::{Camera, Projection};
pub use geom::detail::{DetailBySamples, DetailLevel, DetailPolicy};
pub use geom::frustum::{Containment, Frustum, PlaneMask};
pub use geom::margin::Margin;
pub use geom::multi_view::{MultiView, MultiViewError};
pub use geom::projection::{ClipY, DepthConvention, ViewError, ViewProjection};
pub use geom::rays::{ProjectionKind, Rays};
pub use geom::section::{SectionError, SectionMember, SectionMode, SectionPlane, SectionPlanes};
pub use geom::view::{Anchor, CullView};
pub use glam;
pub use hierarchy::{
    BUILD_BYTES_PER_OBJECT, BoxChange, Hierarchy, HierarchyError, HierarchyWork, MAX_OBJECTS,
};
pub use history::record::NodeState;
pub use history::results::{LeafList, PendingTest, ResultReader, TestResult};
pub use ids::{FrameId, Generation, HierarchyId, LeafIndex, LeafRange, NodeId, ObjectId};
pub use plan::config::{CullConfig, CullTuning};
pub use plan::explain::{Decision, LeafExplanation, NodeHistory, Outcome};
pub use plan::frame_plan::{
    Answer, DrawPhases, FramePlan, PlanStats, ProxyTest, QueryKind, QueryTag, VisibilityTest,
    VisibilityTestSupport,
};
pub use plan::query_shares::QueryShares;
pub use plan::strategy::Strategy;
pub use view_check::{InvalidView, check_camera, check_view, check_view_size};
