//! A measure of triangles that enclose a volume and face outwards or inwards.

use cull::Aabb;
use glam::{DVec3, Vec3};

/// The least `signed_volume`, positive or negative, of triangles that enclose the volume of their
/// box instead of lying in it like a sheet: long thin bottles have little more.
pub const ENCLOSING: f32 = 0.05;

/// The ratio of a surface's summed area vector to its area up to which it counts as closed: 0 for a
/// closed surface, 0.5 for half a ball.
const OPEN: f64 = 0.55;

/// Returns the degree to which counter-clockwise triangles face away from the middle of their box:
/// 1 if all face straight away, as on a ball; -1 if all face the middle; 0 for sheets, for surfaces
/// more open than half a ball, and for triangles with their backs. Triangles with a coordinate that
/// is not finite are ignored.
pub fn signed_volume(bounds: &Aabb, triangles: impl IntoIterator<Item = [Vec3; 3]>) -> f32 {
    let middle = bounds.centre().as_dvec3();
    let mut outwards = 0.0;
    let mut all = 0.0;
    let mut open = DVec3::ZERO;
    let mut whole = 0.0;
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3() - middle);
        let area: DVec3 = (b - a).cross(c - a);
        let out = a + b + c;
        let most = out.length() * area.length();
        if most.is_finite() {
            outwards += out.dot(area);
            all += most;
            open += area;
            whole += area.length();
        }
    }
    let encloses = all > 0.0 && open.length() <= OPEN * whole;
    if encloses { (outwards / all) as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns an octahedron, long along y, around 5, 0, 0; its first half is the upper one.
    fn octahedron() -> Vec<[Vec3; 3]> {
        let corner = |x: f32, y: f32, z: f32| Vec3::new(5.0 + x, 4.0 * y, z);
        let mut triangles = Vec::new();
        for y in [1.0, -1.0] {
            for x in [1.0, -1.0] {
                for z in [1.0, -1.0] {
                    let a = corner(x, 0.0, 0.0);
                    let b = corner(0.0, y, 0.0);
                    let c = corner(0.0, 0.0, z);
                    triangles.push(if x * y * z > 0.0 { [a, b, c] } else { [a, c, b] });
                }
            }
        }
        triangles
    }

    fn of(triangles: &[[Vec3; 3]]) -> f32 {
        let corners = triangles.as_flattened().iter();
        let bounds = corners.fold(Aabb::EMPTY, |all, at| all.union(&Aabb::new(*at, *at)));
        signed_volume(&bounds, triangles.iter().copied())
    }

    #[test]
    fn balls_look_out_their_insides_in_and_sheets_neither() {
        let ball = octahedron();
        assert!(of(&ball) > 0.4, "{}", of(&ball));
        let inside: Vec<[Vec3; 3]> = ball.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        assert_eq!(of(&inside), -of(&ball));
        assert!(of(&[ball.clone(), inside].concat()).abs() < 1e-6, "both sides");
        let square = [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::Y, Vec3::X, Vec3::X + Vec3::Y]];
        assert!(of(&square).abs() < 1e-6, "a sheet");
        assert!(of(&ball[..4]) > ENCLOSING, "half of it");
        let windscreen =
            [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::Y, Vec3::X, Vec3::new(1.0, 1.0, 0.5)]];
        assert_eq!(of(&windscreen), 0.0, "a bent sheet");
        assert_eq!(of(&[]), 0.0);
        assert_eq!(of(&[[Vec3::NAN; 3]]), 0.0);
    }
}
