//! Levels of detail: the coarsest form of an object whose error is too small to be seen.

/// A form of an object by its level: 0 is the finest, and higher levels are coarser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DetailLevel(pub u8);

/// The rule that chooses the form of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailPolicy {
    /// The allowed displacement of a surface (pixels in the middle of the image, above 0).
    pub error_pixels: f32,
    /// The share (0 to 1) by which the error of a coarser form must be below the limit before it is
    /// taken, so that an object at the limit does not switch back and forth.
    pub hysteresis: f32,
    /// The rule for objects with few visible samples; with `None` only the distance decides.
    pub by_samples: Option<DetailBySamples>,
}

/// The rule that gives an object with few visible samples a coarser form than its distance allows
/// ("Efficient Occlusion Culling", GPU Gems, 29.9).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailBySamples {
    /// The number of visible samples of its box from which on only the distance decides.
    pub enough_samples: u32,
    /// The factor, at least 1, by which the error may be larger if no sample is visible.
    pub most: f32,
}

impl Default for DetailBySamples {
    /// Returns a square of 64 pixels, and a factor of 4.
    fn default() -> Self {
        Self { enough_samples: 64 * 64, most: 4.0 }
    }
}

impl Default for DetailPolicy {
    /// Returns half a pixel by distance only. With the hysteresis, an object switches to a coarser
    /// form at a distance larger by a quarter than the distance at which it switches back.
    fn default() -> Self {
        Self { error_pixels: 0.5, hysteresis: 0.2, by_samples: None }
    }
}

impl DetailPolicy {
    /// Returns the pixels per metre with which to [choose](DetailPolicy::choose) the form of an
    /// object that has `visible` samples. With few samples the value is smaller than the distance
    /// gives: the allowed error grows as the width of the visible part shrinks, which is the square
    /// root of the samples. If `visible` is `None`, or without a rule for samples, only the
    /// distance decides.
    ///
    /// The hysteresis applies to samples as to distances: with the default, an object that took a
    /// coarser form keeps it until the number of samples has grown by half. This requires samples
    /// that do not depend on the form, such as the samples of the object's box.
    #[must_use]
    pub fn seen_pixels_per_metre(&self, pixels_per_metre: f32, visible: Option<u32>) -> f32 {
        let (Some(rule), Some(visible)) = (self.by_samples, visible) else {
            return pixels_per_metre;
        };
        let ratio = rule.enough_samples as f32 / visible.max(1) as f32;
        pixels_per_metre / ratio.sqrt().clamp(1.0, rule.most.max(1.0))
    }

    /// Returns the form of an object. Its forms have the errors `errors_m` (metres in the world,
    /// ascending; the first belongs to the finest form), a metre covers `pixels_per_metre` (see
    /// [`CullView::pixels_per_metre`](crate::CullView::pixels_per_metre)), and `now` is its present
    /// form.
    ///
    /// The result depends on nothing else, in particular not on culling: every renderer of a frame
    /// draws the same forms. Without errors, or with values that are not numbers, it is the finest
    /// form.
    #[must_use]
    pub fn choose(&self, pixels_per_metre: f32, errors_m: &[f32], now: DetailLevel) -> DetailLevel {
        let within = |limit_pixels: f32| {
            let fits = |error: &&f32| **error * pixels_per_metre <= limit_pixels;
            errors_m.iter().skip(1).take(usize::from(u8::MAX)).take_while(fits).count() as u8
        };
        let coarsest = within(self.error_pixels);
        let surely = within(self.error_pixels * (1.0 - self.hysteresis.clamp(0.0, 1.0)));
        DetailLevel(now.0.clamp(surely.min(coarsest), coarsest))
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geom::bounds::Aabb;
    use crate::geom::camera::{Camera, Projection};
    use crate::geom::view::CullView;
    use crate::rng::SplitMix64;

    const ERRORS_M: [f32; 4] = [0.0, 0.01, 0.02, 0.08];
    const POLICY: DetailPolicy =
        DetailPolicy { error_pixels: 1.0, hysteresis: 0.2, by_samples: None };

    fn settled(pixels_per_metre: f32) -> u8 {
        let choose = |now| POLICY.choose(pixels_per_metre, &ERRORS_M, DetailLevel(now)).0;
        let from_finest = choose(0);
        let from_coarsest = choose(3);
        assert!(from_finest <= from_coarsest);
        assert_eq!(choose(from_finest), from_finest, "it stays where it is");
        assert_eq!(choose(from_coarsest), from_coarsest, "it stays where it is");
        from_coarsest
    }

    #[test]
    fn the_coarsest_form_whose_error_is_small_enough_is_taken() {
        for (pixels_per_metre, level) in
            [(0.0, 3), (12.5, 3), (12.6, 2), (50.0, 2), (51.0, 1), (100.0, 1), (101.0, 0), (1e9, 0)]
        {
            assert_eq!(settled(pixels_per_metre), level, "{pixels_per_metre}");
        }
    }

    #[test]
    fn an_object_at_the_limit_does_not_change_to_and_fro() {
        let mut level = DetailLevel(0);
        let mut changes = 0;
        for step in 0..100 {
            let pixels_per_metre = if step % 2 == 0 { 99.0 } else { 101.0 };
            let next = POLICY.choose(pixels_per_metre, &ERRORS_M, level);
            changes += u32::from(next != level);
            level = next;
        }
        assert_eq!((level, changes), (DetailLevel(0), 0));
        assert_eq!(POLICY.choose(80.0, &ERRORS_M, level), DetailLevel(1));
        assert_eq!(POLICY.choose(99.0, &ERRORS_M, DetailLevel(1)), DetailLevel(1));
    }

    #[test]
    fn what_is_no_number_gives_the_finest() {
        assert_eq!(POLICY.choose(f32::NAN, &ERRORS_M, DetailLevel(3)), DetailLevel(0));
        assert_eq!(POLICY.choose(1.0, &[0.0, f32::NAN, 0.0], DetailLevel(9)), DetailLevel(0));
        assert_eq!(POLICY.choose(1.0, &[], DetailLevel(9)), DetailLevel(0));
        let odd = DetailPolicy { error_pixels: f32::NAN, hysteresis: -3.0, by_samples: None };
        assert_eq!(odd.choose(1.0, &ERRORS_M, DetailLevel(1)), DetailLevel(0));
    }

    const SEEN: DetailPolicy = DetailPolicy {
        by_samples: Some(DetailBySamples { enough_samples: 1000, most: 4.0 }),
        ..POLICY
    };

    #[test]
    fn fewer_visible_samples_never_give_a_finer_form() {
        let mut rng = SplitMix64::new(11);
        let mut coarser = 0;
        for _ in 0..2_000 {
            let pixels_per_metre = rng.unit() * 300.0;
            let now = DetailLevel(rng.between(0, 3) as u8);
            let choose = |visible: Option<u32>| {
                let seen = SEEN.seen_pixels_per_metre(pixels_per_metre, visible);
                SEEN.choose(seen, &ERRORS_M, now)
            };
            let by_distance = POLICY.choose(pixels_per_metre, &ERRORS_M, now);
            assert_eq!(choose(None), by_distance);
            assert_eq!(choose(Some(rng.between(1000, 9000))), by_distance);
            let few = rng.between(0, 1200);
            let more = rng.between(0, 300);
            assert!(choose(Some(few)) >= choose(Some(few + more)));
            coarser += u32::from(choose(Some(0)) > by_distance);
        }
        assert!(coarser > 300, "{coarser}");
        assert_eq!(POLICY.seen_pixels_per_metre(7.0, Some(0)), 7.0);
    }

    #[test]
    fn the_error_grows_up_to_its_bound() {
        let seen = |visible| SEEN.seen_pixels_per_metre(100.0, Some(visible));
        assert_eq!([seen(0), seen(10), seen(250), seen(1000)], [25.0, 25.0, 50.0, 100.0]);
        for most in [f32::NAN, 0.0, -2.0] {
            let by_samples = Some(DetailBySamples { most, enough_samples: 1000 });
            let odd = DetailPolicy { by_samples, ..POLICY };
            assert_eq!(odd.seen_pixels_per_metre(100.0, Some(1)), 100.0, "{most}");
        }
    }

    #[test]
    fn samples_at_a_threshold_do_not_make_a_form_flicker() {
        let mut rng = SplitMix64::new(5);
        for seed in 0..300 {
            let pixels_per_metre = rng.unit() * 200.0 + 1.0;
            let middle = rng.between(20, 1400) as f32;
            let mut level = DetailLevel(rng.between(0, 3) as u8);
            let mut changes = Vec::new();
            for _ in 0..60 {
                let visible = (middle * (0.82 + 0.36 * rng.unit())) as u32;
                let seen = SEEN.seen_pixels_per_metre(pixels_per_metre, Some(visible));
                let next = SEEN.choose(seen, &ERRORS_M, level);
                changes.extend((next != level).then_some(next > level));
                level = next;
            }
            // The level changes in one direction only, and each level at most once.
            let first = changes.first().copied();
            assert!(changes.len() <= 3, "{seed}: {changes:?}");
            assert!(changes.iter().all(|change| Some(*change) == first), "{seed}: {changes:?}");
        }
    }

    #[test]
    fn a_metre_covers_fewer_pixels_farther_away() {
        let camera = Camera {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(std::f32::consts::FRAC_PI_2),
            near: 0.1,
        };
        let view = CullView::new(&camera, [400, 200], 8);
        let at = |z: f32| Aabb::new(Vec3::new(-1.0, -1.0, z - 1.0), Vec3::new(1.0, 1.0, z));
        for (z, pixels) in [(-1.0, 100.0), (-10.0, 10.0), (0.5, 1000.0)] {
            assert!((view.pixels_per_metre(&at(z)) - pixels).abs() < 0.01, "{z}");
        }
    }
}
