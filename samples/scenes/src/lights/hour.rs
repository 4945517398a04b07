//! The hour of the day: the position of the sun or the moon, and the colours of their light and of
//! the sky.

use std::f32::consts::PI;
use std::fmt;
use std::str::FromStr;

use cull::trigonometry;
use glam::{Vec3, vec3};
use scene::Light;

use super::super::error::GeneratorError;

/// The tilt of the sun's path towards +z, in radians: 29 degrees.
const LEAN_RAD: f32 = 0.5;

/// The sine of the sun's elevation below which it is night.
const NIGHT_BELOW: f32 = 0.06;

/// The colours of one time of day: the sun's or the moon's light, ambient light from above and from
/// below, and the sky.
const DAY: [[f32; 3]; 4] =
    [[1.02, 0.93, 0.78], [0.36, 0.42, 0.52], [0.20, 0.18, 0.16], [0.36, 0.56, 0.80]];
const DUSK: [[f32; 3]; 4] =
    [[0.95, 0.42, 0.14], [0.16, 0.15, 0.22], [0.10, 0.08, 0.08], [0.62, 0.34, 0.22]];
const NIGHT: [[f32; 3]; 4] =
    [[0.15, 0.19, 0.30], [0.055, 0.07, 0.125], [0.03, 0.03, 0.042], [0.014, 0.022, 0.06]];

const MINUTES_PER_DAY: u16 = 24 * 60;

/// An hour of the day, to the minute: the sun rises at 6 and sets at 18.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Hour {
    /// Minutes since midnight, fewer than a day has.
    minutes: u16,
}

impl Hour {
    /// A clear afternoon.
    pub const AFTERNOON: Self = Self { minutes: 13 * 60 + 30 };
    /// A night with a moon.
    pub const NIGHT: Self = Self { minutes: 22 * 60 };

    /// Creates an hour, rounded to minutes; 24 is 0.
    ///
    /// # Errors
    /// [`GeneratorError::Hour`] for a number outside of 0 to 24.
    pub fn new(hour: f32) -> Result<Self, GeneratorError> {
        match hour {
            0.0..=24.0 => Ok(Self { minutes: (hour * 60.0).round() as u16 % MINUTES_PER_DAY }),
            _ => Err(GeneratorError::Hour { text: hour.to_string() }),
        }
    }

    /// Returns the hour this number of minutes later, or earlier for a negative number.
    #[must_use]
    pub fn later(self, minutes: i16) -> Self {
        let day = i32::from(MINUTES_PER_DAY);
        let minutes = (i32::from(self.minutes) + i32::from(minutes)).rem_euclid(day);
        Self { minutes: minutes as u16 }
    }

    /// Returns the unit vector from the scene to the sun.
    fn towards_sun(self) -> Vec3 {
        let turn_rad = (f32::from(self.minutes) / 720.0 - 1.0) * PI;
        let height = trigonometry::cos(turn_rad);
        let lean = height * trigonometry::sin(LEAN_RAD);
        vec3(trigonometry::sin(turn_rad), height * trigonometry::cos(LEAN_RAD), lean)
    }

    /// Returns true while street lamps are on.
    #[must_use]
    pub fn is_night(self) -> bool {
        self.towards_sun().y < NIGHT_BELOW
    }

    /// Returns the sun, or at night the moon opposite of it, and the light of the sky.
    #[must_use]
    pub fn light(self) -> Light {
        let towards_sun = self.towards_sun();
        let height = towards_sun.y;
        // Both are dark at the horizon, where one replaces the other.
        let direct = step(0.0, 0.12, height.abs());
        let day = step(0.0, 0.45, height);
        let night = step(0.0, 0.25, -height);
        let colour = |part: usize| {
            let mixed = |channel: usize| {
                let by_day = mix(DUSK[part][channel], DAY[part][channel], day);
                mix(by_day, NIGHT[part][channel], night)
            };
            [mixed(0), mixed(1), mixed(2)]
        };
        let [mut sun, ambient_above, ambient_below, sky] = [0, 1, 2, 3].map(colour);
        if height < 0.0 {
            sun = NIGHT[0];
        }
        Light {
            towards_sun: if height < 0.0 { -towards_sun } else { towards_sun },
            sun: sun.map(|part| part * direct),
            ambient_above,
            ambient_below,
            sky,
        }
    }
}

fn mix(from: f32, to: f32, share: f32) -> f32 {
    from + (to - from) * share
}

/// Returns 0 up to `low`, 1 from `high` on, and a smooth step between.
fn step(low: f32, high: f32, value: f32) -> f32 {
    let part = ((value - low) / (high - low)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

impl FromStr for Hour {
    type Err = GeneratorError;

    /// Parses an hour such as `17.5` or `17:30`.
    fn from_str(text: &str) -> Result<Self, GeneratorError> {
        let refused = || GeneratorError::Hour { text: text.to_owned() };
        let hour = match text.split_once(':') {
            None => text.parse().map_err(|_| refused())?,
            Some((hours, minutes)) => {
                let hours: u8 = hours.parse().map_err(|_| refused())?;
                let minutes = minutes.parse().ok().filter(|minutes: &u8| *minutes < 60);
                f32::from(hours) + f32::from(minutes.ok_or_else(refused)?) / 60.0
            }
        };
        Self::new(hour).map_err(|_| refused())
    }
}

impl fmt::Display for Hour {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{:02}", self.minutes / 60, self.minutes % 60)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_hour_is_read_as_it_is_written() {
        for (text, shown) in [("0", "0:00"), ("24", "0:00"), ("6.5", "6:30"), ("17:45", "17:45")] {
            assert_eq!(text.parse::<Hour>().unwrap().to_string(), shown);
        }
        for text in ["", "noon", "-1", "24.1", "NaN", "inf", "12:60", "25:00", "1:2:3"] {
            let refused = text.parse::<Hour>().unwrap_err().to_string();
            assert!(refused.contains(&format!("'{text}'")), "{refused}");
        }
        assert_eq!(Hour::NIGHT.later(180).to_string(), "1:00");
        assert_eq!(Hour::AFTERNOON.later(-960).to_string(), "21:30");
    }

    #[test]
    fn the_light_of_a_day_is_finite_unit_and_without_a_jump() {
        let at = |minute: u16| Hour::new(f32::from(minute) / 60.0).unwrap().light();
        for minute in 0..24 * 60 {
            let now = at(minute);
            let next = at((minute + 1) % (24 * 60));
            assert!((now.towards_sun.length() - 1.0).abs() < 1e-5, "minute {minute}");
            assert!(now.towards_sun.y > -1e-6, "what shines is over the horizon");
            let colours = |light: &Light| {
                [light.sun, light.ambient_above, light.ambient_below, light.sky].concat()
            };
            for (now, next) in colours(&now).into_iter().zip(colours(&next)) {
                assert!((0.0..1.1).contains(&now), "minute {minute}: {now}");
                assert!((now - next).abs() < 0.05, "minute {minute}: {now}, then {next}");
            }
        }
    }

    #[test]
    fn days_are_bright_and_nights_dark() {
        let sum = |hour: Hour| hour.light().ambient_above.iter().sum::<f32>();
        assert!(!Hour::AFTERNOON.is_night() && Hour::NIGHT.is_night());
        assert!(sum(Hour::AFTERNOON) > 5.0 * sum(Hour::NIGHT));
        let afternoon = Light::afternoon();
        assert!(Hour::AFTERNOON.light().towards_sun.angle_between(afternoon.towards_sun) < 0.3);
    }
}
