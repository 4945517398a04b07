//! The options of `walkthrough` for lights and their shadows.

use antumbra::shadows::{ShadowBias, ShadowFilter};
use clap::Args;
use scenes::LightSet;

use crate::args::{SceneArgument, usage};
use crate::choices::each_once;
use crate::options::UsageError;
use crate::shadow_choice::{ShadowChoice, ShadowWay, parse_bias, parse_filter};

/// Lights and shadows, as the command line has them.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct LightArguments {
    /// Lights on the scene: the sun of an afternoon; torches, at night; or a number of street
    /// lamps that are on, 1 to 64, in city or field. A file keeps its own lights of that kind
    /// [default: city and field without surfaces, lit by the sun; a file as it is]
    #[arg(long, value_name = "sun|torches|N", help_heading = "Lights")]
    pub lights: Option<LightSet>,
    /// Ways to make shadows to compare, each with each strategy: off, maps, maps_uncached,
    /// maps_unculled, volumes, volumes_unculled [default: off]
    #[arg(long, value_name = "WAY[,WAY]", help_heading = "Lights")]
    #[arg(value_parser = parse_ways)]
    pub shadows: Option<ShadowWays>,
    /// Filters of shadow maps to compare, each with each of those: single, pcf3, adaptive, pcss,
    /// fixed64, pcss64 [default: adaptive]
    #[arg(long, value_name = "NAME[,NAME]", help_heading = "Lights", requires = "shadows")]
    #[arg(value_parser = parse_filters)]
    pub filter: Option<ShadowFilters>,
    /// Remedy of shadow maps against surfaces that shadow themselves: plane, back_faces, midpoint
    /// [default: plane]
    #[arg(long, value_name = "NAME", help_heading = "Lights", requires = "shadows")]
    #[arg(value_parser = parse_bias)]
    pub bias: Option<ShadowBias>,
}

/// Ways to make shadows, each of them once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShadowWays(Vec<ShadowWay>);

/// Filters of shadow maps, each of them once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShadowFilters(Vec<ShadowFilter>);

impl LightArguments {
    /// Returns the ways to draw shadows: a combination of each way with each filter; none without
    /// options about lights.
    ///
    /// # Errors
    /// Shadows in a generated scene without lights; street lamps in a file.
    pub fn choices(&self, scene: &SceneArgument) -> Result<Vec<ShadowChoice>, UsageError> {
        let Self { lights, shadows, filter, bias } = self;
        match (scene, lights) {
            (SceneArgument::Made(_), None) if shadows.is_some() => {
                return usage(
                    "--shadows needs lights that cast them: say --lights sun, torches or a number",
                );
            }
            (SceneArgument::File(_), Some(LightSet::Lamps(lamps))) => {
                return usage(format!(
                    "--lights {lamps} is for city and field, whose street lamps are known: say sun or torches, or leave it out"
                ));
            }
            _ => {}
        }
        if lights.is_none() && shadows.is_none() {
            return Ok(Vec::new());
        }
        let ways = shadows.as_ref().map_or(&[ShadowWay::Off][..], |ways| &ways.0);
        let filters = filter.as_ref().map_or(&[ShadowFilter::Adaptive][..], |filters| &filters.0);
        let bias = bias.unwrap_or_default();
        let of_way = |way: &ShadowWay| {
            let way = *way;
            filters.iter().map(move |filter| ShadowChoice { way, filter: *filter, bias })
        };
        Ok(ways.iter().flat_map(of_way).collect())
    }
}

fn parse_ways(text: &str) -> Result<ShadowWays, String> {
    each_once(text, |name| name.parse::<ShadowWay>()).map(ShadowWays)
}

fn parse_filters(text: &str) -> Result<ShadowFilters, String> {
    each_once(text, parse_filter).map(ShadowFilters)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::Options;
    use crate::args::Arguments;

    fn parse(line: &[&str]) -> Result<Options, String> {
        let parsed = Arguments::try_parse_from([&["walkthrough"], line].concat());
        parsed.map_err(|error| error.to_string())?.options().map_err(|error| error.to_string())
    }

    #[test]
    fn nothing_said_is_as_ever() {
        let options = parse(&[]).unwrap();
        assert_eq!((options.asked.lighting.lights, options.shadows), (None, Vec::new()));
        let lit = parse(&["--lights", "sun"]).unwrap();
        assert_eq!(lit.shadows, [ShadowChoice::OFF]);
    }

    #[test]
    fn each_way_is_combined_with_each_filter() {
        let line = ["--lights", "8", "--shadows", "off,maps", "--filter", "pcf3,adaptive"];
        let options = parse(&line).unwrap();
        assert_eq!(options.asked.lighting.lights, Some(LightSet::Lamps(8)));
        let names: Vec<[&str; 2]> = options
            .shadows
            .iter()
            .map(|shadow| [shadow.way.name(), shadow.filter.name()])
            .collect();
        let expected =
            [["off", "pcf3"], ["off", "adaptive"], ["maps", "pcf3"], ["maps", "adaptive"]];
        assert_eq!(names, expected);
        let biased =
            parse(&["--lights", "sun", "--shadows", "maps", "--bias", "midpoint"]).unwrap();
        assert_eq!(biased.shadows[0].bias, ShadowBias::Midpoint);
        assert_eq!(options.shadows[0].bias, ShadowBias::Plane);
        let of_file = parse(&["--scene", "a.glb", "--shadows", "maps"]).unwrap();
        assert_eq!((of_file.asked.lighting.lights, of_file.shadows.len()), (None, 1));
    }

    #[test]
    fn what_cannot_be_is_refused_in_a_sentence() {
        for (line, reason) in [
            (&["--lights", "0"][..], "1 to 64"),
            (&["--lights", "65"], "there are no lights '65'"),
            (&["--lights", "10000"], "there are no lights '10000'"),
            (&["--lights", "NaN"], "there are no lights 'NaN'"),
            (&["--shadows", "maps"], "--shadows needs lights"),
            (&["--lights", "sun", "--filter", "pcf3"], "--shadows"),
            (&["--lights", "sun", "--bias", "midpoint"], "--shadows"),
            (&["--lights", "sun", "--shadows", "maps", "--bias", "half"], "unknown bias 'half'"),
            (&["--lights", "sun", "--shadows", "volume"], "did you mean 'volumes'?"),
            (&["--lights", "sun", "--shadows", "maps,maps"], "'maps' twice"),
            (&["--lights", "sun", "--shadows", ""], "unknown way to make shadows ''"),
            (&["--lights", "sun", "--shadows", "maps", "--filter", "soft"], "filter 'soft'"),
            (&["--scene", "a.glb", "--lights", "8"], "--lights 8 is for city and field"),
        ] {
            let refused = parse(line).unwrap_err();
            assert!(refused.contains(reason), "{line:?}: {refused}");
        }
    }
}
