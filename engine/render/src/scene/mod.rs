//! Scenes as pure data: meshes, objects, light, and where one can walk or fly through them.
//!
//! [`city`] and [`field`] make them from a number of objects and a seed. Objects of a generated scene
//! neither touch nor have coplanar faces, and what stands on the ground hovers 2 cm over it: so each
//! pixel's colour does not depend on the order in which objects are drawn. Only the ground's tiles
//! share edges, with bit-identical vertices.

mod builder;
mod check;
mod city;
mod field;
mod mesh;
mod motion;
mod outwardness;
mod path;
mod random;
mod single;
mod sprites;
mod surface;
#[cfg(test)]
mod tests;

use cull::{Aabb, ObjectId};
use glam::{Affine3A, Mat3A, Vec3, Vec3A, vec3, vec3a};

pub use city::city;
pub use field::field;
pub use mesh::{
    Mesh, MeshId, Vertex, bounds_of_vertices, pack_normal, pack_unorm, unpack_normal, unpack_unorm,
};
pub use motion::{Cast, Motion, MotionError};
pub use outwardness::{ENCLOSING, outwardness};
pub use path::{CameraPath, EYE_HEIGHT_M, FOV_Y_RAD, NEAR_M, PathKind};
pub use sprites::{MAX_SPRITES, SpriteEnd, SpriteShape, Sprites, pack_sprite_colour};
pub use surface::{
    Alpha, BlendedId, Deformer, DeformerId, Encoding, Filter, Image, ImageId, Level, LightId,
    LightKind, Material, MaterialId, MorphTarget, PunctualLight, Sampler, SkinWeights, SurfaceMesh,
    SurfaceVertex, Surfaces, Texture, TextureId, TextureUse, Wrap,
};

/// The most objects that a generated scene can have.
pub const MAX_OBJECTS: u32 = 2_000_000;

/// How far a thing hovers over what carries it, in metres.
pub(crate) const HOVER_M: f32 = 0.02;

/// Why a scene or a path cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// No objects at all, or more than a generated scene can hold.
    #[error("a scene has 1 to {MAX_OBJECTS} objects, not {asked}: choose a number in that range")]
    ObjectCount {
        /// The number that was asked for.
        asked: u32,
    },
    /// Less memory can be had than the objects take.
    #[error("there is no memory for a scene of {count} objects: use fewer, or end other programs")]
    NoMemory {
        /// How many there were.
        count: u32,
    },
    /// A motion that cannot be made.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A name that no camera path has.
    #[error("there is no camera path named \"{name}\": choose street, fly or cut")]
    UnknownPath {
        /// The name that was asked for.
        name: String,
    },
    /// The scene has no streets, so nobody can walk in it.
    #[error("the scene \"{scene}\" has no streets to walk along: choose the path fly")]
    NoStreets {
        /// The scene's name.
        scene: String,
    },
    /// A mesh that cannot be drawn.
    #[error("the mesh \"{mesh}\" cannot be drawn: {fault}")]
    BrokenMesh {
        /// The mesh's name.
        mesh: String,
        /// What is wrong with it.
        fault: &'static str,
    },
    /// Surfaces that cannot be drawn.
    #[error("{part} {index} of the surfaces cannot be drawn: {fault}")]
    BrokenSurfaces {
        /// Which kind of part: a mesh, a material, a deformer...
        part: &'static str,
        /// Its place among its like.
        index: usize,
        /// What is wrong with it.
        fault: &'static str,
    },
    /// An object that cannot be drawn.
    #[error("object {index} cannot be drawn: {fault}")]
    BrokenObject {
        /// Its place in [`Scene::objects`].
        index: usize,
        /// What is wrong with it.
        fault: &'static str,
    },
}

/// A mesh somewhere in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// What is drawn.
    pub mesh: MeshId,
    /// From the mesh's space to the world's, in metres; y is up. Generated scenes have quarter turns
    /// about y (exact: each column one of the axes) and uniform scales only.
    pub transform: Affine3A,
    /// Linear red, green, blue as unorm8x4, red in the lowest byte; alpha has no meaning. See
    /// [`Vertex::colour`].
    pub tint: u32,
}

/// Something that happens to an object between two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectChange {
    /// It is somewhere else.
    Move {
        /// The object.
        object: ObjectId,
        /// Where it is now.
        transform: Affine3A,
    },
    /// It has another form, for which its mesh's box may be too small, and perhaps another place.
    Reshape {
        /// The object.
        object: ObjectId,
        /// Where it is now.
        transform: Affine3A,
        /// The box around it in its own space, before `transform`. It stays that of the object when
        /// it moves, until it is told another.
        bounds: Aabb,
    },
    /// It is gone; its id may be given to another.
    Remove {
        /// The object.
        object: ObjectId,
    },
    /// It was not there before. The update says which id it gets.
    Add {
        /// What comes. Its mesh is one of the scene's.
        object: Object,
    },
}

/// One directional light, and what comes from everywhere else. All colours are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector from the scene to the sun.
    pub towards_sun: Vec3,
    /// The sun's light on a surface that faces it.
    pub sun: [f32; 3],
    /// Light on surfaces that face up.
    pub ambient_above: [f32; 3],
    /// Light on surfaces that face down; in between, mix by the normal's y.
    pub ambient_below: [f32; 3],
    /// What is seen where nothing is.
    pub sky: [f32; 3],
}

impl Light {
    /// A clear afternoon.
    pub fn afternoon() -> Self {
        Self {
            towards_sun: vec3(0.48, 0.72, 0.5).normalize_or(Vec3::Y),
            sun: [1.02, 0.93, 0.78],
            ambient_above: [0.36, 0.42, 0.52],
            ambient_below: [0.20, 0.18, 0.16],
            sky: [0.36, 0.56, 0.80],
        }
    }
}

/// Where one can walk: straight lines parallel to x and z, all of them crossing. At least 0.3 m around
/// every line, and around every turn with the given radius, no object's box is met at eye level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Streets {
    /// The x of the lines that run along z, in metres, ascending.
    pub xs: Vec<f32>,
    /// The z of the lines that run along x, in metres, ascending.
    pub zs: Vec<f32>,
    /// The radius of turns from line to line, in metres.
    pub turn_radius_m: f32,
}

/// A round trip over the roofs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// The middle of the circle, at the height of the eye, in metres.
    pub centre: Vec3,
    /// Its radius in metres.
    pub radius_m: f32,
    /// How far the view looks down, in radians.
    pub down_rad: f32,
}

/// A world to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// What it is, for people and reports.
    pub name: String,
    /// What it was made from; the same seed and number of objects give the same bytes.
    pub seed: u64,
    /// The meshes that objects name.
    pub meshes: Vec<Mesh>,
    /// The objects, neighbours near each other.
    pub objects: Vec<Object>,
    /// Its light.
    pub light: Light,
    /// Where to walk; empty where one cannot.
    pub streets: Streets,
    /// Where to fly.
    pub flight: Flight,
    /// What it looks like close by; `None` where vertices say it all.
    pub surfaces: Option<Surfaces>,
}

impl Scene {
    /// The mesh of an object, if the scene has it.
    pub fn mesh_of(&self, object: &Object) -> Option<&Mesh> {
        self.meshes.get(object.mesh.0 as usize)
    }

    /// The box around an object in the world, in metres: the box of its mesh's box, exact for quarter
    /// turns, larger than need be for others. `None` if the object's mesh is not in the scene.
    ///
    /// Each bound is computed in the order of operations of `transform * position` (after J. Arvo,
    /// "Transforming Axis-Aligned Bounding Boxes", Graphics Gems), so a vertex that is transformed in
    /// that order never lies outside; one that is transformed in another order, or with fused
    /// multiplication, may by the last place.
    pub fn bounds_of(&self, object: &Object) -> Option<Aabb> {
        Some(bounds_of_transformed(&self.mesh_of(object)?.bounds, &object.transform))
    }

    /// How many triangles its objects have together.
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

    /// Checks that everything can be drawn.
    ///
    /// # Errors
    /// The first mesh whose indices do not fit its vertices or whose numbers are not finite, the first
    /// object that names no mesh or stands nowhere, or the first of its surfaces that does not belong
    /// to it or has a number that is none.
    pub fn validate(&self) -> Result<(), SceneError> {
        for mesh in &self.meshes {
            let broken = |fault| Err(SceneError::BrokenMesh { mesh: mesh.name.clone(), fault });
            if !mesh.indices.len().is_multiple_of(3) {
                return broken("its number of indices is no multiple of 3");
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

/// The box around a transformed box; [`Scene::bounds_of`] says how exact it is.
pub fn bounds_of_transformed(bounds: &Aabb, transform: &Affine3A) -> Aabb {
    let extremes = |column: Vec3A, low: f32, high: f32| {
        let (a, b) = (column * low, column * high);
        (a.min(b), a.max(b))
    };
    let x = extremes(transform.matrix3.x_axis, bounds.min.x, bounds.max.x);
    let y = extremes(transform.matrix3.y_axis, bounds.min.y, bounds.max.y);
    let z = extremes(transform.matrix3.z_axis, bounds.min.z, bounds.max.z);
    Aabb {
        min: (x.0 + y.0 + z.0 + transform.translation).into(),
        max: (x.1 + y.1 + z.1 + transform.translation).into(),
    }
}

/// Returns room for so many objects.
fn room_for_objects(asked: u32) -> Result<Vec<Object>, SceneError> {
    if !(1..=MAX_OBJECTS).contains(&asked) {
        return Err(SceneError::ObjectCount { asked });
    }
    let mut objects = Vec::new();
    let reserved = objects.try_reserve_exact(asked as usize);
    reserved.map(|()| objects).map_err(|_| SceneError::NoMemory { count: asked })
}

/// Turns +z to side `side` (0: +z, 1: +x, 2: -z, 3: -x), scales, and moves. Exact: the matrix holds
/// zeros and the scale only.
pub(crate) fn placement(side: usize, scale: f32, position: Vec3) -> Affine3A {
    let (x, z) = match side % 4 {
        0 => (Vec3A::X, Vec3A::Z),
        1 => (Vec3A::NEG_Z, Vec3A::X),
        2 => (Vec3A::NEG_X, Vec3A::NEG_Z),
        _ => (Vec3A::Z, Vec3A::NEG_X),
    };
    Affine3A {
        matrix3: Mat3A::from_cols(x * scale, vec3a(0.0, scale, 0.0), z * scale),
        translation: position.into(),
    }
}

/// The part of `total` that the `index`-th of `count` gets when it is dealt out evenly.
pub(crate) fn share(total: u32, index: u32, count: u32) -> u32 {
    let up_to = |index: u64| u64::from(total) * index / u64::from(count.max(1));
    (up_to(u64::from(index) + 1) - up_to(u64::from(index))) as u32
}
