//! The plan of all shadow maps of a frame: a plain value that an executor draws.

use std::ops::Range;

use cull::LeafIndex;

use crate::face::Face;
use crate::light::ShadowLightId;
use crate::tiles::Tile;

/// The work for one map in a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FaceWork {
    /// Nothing: the map is as it should be.
    Keep,
    /// The map is cleared, and these casters are drawn.
    Draw(Range<usize>),
    /// The map is cleared, and those of these casters are drawn that shadow something visible, once
    /// that is known. They are in the order of the hierarchy's leaves.
    Cull(Range<usize>),
    /// The layer of resting casters is drawn first, if it is not as it should be; then the map is a
    /// copy of it, with the moving casters drawn on top.
    Layered {
        /// The casters of the resting layer, if it must be drawn.
        resting: Option<Range<usize>>,
        /// The moving casters.
        moving: Range<usize>,
    },
}

impl FaceWork {
    /// Returns the casters that are drawn in any case, among [`ShadowPlan::casters`].
    pub fn drawn_casters(&self) -> impl Iterator<Item = Range<usize>> {
        let [first, second] = match self {
            Self::Keep | Self::Cull(_) => [None, None],
            Self::Draw(all) => [Some(all.clone()), None],
            Self::Layered { resting, moving } => [resting.clone(), Some(moving.clone())],
        };
        first.into_iter().chain(second)
    }
}

/// One map of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedFace {
    /// The light's view. Its origin is the corner of the tile.
    pub face: Face,
    /// The place of the map.
    pub tile: Tile,
    /// The work.
    pub work: FaceWork,
}

/// The maps of a light in a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedLight {
    /// The light.
    pub light: ShadowLightId,
    /// Its maps among [`ShadowPlan::faces`]; empty where there was no room for them.
    pub faces: Range<usize>,
}

/// The shadow maps of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowPlan {
    /// The lights, in the order in which they were given.
    pub lights: Vec<PlannedLight>,
    /// Their maps.
    pub faces: Vec<PlannedFace>,
    /// The casters that [`FaceWork`]s name.
    pub casters: Vec<LeafIndex>,
    /// The layers that the maps lie in.
    pub layers: u32,
    /// Lights without maps, since there was no room.
    pub unshadowed_lights: u32,
}

/// The counts of the shadows of a frame: of maps, or of volumes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowStats {
    /// Lights with shadows; those of volumes once for each view that they reach into.
    pub lights: u32,
    /// Maps.
    pub faces: u32,
    /// Maps that are drawn, wholly or in part.
    pub drawn_faces: u32,
    /// Maps among them whose casters are culled.
    pub culled_faces: u32,
    /// Casters in maps that are drawn, culled or not, or of volumes.
    pub casters: u32,
    /// Tests that decide about culled casters.
    pub tests: u32,
    /// Volumes that are counted by z-fail, since the eye may be in them.
    pub z_fail_volumes: u32,
    /// Triangles of the casters that are drawn, as far as the plan decides.
    pub triangles: u64,
    /// Triangles of culled casters that the tests of the newest frame with results revealed.
    pub revealed_triangles: u64,
    /// Lights without shadows, since there was no room for their maps or in the mask.
    pub unshadowed_lights: u32,
}

impl ShadowPlan {
    /// Returns the counts, without those of triangles and tests: an executor knows them.
    #[must_use]
    pub fn stats(&self) -> ShadowStats {
        let is_drawn = |face: &&PlannedFace| face.work != FaceWork::Keep;
        let is_culled = |face: &&PlannedFace| matches!(face.work, FaceWork::Cull(_));
        ShadowStats {
            lights: self.lights.iter().filter(|light| !light.faces.is_empty()).count() as u32,
            faces: self.faces.len() as u32,
            drawn_faces: self.faces.iter().filter(is_drawn).count() as u32,
            culled_faces: self.faces.iter().filter(is_culled).count() as u32,
            casters: self.casters.len() as u32,
            unshadowed_lights: self.unshadowed_lights,
            ..ShadowStats::default()
        }
    }

    /// Returns true if some map has a resting layer that is drawn or copied.
    #[must_use]
    pub fn has_layers(&self) -> bool {
        self.faces.iter().any(|face| matches!(face.work, FaceWork::Layered { .. }))
    }

    pub(crate) fn clear(&mut self) {
        self.lights.clear();
        self.faces.clear();
        self.casters.clear();
        self.unshadowed_lights = 0;
    }
}
