//! The scene as pure data: meshes, materials, objects, lights, and their changes.
//!
//! No Vulkan, no files, no unsafe code. [`Scene::validate`] checks that a renderer can draw a
//! scene; [`limits`] holds the sizes that every device takes.
//!
//! ```
//! # use antumbra_scene as scene;
//! use scene::{Mesh, Scene};
//!
//! let red = [1.0, 0.1, 0.1];
//! let corners = [([-1.0, 0.0, 0.0], red), ([1.0, 0.0, 0.0], red), ([0.0, 1.0, 0.0], red)];
//! let scene = Scene::single(Mesh::of_triangles("triangle", &corners));
//! assert_eq!((scene.triangles(), scene.validate()), (1, Ok(())));
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod api;
mod backdrop;
mod check;
mod crease;
mod environment;
mod error;
mod feature_edges;
mod flare;
mod image;
pub mod limits;
mod mesh;
mod patches;
mod pieces;
mod pose_bounds;
mod prepared_mesh;
mod prepared_texture;
mod punctual_light;
mod shell;
mod signed_volume;
mod sprites;
mod surface;
#[cfg(test)]
mod tests;
mod update;
mod vertex_surfaces;
mod words;

use std::f32::consts::PI;

use cull::Aabb;
use glam::{Affine3A, Vec3, vec3};

pub use backdrop::{Backdrop, Panorama, Sky, SkyDisk};
pub use crease::{CREASE_RAD, CreasedTriangles, creased};
pub use environment::{ENVIRONMENT_SIDE, Environment, GLOSSY_LEVELS};
pub use error::SceneError;
pub use feature_edges::{EdgeChain, EdgeKind, EdgeRules, EdgeSegment, EdgeSource, FeatureEdges};
pub use flare::{FlarePlace, LensFlare};
pub use glam;
pub use image::{AstcBlock, BlockFormat, Image, Texels};
pub use mesh::{
    Mesh, MeshId, Object, Vertex, bounds_of_transformed, bounds_of_vertices, pack_normal,
    pack_unorm, round_half_away, unpack_normal, unpack_unorm,
};
pub use patches::{
    EvaluatedPoint, MAX_LEVEL, MAX_PATCHES, Patch, PatchEdge, PatchError, PatchSides, PatchSurface,
    SurfaceGrid, SurfacePoint, TessellationLevels, TessellationView, captured_mesh,
    captured_triangle_count, ellipsoid, evaluated, tessellated,
};
pub use pieces::{PieceLimits, PieceMap, spatial_pieces};
pub use pose_bounds::PoseBounds;
pub use prepared_mesh::PreparedMesh;
pub use prepared_texture::PreparedTexture;
pub use punctual_light::{LightCookie, LightKind, PunctualLight};
pub use shell::Shell;
pub use signed_volume::{ENCLOSING, signed_volume};
pub use sprites::{MAX_SPRITES, SpriteEnd, SpriteShape, Sprites, pack_sprite_colour};
pub use surface::{
    Alpha, Encoding, Filter, ImageId, LightId, LodLevel, Material, MaterialId, MorphTarget,
    Sampler, SkinWeights, SkinnedMesh, SkinnedMeshId, SurfaceMesh, SurfaceVertex, Surfaces,
    Texture, TextureId, TextureUse, TransparentId, Wrap,
};
pub use update::{LightMove, ObjectChange, PoseUpdate, SceneUpdate, TransparentMove};
pub use words::counted;

/// The default vertical field of view, in radians.
pub const FOV_Y_RAD: f32 = 60.0 * PI / 180.0;

/// The default distance of the near plane, in metres.
pub const NEAR_M: f32 = 0.2;

/// One directional light, and the ambient light. All colours are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector from the scene to the sun.
    pub towards_sun: Vec3,
    /// The sun's light on a surface that faces it.
    pub sun: [f32; 3],
    /// Light on surfaces that face up.
    pub ambient_above: [f32; 3],
    /// Light on surfaces that face down; other surfaces mix both lights by their normal's y.
    pub ambient_below: [f32; 3],
    /// The colour of the background.
    pub sky: [f32; 3],
}

impl Light {
    /// Returns a clear afternoon.
    pub fn afternoon() -> Self {
        Self {
            towards_sun: vec3(0.48, 0.72, 0.5).normalize_or(Vec3::Y),
            sun: [1.02, 0.93, 0.78],
            ambient_above: [0.36, 0.42, 0.52],
            ambient_below: [0.20, 0.18, 0.16],
            sky: [0.36, 0.56, 0.80],
        }
    }

    /// Returns a sky that fits this light: about the colour of its background, with a ground as
    /// bright as its ambient light.
    #[must_use]
    pub fn sky_around(&self) -> Sky {
        let sky = Vec3::from_array(self.sky);
        let pale = Vec3::splat(0.95 * sky.max_element());
        Sky {
            towards_sun: self.towards_sun.normalize_or(Vec3::Y),
            zenith: (sky * 0.8).to_array(),
            horizon: sky.lerp(pale, 0.5).to_array(),
            ground: self.ambient_below,
            glow: self.sun.map(|part| part * 0.2),
        }
    }
}

/// A world to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The name, for people and reports.
    pub name: String,
    /// The meshes that objects name.
    pub meshes: Vec<Mesh>,
    /// The objects; neighbours in the list should be near each other.
    pub objects: Vec<Object>,
    /// The sun, the ambient light and the colour of the sky.
    pub light: Light,
    /// The surfaces; `None` if the vertices hold the whole appearance.
    pub surfaces: Option<Surfaces>,
}

impl Scene {
    /// Returns a scene of one object without a transform.
    pub fn single(mesh: Mesh) -> Self {
        let transform = Affine3A::IDENTITY;
        let tint = u32::MAX;
        Self {
            name: mesh.name.clone(),
            meshes: vec![mesh],
            objects: vec![Object { mesh: MeshId(0), transform, tint }],
            light: Light::afternoon(),
            surfaces: None,
        }
    }

    /// Returns the scene with [`Surfaces`], so that punctual lights shine on it. The vertex colours
    /// become a matt material, and the sun becomes a directional light of equal brightness. Tints
    /// of objects and the ambient light stay as they are. A scene that has surfaces is returned
    /// unchanged.
    #[must_use]
    pub fn with_surfaces(mut self) -> Self {
        if self.surfaces.is_none() {
            let Light { towards_sun, sun, .. } = self.light;
            let surfaces = vertex_surfaces::of_vertex_colours(&self.meshes, towards_sun, sun);
            self.surfaces = Some(surfaces);
        }
        self
    }

    /// Returns the mesh of an object, if the scene has it.
    pub fn mesh_of(&self, object: &Object) -> Option<&Mesh> {
        self.meshes.get(object.mesh.0 as usize)
    }

    /// Returns the box around an object in the world, in metres: the box around its transformed
    /// mesh box. The result is exact for quarter turns and larger than necessary for other
    /// rotations. `None` if the object's mesh is not in the scene.
    ///
    /// Each bound is computed in the order of operations of `transform * position` (after J. Arvo,
    /// "Transforming Axis-Aligned Bounding Boxes", Graphics Gems), so a vertex that is transformed
    /// in the same order never lies outside. A vertex that is transformed in another order, or with
    /// fused multiplication, may lie outside by the last place.
    pub fn bounds_of(&self, object: &Object) -> Option<Aabb> {
        Some(bounds_of_transformed(&self.mesh_of(object)?.bounds, &object.transform))
    }

    /// Returns the number of triangles of all objects.
    pub fn triangles(&self) -> u64 {
        let mut of_mesh: Vec<u64> = self.meshes.iter().map(Mesh::triangles).collect();
        for sprites in self.surfaces.iter().flat_map(|surfaces| &surfaces.sprites) {
            if let Some(triangles) = of_mesh.get_mut(sprites.mesh.0 as usize) {
                *triangles = 2 * sprites.count() as u64;
            }
        }
        let of_object = |object: &Object| of_mesh.get(object.mesh.0 as usize).copied();
        self.objects.iter().filter_map(of_object).sum()
    }

    /// Checks that a renderer can draw the scene.
    ///
    /// The first fault: a mesh with indices beyond its vertices; an object without a mesh; a part
    /// of the surfaces that does not belong to the scene; a value anywhere that is infinite or NaN.
    pub fn validate(&self) -> Result<(), SceneError> {
        for mesh in &self.meshes {
            let broken = |fault| Err(SceneError::BrokenMesh { mesh: mesh.name.clone(), fault });
            if !mesh.indices.len().is_multiple_of(3) {
                return broken("its number of indices is not a multiple of 3");
            }
            if mesh.indices.iter().any(|&index| index as usize >= mesh.vertices.len()) {
                return broken("an index names a vertex that it does not have");
            }
            if mesh
                .vertices
                .iter()
                .any(|vertex| vertex.position.iter().any(|part| !part.is_finite()))
            {
                return broken("a position is not a finite number");
            }
        }
        let are_sprites = check::sprite_meshes(self);
        for (mesh, are_sprites) in self.meshes.iter().zip(are_sprites) {
            if !are_sprites && mesh.bounds != bounds_of_vertices(&mesh.vertices) {
                let fault = "its bounds are not the box around its vertices";
                return Err(SceneError::BrokenMesh { mesh: mesh.name.clone(), fault });
            }
        }
        for (index, object) in self.objects.iter().enumerate() {
            let broken = |fault| Err(SceneError::BrokenObject { index, fault });
            if self.mesh_of(object).is_none() {
                return broken("the scene does not have its mesh");
            }
            if !object.transform.is_finite() {
                return broken("its transform has a number that is not finite");
            }
        }
        match &self.surfaces {
            Some(surfaces) => check::check_surfaces(self, surfaces),
            None => Ok(()),
        }
    }
}
