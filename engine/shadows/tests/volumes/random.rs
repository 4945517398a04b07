//! A small generator of numbers that look random.

use glam::{Vec3, vec3};

/// The generator's state.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, end: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((mixed >> 33) % u64::from(end)) as u32
    }

    pub fn unit(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }

    pub fn direction(&mut self) -> Vec3 {
        loop {
            let at = 2.0 * vec3(self.unit(), self.unit(), self.unit()) - 1.0;
            if at.length_squared() > 0.01 && at.length_squared() < 1.0 {
                return at.normalize();
            }
        }
    }
}
