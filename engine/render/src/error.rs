//! The errors of the engine.

/// The name of a view in [`Error::ForeignRenderer`].
pub(crate) const FOREIGN_VIEW: &str = "a view (`RenderView`)";

/// An error of the engine. Its text is a sentence for the user.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The GPU layer failed.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    /// The hierarchy could not be built.
    #[error("the scene cannot be culled: {0}")]
    Hierarchy(#[from] cull::HierarchyError),
    /// A matrix that is no projection.
    #[error(transparent)]
    CullView(#[from] cull::ViewError),
    /// A matrix whose depth is not reversed.
    #[error(
        "the renderer draws with reversed depth: give it a matrix whose depth is 1 at the near plane"
    )]
    StandardDepth,
    /// The scene cannot be drawn.
    #[error(transparent)]
    Scene(#[from] scene::SceneError),
    /// A scene with more of something than a renderer takes: beyond
    /// [`MAX_LIGHTS`](scene::limits::MAX_LIGHTS) and similar limits, or beyond the size of the
    /// device's storage buffers.
    #[error("the scene has {wanted} {what}, and a renderer takes at most {limit} here: {instead}")]
    SceneTooLarge {
        /// The part of the scene that is too large.
        what: &'static str,
        /// The number of them.
        wanted: u64,
        /// The largest number on this device.
        limit: u64,
        /// The advice: something smaller that can be drawn.
        instead: &'static str,
    },
    /// Less memory than the scene takes.
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
    /// A strategy that draws objects found beforehand, without a visible set.
    #[error(
        "the strategy `{0}` draws what is known to be visible: find it with `Renderer::visible_set` first"
    )]
    NoVisibleSet(cull::Strategy),
    /// A visible set that was found before the scene changed.
    #[error(
        "the scene has changed since it was found out what is visible: find it again with `Renderer::visible_set`"
    )]
    OldVisibleSet,
    /// A strategy that the renderer was given no method for.
    #[error(
        "this renderer has no method for the strategy `{0}`: give it one with `RendererOptions::methods`"
    )]
    NoMethod(cull::Strategy),
    /// A strategy that does not count samples, and a threshold.
    #[error(transparent)]
    CannotCount(occlusion::CannotCount),
    /// A strategy that tests what is hidden, several samples per pixel, and a device without
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
    /// More frames in flight than make sense.
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
    /// A table of costs with an impossible cost.
    #[error(transparent)]
    Cost(#[from] cull::BadCost),
    /// Options of shadows that no device can fulfil.
    #[error(transparent)]
    Shadows(#[from] ::shadows::ShadowOptionsError),
    /// Shadows of a scene whose lights are not those of surfaces.
    #[error(
        "the scene has no surfaces, and only their lights cast shadows: give it some with `Scene::with_surfaces`, or leave shadows off"
    )]
    NoSurfacesForShadows,
    /// Shadow volumes for an image of several samples per pixel.
    #[error(
        "shadow volumes are counted against one depth per pixel, and the renderer has several samples: take shadow maps, or one sample"
    )]
    MultisampledVolumes,
    /// Options of edges or outlines that are impossible.
    #[error("edges and outlines: {0}")]
    Edges(&'static str),
    /// Light from all around for a scene that has no surfaces.
    #[error(
        "the scene has no surfaces, and only they are lit from all around: give it some with `Scene::with_surfaces`"
    )]
    NoSurfacesForEnvironment,
    /// A frame without a view.
    #[error("a frame needs a view, or there is nothing to draw: name at least one `ViewRequest`")]
    NoView,
    /// An object that another renderer made.
    #[error("{thing} was made by another renderer: each renderer uses only what it made itself")]
    ForeignRenderer {
        /// The name of the object.
        thing: &'static str,
    },
    /// A hierarchy that was not built over the scene's objects.
    #[error(
        "the hierarchy is not over this scene: object {} is not where the scene has it; build it from `object_bounds`", object.0
    )]
    ForeignHierarchy {
        /// The first object that is not in its box, or is in the hierarchy only.
        object: cull::ObjectId,
    },
    /// A readback for an image of another size.
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
    /// An impossible change of the scene.
    #[error("change {index} of the scene cannot be made, so none was: {reason}")]
    Change {
        /// Its place among the changes.
        index: usize,
        /// The reason, and the advice.
        reason: String,
    },
    /// A transparent object that cannot be moved as requested.
    #[error("the transparent object {} cannot be moved: {reason}", transparent.0)]
    Transparent {
        /// The id of the transparent object.
        transparent: scene::TransparentId,
        /// The reason why it cannot move.
        reason: &'static str,
    },
    /// A pose that a mesh cannot take.
    #[error("the skinned mesh {} cannot take this pose: {reason}", skinned_mesh.0)]
    Pose {
        /// The skinned mesh.
        skinned_mesh: scene::SkinnedMeshId,
        /// The reason why the pose does not fit the mesh.
        reason: String,
    },
    /// A view whose area is empty or not within the image.
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
    /// A host's overlay that failed.
    #[error("what is drawn over the image failed: {0}")]
    Overlay(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// An image that is not whole.
    #[error("the image \"{image}\" of {}x{} pixels cannot be drawn: {fault}", size[0], size[1])]
    Image {
        /// The name of the image in the scene.
        image: String,
        /// Its size in pixels.
        size: [u32; 2],
        /// The fault, as the end of a sentence.
        fault: &'static str,
    },
    /// A mesh that cannot be added or removed.
    #[error("mesh {index} of those named cannot be added or removed, so none was: {reason}")]
    Mesh {
        /// Its place among those of the call.
        index: usize,
        /// The reason, and the advice.
        reason: &'static str,
    },
    /// A texture that cannot be added or removed.
    #[error("texture {index} of those named cannot be added or removed, so none was: {reason}")]
    Texture {
        /// Its place among those of the call.
        index: usize,
        /// The reason, and the advice.
        reason: &'static str,
    },
    /// A material that cannot be added or removed.
    #[error("material {index} of those named cannot be added or removed, so none was: {reason}")]
    Material {
        /// Its place among those of the call.
        index: usize,
        /// The reason, and the advice.
        reason: &'static str,
    },
    /// More of something than there is room for.
    #[error(
        "there is no room for {wanted} {what}, at most {left} in one piece, so nothing was added: give the renderer more with `RendererOptions::spare`, or remove others"
    )]
    CapacityExceeded {
        /// The elements without room.
        what: &'static str,
        /// The requested number.
        wanted: u64,
        /// The largest number that there is room for now.
        left: u64,
    },
    /// A light that cannot be changed as requested.
    #[error("the light {} cannot be changed: {reason}", light.0)]
    Light {
        /// The id of the light in the scene.
        light: scene::LightId,
        /// The reason, and the advice.
        reason: &'static str,
    },
    /// A light that cannot be added with its picture.
    #[error("light {index} of those named cannot be added, so none was: {reason}")]
    LightCookie {
        /// Its place among those of the call.
        index: usize,
        /// The reason, and the advice.
        reason: &'static str,
    },
    /// A lens flare that cannot be drawn.
    #[error("flare {index} of those named cannot be drawn, so none was changed: {reason}")]
    Flare {
        /// Its place among those of the call.
        index: usize,
        /// The reason, and the advice.
        reason: &'static str,
    },
    /// Draws in buckets; a renderer has one draw per object.
    #[error(transparent)]
    Buckets(#[from] occlusion::BucketError),
    /// A target that the passes were not compiled for.
    #[error(transparent)]
    Attachments(#[from] occlusion::WrongAttachments),
    /// A target that does not fit the plan.
    #[error(transparent)]
    Target(#[from] occlusion::TargetError),
    /// A frame without the changes of the scene that it draws.
    #[error(transparent)]
    NotUploaded(#[from] occlusion::NotUploaded),
    /// A method that executed a plan which it had not made for the scene as it is.
    #[error("a method executed a plan that it had not made: plan each view once per frame")]
    NoPlan,
    /// A plan with draws among its tests, and a host that takes its draws as lists.
    #[error(transparent)]
    DrawsAmongTests(#[from] occlusion::DrawsAmongTests),
    /// A request for shaders that this build cannot compile.
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
            occlusion::Error::Buckets(error) => Self::Buckets(error),
            occlusion::Error::Attachments(error) => Self::Attachments(error),
            occlusion::Error::Target(error) => Self::Target(error),
            occlusion::Error::DrawsAmongTests(error) => Self::DrawsAmongTests(error),
            occlusion::Error::NotUploaded(error) => Self::NotUploaded(error),
            occlusion::Error::NoPlan => Self::NoPlan,
            occlusion::Error::ForeignView => Self::ForeignRenderer { thing: FOREIGN_VIEW },
            occlusion::Error::NoShaderCompiler(folder) => Self::NoShaderCompiler(folder),
        }
    }
}
