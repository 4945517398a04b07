//! The settings of the tools, and the commands that change one state of them into another.

use antumbra::cull::{Aabb, SectionMode, SectionPlane, SectionPlanes};
use antumbra::glam::{DVec3, Vec3};
use antumbra::render::EdgeMode;

use crate::script::Command;

/// Millimetres per metre.
pub const MM: f32 = 1000.0;

/// The modes of edges, in the order of their key.
pub const EDGE_MODES: [EdgeMode; 5] = [
    EdgeMode::Off,
    EdgeMode::Shaded,
    EdgeMode::ShadedWithHiddenDashed,
    EdgeMode::Visible,
    EdgeMode::HiddenDashed,
];

/// A section plane perpendicular to an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisPlane {
    /// True if it cuts.
    pub is_on: bool,
    /// True if it keeps the side of larger coordinates.
    pub is_flipped: bool,
    /// The position along the axis, in millimetres.
    pub place_mm: f32,
}

/// The measurement that a click makes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measuring {
    /// Nothing: a click selects.
    #[default]
    Off,
    /// The distance from one click to the next.
    Distance,
    /// The length of an edge.
    Edge,
}

/// Two points whose distance was measured, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredLine {
    /// One point.
    pub from: DVec3,
    /// The other point; `None` until it is chosen.
    pub to: Option<DVec3>,
}

/// The settings of the tools.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tools {
    /// The section planes perpendicular to x, y and z.
    pub planes: [AxisPlane; 3],
    /// The mode of edges.
    pub edges: EdgeMode,
    /// The gap between parts, in millimetres; 0 if they are in their places.
    pub gap_mm: f32,
    /// The angle of the lid, in degrees; 0 is closed.
    pub lid_degrees: f32,
    /// True if the projection is orthographic, or changes to it.
    pub is_orthographic: bool,
    /// The measurement that a click makes.
    pub measuring: Measuring,
    /// True if the panel is shown.
    pub has_panel: bool,
    /// True if the page of keys is shown.
    pub has_help: bool,
}

impl Tools {
    /// Returns the initial settings: all planes are off and in the middle of the model.
    pub fn at_rest(bounds: &Aabb) -> Self {
        let middle = (bounds.min + bounds.max) * 0.5 * MM;
        let plane = |place_mm: f32| AxisPlane { place_mm, ..AxisPlane::default() };
        Self {
            planes: middle.to_array().map(plane),
            edges: EdgeMode::Off,
            gap_mm: 0.0,
            lid_degrees: 0.0,
            is_orthographic: false,
            measuring: Measuring::Off,
            has_panel: true,
            has_help: false,
        }
    }

    /// Returns the wanted projection: 0 for perspective, 1 for orthographic.
    pub fn flatness(&self) -> f32 {
        if self.is_orthographic { 1.0 } else { 0.0 }
    }

    /// Returns the section planes.
    pub fn section(&self) -> SectionPlanes {
        let mut planes = Vec::with_capacity(self.planes.len());
        for (axis, plane) in Vec3::AXES.into_iter().zip(&self.planes) {
            let sign = if plane.is_flipped { 1.0 } else { -1.0 };
            let offset_m = -sign * f64::from(plane.place_mm / MM);
            let axis = axis.as_dvec3() * sign;
            // The axis is a valid normal, and sliders have finite values.
            planes.extend(plane.is_on.then(|| SectionPlane::new(axis, offset_m).ok()).flatten());
        }
        SectionPlanes::new(&planes, SectionMode::Intersection).unwrap_or_default()
    }

    /// Returns the commands that change these settings to others.
    pub fn commands_to(&self, other: &Self) -> Vec<Command> {
        let mut commands = Vec::new();
        if self.section() != other.section() {
            commands.push(Command::Section(other.section()));
        }
        if self.edges != other.edges {
            commands.push(Command::Edges(other.edges));
        }
        if self.gap_mm != other.gap_mm {
            commands.push(match other.gap_mm {
                gap_mm if gap_mm > 0.0 => Command::Explode { gap_mm },
                _ => Command::Assemble,
            });
        }
        if self.lid_degrees != other.lid_degrees {
            commands.push(Command::Lid { degrees: other.lid_degrees });
        }
        commands
    }

    /// Returns the settings with the next mode of edges.
    #[must_use]
    pub fn with_next_edges(self) -> Self {
        let place = EDGE_MODES.iter().position(|mode| *mode == self.edges).unwrap_or(0);
        Self { edges: EDGE_MODES[(place + 1) % EDGE_MODES.len()], ..self }
    }
}

/// Returns the position of a plane's handle in the world, in metres: on the plane, in the middle of
/// the model's box.
pub fn handle_of(bounds: &Aabb, axis: usize, plane: &AxisPlane) -> Vec3 {
    let mut at = (bounds.min + bounds.max) * 0.5;
    at[axis] = plane.place_mm / MM;
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_changes_is_commanded() {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 1.0) };
        let rest = Tools::at_rest(&bounds);
        assert_eq!(rest.planes[0].place_mm, 1000.0);
        assert!(rest.commands_to(&rest).is_empty());
        let mut cut = rest;
        cut.planes[0] = AxisPlane { place_mm: 500.0, ..cut.planes[0] };
        assert!(rest.commands_to(&cut).is_empty(), "a plane that is off moves unseen");
        cut.planes[0].is_on = true;
        let [Command::Section(planes)] = &rest.commands_to(&cut)[..] else { panic!() };
        assert!(planes.keeps(DVec3::new(0.4, 0.0, 0.0)) && !planes.keeps(DVec3::X));
        cut.planes[0].is_flipped = true;
        assert!(cut.section().keeps(DVec3::X) && !cut.section().keeps(DVec3::ZERO));
        let apart = Tools { gap_mm: 5.0, ..rest };
        assert_eq!(rest.commands_to(&apart), [Command::Explode { gap_mm: 5.0 }]);
        assert_eq!(apart.commands_to(&rest), [Command::Assemble]);
        let mut edges = rest;
        for _ in EDGE_MODES {
            assert_eq!(edges.commands_to(&edges.with_next_edges()).len(), 1);
            edges = edges.with_next_edges();
        }
        assert_eq!(edges, rest);
    }
}
