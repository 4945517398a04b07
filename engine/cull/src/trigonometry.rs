//! Functions of angles that are the same on every system, bit for bit.
//!
//! C libraries differ in the last bit of sines and tangents in single precision, and vertices,
//! cameras and images would with them. In double precision they differ, too, but of results that
//! are rounded to single precision not one in some hundred million.

/// Returns the sine of an angle (radians).
#[must_use]
pub fn sin(angle_rad: f32) -> f32 {
    f64::from(angle_rad).sin() as f32
}

/// Returns the cosine of an angle (radians).
#[must_use]
pub fn cos(angle_rad: f32) -> f32 {
    f64::from(angle_rad).cos() as f32
}

/// Returns the tangent of an angle (radians).
#[must_use]
pub fn tan(angle_rad: f32) -> f32 {
    f64::from(angle_rad).tan() as f32
}

/// Returns the angle between 0 and π that has a cosine (radians); NaN beyond -1 and 1.
#[must_use]
pub fn acos(cosine: f32) -> f32 {
    f64::from(cosine).acos() as f32
}

/// Returns the angle between -π/2 and π/2 that has a tangent (radians).
#[must_use]
pub fn atan(tangent: f32) -> f32 {
    f64::from(tangent).atan() as f32
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_6;

    use super::*;

    /// Checks a tangent that is almost halfway between two numbers: two C libraries round it to
    /// each.
    #[test]
    fn the_tangent_of_thirty_degrees_is_the_nearest_number() {
        assert_eq!(tan(FRAC_PI_6).to_bits(), 0x3f13cd3a);
    }
}
