//! Boxes in shaders and in a rasteriser: their corners in clip space, computed in single precision
//! with the matrix that draws them, and the triangles between the corners.

use antumbra_cull::{Aabb, CullView};
use glam::{DMat3, DVec2, DVec3, Vec3, Vec4};

/// The corners of each face, as indices in [`Aabb::corners`]: the lower and the upper face of each
/// axis.
const FACES: [[[usize; 4]; 2]; 3] =
    [[[0, 2, 6, 4], [1, 3, 7, 5]], [[0, 1, 5, 4], [2, 3, 7, 6]], [[0, 1, 3, 2], [4, 5, 7, 6]]];

/// A box in clip space.
pub struct ClipBox {
    /// Its eight corners.
    pub corners: [Vec4; 8],
    triangles: Vec<Triangle>,
}

/// A point of a triangle.
#[derive(Clone, Copy)]
pub struct ClipPoint {
    /// The clip coordinate w.
    pub w: f64,
    /// The clip coordinate z.
    pub z: f64,
}

/// A triangle.
struct Triangle {
    /// The weight of each corner at a point, over w: its value in the middle of the image, and its
    /// growth to the right and downwards.
    shares_over_w: [[f64; 3]; 3],
    z: [f64; 3],
}

impl ClipBox {
    /// Returns all faces of an object's box, transformed as in shaders of objects.
    pub fn of_object(view: &CullView, bounds: &Aabb) -> Self {
        let clip = |corner: Vec3| view.from_anchor * (corner - view.anchor).extend(1.0);
        let every = FACES.as_flattened();
        Self::between(bounds.corners().map(clip), every)
    }

    /// Returns the faces of a proxy that its shader treats as front faces.
    pub fn of_proxy(view: &CullView, bounds: &Aabb) -> Self {
        let matrix = view.proxy_view_proj();
        let eye = view.rays.eye();
        let mut front = Vec::new();
        for (axis, [low, high]) in FACES.into_iter().enumerate() {
            if eye[axis] < bounds.min[axis] * eye.w {
                front.push(low);
            }
            if eye[axis] > bounds.max[axis] * eye.w {
                front.push(high);
            }
        }
        Self::between(bounds.corners().map(|corner| matrix * corner.extend(1.0)), &front)
    }

    fn between(corners: [Vec4; 8], faces: &[[usize; 4]]) -> Self {
        let halves = faces.iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let triangles = halves.filter_map(|half| Triangle::of(half.map(|corner| corners[*corner])));
        Self { corners, triangles: triangles.collect() }
    }

    /// Returns the points at a position in normalised device coordinates.
    pub fn points(&self, ndc: DVec2) -> impl Iterator<Item = ClipPoint> {
        self.triangles.iter().filter_map(move |triangle| triangle.point(ndc))
    }
}

impl Triangle {
    /// Returns the triangle between three corners; `None` if it is seen edge-on.
    fn of(corners: [Vec4; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(Vec4::as_dvec4);
        let xyw = DMat3::from_cols(
            DVec3::new(a.x, a.y, a.w),
            DVec3::new(b.x, b.y, b.w),
            DVec3::new(c.x, c.y, c.w),
        );
        let inverse = xyw.inverse();
        let is_seen = xyw.determinant() != 0.0 && inverse.is_finite();
        let shares_over_w = inverse.transpose().to_cols_array_2d().map(|[x, y, w]| [w, x, y]);
        is_seen.then_some(Self { shares_over_w, z: [a.z, b.z, c.z] })
    }

    fn point(&self, ndc: DVec2) -> Option<ClipPoint> {
        let mut over_w = 0.0;
        let mut z_over_w = 0.0;
        for ([middle, right, down], z) in self.shares_over_w.iter().zip(&self.z) {
            let share = middle + right * ndc.x + down * ndc.y;
            if share < 0.0 {
                return None;
            }
            over_w += share;
            z_over_w += share * z;
        }
        (over_w > 0.0).then(|| ClipPoint { w: over_w.recip(), z: z_over_w / over_w })
    }
}
