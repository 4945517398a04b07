//! The command line of `shadows`, and the checks that make it a [`SceneSource`].

use bench::shadow_choice::ShadowWay;
use clap::Parser;
use scenes::Hour;

use super::keys_help::help_with_keys;
use super::show::{FlareChoice, ShowArguments, ShowOptions};
use super::source::SceneSource;

const EXAMPLES: &str = "\
Examples:
  shadows
      A courtyard with shadow maps: J changes the hour, Y the way to make shadows, Z the filter,
      F2 lens flares, F3 the picture that a spot projects.
  shadows --time-of-day 21 --filter pcss
      At night, with shadows as wide as their casters are far away.
  shadows --headless --frames 60 --out images
      The same frames as images, without a window.

Exit codes: 0 all went well; 2 the command line is wrong; 1 the machine cannot do it or a file \
cannot be written; 129, 130 or 143 a closed terminal, Ctrl-C or SIGTERM ended it: that writes what \
there is, and a second one ends it at once.";

/// Shows a courtyard: the shadows of a sun, of spots, lamps and a lantern that moves, lens flares,
/// and a spot that projects the picture of a window.
///
/// The keys are listed on the screen. The same program runs without a window: --headless.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "shadows",
    version,
    allow_negative_numbers = true,
    args_override_self = true,
    after_help = help_with_keys(EXAMPLES, &[])
)]
pub struct ShadowsArguments {
    /// Hour of the day, such as 17.5 or 17:30
    #[arg(long, alias = "hour", value_name = "HOUR", default_value = "16:45")]
    #[arg(help_heading = "Lights")]
    pub time_of_day: Hour,
    /// The options of showing it.
    #[command(flatten)]
    pub show: ShowArguments,
}

impl ShadowsArguments {
    /// Returns the source of the scene and the options of showing it.
    pub fn options(mut self) -> (SceneSource, ShowOptions) {
        self.show.shadows.get_or_insert(ShadowWay::Maps);
        self.show.flares.get_or_insert(FlareChoice::On);
        (SceneSource::Courtyard { hour: self.time_of_day }, self.show.options())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &[&str]) -> Result<(SceneSource, ShowOptions), String> {
        let parsed = ShadowsArguments::try_parse_from([&["shadows"], line].concat());
        parsed.map(ShadowsArguments::options).map_err(|error| error.to_string())
    }

    #[test]
    fn it_begins_with_shadows_at_an_hour() {
        let (source, options) = parse(&[]).unwrap();
        assert_eq!(source, SceneSource::Courtyard { hour: "16:45".parse().unwrap() });
        assert_eq!((options.shadows.way, options.flares), (ShadowWay::Maps, FlareChoice::On));
        assert_eq!(parse(&["--flares", "off"]).unwrap().1.flares, FlareChoice::Off);
        let (_, options) = parse(&["--shadows", "off"]).unwrap();
        assert_eq!(options.shadows.way, ShadowWay::Off);
        for (line, reason) in [
            (["--time-of-day", "30"], "'30' is not an hour"),
            (["--flares", "bright"], "[possible values: off, on]"),
            (["--shadows", "stencil"], "unknown way to make shadows 'stencil'"),
        ] {
            let refused = parse(&line).unwrap_err();
            assert!(refused.contains(reason), "{refused}");
        }
    }
}
