//! The draws of casters to the tiles of shadow maps.

use std::ops::Range;

use ::shadows::{FaceWork, PlannedFace};
use gpu::{BufferSlice, Commands, DepthLayers, Predicates};

use crate::passes::{CasterIo, CasterPass};
use crate::resources::geometry::Geometry;

/// Bytes of an indirect draw.
const DRAW_BYTES: u64 = size_of::<gpu::IndirectDraw>() as u64;

/// The part of the work for a map that is drawn to one image.
#[derive(Clone)]
pub(super) enum TileDraws {
    /// On a cleared tile.
    Afresh(Range<usize>),
    /// On what is there.
    OnTop(Range<usize>),
}

/// The draws of the casters of all maps of a frame.
pub(super) struct CasterDraws<'a> {
    pub(super) geometry: &'a Geometry,
    pub(super) predicates: &'a Predicates,
    /// One indirect command per caster of the plan.
    pub(super) draws: BufferSlice,
}

impl CasterDraws<'_> {
    /// Draws what `part` names of each face, in one rendering per layer.
    pub(super) fn draw(
        &self,
        commands: &Commands,
        (pass, layers): (&CasterPass, &mut DepthLayers),
        faces: &[PlannedFace],
        part: impl Fn(&FaceWork) -> Option<TileDraws>,
    ) {
        let Some(io) = caster_io(self.geometry) else { return };
        layers.draw(commands, |commands, layers| {
            for layer in 0..layers.layers() {
                let is_here = |face: &&PlannedFace| face.tile.layer == layer;
                let mut work = faces
                    .iter()
                    .filter(is_here)
                    .filter_map(|face| Some((face, part(&face.work)?)))
                    .peekable();
                let (Some(target), true) = (layers.target(layer), work.peek().is_some()) else {
                    continue;
                };
                commands.rendering(target, |commands| {
                    pass.bind(commands, &io);
                    work.for_each(|(face, part)| self.draw_face(commands, (pass, &io), face, part));
                });
            }
        });
    }

    fn draw_face(
        &self,
        commands: &Commands,
        (pass, io): (&CasterPass, &CasterIo<'_>),
        face: &PlannedFace,
        part: TileDraws,
    ) {
        let (start, casters) = match part {
            TileDraws::Afresh(casters) => (TileStart::Cleared, casters),
            TileDraws::OnTop(casters) => (TileStart::Kept, casters),
        };
        begin_tile(commands, face, start);
        if casters.is_empty() {
            return;
        }
        pass.set_view(commands, io, &face.face.view);
        let (first, count) = (casters.start as u64, casters.len() as u64);
        let draws = self.draws.part(first * DRAW_BYTES, count * DRAW_BYTES);
        self.predicates.draw_after_counted(commands, draws);
    }
}

/// The contents of a tile before it is drawn to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum TileStart {
    Kept,
    Cleared,
}

/// Restricts the draws that follow to the tile of a map.
pub(super) fn begin_tile(commands: &Commands, face: &PlannedFace, start: TileStart) {
    let (origin, size) = (face.tile.origin, [face.tile.side; 2]);
    commands.set_viewport(&gpu::Viewport::covering(origin, size));
    if start == TileStart::Cleared {
        commands.clear_depth(origin, size, 0.0);
    }
}

pub(super) fn caster_io(geometry: &Geometry) -> Option<CasterIo<'_>> {
    Some(CasterIo {
        vertices: geometry.vertices.whole(),
        indices: geometry.indices.whole(),
        instances: geometry.instances.whole(),
        surfaces: geometry.surfaces.as_ref()?,
    })
}
