//! The errors of the execution of plans.

use crate::leaf_table::{BucketId, MAX_BUCKETS};

/// An error of the execution. Its text is a sentence for the user.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The GPU layer failed.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    /// A box or an object that the hierarchy refuses.
    #[error(transparent)]
    Hierarchy(#[from] cull::HierarchyError),
    /// A strategy that does not count samples, and a threshold.
    #[error(transparent)]
    CannotCount(#[from] CannotCount),
    /// A view and another scene.
    #[error(
        "this view was made for another scene: each view goes with the `CulledScene` that it was made for"
    )]
    ForeignView,
    /// A frame without the changes of the scene that it draws.
    #[error(transparent)]
    NotUploaded(#[from] NotUploaded),
    /// A view without a plan for the scene as it is.
    #[error(
        "the view has no plan for the scene as it is: plan it once before each `execute`, after all changes of the scene"
    )]
    NoPlan,
    /// Buckets where there are none, or others.
    #[error(transparent)]
    Buckets(#[from] BucketError),
    /// A plan with draws among its tests, and a host that draws before and after them.
    #[error(transparent)]
    DrawsAmongTests(#[from] DrawsAmongTests),
    /// A target that the passes were not compiled for.
    #[error(transparent)]
    Attachments(#[from] WrongAttachments),
    /// A target that does not fit the plan.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// A request for shaders that this build cannot compile.
    #[error(
        "this build has no shader compiler, it cannot use the shaders in {0}; build with --features shader-compiler"
    )]
    NoShaderCompiler(String),
}

/// A strategy that does not count samples, and a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the strategy `{strategy}` does not count samples, which a threshold of {threshold_samples} needs: use `antumbra` or `antumbra_queries`, or set the threshold to 0"
)]
pub struct CannotCount {
    /// The strategy that was asked for.
    pub strategy: cull::Strategy,
    /// The threshold in samples.
    pub threshold_samples: u32,
}

/// A plan with draws among its tests, and a host that draws before and after them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the plan of this frame has draws among its tests, and the host takes them as lists: create the scene with `DrawPhases::Two`"
)]
pub struct DrawsAmongTests;

/// A frame without the changes of the scene that it draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the scene has changes that this frame does not upload: call `LeafTable::upload` once in each frame, and execute no plan in a frame where it fails"
)]
pub struct NotUploaded;

/// An error about the buckets of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BucketError {
    /// A bucket that the table does not have.
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
    /// More buckets than a table has room for.
    #[error("{bucket_count} buckets are more than a table has ({MAX_BUCKETS}): share pipelines")]
    TooMany {
        /// The number of buckets.
        bucket_count: u32,
    },
    /// A change of draws in a table with one draw per leaf.
    #[error(
        "this `LeafTable` has one draw per leaf: mark leaves as dirty, or create the scene by `CulledScene::new`"
    )]
    OneDrawPerLeaf,
    /// A method that works with one draw per leaf, and a table with buckets.
    #[error(
        "the strategy `{0}` needs a `LeafTable` with one draw per leaf, and this one has buckets: use `frustum` or one of the `antumbra` strategies"
    )]
    HasBuckets(cull::Strategy),
}

/// A target with other attachments than the passes that test boxes were compiled for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "boxes are tested in renderings to {passes}, and the target of the objects has {target}: compile `OcclusionPasses` for `Target::attachments`"
)]
pub struct WrongAttachments {
    /// The attachments of the passes.
    pub passes: Box<gpu::Attachments>,
    /// Those of the target.
    pub target: Box<gpu::Attachments>,
}

/// An error about a plan and the target that it is drawn to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TargetError {
    /// Several views at once and a target of another number, or of none.
    #[error(
        "{views} views are drawn at once to a target of {target}: compile `OcclusionPasses` for a target with a layer per view"
    )]
    Views {
        /// The views of the plan.
        views: usize,
        /// The views of the target's attachments.
        target: u32,
    },
    /// A view with pixels outside of the target.
    #[error(
        "the view has {}x{} pixels from {}, {} on, and the target has {}x{}: make the view for the size of the target",
        size[0], size[1], origin[0], origin[1], target[0], target[1]
    )]
    ViewSize {
        /// The size of the view.
        size: [u32; 2],
        /// The place of its upper left corner.
        origin: [u32; 2],
        /// The size of the target.
        target: [u32; 2],
    },
    /// A plan with tests by compute shader, and a depth that cannot be copied.
    #[error(
        "the plan has tests by compute shader, and the depth of the target cannot be copied: create the view by `CulledScene::new_view`, for this target"
    )]
    CannotCopyDepth,
}
