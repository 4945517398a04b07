//! The reference for the shaders: the formulas of glTF 2.0 (appendix B), KHR_lights_punctual and
//! Khronos PBR Neutral as in their specifications, in double precision.

use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// A surface's material at a point.
#[derive(Debug, Clone, Copy)]
pub struct ReferencePoint {
    /// Linear red, green and blue, 0 to 1.
    pub base_colour: DVec3,
    /// 0 to 1.
    pub metallic: f64,
    /// 0 to 1.
    pub roughness: f64,
    /// The factor of ambient light.
    pub occlusion: f64,
    /// The emitted light.
    pub emission: DVec3,
    /// In the world, in metres.
    pub position: DVec3,
    /// The unit normal of the surface, in the world.
    pub normal: DVec3,
}

/// A light, with its properties of KHR_lights_punctual.
#[derive(Debug, Clone, Copy)]
pub enum ReferenceLight {
    /// A light of parallel rays.
    Directional {
        /// Unit vector to the light.
        towards: DVec3,
        /// The illuminance of each colour, in lux.
        lux: DVec3,
    },
    /// A light that shines from a point in all directions.
    Point {
        /// The position in the world, in metres.
        position: DVec3,
        /// The intensity of each colour, in candela.
        candela: DVec3,
        /// The range, in metres.
        range: Option<f64>,
    },
    /// A light that shines from a point into a cone.
    Spot {
        /// The position in the world, in metres.
        position: DVec3,
        /// The intensity of each colour, in candela.
        candela: DVec3,
        /// The range, in metres.
        range: Option<f64>,
        /// Unit vector in the direction of the light.
        along: DVec3,
        /// Half the angle of the cone of full strength, in radians.
        inner: f64,
        /// Half the angle of the whole cone, in radians; darkness lies beyond.
        outer: f64,
    },
}

/// The hemisphere of ambient light: above, below.
pub type Ambient = [DVec3; 2];

fn lerp(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a * (1.0 - t) + b * t
}

fn step(positive: f64) -> f64 {
    if positive > 0.0 { 1.0 } else { 0.0 }
}

/// Returns the BRDF of appendix B.2 and B.3: material = mix of a metal's and a dielectric's BRDF,
/// with the terms of B.3.
fn brdf(point: &ReferencePoint, v: DVec3, l: DVec3) -> DVec3 {
    let n = point.normal;
    let h = (l + v).normalize();
    // The engine's own floor: a mirror would not show a light without size.
    let alpha = (point.roughness * point.roughness).max(0.001);
    let a2 = alpha * alpha;
    let n_h = n.dot(h);
    let n_l = n.dot(l);
    let n_v = n.dot(v);
    let h_l = h.dot(l);
    let h_v = h.dot(v);
    let d = a2 * step(n_h) / (PI * (n_h * n_h * (a2 - 1.0) + 1.0).powi(2));
    let side = |cosine: f64, along_h: f64| {
        2.0 * cosine.abs() * step(along_h)
            / (cosine.abs() + (a2 + (1.0 - a2) * cosine * cosine).sqrt())
    };
    let g = side(n_l, h_l) * side(n_v, h_v);
    let specular = g * d / (4.0 * n_l.abs() * n_v.abs());
    let fresnel = |f0: DVec3| f0 + (DVec3::ONE - f0) * (1.0 - h_v.abs()).powi(5);
    // metal_brdf = conductor_fresnel(baseColor, specular_brdf)
    let metal = fresnel(point.base_colour) * specular;
    // dielectric_brdf = fresnel_mix(ior = 1.5, diffuse, specular)
    let diffuse = point.base_colour / PI;
    let f = fresnel(DVec3::splat(0.04));
    let dielectric = diffuse * (DVec3::ONE - f) + f * specular;
    lerp(dielectric, metal, point.metallic)
}

/// Returns the light that arrives at a place, and the direction to the light.
fn arriving(light: &ReferenceLight, place: DVec3) -> (DVec3, DVec3) {
    let falloff = |position: DVec3, range: Option<f64>| {
        let distance = (position - place).length();
        let window = range.map_or(1.0, |range| (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0));
        window / (distance * distance)
    };
    match *light {
        ReferenceLight::Directional { towards, lux } => (towards, lux),
        ReferenceLight::Point { position, candela, range } => {
            ((position - place).normalize(), candela * falloff(position, range))
        }
        ReferenceLight::Spot { position, candela, range, along, inner, outer } => {
            let towards = (position - place).normalize();
            let scale = 1.0 / (inner.cos() - outer.cos()).max(0.001);
            let offset = -outer.cos() * scale;
            let cone = (along.dot(-towards) * scale + offset).clamp(0.0, 1.0);
            (towards, candela * falloff(position, range) * cone * cone)
        }
    }
}

/// Returns the light that goes to the eye.
pub fn radiance(
    point: &ReferencePoint,
    eye: DVec3,
    lights: &[ReferenceLight],
    ambient: &Ambient,
) -> DVec3 {
    let v = (eye - point.position).normalize();
    let mut sum = point.emission;
    for light in lights {
        let (l, strength) = arriving(light, point.position);
        let cosine = point.normal.dot(l);
        if cosine > 0.0 {
            sum += brdf(point, v, l) * strength * cosine;
        }
    }
    // The engine's ambient term, which no specification has.
    let [above, below] = *ambient;
    let hemisphere = |y: f64| lerp(below, above, 0.5 + 0.5 * y);
    let mirrored = (2.0 * point.normal.dot(v) * point.normal - v).y;
    let up = mirrored + (point.normal.y - mirrored) * point.roughness;
    let diffuse = point.base_colour * (1.0 - point.metallic);
    let specular = lerp(DVec3::splat(0.04), point.base_colour, point.metallic);
    sum + (diffuse * hemisphere(point.normal.y) + specular * hemisphere(up)) * point.occlusion
}

/// Returns the colour after the tone mapping of Khronos PBR Neutral.
pub fn tone_mapped(light: DVec3) -> DVec3 {
    const F90: f64 = 0.04;
    const K_S: f64 = 0.8 - F90;
    const K_D: f64 = 0.15;
    let x = light.min_element();
    let f = if x <= 2.0 * F90 { x - x * x / (4.0 * F90) } else { F90 };
    let colour = light - f;
    let p = colour.max_element();
    if p <= K_S {
        return colour;
    }
    let n = 1.0 - (1.0 - K_S).powi(2) / (p + 1.0 - 2.0 * K_S);
    let g = 1.0 / (K_D * (p - n) + 1.0);
    colour * (n / p) * g + DVec3::splat(n) * (1.0 - g)
}

/// Returns the value of a pixel of the image, not rounded.
pub fn encoded(linear: DVec3) -> [f64; 3] {
    linear.to_array().map(|value| {
        let value = value.clamp(0.0, 1.0);
        255.0
            * if value <= 0.003_130_8 {
                value * 12.92
            } else {
                1.055 * value.powf(1.0 / 2.4) - 0.055
            }
    })
}

/// Returns the light that the byte of a colour encodes.
pub fn decoded(byte: u8) -> f64 {
    let value = f64::from(byte) / 255.0;
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Returns three `f32`s as `f64`s.
pub fn wide(v: [f32; 3]) -> DVec3 {
    dvec3(v[0].into(), v[1].into(), v[2].into())
}
