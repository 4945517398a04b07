//! The shapes of the waffle maker's parts, in metres.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, vec2, vec3};
use scene::{Mesh, PatchSurface, TessellationLevels, ellipsoid, tessellated};

use super::super::builder::Paint;
use super::super::solid::{Solid, circle, rounded};

/// Half of the extents of body and lid along x and z.
const HALF: Vec2 = Vec2::new(0.15, 0.125);

/// The radius of their corners.
const CORNER_M: f32 = 0.035;

/// The distance between the outside and the cavity of body and lid.
const RIM_M: f32 = 0.022;

/// The number of edges per rounded corner.
const STEPS: u32 = 12;

/// The number of waffle pegs along x and z on a plate.
const PEGS: [u8; 2] = [6, 5];

const CHARCOAL: u32 = 0x33_363B;
const CREAM: u32 = 0xE4_DCC8;
const IRON: u32 = 0x6B_6E72;
const STEEL: u32 = 0xB9_BEC4;
const BLACK: u32 = 0x1E_1F21;

fn outline(inset: f32, y: f32) -> Vec<Vec3> {
    rounded(HALF - inset, (CORNER_M - inset).max(0.006), y, STEPS)
}

fn cavity(y: f32) -> Vec<Vec3> {
    rounded(HALF - RIM_M, 0.006, y, STEPS)
}

/// Returns the body: a tub whose rim is the parting plane.
pub(super) fn body() -> Mesh {
    let outside = [
        (0.014, 0.0100),
        (0.007, 0.0108),
        (0.0025, 0.0135),
        (0.0, 0.0190),
        (0.0, 0.0530),
        (0.0008, 0.0565),
        (0.0030, 0.0590),
        (0.0055, 0.0598),
    ];
    let mut rings: Vec<Vec<Vec3>> = outside.map(|(inset, y)| outline(inset, y)).into();
    rings.extend([cavity(0.0598), cavity(0.0400)]);
    Solid::loft(&rings).mesh("body", Paint::srgb(CHARCOAL))
}

/// Returns the lid: a dome with a flat top, hollow from below.
pub(super) fn lid() -> Mesh {
    let outside = [
        (0.0055, 0.0604),
        (0.0030, 0.0612),
        (0.0008, 0.0640),
        (0.0, 0.0680),
        (0.0, 0.0860),
        (0.0015, 0.0930),
        (0.0060, 0.0990),
        (0.0130, 0.1040),
        (0.0230, 0.1080),
        (0.0350, 0.1098),
        (0.0450, 0.1105),
    ];
    let mut rings = vec![cavity(0.0800), cavity(0.0604)];
    rings.extend(outside.map(|(inset, y)| outline(inset, y)));
    Solid::loft(&rings).mesh("lid shell", Paint::srgb(CREAM))
}

/// Returns a plate with the relief of waffles, from y = 0 up.
pub(super) fn plate(name: &str) -> Mesh {
    // A peg of a waffle and half of the surrounding grooves, as shares of its cell, with its
    // height.
    const PROFILE: [(f32, f32); 4] = [(0.16, 0.0), (0.30, 1.0), (0.70, 1.0), (0.84, 0.0)];
    let half = HALF - RIM_M - 0.0025;
    let lines = |half: f32, pegs: u8| {
        let edge = 0.006;
        let cell = (half - edge) * 2.0 / f32::from(pegs);
        let mut lines = vec![(-half, 0.0)];
        for peg in 0..pegs {
            let start = edge - half + cell * f32::from(peg);
            lines.extend(PROFILE.map(|(share, height)| (start + cell * share, height)));
        }
        lines.push((half, 0.0));
        lines
    };
    let xs = lines(half.x, PEGS[0]);
    let zs = lines(half.y, PEGS[1]);
    let places = |lines: &[(f32, f32)]| lines.iter().map(|line| line.0).collect::<Vec<_>>();
    let height = |column: usize, row: usize| 0.007 + 0.010 * xs[column].1.min(zs[row].1);
    Solid::relief(&places(&xs), &places(&zs), height).mesh(name, Paint::srgb(IRON))
}

fn turned(name: &str, hex: u32, profile: &[(f32, f32)], segments: u32) -> Mesh {
    Solid::turned(profile, segments).mesh(name, Paint::srgb(hex))
}

/// Returns a rubber foot, which ends half a millimetre below the body.
pub(super) fn foot() -> Mesh {
    let profile = [(0.0105, 0.0), (0.0120, 0.0010), (0.0115, 0.0080), (0.0085, 0.0095)];
    turned("foot", BLACK, &profile, 32)
}

/// Returns a knuckle of the hinge around the x axis: a ring with a tongue that points up and to the
/// front by `up_rad`.
pub(super) fn knuckle(name: &str, up_rad: f32) -> Mesh {
    const SEGMENTS: u32 = 64;
    let radius = |turn: f32| {
        let off = (turn - up_rad).sin_cos();
        let ring: f32 = 0.0085;
        if off.1 <= 0.0 {
            return ring;
        }
        let along = 0.0160 / off.1;
        let across = if off.0 == 0.0 { along } else { 0.006 / off.0.abs() };
        ring.max(along.min(across))
    };
    let ring = |radius: &dyn Fn(f32) -> f32| -> Vec<Vec3> {
        let point = |segment: u32| {
            let turn = TAU * segment as f32 / SEGMENTS as f32;
            let (sin, cos) = turn.sin_cos();
            let radius = radius(turn);
            // In the plane of a loft whose y is the world's x, whose z is the front and whose x is
            // up.
            vec3(radius * sin, 0.0, radius * cos)
        };
        (0..SEGMENTS).map(point).collect()
    };
    let hole = ring(&|_| 0.0042);
    let plate = Solid::pierced(&ring(&radius), &hole, vec2(-0.0125, 0.0125));
    // From (up, right, front) to (right, up, front), which mirrors.
    let turned = glam::Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::Y, Vec3::X, Vec3::Z));
    plate.placed(turned).mesh(name, Paint::srgb(STEEL))
}

/// Returns the pin of the hinge along y, with a head at each end.
pub(super) fn pin() -> Mesh {
    let half = [(0.0036, 0.0815), (0.0064, 0.0815), (0.0064, 0.0835), (0.0050, 0.0850)];
    let below = half.iter().rev().map(|(radius, y)| (*radius, -*y));
    let profile: Vec<(f32, f32)> = below.chain(half).collect();
    turned("hinge pin", STEEL, &profile, 32)
}

/// Returns the dial along y, with a grip ridge.
pub(super) fn dial() -> Mesh {
    let ring = |radius: f32, y: f32| circle(radius, y, 48);
    let ridge = |half_width: f32, y: f32| -> Vec<Vec3> {
        let narrow = |point: Vec3| vec3(point.x.clamp(-half_width, half_width), y, point.z);
        circle(0.0125, y, 48).into_iter().map(narrow).collect()
    };
    let rings = [
        ring(0.0165, 0.0),
        ring(0.0165, 0.004),
        ring(0.0150, 0.006),
        ridge(0.0042, 0.0062),
        ridge(0.0030, 0.0160),
    ];
    Solid::loft(&rings).mesh("dial", Paint::srgb(CREAM))
}

/// Returns the glass of a lamp along y: a dome.
pub(super) fn lamp(name: &str, hex: u32) -> Mesh {
    let dome = (0..=8_u8).map(|step| {
        let (sin, cos) = (TAU / 4.0 * f32::from(step) / 8.0).sin_cos();
        (0.0055 * if step == 8 { 0.0 } else { cos }, 0.001 + 0.0045 * sin)
    });
    let profile: Vec<(f32, f32)> = [(0.0055, 0.0)].into_iter().chain(dome).collect();
    turned(name, hex, &profile, 32)
}

/// Returns the ring around a lamp.
pub(super) fn bezel(name: &str) -> Mesh {
    Solid::ring(vec2(0.0059, 0.0085), vec2(0.0, 0.0022), 32).mesh(name, Paint::srgb(STEEL))
}

/// Returns a post of the handle along y.
pub(super) fn post() -> Mesh {
    turned("handle post", STEEL, &[(0.0070, 0.0), (0.0052, 0.004), (0.0052, 0.0210)], 24)
}

/// Returns the grip of the handle along y: a barrel with round ends.
pub(super) fn grip() -> Mesh {
    const STEPS: u8 = 24;
    let profile = (0..=STEPS).map(|step| {
        let along = f32::from(step) / f32::from(STEPS) * 2.0 - 1.0;
        let radius = 0.0088 + 0.0030 * (1.0 - along * along);
        let round = (1.0 - ((along.abs() - 0.9).max(0.0) / 0.1).powi(2)).max(0.0).sqrt();
        (if step == 0 || step == STEPS { 0.0 } else { radius * round }, 0.080 * along)
    });
    turned("grip", BLACK, &profile.collect::<Vec<_>>(), 40)
}

/// Returns the surface of the knob, about its middle.
pub(super) fn knob() -> Option<PatchSurface> {
    ellipsoid(vec3(0.011, 0.008, 0.011)).ok()
}

pub(super) fn tessellated_knob(surface: &PatchSurface) -> Mesh {
    let levels = TessellationLevels::uniform(surface, 4);
    tessellated(surface, &levels, "lid knob", Paint::srgb(STEEL).packed())
}

/// Returns a screw along y, its head with a hexagonal socket.
pub(super) fn screw(name: &str) -> Mesh {
    let socket = |y: f32| {
        let corner = |segment: u32| {
            // On the sides of a hexagon, with as many points as the head.
            let turn = TAU / 24.0 * (segment % 4) as f32 - TAU / 12.0;
            let radius = 0.0019 / turn.cos();
            let (sin, cos) = (TAU * segment as f32 / 24.0).sin_cos();
            vec3(radius * cos, y, -radius * sin)
        };
        (0..24).map(corner).collect::<Vec<_>>()
    };
    let rings = [
        circle(0.0040, 0.0, 24),
        circle(0.0042, 0.0006, 24),
        circle(0.0038, 0.0022, 24),
        socket(0.0022),
        socket(0.0008),
    ];
    Solid::loft(&rings).mesh(name, Paint::srgb(STEEL))
}

/// Returns the cable, from the back of the body down to the plug.
pub(super) fn cable() -> Mesh {
    const STEPS: u8 = 40;
    const RADIUS_M: f32 = 0.0032;
    let a = vec3(0.105, 0.030, -0.1262);
    let b = vec3(0.105, 0.030, -0.230);
    let c = vec3(0.040, -0.012, -0.190);
    let d = vec3(-0.118, 0.012, -0.190);
    let rings = (0..=STEPS).map(|step| {
        let t = f32::from(step) / f32::from(STEPS);
        let s = 1.0 - t;
        let middle =
            a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t);
        let along = (b - a) * (s * s) + (c - b) * (2.0 * s * t) + (d - c) * (t * t);
        let along = along.normalize_or(Vec3::NEG_Z);
        let aside = along.cross(Vec3::Y).normalize_or(Vec3::X);
        let above = aside.cross(along);
        let point = |segment: u32| {
            let (sin, cos) = (TAU * segment as f32 / 16.0).sin_cos();
            middle + (aside * cos + above * sin) * RADIUS_M
        };
        // Counter-clockwise seen from the end of the cable.
        (0..16).rev().map(point).collect::<Vec<_>>()
    });
    Solid::loft(&rings.collect::<Vec<_>>()).mesh("cable", Paint::srgb(BLACK))
}

/// Returns the plug at the end of the cable.
pub(super) fn plug() -> Mesh {
    let profile =
        [(0.0050, 0.0), (0.0105, 0.006), (0.0150, 0.018), (0.0165, 0.030), (0.0165, 0.031)];
    let turned = super::at(-0.119, 0.012, -0.190)
        * glam::Affine3A::from_rotation_z(std::f32::consts::FRAC_PI_2)
        * glam::Affine3A::from_scale(vec3(0.65, 1.0, 1.0));
    Solid::turned(&profile, 32).placed(turned).mesh("plug", Paint::srgb(BLACK))
}

/// Returns a prong of the plug, along -y.
pub(super) fn prong() -> Mesh {
    let profile = [(0.0, -0.019), (0.0020, -0.017), (0.0024, -0.016), (0.0024, 0.0)];
    turned("prong", STEEL, &profile, 20)
}
