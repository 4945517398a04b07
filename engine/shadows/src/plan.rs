//! The plan of all shadow maps of a frame: a plain value that an executor draws.

use std::ops::Range;

use cull::LeafIndex;

use crate::face::Face;
use crate::light::ShadowLightId;
use crate::tiles::Tile;

/// The work for one map in a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FaceWork {
    /// Nothing: the map is valid.
    Keep,
    /// The map is cleared, and all of these casters are drawn.
    Draw(Range<usize>),
    /// The map is cleared. Of these casters, only those that shadow something visible are drawn,
    /// once the executor has tested them. They are in the order of the hierarchy's leaves.
    Cull(Range<usize>),
    /// The layer of resting casters is drawn first, if it is not valid; then it is copied to the
    /// map, and the moving casters are drawn on top.
    Layered {
        /// The casters of the resting layer; `None` if the layer is valid.
        resting: Option<Range<usize>>,
        /// The moving casters.
        moving: Range<usize>,
    },
}

impl FaceWork {
    /// Returns the ranges of [`ShadowPlan::casters`] that are drawn in any case, without a test.
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
    /// The work for the map.
    pub work: FaceWork,
}

/// The maps of a light in a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedLight {
    /// The light.
    pub light: ShadowLightId,
    /// The light's maps among [`ShadowPlan::faces`]; empty if there was no room for them.
    pub faces: Range<usize>,
}

/// The shadow maps of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowPlan {
    /// The lights, in the order in which they were given.
    pub lights: Vec<PlannedLight>,
    /// The maps of all lights.
    pub faces: Vec<PlannedFace>,
    /// The casters to which [`FaceWork`] refers.
    pub casters: Vec<LeafIndex>,
    /// The number of layers in which the maps lie.
    pub layers: u32,
    /// The number of lights without maps, for lack of room.
    pub unshadowed_lights: u32,
}

/// The counts of a frame's shadows: of maps, or of volumes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowStats {
    /// Lights with shadows; with volumes, a light counts once per view that it reaches.
    pub lights: u32,
    /// Maps.
    pub faces: u32,
    /// Maps that are drawn, with some or all of their casters.
    pub drawn_faces: u32,
    /// Drawn maps whose casters are culled.
    pub culled_faces: u32,
    /// Casters in drawn maps, culled or not, or casters of volumes.
    pub casters: u32,
    /// Tests of culled casters.
    pub tests: u32,
    /// Volumes that are counted by z-fail, since the eye may be inside.
    pub z_fail_volumes: u32,
    /// Triangles of casters that are drawn without a test.
    pub triangles: u64,
    /// Triangles of casters that passed the tests in the newest frame with results.
    pub revealed_triangles: u64,
    /// Lights without shadows, for lack of room for their maps or in the mask.
    pub unshadowed_lights: u32,
}

impl ShadowPlan {
    /// Returns the counts, without triangles and tests, which only an executor can count.
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

    /// Returns true if a map has a resting layer that is drawn or copied.
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
