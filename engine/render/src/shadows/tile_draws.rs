//! The draws of casters to the tiles of shadow maps.

use std::ops::Range;

use ::shadows::{FaceWork, PlannedFace, Tile};
use cull::CullView;
use gpu::{
    BufferSlice, Commands, DepthLayers, Frame, IndirectDraw, Load, Predicates, RenderTarget,
};

use crate::error::Error;
use crate::passes::{CasterIo, CasterPass, SectionIo};
use crate::resources::geometry::Geometry;
use crate::section::Section;

/// The draws of a map to one image, as ranges of casters.
#[derive(Clone)]
pub(super) enum TileDraws {
    /// Draws to a cleared tile.
    Afresh(Range<usize>),
    /// Draws over the contents of a tile.
    OnTop(Range<usize>),
}

impl TileDraws {
    fn start(&self) -> TileStart {
        match self {
            Self::Afresh(_) => TileStart::Cleared,
            Self::OnTop(_) => TileStart::Kept,
        }
    }
}

/// The draws of the casters of all maps of a frame.
pub(super) struct CasterDraws<'a> {
    pub(super) geometry: &'a Geometry,
    pub(super) predicates: &'a Predicates,
    /// An indirect command per caster of the plan.
    pub(super) draws: BufferSlice,
    /// The section planes for each face.
    pub(super) section: &'a FaceSections,
}

/// The section planes for each face of a frame's plan.
#[derive(Default)]
pub(super) struct FaceSections(Vec<SectionIo>);

impl FaceSections {
    /// Uploads the planes of a frame for its faces, in their order. Does nothing without planes.
    pub(super) fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        section: &Section,
        faces: &[PlannedFace],
    ) -> Result<(), Error> {
        self.0.clear();
        for face in faces {
            let view = CullView { section: section.planes, ..face.face.view };
            let Some(io) = section.io_of(frame, &view)? else { break };
            self.0.push(io);
        }
        Ok(())
    }

    /// Sets the view of a face, by its index in the plan, for draws of its casters.
    pub(super) fn bind_face(
        &self,
        commands: &Commands,
        pass: &CasterPass,
        io: &CasterIo<'_>,
        number: usize,
        face: &PlannedFace,
    ) {
        if let Some(section) = self.0.get(number) {
            pass.bind(commands, &CasterIo { section: Some(*section), ..*io });
        }
        pass.set_view(commands, io, &face.face.view);
    }

    /// Binds a pass for all faces, unless each face needs planes of its own.
    pub(super) fn bind(&self, commands: &Commands, pass: &CasterPass, io: &CasterIo<'_>) {
        if self.0.is_empty() {
            pass.bind(commands, io);
        }
    }
}

impl CasterDraws<'_> {
    /// Draws the part of each face that `part` returns, in one rendering per layer.
    pub(super) fn draw(
        &self,
        commands: &Commands,
        pass: &CasterPass,
        layers: &mut DepthLayers,
        faces: &[PlannedFace],
        part: impl Fn(&FaceWork) -> Option<TileDraws>,
    ) {
        let Some(io) = caster_io(self.geometry) else { return };
        layers.draw(commands, |commands, layers| {
            for layer in 0..layers.layers() {
                let is_here = |face: &&PlannedFace| face.tile.layer == layer;
                let mut work = faces
                    .iter()
                    .enumerate()
                    .filter(|(_, face)| is_here(face))
                    .filter_map(|(number, face)| Some((number, face, part(&face.work)?)))
                    .peekable();
                let (Some(target), true) = (layers.target(layer), work.peek().is_some()) else {
                    continue;
                };
                let tiles = faces.iter().filter(is_here).filter_map(|face| {
                    Some(DrawnTile { tile: face.tile, start: part(&face.work)?.start() })
                });
                commands.rendering(tiles_target(target, tiles), |commands| {
                    self.section.bind(commands, pass, &io);
                    work.for_each(|(number, face, part)| {
                        self.draw_face(commands, pass, &io, number, face, part)
                    });
                });
            }
        });
    }

    fn draw_face(
        &self,
        commands: &Commands,
        pass: &CasterPass,
        io: &CasterIo<'_>,
        number: usize,
        face: &PlannedFace,
        part: TileDraws,
    ) {
        begin_tile(commands, face, part.start());
        let (TileDraws::Afresh(casters) | TileDraws::OnTop(casters)) = part;
        if casters.is_empty() {
            return;
        }
        self.section.bind_face(commands, pass, io, number, face);
        let casters = casters.start as u32..casters.end as u32;
        let draws = self.draws.elements::<IndirectDraw>(casters);
        self.predicates.draw_after_counted(commands, draws);
    }
}

/// The contents of a tile before it is drawn to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TileStart {
    Kept,
    Cleared,
}

/// A tile that is drawn to.
#[derive(Clone, Copy, Debug)]
pub(super) struct DrawnTile {
    pub(super) tile: Tile,
    pub(super) start: TileStart,
}

/// Returns the target of a rendering to these tiles of a layer, which must not overlap. It loads
/// and stores only what the tiles need.
pub(super) fn tiles_target(
    layer: RenderTarget,
    tiles: impl Iterator<Item = DrawnTile>,
) -> RenderTarget {
    let area = TilesArea::of(tiles);
    let mut target = layer.within(area.origin, area.size);
    if area.contents == TileStart::Cleared {
        target.depth_load = Load::Forget;
    }
    target
}

/// The smallest area around tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct TilesArea {
    origin: [u32; 2],
    size: [u32; 2],
    /// Cleared if clearing the tiles overwrites the whole area.
    contents: TileStart,
}

impl TilesArea {
    fn of(tiles: impl Iterator<Item = DrawnTile>) -> Self {
        let mut low = [u32::MAX; 2];
        let mut high = [0; 2];
        let mut cleared = 0_u64;
        for DrawnTile { tile, start } in tiles {
            for (axis, at) in tile.origin.into_iter().enumerate() {
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at.saturating_add(tile.side));
            }
            if start == TileStart::Cleared {
                cleared += u64::from(tile.side) * u64::from(tile.side);
            }
        }
        let [width, height] = [0, 1].map(|axis: usize| high[axis].saturating_sub(low[axis]));
        let contents = if cleared == u64::from(width) * u64::from(height) {
            TileStart::Cleared
        } else {
            TileStart::Kept
        };
        Self { origin: low, size: [width, height], contents }
    }
}

/// Restricts the draws that follow to the tile of a map.
pub(super) fn begin_tile(commands: &Commands, face: &PlannedFace, start: TileStart) {
    let origin = face.tile.origin;
    let size = [face.tile.side; 2];
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
        section: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(tiles: &[([u32; 2], u32, TileStart)]) -> TilesArea {
        let tile = |(origin, side, start): &([u32; 2], u32, TileStart)| {
            let tile = Tile { layer: 0, origin: *origin, side: *side };
            DrawnTile { tile, start: *start }
        };
        TilesArea::of(tiles.iter().map(tile))
    }

    #[test]
    fn an_area_is_loaded_unless_cleared_tiles_fill_it() {
        use TileStart::{Cleared, Kept};
        let found = |origin, size, contents| TilesArea { origin, size, contents };
        let one = ([64, 0], 64, Cleared);
        assert_eq!(area(&[one]), found([64, 0], [64, 64], Cleared));
        assert_eq!(area(&[one, ([128, 0], 64, Cleared)]), found([64, 0], [128, 64], Cleared));
        assert_eq!(area(&[one, ([128, 0], 32, Cleared)]), found([64, 0], [96, 64], Kept));
        assert_eq!(area(&[one, ([128, 0], 64, Kept)]), found([64, 0], [128, 64], Kept));
        assert_eq!(area(&[([64, 0], 64, Kept)]), found([64, 0], [64, 64], Kept));
    }
}
