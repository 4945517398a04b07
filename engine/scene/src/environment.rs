//! The light from all around: a sky or a picture, as it lights matt and glossy surfaces, and as it
//! is seen as the backdrop.
//!
//! Directions lie on the square of an octahedron (Cigolle et al., "A Survey of Efficient
//! Representations for Independent Unit Vectors", 2014). Each level holds the mean radiance around
//! a direction: the first as sharp as the square has texels, the next ones weighted by the lobes of
//! rougher surfaces (Karis, "Real Shading in Unreal Engine 4", 2013), the last by the cosine, as a
//! matt surface sees it.

use cull::trigonometry;
use glam::{Vec2, Vec2Swizzles, Vec3, vec2, vec3};

use crate::backdrop::{BRIGHTEST, Backdrop, Panorama, Sky, SkyDisk};
use crate::error::SceneError;

/// The side of the square of directions in texels.
pub const ENVIRONMENT_SIDE: u32 = 64;

/// The levels for glossy surfaces, from a roughness of 0 to 1.
pub const GLOSSY_LEVELS: u32 = 6;

/// The size of the backdrop of light by direction, in texels.
const RADIANCE_SIZE: [u32; 2] = [1024, 512];

/// The number of directions that a lobe is sampled with.
const LOBE_SAMPLES: u32 = 64;

/// The light from all around a scene, in the units of the scene's ambient light.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// [`GLOSSY_LEVELS`] squares and one for matt surfaces, each of [`ENVIRONMENT_SIDE`] rows.
    texels: Vec<[f32; 3]>,
    /// The sky or the picture, as it is seen.
    backdrop: Backdrop,
    /// The sun's or the moon's disk, as it is seen.
    disk: Option<SkyDisk>,
}

impl Environment {
    /// Creates the light of a sky.
    ///
    /// # Errors
    /// [`SceneError::BrokenEnvironment`] for a colour or direction that is not finite.
    pub fn of_sky(sky: &Sky) -> Result<Self, SceneError> {
        let texels = levels_of(|direction| sky.radiance(direction))?;
        Ok(Self { texels, backdrop: Backdrop::Sky(*sky), disk: None })
    }

    /// Creates the light of an equirectangular picture of linear radiance. The first row is
    /// straight above; the middle of a row looks along -z, and its right quarter along +x. The
    /// picture is shown with all its pixels, up to
    /// [`MAX_PANORAMA_TEXELS`](crate::limits::MAX_PANORAMA_TEXELS) and the limits of the device.
    /// Larger pictures are shown at a half or a quarter of their size.
    ///
    /// # Errors
    /// [`SceneError::BrokenEnvironment`] for a size of 0, for a number of pixels that does not
    /// match the size, and for a value that is not finite.
    pub fn of_equirectangular(size: [u32; 2], pixels: &[[f32; 3]]) -> Result<Self, SceneError> {
        let panorama = Panorama::new(size, pixels)?;
        let texels = levels_of(|direction| panorama.radiance(direction))?;
        Ok(Self { texels, backdrop: Backdrop::Panorama(panorama), disk: None })
    }

    /// Creates the light of a radiance that is a function of the direction, a unit vector.
    ///
    /// # Errors
    /// [`SceneError::BrokenEnvironment`] for a radiance that is not finite.
    pub fn of_radiance(radiance: impl Fn(Vec3) -> Vec3) -> Result<Self, SceneError> {
        let texels = levels_of(&radiance)?;
        let pixels =
            Panorama::directions(RADIANCE_SIZE).map(|towards| radiance(towards).to_array());
        let panorama = Panorama::new(RADIANCE_SIZE, &pixels.collect::<Vec<_>>())?;
        Ok(Self { texels, backdrop: Backdrop::Panorama(panorama), disk: None })
    }

    /// Returns the environment with a disk in the sky.
    ///
    /// # Errors
    /// [`SceneError::BrokenEnvironment`] for a disk without direction or size, or with a value that
    /// is not finite.
    pub fn with_disk(self, disk: SkyDisk) -> Result<Self, SceneError> {
        let is_bright = disk.radiance.iter().all(|part| (0.0..=BRIGHTEST).contains(part));
        let has_size = disk.radius_rad > 0.0 && disk.radius_rad < 0.5;
        if !(disk.towards.is_normalized() && has_size && is_bright) {
            let fault = "its disk has no direction, size or radiance";
            return Err(SceneError::BrokenEnvironment { fault });
        }
        Ok(Self { disk: Some(disk), ..self })
    }

    /// Returns the backdrop that is seen where nothing is drawn.
    #[must_use]
    pub fn backdrop(&self) -> &Backdrop {
        &self.backdrop
    }

    /// Returns the disk in the sky, if there is one.
    #[must_use]
    pub fn disk(&self) -> Option<&SkyDisk> {
        self.disk.as_ref()
    }

    /// Returns the texels: level by level, row by row.
    #[must_use]
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// Returns the side of a level with a border of one texel, and the texels, level by level.
    /// Samplers that do not support octahedral maps need the border.
    #[must_use]
    pub fn bordered(&self) -> (u32, Vec<[f32; 3]>) {
        let side = i64::from(ENVIRONMENT_SIDE);
        let levels = self.texels.chunks((side * side) as usize);
        let texel = |level: &[[f32; 3]], place: [i64; 2]| {
            let [x, y] = wrapped(place, side);
            level.get((y * side + x) as usize).copied().unwrap_or_default()
        };
        let rows =
            |level| (-1..=side).flat_map(move |y| (-1..=side).map(move |x| texel(level, [x, y])));
        (ENVIRONMENT_SIDE + 2, levels.flat_map(rows).collect())
    }

    /// Returns the light of a matt surface with this normal, as the radiance of a uniform sky that
    /// would light it equally.
    #[must_use]
    pub fn matt(&self, normal: Vec3) -> Vec3 {
        self.level(GLOSSY_LEVELS, normal)
    }

    /// Returns the radiance that a surface of a roughness reflects, where `direction` is the
    /// mirrored one.
    #[must_use]
    pub fn glossy(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let place = roughness.clamp(0.0, 1.0) * (GLOSSY_LEVELS - 1) as f32;
        let below = (place as u32).min(GLOSSY_LEVELS - 1);
        let above = (below + 1).min(GLOSSY_LEVELS - 1);
        let share = place - below as f32;
        self.level(below, direction).lerp(self.level(above, direction), share)
    }

    fn level(&self, level: u32, direction: Vec3) -> Vec3 {
        let count = (ENVIRONMENT_SIDE * ENVIRONMENT_SIDE) as usize;
        let first = level as usize * count;
        let texels = self.texels.get(first..first + count).unwrap_or_default();
        sampled(direction, |place| texels.get(place).copied().map_or(Vec3::ZERO, Vec3::from_array))
    }
}

/// Returns the texels of all levels of a radiance by direction.
fn levels_of(radiance: impl Fn(Vec3) -> Vec3) -> Result<Vec<[f32; 3]>, SceneError> {
    let directions: Vec<Vec3> = (0..ENVIRONMENT_SIDE * ENVIRONMENT_SIDE)
        .map(|texel| direction_of(texel_place(texel % ENVIRONMENT_SIDE, texel / ENVIRONMENT_SIDE)))
        .collect();
    let sharp: Vec<Vec3> = directions.iter().map(|direction| radiance(*direction)).collect();
    if sharp.iter().any(|radiance| !radiance.is_finite()) {
        let fault = "one of its values is not finite";
        return Err(SceneError::BrokenEnvironment { fault });
    }
    let bright = Vec3::splat(BRIGHTEST);
    let sharp: Vec<Vec3> = sharp.iter().map(|light| light.clamp(Vec3::ZERO, bright)).collect();
    let mut texels: Vec<[f32; 3]> = sharp.iter().map(Vec3::to_array).collect();
    for level in 1..GLOSSY_LEVELS {
        let roughness = level as f32 / (GLOSSY_LEVELS - 1) as f32;
        let lobe = glossy_lobe(roughness);
        texels.extend(directions.iter().map(|towards| mean(&sharp, *towards, &lobe).to_array()));
    }
    let lobe = matt_lobe();
    texels.extend(directions.iter().map(|towards| mean(&sharp, *towards, &lobe).to_array()));
    Ok(texels)
}

/// Returns the place of a texel's centre in the square, each coordinate from -1 to 1.
fn texel_place(x: u32, y: u32) -> Vec2 {
    (vec2(x as f32, y as f32) + 0.5) * (2.0 / ENVIRONMENT_SIDE as f32) - 1.0
}

/// Returns the direction of a place in the square.
fn direction_of(place: Vec2) -> Vec3 {
    let up = 1.0 - place.x.abs() - place.y.abs();
    let folded = (1.0 - place.yx().abs()) * signs(place);
    let across = if up < 0.0 { folded } else { place };
    vec3(across.x, up, across.y).normalize()
}

/// Returns the place of a direction in the square.
fn place_of(direction: Vec3) -> Vec2 {
    let scaled = direction / direction.abs().element_sum().max(1e-20);
    let place = vec2(scaled.x, scaled.z);
    if scaled.y < 0.0 { (1.0 - place.yx().abs()) * signs(place) } else { place }
}

fn signs(place: Vec2) -> Vec2 {
    let sign = |part: f32| if part < 0.0 { -1.0 } else { 1.0 };
    vec2(sign(place.x), sign(place.y))
}

/// Returns the mix of the four texels around a direction. Beyond each edge the square continues
/// with its mirror image along the same edge.
fn sampled(direction: Vec3, texel: impl Fn(usize) -> Vec3) -> Vec3 {
    let side = ENVIRONMENT_SIDE as i64;
    let place = (place_of(direction) + 1.0) * (0.5 * ENVIRONMENT_SIDE as f32) - 0.5;
    let low = place.floor();
    let share = place - place.floor();
    let at = |x: i64, y: i64| {
        let [x, y] = wrapped([x, y], side);
        texel((y * side + x) as usize)
    };
    let x = low.x as i64;
    let y = low.y as i64;
    let row = |y: i64| at(x, y).lerp(at(x + 1, y), share.x);
    row(y).lerp(row(y + 1), share.y)
}

/// Returns the texel that continues the square at a place beyond an edge.
fn wrapped(place: [i64; 2], side: i64) -> [i64; 2] {
    let [x, y] = place;
    let last = side - 1;
    let mut x = x;
    let mut y = y;
    if !(0..side).contains(&x) {
        (x, y) = (x.clamp(0, last), last - y);
    }
    if !(0..side).contains(&y) {
        (x, y) = (last - x, y.clamp(0, last));
    }
    [x.clamp(0, last), y.clamp(0, last)]
}

/// Directions around +y and their weights.
type Lobe = Vec<(Vec3, f32)>;

/// Returns evenly spread directions of the upper half, each as a number of 0 to 1 that its height
/// follows from, and an angle around the axis.
fn spiral() -> impl Iterator<Item = (f32, f32)> {
    const GOLDEN: f32 = 2.399_963_2;
    (0..LOBE_SAMPLES)
        .map(|index| ((index as f32 + 0.5) / LOBE_SAMPLES as f32, index as f32 * GOLDEN))
}

/// Returns the lobe of a surface seen from straight above (GGX, as alpha is roughness squared):
/// directions that it mirrors, weighted by their cosine.
fn glossy_lobe(roughness: f32) -> Lobe {
    let squared = roughness * roughness * roughness * roughness;
    let sample = |(height, turn): (f32, f32)| {
        let cosine = ((1.0 - height) / (1.0 + (squared - 1.0) * height)).max(0.0).sqrt();
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let half = vec3(sine * trigonometry::cos(turn), cosine, sine * trigonometry::sin(turn));
        let mirrored = half * (2.0 * half.y) - Vec3::Y;
        (mirrored, mirrored.y.max(0.0))
    };
    spiral().map(sample).filter(|(_, weight)| *weight > 0.0).collect()
}

fn matt_lobe() -> Lobe {
    let sample = |(height, turn): (f32, f32)| {
        let sine = height.sqrt();
        let cosine = (1.0 - height).sqrt();
        (vec3(sine * trigonometry::cos(turn), cosine, sine * trigonometry::sin(turn)), 1.0)
    };
    spiral().map(sample).collect()
}

/// Returns the mean radiance of a lobe around a direction.
fn mean(sharp: &[Vec3], direction: Vec3, lobe: &Lobe) -> Vec3 {
    let (across, along) = direction.any_orthonormal_pair();
    let mut sum = Vec3::ZERO;
    let mut weights = 0.0;
    for (sample, weight) in lobe {
        let towards = across * sample.x + direction * sample.y + along * sample.z;
        sum += sampled(towards, |index| sharp.get(index).copied().unwrap_or_default()) * *weight;
        weights += weight;
    }
    sum / f32::max(weights, 1e-20)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> impl Iterator<Item = Vec3> {
        (0..500).map(|index| {
            let height = 1.0 - (index as f32 + 0.5) / 250.0;
            let turn = index as f32 * 2.4;
            let across = (1.0 - height * height).sqrt();
            vec3(across * turn.cos(), height, across * turn.sin())
        })
    }

    #[test]
    fn places_and_directions_belong_together() {
        for direction in directions() {
            let again = direction_of(place_of(direction));
            assert!((again - direction).length() < 1e-5, "{direction} became {again}");
        }
    }

    #[test]
    fn disks_are_seen_and_light_nothing_or_are_refused() {
        let sky = || Environment::of_radiance(|_| Vec3::ONE).expect("numbers");
        let disk = SkyDisk { towards: Vec3::Y, radius_rad: 0.01, radiance: [9.0; 3] };
        let with = sky().with_disk(disk).expect("a disk");
        assert_eq!((with.disk(), with.texels()), (Some(&disk), sky().texels()));
        for broken in [
            SkyDisk { towards: Vec3::ZERO, ..disk },
            SkyDisk { towards: Vec3::NAN, ..disk },
            SkyDisk { radius_rad: 0.0, ..disk },
            SkyDisk { radius_rad: f32::NAN, ..disk },
            SkyDisk { radiance: [1.0, -1.0, 0.0], ..disk },
            SkyDisk { radiance: [f32::INFINITY; 3], ..disk },
        ] {
            assert!(sky().with_disk(broken).is_err(), "{broken:?}");
        }
    }

    #[test]
    fn the_same_light_all_around_is_the_same_for_all_surfaces() {
        let light = vec3(0.2, 0.5, 3.0);
        let environment = Environment::of_radiance(|_| light).expect("numbers");
        for direction in directions() {
            let found = [0.0, 0.3, 1.0].map(|roughness| environment.glossy(direction, roughness));
            for found in found.into_iter().chain([environment.matt(direction)]) {
                assert!((found - light).length() < 1e-4, "{found}");
            }
        }
    }

    #[test]
    fn what_is_smooth_is_found_again() {
        let radiance = |direction: Vec3| Vec3::splat(1.5 + direction.x - 0.4 * direction.z);
        let environment = Environment::of_radiance(radiance).expect("numbers");
        for direction in directions() {
            let error = (environment.glossy(direction, 0.0) - radiance(direction)).length();
            assert!(error < 0.08, "{direction}: {error}");
            // The cosine takes a linear function to two thirds of its slope (Ramamoorthi and
            // Hanrahan, 2001).
            let expected = 1.5 + (radiance(direction) - 1.5) * (2.0 / 3.0);
            let error = (environment.matt(direction) - expected).length();
            assert!(error < 0.05, "{direction}: {error}");
        }
    }

    #[test]
    fn a_picture_lies_around_as_it_is_told() {
        // Four columns and three rows, each in its own brightness.
        let pixels: Vec<[f32; 3]> = (0..12).map(|index| [index as f32, 0.0, 0.0]).collect();
        let environment = Environment::of_equirectangular([4, 3], &pixels).expect("numbers");
        let seen = |direction: Vec3| environment.glossy(direction.normalize(), 0.0).x;
        // Between the second and the third column of the middle row.
        assert!((seen(Vec3::NEG_Z) - 5.5).abs() < 0.5, "{}", seen(Vec3::NEG_Z));
        assert!((seen(Vec3::X) - 6.5).abs() < 0.6, "{}", seen(Vec3::X));
        assert!(seen(vec3(0.0, 1.0, 0.01)) < 4.0 && seen(vec3(0.0, -1.0, 0.01)) > 7.0);
    }

    #[test]
    fn broken_pictures_are_refused() {
        for (size, pixels) in [([0, 0], vec![]), ([2, 2], vec![[0.0; 3]; 3])] {
            assert!(Environment::of_equirectangular(size, &pixels).is_err());
        }
        let nan = [[f32::NAN, 0.0, 0.0]];
        assert!(Environment::of_equirectangular([1, 1], &nan).is_err());
        assert!(Environment::of_radiance(|_| Vec3::NAN).is_err());
    }

    #[test]
    fn edges_of_the_square_go_on_at_the_same_edge() {
        let side = i64::from(ENVIRONMENT_SIDE);
        for along in 0..side {
            for beyond in [[-1, along], [side, along], [along, -1], [along, side]] {
                let place = (vec2(beyond[0] as f32, beyond[1] as f32) + 0.5)
                    * (2.0 / ENVIRONMENT_SIDE as f32)
                    - 1.0;
                let inside = place.clamp(Vec2::splat(-1.0), Vec2::ONE);
                let [x, y] = wrapped(beyond, side);
                let texel = direction_of(texel_place(x as u32, y as u32));
                assert!(direction_of(inside).dot(texel) > 0.98, "{beyond:?} -> {x}, {y}");
            }
        }
    }
}
