//! The command line of `city`, and the checks that make it a [`SceneSource`].

use std::path::PathBuf;

use clap::Parser;

use super::fly_out;
use super::keys_help::help_with_keys;
use super::show::{ShowArguments, ShowOptions};
use super::source::SceneSource;
use bench::args::{MadeArguments, SceneArgument, usage};
use bench::choices::{CameraPathChoice, CostModelChoice, parse_path};
use bench::options::{PathChoice, UsageError};
use bench::shadow_choice::ShadowWay;
use bench::terminal::shown;
use scenes::Hour;

const EXAMPLES: &str = "\
Examples:
  city
      Fly: W A S D, Q and E, look with a mouse button held.
  city --path street --strategy frustum
      Walks down the streets until you take over.
  city --time-of-day 19 --shadows maps
      At dusk, with shadows; J, Y and Z change the hour and the shadows.
  city --headless --frames 60 --path street --out images
      The same frames as images, without a window.
  city --headless --size 480x270 --msaa 4 --fly-out fly_out.png
      An animation of what the culling leaves out.
  city --path my-path.txt --trace trace.json
      A path recorded with the key R, and a trace for ui.perfetto.dev.

Exit codes: 0 all went well; 2 the command line is wrong; 1 the machine cannot do it or a file \
cannot be written; 129, 130 or 143 a closed terminal, Ctrl-C or SIGTERM ended it: that writes what \
there is, and a second one ends it at once.";

/// Flies through a city in a window, and shows the state of the engine.
///
/// The keys are listed on the screen. The same program runs without a window: --headless.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "city",
    version,
    allow_negative_numbers = true,
    args_override_self = true,
    after_help = help_with_keys(EXAMPLES, &[])
)]
pub struct CityArguments {
    /// The scene to fly through: city, field, assembly or waffle
    #[arg(
        long,
        value_name = "city|field|assembly|waffle",
        default_value = "city",
        help_heading = "Scene"
    )]
    pub scene: SceneArgument,
    /// The numbers that it is made from.
    #[command(flatten)]
    pub made: MadeArguments,
    /// The path of the camera, until you steer: street, fly, cut, or a recorded file, whose name
    /// ends in .txt or has a slash [default: it stands where street begins]
    #[arg(
        long,
        visible_alias = "replay",
        value_name = "street|fly|cut|FILE",
        value_parser = parse_path,
        help_heading = "Scene"
    )]
    pub path: Option<PathChoice>,
    /// Hour of the day, such as 17.5 or 17:30: sun, sky, and street lamps at night [default: none,
    /// all lit evenly; with --shadows an afternoon]
    #[arg(long, alias = "hour", value_name = "HOUR", help_heading = "Lights")]
    pub time_of_day: Option<Hour>,
    /// Animated PNG to write in place of frames: the camera walks, the culling is frozen, the eye
    /// flies up to show what is drawn, and back; --frames is the number of its images [default: 84]
    #[arg(long, value_name = "FILE.png", requires = "headless", help_heading = "Output")]
    #[arg(conflicts_with_all = ["script", "hud", "out", "trace", "capture", "time_passes"])]
    pub fly_out: Option<PathBuf>,
    /// The options of showing it.
    #[command(flatten)]
    pub show: ShowArguments,
}

impl CityArguments {
    /// Returns the source of the scene and the options of showing it. Looks at nothing but the
    /// arguments: files and devices come later.
    ///
    /// # Errors
    /// A scene's file; an animation that cannot be.
    pub fn options(&self) -> Result<(SceneSource, ShowOptions), UsageError> {
        let made = match &self.scene {
            SceneArgument::Made(scene) => self.made.of(*scene),
            SceneArgument::File(file) => {
                let file = shown(file);
                return usage(format!(
                    "--scene: city makes its scenes; `viewer {file}` shows a file"
                ));
            }
        };
        let mut show = self.show.options();
        let mut path = self.path.clone();
        if let Some(file) = &self.fly_out {
            self.check_fly_out()?;
            path.get_or_insert(PathChoice::Made(CameraPathChoice::Street));
            show = ShowOptions {
                fly_out: Some(file.clone()),
                frames: self.show.frames.or(Some(fly_out::IMAGES)),
                // Measured costs differ from run to run, and with them the decisions.
                cost_model: CostModelChoice::Off,
                ..show
            };
        }
        let casts_shadows = show.shadows.way != ShadowWay::Off;
        let hour = self.time_of_day.or(casts_shadows.then_some(Hour::AFTERNOON));
        Ok((SceneSource::Made { made, path, hour }, show))
    }

    /// Refuses an animation that has too many images, or whose culling cannot be frozen.
    fn check_fly_out(&self) -> Result<(), UsageError> {
        let most = fly_out::MAX_IMAGES;
        if self.show.frames.is_some_and(|images| images > most) {
            return usage(format!("--frames: with --fly-out there are at most {most} images"));
        }
        let strategy = self.show.strategy;
        if strategy.is_gpu_driven() {
            return usage(format!(
                "--fly-out: with {strategy} only the GPU knows what is drawn; choose another strategy"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hud::HudLevel;
    use bench::options::PathChoice;
    use bench::strategy::Strategy;

    fn parse_all(line: &[&str]) -> Result<(SceneSource, ShowOptions), String> {
        let parsed = CityArguments::try_parse_from([&["city"], line].concat());
        parsed.map_err(|error| error.to_string())?.options().map_err(|error| error.to_string())
    }

    fn parse(line: &[&str]) -> Result<ShowOptions, String> {
        parse_all(line).map(|(_, show)| show)
    }

    fn path_of(line: &[&str]) -> Option<PathChoice> {
        match parse_all(line).unwrap().0 {
            SceneSource::Made { path, .. } => path,
            source => panic!("{source:?}"),
        }
    }

    #[test]
    fn nothing_said_opens_a_window() {
        let options = parse(&[]).unwrap();
        assert_eq!(
            (options.is_headless, options.hud, options.frames),
            (false, HudLevel::Compact, None)
        );
        assert_eq!((options.strategy, path_of(&[])), (Strategy::ANTUMBRA, None));
        let options = parse(&["--headless"]).unwrap();
        assert_eq!((options.hud, options.frames), (HudLevel::Off, Some(120)));
    }

    #[test]
    fn shadows_need_an_hour_and_have_one() {
        let hour_of = |line: &[&str]| match parse_all(line).unwrap().0 {
            SceneSource::Made { hour, .. } => hour,
            source => panic!("{source:?}"),
        };
        assert_eq!(hour_of(&[]), None);
        assert_eq!(hour_of(&["--shadows", "maps"]), Some(Hour::AFTERNOON));
        assert_eq!(hour_of(&["--time-of-day", "22"]), Some(Hour::NIGHT));
        assert_eq!(hour_of(&["--hour", "22"]), Some(Hour::NIGHT), "its former name");
        let line = ["--shadows", "maps_uncached", "--filter", "pcss", "--bias", "midpoint"];
        let shadows = parse(&line).unwrap().shadows;
        assert_eq!(shadows.bias.name(), "midpoint");
        assert_eq!((shadows.way.name(), shadows.filter.name()), ("maps_uncached", "pcss"));
    }

    #[test]
    fn an_animation_walks_down_a_street_and_decides_the_same_each_time() {
        let line = ["--headless", "--fly-out", "a.png"];
        let options = parse(&line).unwrap();
        assert_eq!(options.fly_out, Some("a.png".into()));
        assert_eq!((options.frames, options.cost_model), (Some(84), CostModelChoice::Off));
        assert_eq!(path_of(&line), Some(PathChoice::Made(CameraPathChoice::Street)));
        let with = |more: &[&str]| parse(&[&line[..], more].concat());
        assert_eq!(with(&["--frames", "9"]).unwrap().frames, Some(9));
        for (more, reason) in [
            (["--frames", "601"], "at most 600 images"),
            (["--strategy", "hzb"], "only the GPU knows"),
            (["--script", "a"], "cannot be used with"),
            (["--hud", "on"], "cannot be used with"),
            (["--out", "a"], "cannot be used with"),
        ] {
            let refused = with(&more).unwrap_err();
            assert!(refused.contains(reason), "{more:?}: {refused}");
        }
        let refused = parse(&["--fly-out", "a.png"]).unwrap_err();
        assert!(refused.contains("--headless"), "{refused}");
    }

    #[test]
    fn paths_are_named_or_files() {
        let street = PathChoice::Made(CameraPathChoice::Street);
        assert_eq!(path_of(&["--path", "street"]), Some(street));
        for file in ["path.txt", "./path", "/a/b"] {
            let path = path_of(&["--replay", file]);
            assert_eq!(path, Some(PathChoice::Recorded(file.into())));
        }
    }

    #[test]
    fn of_an_option_said_twice_the_last_counts() {
        let options = parse(&["--frames=1", "--headless", "--frames", "2", "--headless"]).unwrap();
        assert_eq!((options.frames, options.is_headless), (Some(2), true));
    }

    #[test]
    fn what_only_a_window_heeds_is_refused_without_one() {
        for option in [["--present-mode", "fifo"], ["--frame-limit", "60"]] {
            assert!(parse(&option).is_ok());
            let refused = parse(&[&option[..], &["--headless"]].concat()).unwrap_err();
            let named = option[0];
            let headless = "cannot be used with '--headless'";
            assert!(refused.contains(named) && refused.contains(headless), "{refused}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (line, reason) in [
            (["--strategy", "ideal"], "see walkthrough"),
            (["--strategy", "antumbar"], "did you mean 'antumbra'?"),
            (["--present-mode", "vsync"], "fifo_relaxed, mailbox"),
            (["--frame-limit", "0"], "0.1 to 10000"),
            (["--frame-limit", "NaN"], "'NaN'"),
            (["--hud", "maybe"], "[possible values: off, on, details]"),
            (["--cost-model", "measure"], "a similar value exists: 'measured'"),
            (["--path", "stret"], "did you mean 'street'?"),
            (["--scene", "a.glb"], "`viewer a.glb`"),
            (["--frames", "0"], "0 is not in 1..=1000000"),
            (["--capture", "-1"], "-1 is not in 0..="),
            (["--size", "1x0"], "1280x720"),
            (["--time-of-day", "25"], "'25' is not an hour of the day"),
            (["--time-of-day", "NaN"], "'NaN' is not an hour of the day"),
            (["--shadows", "volume"], "did you mean 'volumes'?"),
            (["--filter", "soft"], "unknown filter 'soft'"),
            (["--bias", "half"], "unknown bias 'half'"),
        ] {
            let refused = parse(&line).unwrap_err();
            assert!(refused.contains(reason), "{line:?}: {refused}");
        }
    }
}
