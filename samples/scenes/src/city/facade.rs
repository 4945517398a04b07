//! The walls of a building: one side at a time, floor by floor, bay by bay.

use super::super::builder::{Frame, MeshBuilder, Panel, panel};
use super::super::random::Random;
use super::palette::Materials;

/// The look of the upper floors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Facade {
    /// Single windows in recesses.
    Punched,
    /// Single windows with protruding sills and a key stone above each.
    Framed,
    /// A band of glass per floor, behind fins that run up the wall.
    Ribbon,
    /// Recessed strips from bottom to top, a pane and a spandrel per floor.
    Strips,
    /// Deep niches with a parapet in front.
    Loggia,
}

/// One side of a building, ready to be built.
pub(super) struct Side<'a> {
    pub(super) frame: Frame,
    pub(super) width_m: f32,
    pub(super) bays: u32,
    pub(super) floors: u32,
    pub(super) floor_m: f32,
    pub(super) ground_m: f32,
    pub(super) facade: Facade,
    pub(super) entrance: Entrance,
    pub(super) materials: &'a Materials,
}

/// The ground floor of a side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Entrance {
    /// Shop windows around a door with steps and a canopy.
    Front,
    /// A few small windows.
    Plain,
}

fn inner(cell: Panel, left: f32, bottom: f32, top: f32) -> Panel {
    panel(cell.u0 + left, cell.v0 + bottom, cell.u1 - left, cell.v1 - top)
}

impl Side<'_> {
    fn cell(&self, bay: u32, low: f32, high: f32) -> Panel {
        let edge = |bay: u32| self.width_m * bay as f32 / self.bays as f32;
        panel(edge(bay), low, edge(bay + 1), high)
    }

    /// Returns the height of a floor above the ground floor.
    fn level(&self, floor: u32) -> f32 {
        self.ground_m + self.floor_m * floor as f32
    }

    fn top(&self) -> f32 {
        self.level(self.floors)
    }

    pub(super) fn build(&self, builder: &mut MeshBuilder, random: &mut Random) {
        self.ground_floor(builder, random);
        match self.facade {
            Facade::Punched | Facade::Framed | Facade::Loggia => {
                for floor in 0..self.floors {
                    for bay in 0..self.bays {
                        let cell = self.cell(bay, self.level(floor), self.level(floor + 1));
                        self.window(builder, cell, random);
                    }
                }
            }
            Facade::Ribbon => self.ribbons(builder, random),
            Facade::Strips => self.strips(builder, random),
        }
    }

    fn ground_floor(&self, builder: &mut MeshBuilder, random: &mut Random) {
        let Self { frame, materials, .. } = self;
        let door_bay = self.bays / 2;
        for bay in 0..self.bays {
            let cell = self.cell(bay, 0.0, self.ground_m);
            let (hole, glass) = match self.entrance {
                Entrance::Front if bay == door_bay => {
                    let margin = ((cell.u1 - cell.u0) / 2.0 - 0.85).max(0.2);
                    (inner(cell, margin, 0.15, 0.9), materials.wood)
                }
                Entrance::Front => (inner(cell, 0.35, 0.6, 0.85), random.pick(&materials.glass)),
                Entrance::Plain => {
                    (inner(cell, (cell.u1 - cell.u0) * 0.3, 1.4, 0.9), materials.glass[0])
                }
            };
            builder.recess(frame, cell, hole, 0.25, [materials.stone, materials.reveal]);
            builder.rectangle(frame, hole, -0.25, glass);
            if self.entrance == Entrance::Front && bay == door_bay {
                let canopy = panel(hole.u0 - 0.3, hole.v1 + 0.1, hole.u1 + 0.3, hole.v1 + 0.25);
                builder.ledge(frame, canopy, 0.28, materials.iron);
            }
        }
    }

    fn window(&self, builder: &mut MeshBuilder, cell: Panel, random: &mut Random) {
        let Self { frame, materials, .. } = self;
        let width = cell.u1 - cell.u0;
        let glass = random.pick(&materials.glass);
        if self.facade == Facade::Loggia {
            // Less deep than far from the corner, since the next side has niches, too.
            let depth = 0.6;
            let hole = inner(cell, 0.65, 0.25, 0.3);
            builder.recess(frame, cell, hole, depth, [materials.wall, materials.reveal.shade(0.8)]);
            builder.rectangle(frame, hole, -depth, glass);
            let rail = panel(hole.u0, hole.v0, hole.u1, hole.v0 + 0.9);
            builder.rectangle(frame, rail, -0.15, materials.trim);
            return;
        }
        let hole = inner(cell, (width * 0.27).max(width / 2.0 - 0.75), 0.85, 0.55);
        builder.recess(frame, cell, hole, 0.22, [materials.wall, materials.reveal]);
        builder.rectangle(frame, hole, -0.22, glass);
        if self.facade == Facade::Framed {
            let sill = panel(hole.u0 - 0.12, hole.v0 - 0.16, hole.u1 + 0.12, hole.v0);
            builder.ledge(frame, sill, 0.14, materials.trim);
        }
    }

    fn ribbons(&self, builder: &mut MeshBuilder, random: &mut Random) {
        let Self { frame, materials, width_m, .. } = self;
        let margin = 0.6;
        for floor in 0..self.floors {
            let cell = panel(0.0, self.level(floor), *width_m, self.level(floor + 1));
            let hole = inner(cell, margin, 1.0, 0.45);
            builder.recess(frame, cell, hole, 0.3, [materials.wall, materials.reveal]);
            for bay in 0..self.bays {
                let edge = |bay: u32| hole.u0 + (hole.u1 - hole.u0) * bay as f32 / self.bays as f32;
                let pane = panel(edge(bay), hole.v0, edge(bay + 1), hole.v1);
                builder.rectangle(frame, pane, -0.3, random.pick(&materials.glass));
            }
        }
        for fin in 0..=self.bays {
            let u = margin + (width_m - 2.0 * margin) * fin as f32 / self.bays as f32;
            let area = panel(u - 0.11, self.ground_m + 0.3, u + 0.11, self.top() - 0.2);
            builder.ledge(frame, area, 0.2, materials.trim);
        }
    }

    fn strips(&self, builder: &mut MeshBuilder, random: &mut Random) {
        let Self { frame, materials, .. } = self;
        for bay in 0..self.bays {
            let cell = self.cell(bay, self.level(0), self.top());
            let hole = inner(cell, (cell.u1 - cell.u0) * 0.2, 0.4, 0.6);
            builder.recess(frame, cell, hole, 0.28, [materials.wall, materials.reveal]);
            let step = (hole.v1 - hole.v0) / self.floors as f32;
            for floor in 0..self.floors {
                let low = hole.v0 + step * floor as f32;
                let high = if floor + 1 == self.floors { hole.v1 } else { low + step };
                let parting = low + step * 0.34;
                let spandrel = panel(hole.u0, low, hole.u1, parting);
                let pane = panel(hole.u0, parting, hole.u1, high);
                builder.rectangle(frame, spandrel, -0.28, materials.stone);
                builder.rectangle(frame, pane, -0.28, random.pick(&materials.glass));
            }
        }
    }
}
