//! The reasons why changes of a scene are refused.

use scene::MeshId;

/// The reason why a change of the scene cannot be made, with advice.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ChangeError {
    /// The object did not exist before the update, or an earlier change removes it.
    #[error(
        "object {} is not in the scene, or an earlier change removes it: name an object that stays",
        object.0
    )]
    UnknownObject {
        /// The id of the object.
        object: cull::ObjectId,
    },
    /// The scene has no mesh with the id of the new object's mesh.
    #[error("the scene has no such mesh as {}: add it with `Renderer::add_meshes`", mesh.0)]
    UnknownMesh {
        /// The id of the mesh.
        mesh: MeshId,
    },
    /// The transform leads to infinite or NaN coordinates, or beyond [`cull::MAX_COORDINATE`].
    #[error(
        "its transform takes it nowhere: check it for infinities, NaN, and coordinates beyond {:e}",
        cull::MAX_COORDINATE
    )]
    BadTransform,
    /// The mesh of the new object is skinned and belongs to another object. The box of one object
    /// would not hold the other.
    #[error("its mesh is skinned and another object has it: remove that first")]
    SkinnedMeshInUse {
        /// The id of the mesh.
        mesh: MeshId,
    },
    /// There is no room for another object.
    #[error(
        "the hierarchy has no free leaf: remove an object first, or make the renderer with more \
         `RendererOptions::spare_objects`"
    )]
    NoFreeLeaf,
}

/// The reason why a mesh cannot take a pose.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// The scene has no skinned mesh with this id.
    #[error("the scene has no such skinned mesh")]
    UnknownSkinnedMesh,
    /// The number of joints is wrong.
    #[error("it has {joints} joints, not {given}")]
    JointCount {
        /// The number of joints of the mesh.
        joints: usize,
        /// The number of joints of the pose.
        given: usize,
    },
    /// The number of weights is wrong.
    #[error("it has {targets} morph targets, not {given}")]
    TargetCount {
        /// The number of morph targets of the mesh.
        targets: usize,
        /// The number of weights of the pose.
        given: usize,
    },
    /// The transform of a joint has a number that is infinite or NaN.
    #[error("its joint {joint} has a number that is not finite")]
    JointNotFinite {
        /// The index of the joint.
        joint: usize,
    },
    /// The weight of a morph target is infinite or NaN.
    #[error("the weight of its target {target} is not finite")]
    WeightNotFinite {
        /// The index of the morph target.
        target: usize,
    },
    /// The pose moves vertices beyond [`cull::MAX_COORDINATE`] in the space of the mesh.
    #[error("it takes the mesh beyond all that can be drawn")]
    MeshOutOfRange,
    /// The pose moves the object beyond [`cull::MAX_COORDINATE`] in the world.
    #[error("it takes its object farther than anything can be")]
    ObjectOutOfRange,
}

/// The reason why a transparent object cannot be moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TransparentError {
    /// The scene has no transparent object with this id.
    #[error("the scene has no such transparent object")]
    UnknownObject,
    /// The transform leads to infinite or NaN coordinates, or beyond [`cull::MAX_COORDINATE`].
    #[error(
        "its transform takes it nowhere: check it for infinities, NaN, and coordinates beyond {:e}",
        cull::MAX_COORDINATE
    )]
    BadTransform,
}

/// The reason why a light cannot be changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LightError {
    /// The scene has no surfaces.
    #[error("the scene has no surfaces that it could light")]
    NoSurfaces,
    /// The scene has no light with this id.
    #[error("the scene has no such light")]
    UnknownLight,
    /// The light is of another kind than its replacement.
    #[error("it cannot become another kind of light: remove it and add another")]
    OtherKind,
    /// The picture of the light cannot be used.
    #[error("{fault}")]
    Cookie {
        /// The fault, as the end of a sentence.
        fault: &'static str,
    },
    /// The width of penumbras is negative, NaN or too large.
    #[error("the width of its penumbras must be a number of metres from 0 to below 1e3")]
    PenumbraWidth,
}
