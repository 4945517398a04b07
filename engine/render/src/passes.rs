//! The passes. Each is a struct with its pipeline, and has an `Io` struct of its reads and writes.

mod cap;
mod caster;
mod count;
mod edges;
mod flare;
mod fragments;
mod layers;
mod midpoint;
mod opaque;
mod overlay;
pub(crate) mod pipelines;
mod section;
mod seen;
mod skinning;
mod sky;
mod surface;
mod volume_constants;
mod volume_extruder;
mod volumes;

pub(crate) use cap::{CapDraw, CapIo, CapKind, CapPass, CapRow};
pub(crate) use caster::MapPasses;
pub use caster::{CasterIo, CasterPass, CasterSide, WholeCasters};
pub(crate) use count::CountPass;
pub use edges::EdgePath;
pub(crate) use edges::{EdgeIo, EdgePass, EdgeSegment, EdgeStyle, EdgeTest, OutlinePass};
pub(crate) use flare::{FlareBlockIo, FlarePass, TRANSMITTANCE_LEVELS};
pub use flare::{FlareBlockRow, FlareShape, FlareSprite};
pub(crate) use fragments::{FragmentIo, FragmentPasses};
pub(crate) use layers::{LayersIo, LayersPass};
pub(crate) use midpoint::{MidpointIo, MidpointPass, MidpointTile};
pub use opaque::{OpaqueIo, OpaquePass};
pub use overlay::OverlayVertex;
pub(crate) use overlay::{OverlayIo, OverlayPass};
pub use section::SectionIo;
pub(crate) use section::{ImageRows, SectionRow};
pub(crate) use seen::{SeenIo, SeenPass};
pub(crate) use skinning::{
    NOTHING, PredicatedJob, REST_VALUES, SkinningIo, SkinningJob, SkinningPass,
};
pub(crate) use sky::SkyIo;
pub use sky::{SkyPass, SkyRow};
pub use surface::{SurfaceIo, SurfaceKind, SurfacePass, SurfaceShadows};
pub use volume_constants::VolumeGroup;
pub use volumes::{
    DrawGroup, VolumeCaster, VolumeCasters, VolumeDraws, VolumeIo, VolumeLight, VolumePass,
    VolumePath,
};
