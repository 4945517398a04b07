//! An object in the form that vertex shaders read.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat3A, Vec3A};

/// An object in the form that vertex shaders read; mirrors `instance.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
pub(crate) struct Instance {
    pub(crate) rows: [[f32; 4]; 3],
    /// The tint as three floats and a 0; in scenes with surfaces `SurfaceResources::instance_tail`.
    pub(crate) tail: [u32; 4],
}

const _: () = assert!(size_of::<Instance>() == 64);

impl Instance {
    /// Returns the transform of the object.
    pub(crate) fn transform(&self) -> Affine3A {
        let [x, y, z] = self.rows;
        let column = |number: usize| Vec3A::new(x[number], y[number], z[number]);
        Affine3A {
            matrix3: Mat3A::from_cols(column(0), column(1), column(2)),
            translation: column(3),
        }
    }
}

pub(crate) fn rows_of(transform: &Affine3A) -> [[f32; 4]; 3] {
    std::array::from_fn(|r| {
        let row = transform.matrix3.row(r);
        [row.x, row.y, row.z, transform.translation[r]]
    })
}

/// Packs the number of an object's lights, at most 255, and its tint into the third value of an
/// instance's tail in scenes with surfaces.
pub(crate) fn lights_and_tint(lights: u32, tint: u32) -> u32 {
    lights & 0xFF | tint << 8
}

/// Returns a value packed by [`lights_and_tint`], with another number of lights.
pub(crate) fn with_lights(packed: u32, lights: u32) -> u32 {
    lights_and_tint(lights, packed >> 8)
}

#[cfg(test)]
mod tests {
    use scene::limits::MAX_LIGHTS_PER_OBJECT;

    use super::*;

    #[test]
    fn lights_and_tint_do_not_disturb_each_other() {
        const { assert!(MAX_LIGHTS_PER_OBJECT <= 0xFF) };
        let packed = lights_and_tint(16, 0xFF_AABBCC);
        assert_eq!(packed, 0xAABB_CC10);
        assert_eq!(with_lights(packed, 3), 0xAABB_CC03);
        assert_eq!(with_lights(lights_and_tint(0, u32::MAX), 0), 0xFFFF_FF00);
    }
}
