//! The view of one frame, derived from a camera or a host's matrix and the size of its image.

use glam::{DMat4, DVec3, DVec4, Mat4, Vec3, Vec4};

use crate::geom::bounds::Aabb;
use crate::geom::camera::{Camera, Projection};
use crate::geom::frustum::Frustum;
use crate::geom::margin::{Margin, rounding};
use crate::geom::projection::{DEPTH_ROUNDING, DepthConvention, ViewError, ViewProjection};
use crate::geom::rays::{ProjectionKind, Rays};
use crate::geom::section::SectionPlanes;
use crate::trigonometry;

/// One frame's view: the matrix that draws and the volumes that cull, from the same numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CullView {
    /// The matrix from world to Vulkan clip space: y down, depth from 0 to 1. Shaders of hosts use
    /// it unchanged; shaders of proxies use [`CullView::proxy_view_proj`], which is derived from
    /// it.
    pub view_proj: Mat4,
    /// The point of the world, near the eye, that shaders of objects subtract from positions first
    /// (metres). So large coordinates do not lose precision.
    pub anchor: Vec3,
    /// The matrix of [`CullView::view_proj`] for points relative to the anchor. Unless the view was
    /// given an [`Anchor`], the anchor is [`Rays::origin`], where clip x and y are 0.
    pub from_anchor: Mat4,
    /// The direction in which depths grow.
    pub depth: DepthConvention,
    /// The rays through the image.
    pub rays: Rays,
    /// Size of the image (pixels).
    pub size: [u32; 2],
    /// The position of the image in a larger image: its upper left corner (pixels). Culling does
    /// not depend on it.
    pub origin: [u32; 2],
    /// The number of steps of the device's sub-pixel grid from the middle of the image to its
    /// edges. Vertex shaders snap vertices to this grid, so that each triangle is rasterised with
    /// its own depth.
    pub snap_steps: [f32; 2],
    /// The volume that the view sees.
    pub frustum: Frustum,
    /// The margin by which proxies of boxes are enlarged in this view.
    pub margin: Margin,
    /// The planes that cut objects in this view; none by default.
    pub section: SectionPlanes,
}

impl CullView {
    /// Derives a view for an image of `size` pixels on a device that snaps vertices to
    /// `2^-sub_pixel_bits` pixels (Vulkan's `subPixelPrecisionBits`). Depth is reversed; the far
    /// plane of a perspective camera is infinitely far away.
    ///
    /// Never fails, but repairs its input. A size of 0 becomes 1. An eye that is not finite is
    /// moved to the origin. A missing `forward` becomes -z, and an unusable `up` becomes some
    /// direction perpendicular to `forward`. The angle is clamped to 0.001 to 3.1 radians, the near
    /// plane of a perspective camera to 1e-6 to 1e6 m, and the size of an orthographic camera's
    /// volume to 1e-6 to 1e9 m.
    #[must_use]
    pub fn new(camera: &Camera, size: [u32; 2], sub_pixel_bits: u32) -> Self {
        Self::anchored(camera, None, size, sub_pixel_bits)
    }

    /// Derives a view like [`CullView::new`], with the given anchor if there is one. The anchor
    /// then determines the exact position of the eye, which single precision may be unable to
    /// represent far from the origin of the world. The camera's eye must be the nearest
    /// representable position.
    #[must_use]
    pub fn anchored(
        camera: &Camera,
        anchor: Option<Anchor>,
        size: [u32; 2],
        sub_pixel_bits: u32,
    ) -> Self {
        let [width, height] = size.map(|pixels| pixels.max(1));
        let aspect = width as f32 / height as f32;
        let eye = if camera.eye.is_finite() { camera.eye } else { Vec3::ZERO };
        let forward = camera.forward.try_normalize().unwrap_or(Vec3::NEG_Z);
        let right = sideways(forward, camera.up);
        let up = right.cross(forward);
        let (kind, half_height, near, depth, origin) = match camera.projection {
            Projection::Perspective { fov_y } => {
                let near = clamp_or(camera.near, 1.0e-6, 1.0e6, 0.1);
                let half_height = trigonometry::tan(0.5 * clamp_or(fov_y, 1.0e-3, 3.1, 1.0));
                (ProjectionKind::Perspective, half_height, near, [0.0, near], eye)
            }
            Projection::Orthographic { height, far } => {
                let near = clamp_or(camera.near, -1.0e9, 1.0e9, 0.0);
                let length = clamp_or(far - near, 1.0e-6, 1.0e9, 1.0e3);
                let half_height = clamp_or(height, 1.0e-6, 1.0e9, 1.0) * 0.5;
                let depth = [1.0, -length.recip()];
                (ProjectionKind::Orthographic, half_height, 0.0, depth, eye + forward * near)
            }
        };
        let rays = Rays {
            kind,
            origin,
            forward,
            middle: forward,
            right: right * (half_height * aspect),
            down: up * -half_height,
            near,
            depth,
            coordinate: origin.abs().max_element(),
        };
        let projection = projection(&rays, [half_height * aspect, half_height]);
        let Anchor { place, seen } = anchor.unwrap_or(Anchor { place: origin, seen: DVec3::ZERO });
        let mut from_anchor = projection * world_to_eye(Vec3::ZERO, right, up, forward);
        // In eye space the camera looks along -z.
        let seen = DVec4::new(seen.x, seen.y, -seen.z, 1.0);
        from_anchor.w_axis = (projection.as_dmat4() * seen).as_vec4();
        let view_proj = projection * world_to_eye(origin, right, up, forward);
        let matrices = Matrices { view_proj, anchor: place, from_anchor };
        Self::of(matrices, DepthConvention::Reversed, rays, [width, height], sub_pixel_bits)
    }

    /// Derives the view of a host's matrix for an image of `size` pixels (at least 1) on a device
    /// that snaps vertices to `2^-sub_pixel_bits` pixels.
    ///
    /// All properties follow from the one matrix: the eye, the frustum with its far plane if there
    /// is one, the size of pixels, and the depth of points. So a jitter affects all of them.
    /// Shaders use the matrix bit for bit, except for the sign of y if y is up.
    ///
    /// ```
    /// # use antumbra_cull as cull;
    /// use cull::{ClipY, DepthConvention, CullView, ViewProjection};
    /// use glam::{Mat4, Vec4, vec3};
    ///
    /// // Infinitely far, depth from 1 at the near plane to 0, y down as in Vulkan.
    /// let (focal_length, aspect, near) = (1.7, 16.0 / 9.0, 0.1);
    /// let projection = Mat4::from_cols(
    ///     Vec4::X * (focal_length / aspect),
    ///     Vec4::NEG_Y * focal_length,
    ///     Vec4::NEG_W,
    ///     Vec4::Z * near,
    /// );
    /// let eye = Mat4::from_translation(-vec3(0.0, 1.8, 5.0));
    /// let matrix = projection * eye;
    /// let matrix = ViewProjection { matrix, depth: DepthConvention::Reversed, y: ClipY::Down };
    /// let view = CullView::from_matrix(&matrix, [1920, 1080], 8)?;
    /// assert!((view.rays.origin - vec3(0.0, 1.8, 5.0)).length() < 1e-4);
    /// # Ok::<(), cull::ViewError>(())
    /// ```
    ///
    /// # Errors
    /// [`ViewError`] if the matrix is not a projection or does not follow the given conventions.
    pub fn from_matrix(
        projection: &ViewProjection,
        size: [u32; 2],
        sub_pixel_bits: u32,
    ) -> Result<Self, ViewError> {
        let size = size.map(|pixels| pixels.max(1));
        let rays = projection.rays()?;
        let view_proj = projection.downwards();
        let from_anchor = from_origin(&view_proj, &rays);
        let matrices = Matrices { view_proj, anchor: rays.origin, from_anchor };
        Ok(Self::of(matrices, projection.depth, rays, size, sub_pixel_bits))
    }

    fn of(
        matrices: Matrices,
        depth: DepthConvention,
        rays: Rays,
        size: [u32; 2],
        sub_pixel_bits: u32,
    ) -> Self {
        let Matrices { view_proj, anchor, from_anchor } = matrices;
        let steps_per_pixel = 2.0_f32.powi(sub_pixel_bits.min(24) as i32);
        Self {
            view_proj,
            anchor,
            from_anchor,
            depth,
            rays,
            size,
            origin: [0, 0],
            snap_steps: size.map(|side| side as f32 * 0.5 * steps_per_pixel),
            frustum: Frustum::new(&from_anchor, anchor, depth, &rays),
            margin: Margin::new(&rays, size, sub_pixel_bits),
            section: SectionPlanes::default(),
        }
    }

    /// Returns the frustum of an image that is larger by `pixels` on each side. An object that is
    /// drawn wider than its geometry, such as a line, shows in the image only if it meets this
    /// frustum.
    #[must_use]
    pub fn frustum_around(&self, pixels: f32) -> Frustum {
        let larger = self.size.map(|side| 1.0 + 2.0 * pixels.max(0.0) / side.max(1) as f32);
        let smaller = Mat4::from_scale(Vec3::new(larger[0].recip(), larger[1].recip(), 1.0));
        Frustum::new(&(smaller * self.from_anchor), self.anchor, self.depth, &self.rays)
    }

    /// Returns the frustum of a pixel, counted from the upper left: every object that covers a
    /// sample of the pixel meets this frustum.
    #[must_use]
    pub fn frustum_of_pixel(&self, pixel: [u32; 2]) -> Frustum {
        let size = self.size.map(|side| side.max(1) as f32);
        let middle = [0, 1].map(|axis| (pixel[axis] as f32 + 0.5) / size[axis] * 2.0 - 1.0);
        let to_middle = Mat4::from_translation(Vec3::new(-middle[0], -middle[1], 0.0));
        // Slightly more than the pixel, for the rounding of its sides.
        let larger = Mat4::from_scale(Vec3::new(size[0] * 0.99, size[1] * 0.99, 1.0));
        Frustum::new(&(larger * to_middle * self.from_anchor), self.anchor, self.depth, &self.rays)
    }

    /// Returns the clip coordinates of a point (metres), with the same precision far from the
    /// origin of the world as near it.
    #[must_use]
    pub fn clip(&self, point: Vec3) -> DVec4 {
        let from_anchor = point.as_dvec3() - self.anchor.as_dvec3();
        self.from_anchor.as_dmat4() * from_anchor.extend(1.0)
    }

    /// Returns the matrix that proxies are drawn with: [`CullView::view_proj`], but with depths
    /// that are nearer by a bound on their rounding (see [`Margin`]).
    ///
    /// For a reversed depth with an infinite far plane the two are equal, because such depths have
    /// the same number of significant digits as distances.
    #[must_use]
    pub fn proxy_view_proj(&self) -> Mat4 {
        let [constant, _] = self.rays.depth;
        let towards_eye = self.depth.sign() * DEPTH_ROUNDING * constant.abs();
        let w = self.view_proj.row(3);
        let coordinate = match self.rays.kind {
            ProjectionKind::Perspective => w.truncate().length() * self.rays.coordinate,
            ProjectionKind::Orthographic => 0.0,
        };
        let nearer = (w + Vec4::W * coordinate) * towards_eye;
        let mut columns = self.view_proj.to_cols_array_2d();
        for (column, nearer) in columns.iter_mut().zip(nearer.to_array()) {
            column[2] += nearer;
        }
        Mat4::from_cols_array_2d(&columns)
    }

    /// Returns true if the [section planes](CullView::section) remove everything in a box, by more
    /// than the rounding of drawn geometry.
    #[must_use]
    pub fn cuts_away(&self, bounds: &Aabb) -> bool {
        !self.section.is_empty()
            && self.section.removes(bounds, rounding(bounds, self.rays.coordinate))
    }

    /// Returns the size of a pixel at a distance (metres).
    pub(crate) fn pixel_m(&self, distance_m: f32) -> f32 {
        self.margin.pixel_m(distance_m)
    }

    /// Returns the number of pixels that a metre covers at the nearest point of `bounds`, in the
    /// middle of the image; at the near plane if the box is nearer.
    #[must_use]
    pub fn pixels_per_metre(&self, bounds: &Aabb) -> f32 {
        self.pixel_m(self.rays.distance(bounds).max(self.rays.near)).recip()
    }
}

/// Returns `value` clamped to a range, or `otherwise` if it is NaN.
fn clamp_or(value: f32, low: f32, high: f32, otherwise: f32) -> f32 {
    if value.is_nan() { otherwise } else { value.clamp(low, high) }
}

/// Returns the unit vector to the right, even if `up` is missing or parallel to `forward`.
fn sideways(forward: Vec3, up: Vec3) -> Vec3 {
    let across = forward.cross(up.normalize_or_zero());
    if across.is_finite() && across.length_squared() > 1.0e-12 {
        return across.normalize();
    }
    forward.any_orthonormal_vector()
}

/// Returns the matrix from world to eye space, which is right-handed: x is right, y is up, and the
/// camera looks along -z.
fn world_to_eye(eye: Vec3, right: Vec3, up: Vec3, forward: Vec3) -> Mat4 {
    let back = -forward;
    let rotation =
        Mat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), Vec4::W).transpose();
    rotation * Mat4::from_translation(-eye)
}

/// The anchor of a view, if it is not the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// The anchor in the world (metres).
    pub place: Vec3,
    /// The anchor relative to the eye: to the right, up and ahead (metres). In an orthographic view
    /// it is relative to the middle of the near plane.
    pub seen: DVec3,
}

/// The matrices of a view: for points in the world, and for points relative to the anchor.
#[derive(Clone, Copy)]
struct Matrices {
    view_proj: Mat4,
    anchor: Vec3,
    from_anchor: Mat4,
}

/// Returns a host's matrix for points relative to the origin of its rays, where clip x and y are 0,
/// and in perspective also w.
fn from_origin(view_proj: &Mat4, rays: &Rays) -> Mat4 {
    let moved = view_proj.as_dmat4() * DMat4::from_translation(rays.origin.as_dvec3());
    let w = match rays.kind {
        ProjectionKind::Perspective => 0.0,
        ProjectionKind::Orthographic => moved.w_axis.w,
    };
    let w_axis = DVec4::new(0.0, 0.0, moved.w_axis.z, w);
    DMat4::from_cols(moved.x_axis, moved.y_axis, moved.z_axis, w_axis).as_mat4()
}

/// Returns the projection of a camera's rays, y down.
fn projection(rays: &Rays, half_size: [f32; 2]) -> Mat4 {
    let [half_width, half_height] = half_size;
    let [constant, scaled] = rays.depth;
    let (z_column, w_column) = match rays.kind {
        ProjectionKind::Perspective => {
            (Vec4::new(0.0, 0.0, -constant, -1.0), Vec4::new(0.0, 0.0, scaled, 0.0))
        }
        ProjectionKind::Orthographic => {
            (Vec4::new(0.0, 0.0, -scaled, 0.0), Vec4::new(0.0, 0.0, constant, 1.0))
        }
    };
    Mat4::from_cols(
        Vec4::new(1.0 / half_width, 0.0, 0.0, 0.0),
        Vec4::new(0.0, -1.0 / half_height, 0.0, 0.0),
        z_column,
        w_column,
    )
}
