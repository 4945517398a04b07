//! The errors of the engine.

use crate::resource_errors::{MaterialError, MeshError, TextureError};
use crate::update_errors::{ChangeError, LightError, PoseError, TransparentError};

/// The name of a view in [`Error::ForeignRenderer`].
pub(crate) const FOREIGN_VIEW: &str = "a view (`RenderView`)";

/// Returns the words about the size of textures in [`Error::SceneMemory`].
fn with_textures(side: u32) -> String {
    match side {
        0 => String::new(),
        side => format!(" with textures of at most {side} texels per side"),
    }
}

/// An error of the engine. Its text is a sentence for the user.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The GPU layer failed.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    /// The hierarchy could not be built.
    #[error("the scene cannot be culled: {0}")]
    Hierarchy(#[from] cull::HierarchyError),
    /// A matrix is not a projection.
    #[error(transparent)]
    CullView(#[from] cull::ViewError),
    /// A camera or a view has a number that is infinite or NaN, or no pixels.
    #[error(transparent)]
    InvalidView(#[from] cull::InvalidView),
    /// The depth of a matrix is not reversed.
    #[error(
        "the renderer draws with reversed depth: give it a matrix whose depth is 1 at the near plane"
    )]
    StandardDepth,
    /// The scene cannot be drawn.
    #[error(transparent)]
    Scene(#[from] scene::SceneError),
    /// A scene has more of something than a renderer takes: more than
    /// [`MAX_LIGHTS`](scene::limits::MAX_LIGHTS) and similar limits allow, or than the device's
    /// storage buffers hold.
    #[error("the scene has {wanted} {what}, and a renderer takes at most {limit} here: {instead}")]
    SceneTooLarge {
        /// The part of the scene that is too large.
        what: &'static str,
        /// The number in the scene.
        wanted: u64,
        /// The highest number on this device.
        limit: u64,
        /// Advice: something smaller that can be drawn.
        instead: &'static str,
    },
    /// There is not enough memory for the scene.
    #[error(
        "there is no memory for {what} (about {} MiB): use fewer objects, or end other programs",
        size_bytes >> 20
    )]
    NoMemory {
        /// The purpose of the memory.
        what: &'static str,
        /// The size of the request in bytes.
        size_bytes: usize,
    },
    /// A scene does not fit into the memory of the device or its budget, also with smaller
    /// textures. Nothing else on the device has changed.
    #[error(
        "the scene needs about {needed_mib} MiB of GPU memory{}, and {left_mib} MiB are left: {source}",
        with_textures(*.texture_side)
    )]
    SceneMemory {
        /// About the size of the scene (MiB), rounded up, without what it takes for a time only.
        needed_mib: u64,
        /// The memory that was left before the scene (MiB).
        left_mib: u64,
        /// The most texels per side of a texture in the last attempt; 0 without textures.
        texture_side: u32,
        /// The failed allocation.
        source: Box<gpu::Error>,
    },
    /// A view is finished that the newest frame does not show.
    #[error(
        "the newest image of the renderer does not show this view: finish a view right after its frame, before another one is rendered"
    )]
    NotNewest,
    /// The strategy draws objects found in advance, and no visible set is given.
    #[error(
        "the strategy `{0}` draws what is known to be visible: find it with `Renderer::visible_set` first"
    )]
    NoVisibleSet(cull::Strategy),
    /// The scene has changed since the visible set was found.
    #[error(
        "the scene has changed since it was found out what is visible: find it again with `Renderer::visible_set`"
    )]
    OldVisibleSet,
    /// The renderer has no method for the strategy.
    #[error(
        "this renderer has no method for the strategy `{0}`: give it one with `RendererOptions::methods`"
    )]
    NoMethod(cull::Strategy),
    /// A threshold is set, and the strategy does not count samples.
    #[error(transparent)]
    CannotCount(occlusion::CannotCount),
    /// The strategy has tests, the image has several samples per pixel, and the device lacks
    /// [`gpu::OptionalFeature::SampleDepths`].
    #[error(
        "the device {device} takes the depth of a sample from another place than its coverage, so `{strategy}` could lose some: draw with one sample per pixel, or with `frustum`"
    )]
    SampleDepths {
        /// The device's name.
        device: String,
        /// The strategy.
        strategy: cull::Strategy,
    },
    /// More frames in flight are requested than a renderer takes.
    #[error(
        "{wanted} frames in flight are more than a renderer takes ({}): two or three keep a GPU busy, more only make answers older",
        most
    )]
    FramesInFlight {
        /// The requested number.
        wanted: usize,
        /// The largest number.
        most: usize,
    },
    /// A table of costs contains an impossible cost.
    #[error(transparent)]
    Cost(#[from] cull::BadCost),
    /// The options of shadows are impossible on any device.
    #[error(transparent)]
    Shadows(#[from] ::shadows::ShadowOptionsError),
    /// Shadows need lights of surfaces, and the scene has none.
    #[error(
        "the scene has no surfaces, and only their lights cast shadows: give it some with `Scene::with_surfaces`, or leave shadows off"
    )]
    NoSurfacesForShadows,
    /// Shadow volumes are requested for an image with several samples per pixel.
    #[error(
        "shadow volumes are counted against one depth per pixel, and the renderer has several samples: take shadow maps, or one sample"
    )]
    MultisampledVolumes,
    /// The options of edges or outlines are impossible.
    #[error("edges and outlines: {0}")]
    Edges(&'static str),
    /// An environment needs surfaces, and the scene has none.
    #[error(
        "the scene has no surfaces, and only they are lit from all around: give it some with `Scene::with_surfaces`"
    )]
    NoSurfacesForEnvironment,
    /// A frame has no view.
    #[error("a frame needs a view, or there is nothing to draw: name at least one `ViewRequest`")]
    NoView,
    /// The device of a renderer is lost, and the renderer does not keep its scene.
    #[error(
        "the renderer does not keep its scene, so it cannot draw it on another device: call `Renderer::keep_scene` when it is created, or create another renderer"
    )]
    SceneNotKept,
    /// A scene is to be kept that the renderer was not created from.
    #[error(
        "the scene to keep has other meshes or objects than the renderer: give the scene that the renderer was created from, before the first change"
    )]
    OtherScene,
    /// A view was last drawn on a device that is lost.
    #[error(
        "the view was last drawn on a device that is lost: render a frame of it on the present device first"
    )]
    ViewOfLostDevice,
    /// An object was made by another renderer.
    #[error("{thing} was made by another renderer: each renderer uses only what it made itself")]
    ForeignRenderer {
        /// The name of the object.
        thing: &'static str,
    },
    /// The hierarchy was not built over the scene's objects.
    #[error(
        "the hierarchy is not over this scene: object {} is not where the scene has it; build it from `object_bounds`", object.0
    )]
    ForeignHierarchy {
        /// The first object that has another box in the scene, or is only in the hierarchy.
        object: cull::ObjectId,
    },
    /// The readback has another size than the image.
    #[error(
        "the image wanted is {}x{} pixels, the one drawn {}x{}: make the `Readback` with `Renderer::size`",
        wanted[0], wanted[1], drawn[0], drawn[1]
    )]
    ImageSize {
        /// Size of the readback in pixels.
        wanted: [u32; 2],
        /// Size of the image in pixels.
        drawn: [u32; 2],
    },
    /// A change of the scene is impossible.
    #[error("change {index} of the scene cannot be made, so none was: {reason}")]
    Change {
        /// The index of the change.
        index: usize,
        /// The reason, and advice.
        reason: ChangeError,
    },
    /// A transparent object cannot be moved as requested.
    #[error("the transparent object {} cannot be moved: {reason}", transparent.0)]
    Transparent {
        /// The id of the transparent object.
        transparent: scene::TransparentId,
        /// The reason why it cannot move.
        reason: TransparentError,
    },
    /// A mesh cannot take a pose.
    #[error("the skinned mesh {} cannot take this pose: {reason}", skinned_mesh.0)]
    Pose {
        /// The skinned mesh.
        skinned_mesh: scene::SkinnedMeshId,
        /// The reason why the pose does not fit the mesh.
        reason: PoseError,
    },
    /// The area of a view is empty or not within the image.
    #[error(
        "a view of {}x{} pixels at {}, {} is not within the image of {}x{}: choose an area of at least a pixel inside",
        area.size[0], area.size[1], area.origin[0], area.origin[1], image[0], image[1]
    )]
    Rect {
        /// The requested area.
        area: occlusion::Rect,
        /// Size of the image in pixels.
        image: [u32; 2],
    },
    /// A host's overlay failed.
    #[error("what is drawn over the image failed: {0}")]
    Overlay(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// An image is incomplete.
    #[error("the image \"{image}\" of {}x{} pixels cannot be drawn: {fault}", size[0], size[1])]
    Image {
        /// The name of the image in the scene.
        image: String,
        /// The size in pixels.
        size: [u32; 2],
        /// The fault, as the end of a sentence.
        fault: &'static str,
    },
    /// A mesh cannot be added or removed.
    #[error("mesh {index} of those named cannot be added or removed, so none was: {reason}")]
    Mesh {
        /// The index of the mesh in the call.
        index: usize,
        /// The reason, and advice.
        reason: MeshError,
    },
    /// A texture cannot be added or removed.
    #[error("texture {index} of those named cannot be added or removed, so none was: {reason}")]
    Texture {
        /// The index of the texture in the call.
        index: usize,
        /// The reason, and advice.
        reason: TextureError,
    },
    /// A material cannot be added or removed.
    #[error("material {index} of those named cannot be added or removed, so none was: {reason}")]
    Material {
        /// The index of the material in the call.
        index: usize,
        /// The reason, and advice.
        reason: MaterialError,
    },
    /// There is not enough room for elements that are added.
    #[error(
        "there is no room for {wanted} {what}, at most {left} in one piece, so nothing was added: give the renderer more with `RendererOptions::spare`, or remove others"
    )]
    CapacityExceeded {
        /// The name of the elements.
        what: &'static str,
        /// The requested number.
        wanted: u64,
        /// The highest number for which there is room now.
        left: u64,
    },
    /// A light cannot be changed as requested.
    #[error("the light {} cannot be changed: {reason}", light.0)]
    Light {
        /// The id of the light in the scene.
        light: scene::LightId,
        /// The reason, and advice.
        reason: LightError,
    },
    /// A light cannot be added with its picture.
    #[error("light {index} of those named cannot be added, so none was: {reason}")]
    LightCookie {
        /// The index of the light in the call.
        index: usize,
        /// The reason, and advice.
        reason: &'static str,
    },
    /// A lens flare cannot be drawn.
    #[error("flare {index} of those named cannot be drawn, so none was changed: {reason}")]
    Flare {
        /// The index of the flare in the call.
        index: usize,
        /// The reason, and advice.
        reason: &'static str,
    },
    /// Draws are in buckets, but a renderer has one draw per object.
    #[error(transparent)]
    Buckets(#[from] occlusion::BucketError),
    /// The passes were not compiled for the attachments of the target.
    #[error(transparent)]
    Attachments(#[from] occlusion::WrongAttachments),
    /// The target does not fit the plan.
    #[error(transparent)]
    Target(#[from] occlusion::TargetError),
    /// A frame does not upload the changes of the scene that it draws.
    #[error(transparent)]
    NotUploaded(#[from] occlusion::NotUploaded),
    /// A method executed a plan that it had not made for the present state of the scene.
    #[error("a method executed a plan that it had not made: plan each view once per frame")]
    NoPlan,
    /// A plan has draws among its tests, and the host takes its draws as lists.
    #[error(transparent)]
    DrawsAmongTests(#[from] occlusion::DrawsAmongTests),
    /// The shaders cannot be compiled by this build.
    #[error(
        "this build has no shader compiler, it cannot use the shaders in {0}; build with --features shader-compiler"
    )]
    NoShaderCompiler(String),
}

impl From<occlusion::Error> for Error {
    fn from(error: occlusion::Error) -> Self {
        match error {
            occlusion::Error::Gpu(error) => Self::Gpu(error),
            occlusion::Error::Hierarchy(error) => Self::Hierarchy(error),
            occlusion::Error::CannotCount(error) => Self::CannotCount(error),
            occlusion::Error::InvalidView(error) => Self::InvalidView(error),
            occlusion::Error::Buckets(error) => Self::Buckets(error),
            occlusion::Error::Attachments(error) => Self::Attachments(error),
            occlusion::Error::Target(error) => Self::Target(error),
            occlusion::Error::DrawsAmongTests(error) => Self::DrawsAmongTests(error),
            occlusion::Error::NotUploaded(error) => Self::NotUploaded(error),
            // A renderer begins no scope.
            occlusion::Error::NoPlan
            | occlusion::Error::OtherRing
            | occlusion::Error::TestsMissing
            | occlusion::Error::Incomplete
            | occlusion::Error::NotPlanned(_) => Self::NoPlan,
            occlusion::Error::FramesInFlight { ring: wanted, scene: most } => {
                Self::FramesInFlight { wanted, most }
            }
            occlusion::Error::ForeignView => Self::ForeignRenderer { thing: FOREIGN_VIEW },
            occlusion::Error::NoShaderCompiler(folder) => Self::NoShaderCompiler(folder),
        }
    }
}
