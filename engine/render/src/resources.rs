//! Scenes on the GPU: meshes, instances, levels of detail and poses, and the checks that they fit.

pub(crate) mod edge_meshes;
pub(crate) mod geometry;
pub(crate) mod instance;
pub(crate) mod joined_meshes;
pub(crate) mod limits;
pub(crate) mod lod;
pub(crate) mod mesh_slots;
pub(crate) mod object_bounds;
pub(crate) mod scene_memory;
pub(crate) mod skinned_mesh_state;
pub(crate) mod skinned_meshes;
pub(crate) mod spare_capacity;
pub(crate) mod sprites;
pub(crate) mod upload_queue;
pub(crate) mod volume_meshes;
