//! The routes along which one can walk and fly through a generated scene.

use glam::Vec3;

/// The angle by which one looks inwards from a circle over a wide scene, in radians: there is most
/// to see.
pub(crate) const AIRCRAFT_INWARDS_RAD: f32 = 0.6;

/// The routes for walks and flights.
#[derive(Clone, Debug, PartialEq)]
pub struct Routes {
    /// The seed of the scene and of its walks; the same seed and number of objects give the same
    /// bytes.
    pub seed: u64,
    /// The lines to walk on; empty where one cannot walk.
    pub streets: Streets,
    /// The round trip to fly.
    pub flight: Flight,
}

/// Lines to walk on: straight, parallel to x and z, all of them crossing. At least 0.3 m around
/// every line, and around every turn with the given radius, there is no object's box at eye level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Streets {
    /// The x of the lines that run along z, in metres, ascending.
    pub xs: Vec<f32>,
    /// The z of the lines that run along x, in metres, ascending.
    pub zs: Vec<f32>,
    /// The radius of turns from line to line, in metres.
    pub turn_radius_m: f32,
}

/// A round trip over the roofs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// The middle of the circle, at the height of the eye, in metres.
    pub centre: Vec3,
    /// Its radius in metres.
    pub radius_m: f32,
    /// The angle by which the view looks down, in radians.
    pub down_rad: f32,
    /// The angle by which it looks from along the circle towards its middle, in radians.
    pub inwards_rad: f32,
}
