//! The routes for walks and flights through a generated scene.

use glam::Vec3;

/// The angle by which the camera looks inwards from a circle over a wide scene, in radians: the
/// most objects are visible in this direction.
pub(crate) const AIRCRAFT_INWARDS_RAD: f32 = 0.6;

/// The routes for walks and flights.
#[derive(Clone, Debug, PartialEq)]
pub struct Routes {
    /// The seed of the scene and of its walks. The same seed and number of objects give the same
    /// bytes.
    pub seed: u64,
    /// The walking lines; empty if the scene has none.
    pub streets: Streets,
    /// The circle of the flight.
    pub flight: Flight,
}

/// Walking lines: straight, parallel to x and z, and all crossing. At eye level, no object's box is
/// within 0.3 m of a line or of a turn with the given radius.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Streets {
    /// The x of the lines that run along z, in metres, ascending.
    pub xs: Vec<f32>,
    /// The z of the lines that run along x, in metres, ascending.
    pub zs: Vec<f32>,
    /// The radius of turns from line to line, in metres.
    pub turn_radius_m: f32,
}

/// A circular flight over the roofs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// The middle of the circle, at the height of the eye, in metres.
    pub centre: Vec3,
    /// The radius in metres.
    pub radius_m: f32,
    /// The angle by which the view looks down, in radians.
    pub down_rad: f32,
    /// The angle of the view from the flight direction towards the middle of the circle, in
    /// radians.
    pub inwards_rad: f32,
}
