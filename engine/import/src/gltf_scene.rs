//! The result of loading a file: a scene, its rig, and its clips.

use animation::{Clip, Pose, Rig, RigNodeId, Skin};
use cull::{Aabb, ObjectId, Projection, trigonometry};
use glam::{Affine3A, DVec3, Vec3};
use scene::{LightId, Scene, SkinnedMeshId, TransparentId};

use crate::Note;
use crate::lods::{self, LevelOptions};

/// A camera of the file. It looks along -z of its node, with y upwards.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// The name of its node, or of the camera.
    pub name: String,
    /// The node to which it is attached.
    pub node: RigNodeId,
    /// The projection for images at least as wide as [`SceneCamera::aspect_ratio`].
    pub projection: Projection,
    /// The aspect ratio of its image; `None` if the file does not specify it.
    pub aspect_ratio: Option<f32>,
    /// The distance of the near plane, in metres.
    pub near_m: f32,
}

impl SceneCamera {
    /// The widest field of view, in radians.
    const WIDEST_RAD: f32 = std::f32::consts::PI - 0.1;

    /// Returns the projection for images of `size` pixels. In images that are narrower than the
    /// camera's own, its field of view is higher, so that nothing is cut off at the sides.
    pub fn projection_in(&self, size: [u32; 2]) -> Projection {
        let [width, height] = size.map(|side| side.max(1) as f32);
        let narrower = (self.aspect_ratio.unwrap_or_default() * height / width).max(1.0);
        match self.projection {
            Projection::Perspective { fov_y } if narrower > 1.0 => {
                let wider = 2.0 * trigonometry::atan(trigonometry::tan(fov_y * 0.5) * narrower);
                Projection::perspective(wider.clamp(fov_y, Self::WIDEST_RAD.max(fov_y)))
            }
            Projection::Orthographic { height, far } => {
                Projection::Orthographic { height: height * narrower, far }
            }
            as_it_is => as_it_is,
        }
    }

    /// Returns the camera for images of `size` pixels while its node is at `world`.
    pub(crate) fn seen_from(&self, world: &Affine3A, size: [u32; 2]) -> cull::Camera {
        let forward = Vec3::from(-world.matrix3.z_axis).try_normalize().unwrap_or(Vec3::NEG_Z);
        // The image is upright under any transform of the node.
        let up = Vec3::from(world.matrix3.y_axis).reject_from_normalized(forward).try_normalize();
        cull::Camera {
            eye: world.translation.into(),
            forward,
            up: up.unwrap_or_else(|| forward.any_orthonormal_vector()),
            projection: self.projection_in(size),
            near: self.near_m,
        }
    }
}

/// An object or light that is attached to a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlacedNode {
    /// An object of [`Scene::objects`].
    Object(ObjectId),
    /// An object of [`Surfaces::transparent`](scene::Surfaces::transparent).
    Transparent(TransparentId),
    /// A light of [`Surfaces::lights`](scene::Surfaces::lights).
    Light(LightId),
}

/// An attached object or light that moves or is posed.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeAttachment {
    /// The node of the file to which it is attached. An unskinned object moves with this node. A
    /// skinned object moves with its joints and is in the space of its skeleton
    /// ([`Skeleton::space`](animation::Skeleton::space)), for the joints that its vertices follow.
    pub node: RigNodeId,
    /// The attached object or light.
    pub placed: PlacedNode,
    /// The transform from its space to the node's.
    pub local: Affine3A,
    /// The skinned mesh, with the index of its skin in [`GltfScene::skins`].
    pub skinned_mesh: Option<(SkinnedMeshId, Option<usize>)>,
    /// The box around it in the world at rest; empty if it is not skinned.
    pub seen_at_rest: Aabb,
    /// A loose box in its own space that it never leaves under any mix of the clips; empty if it is
    /// not skinned.
    pub reach: Aabb,
}

/// A scene and its animation.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfScene {
    /// The scene at rest.
    pub scene: Scene,
    /// The point of the file that became the scene's origin, in whole metres: zero unless
    /// [`ScenePlace::NearOrigin`](crate::ScenePlace::NearOrigin) moved the scene.
    pub origin_m: DVec3,
    /// The nodes of the shown scene, at rest.
    pub rig: Rig,
    /// The node of each object of the scene; empty for files without nodes.
    pub object_nodes: Vec<RigNodeId>,
    /// The clips that animate the nodes.
    pub clips: Vec<Clip>,
    /// The joints of skinned meshes.
    pub skins: Vec<Skin>,
    /// Everything that moves: objects and lights on nodes that a clip moves, and all skinned
    /// objects. Other objects never move.
    pub placements: Vec<NodeAttachment>,
    /// The cameras of the shown scene, in the order of the file's list.
    pub cameras: Vec<SceneCamera>,
    /// The tolerated deviations of the file, and the parts that are not shown.
    pub notes: Vec<Note>,
}

impl GltfScene {
    /// Returns the box around everything visible at rest; the origin if there is nothing.
    pub fn bounds(&self) -> Aabb {
        bounds(self)
    }

    /// Returns a view of everything visible at rest, diagonally from the front and above, for
    /// images at least four thirds as wide as high.
    pub fn overview(&self) -> cull::Camera {
        crate::convert::framing::overview(&self.bounds())
    }

    /// Returns the first camera of the file at rest, for images of `size` pixels. Without a camera,
    /// returns a view of the whole scene, diagonally from the front and above.
    pub fn default_camera(&self, size: [u32; 2]) -> cull::Camera {
        let Some(camera) = self.cameras.first() else { return self.overview() };
        let mut worlds = Vec::new();
        self.rig.world(&Pose::new(&self.rig), &mut worlds);
        let world = worlds.get(camera.node.0 as usize).copied().unwrap_or(Affine3A::IDENTITY);
        camera.seen_from(&world, size)
    }

    /// Creates coarser levels of all meshes except skinned and transparent ones. The levels take
    /// about as much index memory as the meshes. Meshes with corners in which thousands of
    /// triangles meet get no coarser levels, and a note says so: simplification takes time
    /// proportional to the square of their number.
    pub fn make_levels(&mut self, options: &LevelOptions) {
        self.notes.extend(lods::make_levels(&mut self.scene, options));
    }
}

/// Returns the box around everything at rest; the origin if there is nothing.
fn bounds(imported: &GltfScene) -> Aabb {
    let scene = &imported.scene;
    let transparent = scene.surfaces.iter().flat_map(|surfaces| &surfaces.transparent);
    let objects = scene.objects.len();
    // A skinned object is not shown where its mesh is.
    let skinned = imported.placements.iter().filter(|placement| placement.skinned_mesh.is_some());
    let seen: std::collections::HashMap<usize, Aabb> = skinned
        .filter_map(|placement| match placement.placed {
            PlacedNode::Object(id) => Some((id.0 as usize, placement.seen_at_rest)),
            PlacedNode::Transparent(id) => Some((objects + id.0 as usize, placement.seen_at_rest)),
            PlacedNode::Light(_) => None,
        })
        .collect();
    let all = scene.objects.iter().chain(transparent).enumerate().fold(
        Aabb::EMPTY,
        |all, (place, object)| {
            let at = seen.get(&place).copied().or_else(|| scene.bounds_of(object));
            at.map_or(all, |one| all.union(&one))
        },
    );
    if all.is_empty() { Aabb::new(Vec3::ZERO, Vec3::ZERO) } else { all }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_narrower_than_a_camera_are_higher_and_as_wide() {
        let camera = SceneCamera {
            name: String::new(),
            node: RigNodeId(0),
            projection: Projection::perspective(0.8),
            aspect_ratio: Some(1.5),
            near_m: 0.1,
        };
        let across = |camera: &SceneCamera, size: [u32; 2]| {
            camera.projection_in(size).height_at(1.0) * size[0] as f32 / size[1] as f32
        };
        let as_given = Projection::perspective(0.8);
        assert_eq!(camera.projection_in([300, 200]), as_given);
        assert_eq!(
            camera.projection_in([900, 200]),
            as_given,
            "wider images show more at the sides"
        );
        let own = 2.0 * (0.4_f32).tan() * 1.5;
        for size in [[200, 200], [200, 900]] {
            assert!((across(&camera, size) / own - 1.0).abs() < 1e-5, "{size:?}");
        }
        assert!(camera.projection_in([1, 16_384]).height_at(1.0) > 0.0, "less than 180 degrees");
        let any = SceneCamera { aspect_ratio: None, ..camera.clone() };
        assert_eq!(any.projection_in([200, 900]), as_given);
        let projection = Projection::Orthographic { height: 4.0, far: 9.0 };
        let plan = SceneCamera { projection, ..camera };
        assert_eq!(plan.projection_in([900, 200]), projection);
        let higher = Projection::Orthographic { height: 12.0, far: 9.0 };
        assert_eq!(plan.projection_in([200, 400]), higher, "6 m wide");
    }
}
