//! What a file becomes: a scene, the rig it hangs on, and what plays on that.

use std::sync::Arc;

use animation::{Clip, NodeId, Pose, Rig, Skin};
use cull::{Aabb, ObjectId};
use glam::{Affine3A, Vec3};
use render::scene::{BlendedId, DeformerId, LightId, Scene};

/// A camera of the file. It looks along its node's -z, up is y.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Its node's name, or its own.
    pub name: String,
    /// Where it is.
    pub node: NodeId,
    /// The full vertical angle of sight, in radians.
    pub fov_y_rad: f32,
    /// Distance of the near plane, in metres.
    pub near_m: f32,
    /// How far behind its node the eye is, in metres: 0 but for what stands for an orthographic camera.
    pub behind_m: f32,
}

/// What hangs on a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placed {
    /// An object of [`Scene::objects`].
    Object(ObjectId),
    /// An object of [`Surfaces::blended`](render::scene::Surfaces::blended).
    Blended(BlendedId),
    /// A light.
    Light(LightId),
}

/// Something that moves, or that changes its form.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// The node of the file that has it, and where it goes. What hangs on a skin goes where its joints go
    /// instead: it is in the space of its skeleton, [`Skeleton::space`](animation::Skeleton::space), which is
    /// made of the joints that its vertices follow.
    pub node: NodeId,
    /// What.
    pub placed: Placed,
    /// From its own space to its node's.
    pub local: Affine3A,
    /// What changes its form, with the index of its skin in [`Imported::skins`].
    pub deformer: Option<(DeformerId, Option<usize>)>,
    /// The box, in its own space, that it is in while nothing plays; empty where it does not change its
    /// form. Its mesh's own bounds are those of its vertices before joints and targets move them.
    pub rest_bounds: Aabb,
    /// A box in the world around what is seen of it at rest; empty where it does not change its form.
    pub seen_at_rest: Aabb,
    /// For clips that change its form, by their numbers, a box in its own space that it stays in while that
    /// clip plays alone. Where there are too many to find all, some are not here:
    /// [`Placement::blend_bounds`] holds for them too. Clips that are not here and do not change its form
    /// leave it in [`Placement::rest_bounds`].
    pub clip_bounds: Arc<[(usize, Aabb)]>,
    /// A box, in its own space, that it stays in whatever clips play, together or one after the other;
    /// empty where it does not change its form.
    pub blend_bounds: Aabb,
}

/// A scene and its life.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The scene at rest.
    pub scene: Scene,
    /// Its nodes.
    pub rig: Rig,
    /// What plays on them.
    pub clips: Vec<Clip>,
    /// The joints of skinned meshes.
    pub skins: Vec<Skin>,
    /// What moves: all that hangs on a node that a clip moves, and all that changes its form. What is in the
    /// scene and not here stays where it is.
    pub placements: Vec<Placement>,
    /// Its cameras.
    pub cameras: Vec<Camera>,
    /// What was in the file that is not shown, for people.
    pub notes: Vec<String>,
}

impl Placement {
    /// The box of a clip that changes its form and plays alone.
    pub fn bounds_of(&self, clip: usize) -> Aabb {
        let place = self.clip_bounds.binary_search_by_key(&clip, |(clip, _)| *clip);
        let found = place.ok().and_then(|place| self.clip_bounds.get(place));
        found.map_or(self.blend_bounds, |(_, bounds)| *bounds)
    }
}

impl Imported {
    /// The box around everything that is seen, at rest; the origin alone if there is nothing.
    pub fn bounds(&self) -> Aabb {
        crate::convert::bounds(self)
    }

    /// What the first camera of the file sees at rest; without one a view of the whole scene, three
    /// quarters from the front and somewhat from above.
    pub fn default_camera(&self) -> cull::Camera {
        let Some(camera) = self.cameras.first() else {
            return crate::convert::overview(&self.bounds());
        };
        let mut worlds = Vec::new();
        self.rig.world(&Pose::new(&self.rig), &mut worlds);
        let world = worlds.get(camera.node.0 as usize).copied().unwrap_or(Affine3A::IDENTITY);
        let axis = |axis: glam::Vec3A| Vec3::from(axis).try_normalize();
        let forward = axis(-world.matrix3.z_axis).unwrap_or(Vec3::NEG_Z);
        let up = axis(world.matrix3.y_axis).filter(|up| up.cross(forward).length() > 1e-3);
        cull::Camera {
            eye: Vec3::from(world.translation) - forward * camera.behind_m,
            forward,
            up: up.unwrap_or_else(|| forward.any_orthonormal_vector()),
            fov_y: camera.fov_y_rad,
            near: camera.near_m,
        }
    }
}
