//! Sets of lights for scenes: the sun by the hour of the day, torches, or a night with lamps.

mod glow;
mod hour;
mod lamps;
#[cfg(test)]
mod tests;

use std::fmt;
use std::str::FromStr;

use glam::Vec3;
use scene::{LightId, LightKind, LightMove, Material, MaterialId, PunctualLight, Scene, Surfaces};

pub use self::glow::GLOW_NAME;
pub(crate) use self::glow::let_glow;
pub use self::hour::Hour;
use self::lamps::{LampKind, light_lamps};
use super::error::{GeneratorError, MAX_LAMPS};

/// The most street lamps of [`LightSet::Torches`].
const MOST_TORCHES: u32 = 32;

/// A set of lights, with names for [`FromStr`] and [`Display`](fmt::Display).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSet {
    /// `sun`: only the sun of an hour. A scene with its own suns keeps them.
    Sun(Hour),
    /// `torches`: point lights at night. A scene with its own point or spot lights keeps them;
    /// otherwise the torches are at the nearest street lamps.
    Torches,
    /// A number, 1 to [`MAX_LAMPS`]: this many of the nearest street lamps at night, as spot
    /// lights.
    Lamps(u32),
}

impl FromStr for LightSet {
    type Err = GeneratorError;

    fn from_str(text: &str) -> Result<Self, GeneratorError> {
        match text {
            "sun" => Ok(Self::Sun(Hour::AFTERNOON)),
            "torches" => Ok(Self::Torches),
            _ => {
                let lamps = text.parse().ok().filter(|lamps| (1..=MAX_LAMPS).contains(lamps));
                let unknown = || GeneratorError::UnknownLights { name: text.to_owned() };
                lamps.map(Self::Lamps).ok_or_else(unknown)
            }
        }
    }
}

impl fmt::Display for LightSet {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sun(_) => formatter.write_str("sun"),
            Self::Torches => formatter.write_str("torches"),
            Self::Lamps(lamps) => write!(formatter, "{lamps}"),
        }
    }
}

impl LightSet {
    /// Returns the scene with these lights and with surfaces. `eyes` are places along the camera's
    /// path, in order: lamps near its beginning are preferred.
    ///
    /// Lights of the scene that are not in the set are kept, but dark, so that light ids stay
    /// valid.
    ///
    /// # Errors
    /// [`GeneratorError::TooFewLamps`]: the scene has fewer street lamps.
    pub fn light(self, scene: Scene, eyes: &[Vec3]) -> Result<Scene, GeneratorError> {
        let is_plain = scene.surfaces.is_none();
        match self {
            Self::Sun(hour) if is_plain => {
                Ok(Scene { light: hour.light(), ..scene }.with_surfaces())
            }
            Self::Sun(hour) => Ok(keep(scene, is_sun, || sun_of(hour))),
            Self::Torches if is_plain => {
                light_lamps(night(scene), eyes, LampKind::Torch, 1..=MOST_TORCHES)
            }
            Self::Torches => {
                let is_torch = |light: &PunctualLight| !is_sun(light);
                let lights = scene.surfaces.iter().flat_map(|surfaces| &surfaces.lights);
                if !lights.clone().any(is_torch) {
                    return Err(GeneratorError::NoTorches);
                }
                Ok(keep(scene, is_torch, || None))
            }
            Self::Lamps(lamps) => light_lamps(night(scene), eyes, LampKind::Spot, lamps..=lamps),
        }
    }
}

/// The lights of a scene that change with the hour.
#[derive(Clone, Debug, PartialEq)]
pub struct Daylight {
    /// The hour.
    pub hour: Hour,
    /// The street lamps as they shine at night, by their ids.
    pub lamps: Vec<(LightId, PunctualLight)>,
    /// The material that glows at night, with its glow.
    pub glow: Option<(MaterialId, Material)>,
    /// The hours at which the lamps are on.
    pub lamp_hours: LampHours,
    /// The displacement from the light of an omnidirectional lamp to the middle of its glass, in
    /// metres.
    pub glass: Vec3,
    /// True if lamps with a picture project it instead of white light.
    pub shows_pictures: bool,
}

/// The hours at which lamps are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LampHours {
    /// From dusk to dawn.
    Night,
    /// All hours.
    Always,
}

/// The id of the sun in scenes with [`Daylight`].
const SUN: LightId = LightId(0);

impl Daylight {
    /// Returns a scene at night with up to `lamps` lit street lamps, and the lights that change
    /// with the hour. A scene without street lamps gets none.
    ///
    /// # Errors
    /// The errors of [`LightSet::light`].
    pub fn new(scene: Scene, eyes: &[Vec3], lamps: u32) -> Result<(Scene, Self), GeneratorError> {
        let scene = light_lamps(night(scene), eyes, LampKind::Spot, 0..=lamps)?;
        let surfaces = scene.surfaces.as_ref();
        let lights = surfaces.map_or(&[][..], |surfaces| &surfaces.lights);
        let numbered = (0..).map(LightId).zip(lights);
        let lamps = numbered.filter(|(_, light)| !is_sun(light)).map(|(id, light)| (id, *light));
        let lamps = lamps.collect();
        let materials = surfaces.map_or(&[][..], |surfaces| &surfaces.materials);
        let glow =
            (0..).map(MaterialId).zip(materials).find(|(_, material)| material.name == GLOW_NAME);
        let glow = glow.map(|(id, material)| (id, material.clone()));
        let daylight = Self {
            hour: Hour::NIGHT,
            lamps,
            glow,
            lamp_hours: LampHours::Night,
            glass: Vec3::ZERO,
            shows_pictures: true,
        };
        Ok((scene, daylight))
    }

    /// Returns the lights at the current hour.
    pub fn lights(&self) -> Vec<LightMove> {
        let are_on = self.hour.is_night() || self.lamp_hours == LampHours::Always;
        let lamp = |(light, lamp): &(LightId, PunctualLight)| {
            let intensity = if are_on { lamp.intensity } else { 0.0 };
            let picture = lamp.cookie.filter(|_| self.shows_pictures);
            LightMove { light: *light, to: PunctualLight { intensity, cookie: picture, ..*lamp } }
        };
        let sun = sun_of(self.hour).map(|to| LightMove { light: SUN, to });
        let dark = || sun_of(Hour::NIGHT).map(|sun| PunctualLight { intensity: 0.0, ..sun });
        let sun = sun.or_else(|| dark().map(|to| LightMove { light: SUN, to }));
        sun.into_iter().chain(self.lamps.iter().map(lamp)).collect()
    }

    /// Returns the glowing material at the current hour.
    pub fn material(&self) -> Option<(MaterialId, Material)> {
        let (id, glow) = self.glow.as_ref()?;
        let emission = if self.hour.is_night() { glow.emission } else { [0.0; 3] };
        Some((*id, Material { emission, ..glow.clone() }))
    }
}

/// Returns the scene with surfaces, in moonlight.
fn night(scene: Scene) -> Scene {
    Scene { light: Hour::NIGHT.light(), ..scene }.with_surfaces()
}

fn is_sun(light: &PunctualLight) -> bool {
    light.kind == LightKind::Directional
}

/// Returns the sun or the moon of an hour as a light; `None` at the horizon, where it is dark.
fn sun_of(hour: Hour) -> Option<PunctualLight> {
    sun_light(&hour.light())
}

/// Returns the sun of a plain scene's light as a punctual light, as [`Scene::with_surfaces`]
/// creates it; `None` if it is dark.
#[must_use]
pub fn sun_light(light: &scene::Light) -> Option<PunctualLight> {
    let nothing =
        Scene { light: *light, ..Scene::single(scene::Mesh::of_triangles("nothing", &[])) };
    nothing.with_surfaces().surfaces?.lights.first().copied()
}

/// Returns a scene with surfaces in which only the lights shine that `is_kept` accepts. If there
/// are none, `other` is added.
fn keep(
    mut scene: Scene,
    is_kept: impl Fn(&PunctualLight) -> bool,
    other: impl Fn() -> Option<PunctualLight>,
) -> Scene {
    if let Some(Surfaces { lights, .. }) = &mut scene.surfaces {
        for light in lights.iter_mut().filter(|light| !is_kept(light)) {
            light.intensity = 0.0;
        }
        if !lights.iter().any(is_kept) {
            lights.extend(other());
        }
    }
    scene
}
