//! The errors of the execution of plans.

use crate::leaf_table::{BucketId, MAX_BUCKETS};

/// An error of the execution. Its text is a sentence for the user.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The GPU layer failed.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    /// The hierarchy refuses a box or an object.
    #[error(transparent)]
    Hierarchy(#[from] cull::HierarchyError),
    /// A threshold is set, and the strategy does not count samples.
    #[error(transparent)]
    CannotCount(#[from] CannotCount),
    /// A view is used with a scene that it was not made for.
    #[error(
        "this view was made for another scene: each view goes with the `CulledScene` that it was made for"
    )]
    ForeignView,
    /// A view has a number that is infinite or NaN, or no pixels.
    #[error(transparent)]
    InvalidView(#[from] cull::InvalidView),
    /// A frame does not upload the changes of the scene that it draws.
    #[error(transparent)]
    NotUploaded(#[from] NotUploaded),
    /// A frame of another ring than the frames before.
    #[error(
        "the scene's frames come from another ring: a scene and its views stay with one `FrameRing`, unless `CulledScene::set_frames_in_flight` announces a new one"
    )]
    OtherRing,
    /// Draws that were listed in a frame, without the tests that fill the lists.
    #[error(
        "draws were listed in this frame and their tests were not recorded: call `ListedView::record` for each `FrameScope::list`"
    )]
    TestsMissing,
    /// A view could not be recorded, so that the frame has its commands in part.
    #[error(
        "a view of this frame was refused while it was recorded: give the frame up, and draw all views in the next one"
    )]
    Incomplete,
    /// A strategy that the culler does not plan.
    #[error(
        "the strategy `{0}` is not planned by the culler: use `frustum` or one of the `antumbra` strategies, or draw it by its `Method`"
    )]
    NotPlanned(cull::Strategy),
    /// A frame of a ring with more slots than the scene has.
    #[error(
        "the frames come from a ring of {ring}, and the scene was created for {scene} in flight: set `CulledSceneOptions::frames_in_flight`"
    )]
    FramesInFlight {
        /// The slots of the ring.
        ring: usize,
        /// The slots of the scene.
        scene: usize,
    },
    /// The view has no plan for the current state of the scene.
    #[error(
        "the view has no plan for this frame and the scene as it is: plan it once per frame, after all changes of the scene"
    )]
    NoPlan,
    /// The buckets of a draw or method do not match the buckets of the table.
    #[error(transparent)]
    Buckets(#[from] BucketError),
    /// A plan has draws among its tests, and the host draws only before and after the tests.
    #[error(transparent)]
    DrawsAmongTests(#[from] DrawsAmongTests),
    /// The passes were not compiled for the attachments of the target.
    #[error(transparent)]
    Attachments(#[from] WrongAttachments),
    /// The target does not fit the plan.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// The shaders cannot be compiled by this build.
    #[error(
        "this build has no shader compiler, it cannot use the shaders in {0}; build with --features shader-compiler"
    )]
    NoShaderCompiler(String),
}

/// A threshold with a strategy that does not count samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the strategy `{strategy}` does not count samples, which a threshold of {threshold_samples} needs: use `antumbra` or `antumbra_queries`, or set the threshold to 0"
)]
pub struct CannotCount {
    /// The requested strategy.
    pub strategy: cull::Strategy,
    /// The threshold in samples.
    pub threshold_samples: u32,
}

/// A plan with draws among its tests, for a host that draws only before and after the tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the plan of this frame has draws among its tests, and the host takes them as lists: create the scene with `DrawPhases::Two`"
)]
pub struct DrawsAmongTests;

/// A frame that does not upload the changes of the scene that it draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the scene has changes that this frame does not upload: begin each frame by `CulledScene::begin` (or `LeafTable::upload`), and change nothing before it ends"
)]
pub struct NotUploaded;

/// A mismatch between draws or methods and the buckets of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BucketError {
    /// A draw names a bucket that the table does not have.
    #[error(
        "a draw names bucket {} of {bucket_count}: create the scene with as many buckets as there are pipelines",
        bucket.0
    )]
    Unknown {
        /// The bucket of the draw.
        bucket: BucketId,
        /// The number of buckets of the table.
        bucket_count: u32,
    },
    /// More buckets are requested than a table can have.
    #[error("{bucket_count} buckets are more than a table has ({MAX_BUCKETS}): share pipelines")]
    TooMany {
        /// The number of buckets.
        bucket_count: u32,
    },
    /// Draws are changed in a table with one draw per leaf.
    #[error(
        "this `LeafTable` has one draw per leaf: mark leaves as dirty, or create the scene by `CulledScene::new`"
    )]
    OneDrawPerLeaf,
    /// A method that needs one draw per leaf is used with a table with buckets.
    #[error(
        "the strategy `{0}` needs a `LeafTable` with one draw per leaf, and this one has buckets: use `frustum` or one of the `antumbra` strategies"
    )]
    HasBuckets(cull::Strategy),
}

/// A target with other attachments than those that the passes were compiled for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "boxes are tested in renderings to {passes}, and the target of the objects has {target}: create the scene for `Target::attachments`"
)]
pub struct WrongAttachments {
    /// The attachments of the passes.
    pub passes: Box<gpu::Attachments>,
    /// The attachments of the target.
    pub target: Box<gpu::Attachments>,
}

/// A mismatch between a plan and the target that it is drawn to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TargetError {
    /// Several views are drawn at once to a target with another number of views.
    #[error(
        "{views} views are drawn at once to a target of {target}: create the scene for a target with a layer per view"
    )]
    Views {
        /// The number of views of the plan.
        views: usize,
        /// The number of views of the target's attachments.
        target: u32,
    },
    /// A view has pixels outside of the target.
    #[error(
        "the view has {}x{} pixels from {}, {} on, and the target has {}x{}: make the view for the size of the target",
        size[0], size[1], origin[0], origin[1], target[0], target[1]
    )]
    ViewSize {
        /// The size of the view.
        size: [u32; 2],
        /// The position of the view's upper left corner.
        origin: [u32; 2],
        /// The size of the target.
        target: [u32; 2],
    },
    /// A plan has tests by compute shader, and the depth of the target cannot be copied.
    #[error(
        "the plan has tests by compute shader, and the depth of the target cannot be copied: create the view by `CulledScene::new_view`, for this target"
    )]
    CannotCopyDepth,
}
