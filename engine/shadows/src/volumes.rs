//! Shadow volumes: triangles with adjacency, their extrusion, and the way of counting.
//!
//! After Stich, Waechter, Keller, "Efficient and Robust Shadow Volumes Using Hierarchical Occlusion
//! Culling and Geometry Shaders" (GPU Gems 3, chapter 11).

mod adjacency;
mod counting;
mod end;
mod extrude;
mod lit_area;
mod mesh;
mod volume_plan;
mod weld;

pub use counting::{Caps, NearSpan, VolumeCounting};
pub use end::VolumeEnd;
pub use extrude::{Extrusion, VolumeTriangle};
pub use lit_area::LitArea;
pub use mesh::{Enclosure, VolumeError, VolumeKind, VolumeMesh, VolumeSource};
pub use volume_plan::{MASK_LIGHTS, PlannedVolumes, VolumePlan, VolumeRange};
