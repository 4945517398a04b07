//! The hour of day and the shadows of a session.

use antumbra::glam::Vec3;
use antumbra::render;
use antumbra::shadows::{CasterCulling, ShadowCaching, ShadowFilter, ShadowMethod};

use crate::window::actions::Action;
use crate::window::flares::{flares_of, projector_of};
use crate::window::loaded_scene::show_hour;
use crate::window::page_text::{Facts, fact};
use crate::window::session::{LightingRequest, Session};
use crate::window::show::FlareChoice;
use bench::run_error::RunError;
use bench::shadow_choice::{ShadowChoice, ShadowWay};
use scenes::Hour;

/// The methods that a key cycles through; the others are for comparisons.
const BY_KEY: [ShadowWay; 3] = [ShadowWay::Off, ShadowWay::Maps, ShadowWay::Volumes];

const NO_FLARES: &str = "there are lens flares in city, in field, and in `shadows`";

const NO_PICTURES: &str = "no light of the scene projects a picture: start `shadows` for one";

const NO_DETAIL: &str =
    "the scene has no levels of detail: start it with --detail, as in `viewer FILE --detail 1`";

/// The step of the hour.
const STEP_MINUTES: i16 = 60;

const NO_HOURS: &str = "the hour changes in city, in field, and in `shadows`";

const NOTHING_TO_LIGHT: &str = "there is no scene yet that casts shadows: O has a list";

impl Session {
    /// Returns the hour of the scene, if it has one.
    pub(crate) fn hour(&self) -> Option<Hour> {
        self.daylight.as_ref().map(|daylight| daylight.hour)
    }

    /// Returns true if an action must wait until the scene was loaded with lights.
    pub(crate) fn needs_lights(&self, action: Action) -> bool {
        self.lit.is_some() && is_about_lights(action)
    }

    /// Takes the action that waits for lights, with the source of the scene that has them.
    pub fn take_lighting_request(&mut self) -> Option<LightingRequest> {
        let action = self.waiting_for_lights.take()?;
        Some(LightingRequest { source: self.lit.clone()?, action })
    }

    /// Shows the current hour.
    pub(crate) fn tell_hour(&mut self) {
        if let Some(hour) = self.hour() {
            self.tell(format!("the hour is {hour}"));
        }
    }

    /// Shows the scene at an hour; at the next hour if `hour` is `None`.
    pub(crate) fn set_hour(&mut self, hour: Option<Hour>) -> Result<(), RunError> {
        let Some(daylight) = &mut self.daylight else {
            self.refuse(NO_HOURS.to_owned());
            return Ok(());
        };
        daylight.hour = hour.unwrap_or_else(|| daylight.hour.later(STEP_MINUTES));
        show_hour(&mut self.renderer, daylight)?;
        self.tell_hour();
        Ok(())
    }

    /// Switches lens flares on or off.
    pub(crate) fn toggle_flares(&mut self) {
        if self.daylight.is_none() {
            return self.refuse(NO_FLARES.to_owned());
        }
        if let Err(error) = self.renderer.supports_counts() {
            return self.refuse(error.to_string());
        }
        let (choice, told) = match self.flares {
            FlareChoice::Off => (FlareChoice::On, "lens flares"),
            FlareChoice::On => (FlareChoice::Off, "no lens flares"),
        };
        self.flares = choice;
        self.tell(told.to_owned());
    }

    /// Updates the lens flares for the next frame. Frames that are compared have no flares, since
    /// the flares of two views begin at different times.
    pub(crate) fn follow_flares(&mut self, eye: Vec3) -> Result<(), RunError> {
        let is_shown = self.flares == FlareChoice::On && self.comparison.is_none();
        let flares = match &self.daylight {
            Some(daylight) if is_shown && self.renderer.supports_counts().is_ok() => {
                flares_of(daylight, self.scene_view.moved_light(), eye)
            }
            _ => Vec::new(),
        };
        Ok(self.renderer.set_flares(&flares)?)
    }

    /// Switches between pictures projected by spots and white light.
    pub(crate) fn toggle_pictures(&mut self) -> Result<(), RunError> {
        let Some(daylight) =
            self.daylight.as_mut().filter(|daylight| projector_of(daylight).is_some())
        else {
            self.refuse(NO_PICTURES.to_owned());
            return Ok(());
        };
        daylight.shows_pictures = !daylight.shows_pictures;
        let told = if daylight.shows_pictures {
            "a spot projects a picture"
        } else {
            "no spot projects a picture"
        };
        show_hour(&mut self.renderer, daylight)?;
        self.tell(told.to_owned());
        Ok(())
    }

    /// Switches between levels of detail by visible samples, too, and only by distance.
    pub(crate) fn toggle_detail_by_samples(&mut self) -> Result<(), RunError> {
        if let Err(error) = self.renderer.supports_counts() {
            self.refuse(error.to_string());
            return Ok(());
        }
        let Some(detail) = &mut self.scene_view.detail else {
            self.refuse(NO_DETAIL.to_owned());
            return Ok(());
        };
        let told = detail.toggle();
        detail.watch(&mut self.history)?;
        self.tell(told);
        Ok(())
    }

    /// Returns the current choice of shadows.
    fn shadows(&self) -> ShadowChoice {
        let options = self.renderer.shadows();
        let way = match (options.method, options.caching, options.culling) {
            (ShadowMethod::Off, ..) => ShadowWay::Off,
            (ShadowMethod::Maps, ShadowCaching::Cached, _) => ShadowWay::Maps,
            (ShadowMethod::Maps, _, CasterCulling::Culled) => ShadowWay::MapsUncached,
            (ShadowMethod::Maps, _, CasterCulling::Unculled) => ShadowWay::MapsUnculled,
            (ShadowMethod::Volumes, _, CasterCulling::Culled) => ShadowWay::Volumes,
            (ShadowMethod::Volumes, _, CasterCulling::Unculled) => ShadowWay::VolumesUnculled,
        };
        ShadowChoice { way, filter: options.filter, bias: options.bias }
    }

    pub(crate) fn choose_shadows(&mut self, way: ShadowWay) {
        self.draw_shadows(ShadowChoice { way, ..self.shadows() });
    }

    pub(crate) fn choose_next_shadows(&mut self) {
        self.choose_shadows(next(&BY_KEY, self.shadows().way));
    }

    pub(crate) fn choose_filter(&mut self, filter: ShadowFilter) {
        self.draw_shadows(ShadowChoice { filter, ..self.shadows() });
    }

    pub(crate) fn choose_next_filter(&mut self) {
        self.choose_filter(next(&ShadowFilter::ALL, self.shadows().filter));
    }

    fn draw_shadows(&mut self, choice: ShadowChoice) {
        let before = self.renderer.degradations().texts();
        match self.renderer.set_shadows(choice.options()) {
            Ok(()) => {}
            Err(render::Error::NoSurfacesForShadows) => {
                return self.refuse(NOTHING_TO_LIGHT.to_owned());
            }
            Err(error) => return self.refuse(error.to_string()),
        }
        let mut lines = vec![format!("shadows {}", text(choice))];
        let lost = self.renderer.degradations().texts();
        lines.extend(lost.into_iter().filter(|text| !before.contains(text)));
        self.tell(lines.join("\n"));
    }

    /// Returns the facts about light, if there are any.
    pub(crate) fn light_facts(&self) -> Option<Facts> {
        let hour = self.hour().map(|hour| fact("hour", hour.to_string()));
        let choice = self.shadows();
        let stats = &self.report.shadows;
        let shadows = (choice.way != ShadowWay::Off).then(|| {
            [
                fact("shadows", text(choice)),
                fact("lights with shadows", stats.lights.to_string()),
                match choice.way {
                    ShadowWay::Volumes | ShadowWay::VolumesUnculled => {
                        fact("volumes by z-fail", stats.z_fail_volumes.to_string())
                    }
                    _ => {
                        let maps = format!("{} of {}", stats.drawn_faces, stats.faces);
                        fact("shadow maps drawn", maps)
                    }
                },
                fact("casters in them", stats.casters.to_string()),
                fact("tests of casters", stats.tests.to_string()),
                fact(
                    "triangles of casters",
                    (stats.triangles + stats.revealed_triangles).to_string(),
                ),
            ]
        });
        let facts: Facts = hour.into_iter().chain(shadows.into_iter().flatten()).collect();
        (!facts.is_empty()).then_some(facts)
    }
}

/// Returns true for an action that has no effect in a scene without its own lights.
fn is_about_lights(action: Action) -> bool {
    use Action::{Filter, Flares, Hour, NextFilter, NextHour, NextShadows, Shadows};
    matches!(
        action,
        NextHour | Hour(_) | NextShadows | Shadows(_) | NextFilter | Filter(_) | Flares
    )
}

/// Returns the element after `current`, or the first after the last.
fn next<T: Copy + PartialEq>(all: &[T], current: T) -> T {
    let following = all.iter().skip_while(|one| **one != current).nth(1);
    following.or(all.first()).copied().unwrap_or(current)
}

fn text(choice: ShadowChoice) -> String {
    match choice.way {
        ShadowWay::Off | ShadowWay::Volumes => choice.way.name().to_owned(),
        way => format!("{}, {}", way.name(), choice.filter.name()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_go_through_all_choices() {
        let ways = [0, 1, 2].map(|step| next(&BY_KEY, BY_KEY[step]).name());
        assert_eq!(ways, ["maps", "volumes", "off"]);
        assert_eq!(next(&BY_KEY, ShadowWay::MapsUnculled), ShadowWay::Off);
        let mut filter = ShadowFilter::Single;
        for _ in ShadowFilter::ALL {
            filter = next(&ShadowFilter::ALL, filter);
        }
        assert_eq!(filter, ShadowFilter::Single);
    }
}
