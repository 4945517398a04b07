//! The shadows of lights as pure values: the faces from which a light is drawn, their tiles in an
//! image, their casters, and the faces that a frame must draw again.
//!
//! No Vulkan, no clock, no unsafe code. [`ShadowCache::plan`] makes a [`ShadowPlan`], which an
//! executor draws. [`JitterTexture`] holds the samples of filters. Stencil shadow volumes are
//! extruded from a [`VolumeMesh`].
//!
//! ```
//! # use antumbra_shadows as shadows;
//! use cull::{Aabb, BoxChange, Hierarchy, ObjectId};
//! use glam::{Vec3, vec3};
//! use shadows::{
//!     Casters, ShadowViews, FaceWork, LightShape, ShadowCache, ShadowLight, ShadowLightId,
//!     ShadowMethod, ShadowOptions, ShadowPlan,
//! };
//!
//! let corners = (0..10).map(|x| vec3(x as f32, 0.0, 0.0));
//! let crates = corners.map(|corner| Aabb::new(corner, corner + vec3(0.8, 1.0, 1.0)));
//! let mut hierarchy = Hierarchy::build(&crates.collect::<Vec<_>>())?;
//! let shape = LightShape::Sun { towards: Vec3::Y };
//! let lights = [ShadowLight { id: ShadowLightId(0), shape, penumbra_m: 0.1 }];
//! let eyes = &[vec3(0.0, 1.7, 5.0)];
//! let views = ShadowViews { eyes, sub_pixel_bits: 8, drawn_share: None };
//! let method = ShadowMethod::Maps;
//! let options = ShadowOptions { method, cascades: 1, ..ShadowOptions::default() };
//!
//! let mut cache = ShadowCache::new(options);
//! let mut plan = ShadowPlan::default();
//! let mut frame = |hierarchy: &Hierarchy, changes: &[BoxChange]| {
//!     cache.plan(&lights, &Casters { hierarchy, changes: Some(changes) }, &views, &mut plan);
//!     cache.submitted();
//!     plan.stats().casters
//! };
//! assert_eq!(frame(&hierarchy, &[]), 10, "the first frame draws all");
//! assert_eq!(frame(&hierarchy, &[]), 0, "nothing changed");
//! let before = Aabb::new(Vec3::ZERO, vec3(0.8, 1.0, 1.0));
//! let after = Aabb::new(Vec3::ZERO, Vec3::ONE);
//! hierarchy.refit([(ObjectId(0), after)])?;
//! let changes = [BoxChange { object: ObjectId(0), before, after }];
//! assert_eq!(frame(&hierarchy, &changes), 10, "nine that rest in their layer, and one on top");
//! assert_eq!(frame(&hierarchy, &changes), 1, "the layer is there");
//! # Ok::<(), cull::HierarchyError>(())
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod cache;
mod face;
mod jitter;
mod light;
mod options;
mod plan;
mod reach;
mod sun_distance;
mod tiles;
mod volumes;

pub use cache::{Casters, ShadowCache, ShadowViews};
pub use face::{Face, FaceId, cascade_reach_m};
pub use jitter::{DISK_SAMPLES, JitterTexture};
pub use light::{LightShape, ShadowLight, ShadowLightId, WIDEST_CONE_RAD};
pub use options::{
    CasterCulling, MAX_CASCADES, MIDPOINT_TEXELS, MIN_SIDE, ShadowBias, ShadowCaching,
    ShadowFilter, ShadowMethod, ShadowOptions, ShadowOptionsError,
};
pub use plan::{FaceWork, PlannedFace, PlannedLight, ShadowPlan, ShadowStats};
pub use reach::light_reach;
pub use tiles::{Tile, TilePool};
pub use volumes::{
    Caps, Enclosure, Extrusion, LitArea, MASK_LIGHTS, NearSpan, PlannedVolumes, VolumeCounting,
    VolumeEnd, VolumeError, VolumeKind, VolumeMesh, VolumePlan, VolumeRange, VolumeSource,
    VolumeTriangle,
};
