//! Makes numbers from files safe: unit vectors from any vectors, and transforms that can be drawn.

use glam::{Affine3A, DVec3, Quat, Vec3};

/// Returns the direction of a vector, however long or short; `None` if it has none.
pub(super) fn direction(vector: Vec3) -> Option<Vec3> {
    let largest = vector.abs().max_element();
    if !vector.is_finite() || largest == 0.0 {
        return None;
    }
    // In double precision, squares of neither 1e38 nor 1e-45 are lost.
    let precise = vector.as_dvec3();
    let unit = (precise / precise.length()).as_vec3();
    unit.is_finite().then_some(unit)
}

/// Returns the rotation of a quaternion of any length; `None` if it has no direction.
pub(super) fn rotation(parts: [f32; 4]) -> Option<Quat> {
    let precise = glam::DQuat::from_array(parts.map(f64::from));
    let length = precise.length();
    if !length.is_finite() || length == 0.0 {
        return None;
    }
    // A unit quaternion is returned unchanged.
    if (length - 1.0).abs() < 1e-6 {
        return Some(Quat::from_array(parts));
    }
    let unit = glam::DQuat::from_array(precise.to_array().map(|part| part / length));
    Some(unit.as_quat())
}

/// Returns the normal of a triangle by the right-hand rule; `None` if it has no area.
pub(super) fn triangle_normal(corners: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let cross = (b - a).cross(c - a);
    let length = cross.length();
    (length > 0.0 && length.is_finite()).then(|| (cross / length).as_vec3())
}

fn columns(transform: &Affine3A) -> [DVec3; 3] {
    let matrix = &transform.matrix3;
    [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.as_dvec3())
}

/// Returns true if a transform changes handedness.
pub(super) fn mirrors(transform: &Affine3A) -> bool {
    let [x, y, z] = columns(transform);
    x.cross(y).dot(z) < 0.0
}

/// Returns true if everything with an area has an area after the transform.
pub(super) fn keeps_areas(transform: &Affine3A) -> bool {
    let [x, y, z] = columns(transform);
    [x.cross(y), y.cross(z), z.cross(x)].iter().any(|area| area.length_squared() > 0.0)
}

/// Returns true if everything with a volume has a volume after the transform.
pub(super) fn has_volume(transform: &Affine3A) -> bool {
    let [x, y, z] = columns(transform);
    x.cross(y).dot(z) != 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat3, vec3};

    #[test]
    fn directions_of_huge_and_tiny_vectors_are_unit_vectors_and_of_nothing_there_is_none() {
        for scale in [1e-44, 1e-20, 1.0, 1e20, 3e38] {
            assert_eq!(direction(vec3(0.0, -scale, 0.0)), Some(Vec3::NEG_Y), "{scale}");
        }
        assert_eq!(direction(vec3(3.0, 0.0, 4.0)), Some(vec3(0.6, 0.0, 0.8)));
        for none in [Vec3::ZERO, Vec3::NAN, vec3(0.0, f32::INFINITY, 1.0)] {
            assert_eq!(direction(none), None);
        }
    }

    #[test]
    fn quaternions_of_any_length_are_rotations_and_of_none_are_not() {
        assert_eq!(rotation([0.0, 2.0, 0.0, 0.0]), Some(Quat::from_xyzw(0.0, 1.0, 0.0, 0.0)));
        assert_eq!(rotation([0.0, 0.0, 0.0, 1e-30]), Some(Quat::IDENTITY));
        assert_eq!(rotation([0.0; 4]), None);
        assert_eq!(rotation([f32::NAN, 0.0, 0.0, 1.0]), None);
    }

    #[test]
    fn mirrors_areas_and_volumes_are_told_at_any_scale() {
        let scaled =
            |x: f32, y: f32, z: f32| Affine3A::from_mat3(Mat3::from_diagonal(vec3(x, y, z)));
        for scale in [1e-20, 1.0, 1e20] {
            assert!(mirrors(&scaled(-scale, scale, scale)));
            assert!(!mirrors(&scaled(-scale, -scale, scale)));
            assert!(keeps_areas(&scaled(scale, 0.0, scale)));
            assert!(!keeps_areas(&scaled(scale, 0.0, 0.0)));
        }
        assert!(has_volume(&scaled(1e-20, 1.0, -1.0)) && !has_volume(&scaled(1.0, 0.0, 1.0)));
    }

    #[test]
    fn triangles_without_area_have_no_normal() {
        let big = 1e18;
        let corners = [Vec3::ZERO, vec3(big, 0.0, 0.0), vec3(0.0, big, 0.0)];
        assert_eq!(triangle_normal(corners), Some(Vec3::Z));
        assert_eq!(triangle_normal([Vec3::ZERO, Vec3::X, vec3(2.0, 0.0, 0.0)]), None);
    }
}
