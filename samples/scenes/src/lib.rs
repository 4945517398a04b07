//! Scenes that are generated from a number of objects and a seed, and camera routes through them.
//!
//! [`city`] and [`field`] generate scenes for culling. Their objects neither touch nor have
//! coplanar faces, and objects on the ground hover 2 cm above it. So no pixel's colour depends on
//! the order in which objects are drawn. Only the tiles of the ground share edges, with
//! bit-identical vertices. Transforms are only quarter turns about y (exact: each column is one of
//! the axes) and uniform scales. [`assembly`] and [`waffle_maker`] create models of closed parts,
//! in a tree, at any angle. [`LightSet`] adds lights: the sun of an [`Hour`], torches, or street
//! lamps.
//!
//! ```
//! use scenes::{CameraPath, PathKind};
//!
//! let city = scenes::city(1_000, 7)?;
//! let path = CameraPath::new(PathKind::Street, &city.routes)?;
//! assert_eq!(city.scene.objects.len(), 1_000);
//! assert!(path.camera(30).eye.y > 1.0);
//! # Ok::<(), scenes::GeneratorError>(())
//! ```
#![forbid(unsafe_code)]

mod assembly;
mod builder;
mod city;
mod courtyard;
mod error;
mod field;
mod generated;
mod lights;
mod motion;
mod parts;
mod path;
mod random;
mod routes;
mod solid;
#[cfg(test)]
mod tests;
mod waffle_maker;

pub use assembly::{Assembly, assembly};
pub use city::city;
pub use courtyard::{Courtyard, YardMotion, courtyard};
pub use error::{GeneratorError, MAX_LAMPS, MAX_OBJECTS, MotionError};
pub use field::field;
pub use generated::GeneratedScene;
pub use lights::{Daylight, GLOW_NAME, Hour, LampHours, LightSet, sun_light};
pub use motion::{Cast, Motion};
pub use parts::{PartId, PartNode, PartTree};
pub use path::{CameraPath, PathKind};
pub use routes::{Flight, Routes, Streets};
pub use waffle_maker::{CurvedMesh, Hinge, WaffleMaker, waffle_maker};
