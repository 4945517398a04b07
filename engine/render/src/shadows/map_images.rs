//! The images of shadow maps: those that casters are drawn to, and those that are sampled.
//!
//! ```text
//! casters   all casters of a map, or the resting ones copied and the moving ones on top
//! resting   those that rest, of maps in two layers
//! midpoints what is sampled in place of `casters`, made of their fronts and backs
//! ```
//!
//! Fronts and backs are both nearest depths, and a midpoint is a function of two texels. So maps in
//! two layers have the same midpoints as maps that are drawn whole.

use ::shadows::{FaceWork, PlannedFace, ShadowBias, ShadowOptions, ShadowPlan};
use gpu::{Commands, DepthLayers, DepthTile, Device, Error};

use crate::passes::{MapPasses, MidpointIo, MidpointPass, MidpointTile};
use crate::shadows::tile_draws::{
    CasterDraws, DrawnTile, TileDraws, TileStart, begin_tile, tiles_target,
};

/// The depths of casters, in images with the same tiles.
struct CasterDepths {
    /// The depths of the side that maps hold, or of fronts.
    near: DepthLayers,
    /// The depths of backs, if maps hold midpoints.
    backs: Option<DepthLayers>,
    /// True if the newest frame recorded a use of these images.
    is_used: bool,
}

/// The images of all maps.
pub(super) struct MapImages {
    casters: CasterDepths,
    resting: Option<CasterDepths>,
    midpoints: Option<DepthLayers>,
    tiles: Vec<DepthTile>,
}

/// The debug names of the depths of casters.
struct CasterDepthNames<'a> {
    /// The name of the only image.
    near: &'a str,
    /// The name of the image of front faces, if there is also one of back faces.
    fronts: &'a str,
    /// The name of the image of back faces.
    backs: &'a str,
}

impl CasterDepths {
    /// Creates images for a bias.
    fn new(
        device: &Device,
        side: u32,
        layers: u32,
        bias: ShadowBias,
        names: &CasterDepthNames<'_>,
    ) -> Result<Self, Error> {
        let of = |name| DepthLayers::new(device, side, layers, name);
        let (near, backs) = match bias {
            ShadowBias::Plane | ShadowBias::BackFaces => (of(names.near)?, None),
            ShadowBias::Midpoint => (of(names.fronts)?, Some(of(names.backs)?)),
        };
        Ok(Self { near, backs, is_used: false })
    }

    /// Draws the part of each face that `part` returns, to both images if there are two.
    fn draw(
        &mut self,
        commands: &Commands,
        casters: &CasterDraws<'_>,
        passes: &MapPasses,
        faces: &[PlannedFace],
        part: impl Fn(&FaceWork) -> Option<TileDraws>,
    ) {
        self.is_used = true;
        casters.draw(commands, &passes.casters, &mut self.near, faces, &part);
        if let (Some((pass, _)), Some(backs)) = (&passes.midpoints, &mut self.backs) {
            casters.draw(commands, pass, backs, faces, &part);
        }
    }

    fn copy_from(&mut self, commands: &Commands, from: &mut Self, tiles: &[DepthTile]) {
        (self.is_used, from.is_used) = (true, true);
        self.near.copy_from(commands, &mut from.near, tiles);
        if let (Some(backs), Some(from)) = (&mut self.backs, &mut from.backs) {
            backs.copy_from(commands, from, tiles);
        }
    }

    /// Notes that the frame was submitted. Contents that were recorded in a frame without a submit
    /// stay undefined.
    fn submitted(&mut self) {
        if self.is_used {
            self.near.submitted();
            self.backs.iter_mut().for_each(DepthLayers::submitted);
        }
    }
}

impl MapImages {
    /// Creates images with this number of layers for options that were checked.
    pub(super) fn new(
        device: &Device,
        options: &ShadowOptions,
        layers: u32,
    ) -> Result<Self, Error> {
        let side = options.layer_side();
        let names = CasterDepthNames {
            near: "shadow maps",
            fronts: "fronts of casters",
            backs: "backs of casters",
        };
        let casters = CasterDepths::new(device, side, layers, options.bias, &names)?;
        let midpoints =
            casters.backs.is_some().then(|| DepthLayers::new(device, side, layers, "shadow maps"));
        Ok(Self { casters, resting: None, midpoints: midpoints.transpose()?, tiles: Vec::new() })
    }

    /// Returns the number of layers.
    pub(super) fn layers(&self) -> u32 {
        self.casters.near.layers()
    }

    /// Creates images of resting casters unless they exist.
    pub(super) fn keep_resting(
        &mut self,
        device: &Device,
        options: &ShadowOptions,
    ) -> Result<(), Error> {
        if self.resting.is_none() {
            let side = options.layer_side();
            let layers = self.layers();
            let names = CasterDepthNames {
                near: "resting shadow maps",
                fronts: "fronts of resting casters",
                backs: "backs of resting casters",
            };
            self.resting = Some(CasterDepths::new(device, side, layers, options.bias, &names)?);
        }
        Ok(())
    }

    /// Returns the maps to sample.
    pub(super) fn maps(&self) -> &DepthLayers {
        self.midpoints.as_ref().unwrap_or(&self.casters.near)
    }

    /// Begins the recording of a frame. The previous frame may never have been submitted.
    pub(super) fn begin_frame(&mut self) {
        let all = std::iter::once(&mut self.casters).chain(&mut self.resting);
        all.for_each(|casters| casters.is_used = false);
    }

    /// Returns the maps to prepare, or to draw culled casters to. Culled maps have no midpoints.
    pub(super) fn maps_mut(&mut self) -> &mut DepthLayers {
        match &mut self.midpoints {
            Some(midpoints) => midpoints,
            None => {
                self.casters.is_used = true;
                &mut self.casters.near
            }
        }
    }

    /// Draws everything in a plan except culled casters.
    pub(super) fn draw(
        &mut self,
        commands: &Commands,
        casters: &CasterDraws<'_>,
        passes: &MapPasses,
        plan: &ShadowPlan,
    ) {
        let faces = &plan.faces[..];
        commands.pass("shadow maps", |commands| self.draw_casters(commands, casters, passes, plan));
        let Self { casters: CasterDepths { near, backs, .. }, midpoints, .. } = self;
        if let (Some((_, pass)), Some(backs), Some(midpoints)) =
            (&passes.midpoints, backs, midpoints)
        {
            // Without casters nothing has been drawn to these images.
            near.prepare(commands);
            backs.prepare(commands);
            commands.pass("shadow midpoints", |commands| {
                draw_midpoints(commands, pass, near, backs, midpoints, faces);
            });
        }
    }

    fn draw_casters(
        &mut self,
        commands: &Commands,
        draws: &CasterDraws<'_>,
        passes: &MapPasses,
        plan: &ShadowPlan,
    ) {
        let Self { casters, resting, tiles, .. } = self;
        if let Some(resting) = resting.as_mut().filter(|_| plan.has_layers()) {
            let part = |work: &FaceWork| match work {
                FaceWork::Layered { resting: Some(casters), .. } => {
                    Some(TileDraws::Afresh(casters.clone()))
                }
                _ => None,
            };
            resting.draw(commands, draws, passes, &plan.faces, part);
            let is_layered = |face: &&PlannedFace| matches!(face.work, FaceWork::Layered { .. });
            let layered = plan.faces.iter().filter(is_layered).map(|face| DepthTile {
                layer: face.tile.layer,
                origin: face.tile.origin,
                side: face.tile.side,
            });
            tiles.clear();
            tiles.extend(layered);
            casters.copy_from(commands, resting, tiles);
        }
        casters.draw(commands, draws, passes, &plan.faces, |work| match work {
            FaceWork::Keep | FaceWork::Cull(_) => None,
            FaceWork::Draw(all) => Some(TileDraws::Afresh(all.clone())),
            FaceWork::Layered { moving, .. } => Some(TileDraws::OnTop(moving.clone())),
        });
    }

    /// Notes that the recorded frame was submitted.
    pub(super) fn submitted(&mut self) {
        self.casters.submitted();
        self.resting.iter_mut().for_each(CasterDepths::submitted);
        // Every frame prepares the maps to sample.
        self.midpoints.iter_mut().for_each(DepthLayers::submitted);
    }
}

/// Writes the midpoints of maps that were drawn.
fn draw_midpoints(
    commands: &Commands,
    pass: &MidpointPass,
    fronts: &DepthLayers,
    backs: &DepthLayers,
    midpoints: &mut DepthLayers,
    faces: &[PlannedFace],
) {
    let io = MidpointIo { fronts: fronts.reading(), backs: backs.reading() };
    midpoints.draw(commands, |commands, layers| {
        for layer in 0..layers.layers() {
            let is_drawn = |face: &&PlannedFace| {
                face.tile.layer == layer && face.work.drawn_casters().next().is_some()
            };
            let mut drawn = faces.iter().filter(is_drawn).peekable();
            let (Some(target), true) = (layers.target(layer), drawn.peek().is_some()) else {
                continue;
            };
            let tiles =
                drawn.clone().map(|face| DrawnTile { tile: face.tile, start: TileStart::Cleared });
            commands.rendering(tiles_target(target, tiles), |commands| {
                pass.bind(commands, &io);
                for face in drawn {
                    begin_tile(commands, face, TileStart::Cleared);
                    pass.draw(commands, &MidpointTile::new(&face.face.view, layer));
                }
            });
        }
    });
}
