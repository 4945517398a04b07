//! The reasons why meshes, textures and materials are not added, replaced or removed.

/// The reason why a mesh cannot be added or removed, with advice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The scene has surfaces and the mesh has none.
    #[error("the scene has surfaces and the mesh has none")]
    SurfaceMissing,
    /// The mesh has a surface and the scene has none.
    #[error("the scene has no surfaces and the mesh has one")]
    NoSurfaces,
    /// The material of the mesh does not exist.
    #[error("the scene does not have its material")]
    UnknownMaterial,
    /// The material of the mesh blends.
    #[error("its material blends, and transparent meshes cannot be added")]
    Transparent,
    /// The mesh does not exist.
    #[error("the renderer has no such mesh")]
    UnknownMesh,
    /// The mesh is skinned or of sprites.
    #[error("meshes that are skinned or of sprites stay")]
    Permanent,
    /// Objects have the mesh.
    #[error("objects have it: remove those first")]
    InUse,
    /// One call removes the mesh twice.
    #[error("it is named twice")]
    NamedTwice,
}

/// The reason why a texture cannot be added or removed, with advice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// The scene has no surfaces.
    #[error("the scene has no surfaces")]
    NoSurfaces,
    /// A side of the texture is beyond the device's limits.
    #[error("the device has no images of its size")]
    Size,
    /// No room is kept for textures of this kind.
    #[error("no room is kept for its size, encoding and sampler (`SpareCapacity::textures`)")]
    NoRoomForKind,
    /// The renderer began with the texture.
    #[error("it belongs to the scene that the renderer began with, and stays")]
    Permanent,
    /// The texture does not exist.
    #[error("the renderer has no such texture")]
    UnknownTexture,
    /// Materials or lights use the texture.
    #[error("materials use it, or lights project it: change those first")]
    InUse,
    /// One call removes the texture twice.
    #[error("it is named twice")]
    NamedTwice,
}

/// The reason why a material cannot be added, replaced or removed, with advice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MaterialError {
    /// The scene has no surfaces.
    #[error("the scene has no surfaces")]
    NoSurfaces,
    /// The material blends.
    #[error("it blends, and transparent objects cannot be added")]
    Transparent,
    /// The material is broken ([`Material::check`](scene::Material::check)).
    #[error("{fault}")]
    Broken {
        /// The fault, as the end of a sentence.
        fault: &'static str,
    },
    /// A texture of the material is not on the GPU.
    #[error(
        "one of its textures is not on the GPU: it was removed, or no material of the scene that \
         the renderer began with used it"
    )]
    UnknownTexture,
    /// A texture of the material has the wrong encoding.
    #[error(
        "it samples numbers as colours, or colours as numbers: base colours and emission are \
         `Encoding::Srgb`, all others `Encoding::Linear`"
    )]
    Encoding,
    /// The material does not exist.
    #[error("the renderer has no such material")]
    UnknownMaterial,
    /// The material or its replacement is not opaque.
    #[error("only opaque materials can be replaced, by opaque ones")]
    NotOpaque,
    /// Meshes have the material.
    #[error("meshes have it: remove those first")]
    InUse,
    /// One call removes the material twice.
    #[error("it is named twice")]
    NamedTwice,
}
