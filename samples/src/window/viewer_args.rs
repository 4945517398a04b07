//! The command line of `viewer`, and the checks that make it a [`SceneSource`].

use std::path::PathBuf;

use clap::Parser;

use super::actions::FILE_KEYS;
use super::keys_help::help_with_keys;
use super::show::{ShowArguments, ShowOptions};
use super::source::{FileSource, SceneSource};
use bench::args::usage;
use bench::choices::path_file;
use bench::options::UsageError;

const EXAMPLES: &str = "\
Examples:
  viewer rooms.glb
      Look around: W A S D, Q and E; look with a mouse button held.
  viewer rooms.glb --camera walk --strategy frustum
      Begins with the camera \"walk\" of the file, without occlusion culling.
  viewer rooms.glb --detail 1 --detail-by-samples
      Coarser levels of detail where objects are far away, or mostly hidden.
  viewer rooms.glb --headless --frames 60 --camera walk --out images
      The first second as images, without a window.

Exit codes: 0 all went well; 2 the command line or the file is wrong; 1 the machine cannot do it or a file \
cannot be written; 129, 130 or 143 a closed terminal, Ctrl-C or SIGTERM ended it: that writes what \
there is, and a second one ends it at once.";

/// Shows the scene of a glTF, STL or OBJ file in a window, with its animations, and with occlusion
/// culling.
///
/// The keys are listed on the screen; another file can be dropped into the window. The same program
/// runs without a window: --headless.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "viewer",
    version,
    allow_negative_numbers = true,
    args_override_self = true,
    after_help = help_with_keys(EXAMPLES, &FILE_KEYS)
)]
pub struct ViewerArguments {
    /// The scene: glTF 2.0, as .glb or .gltf; a window can do without until a file is dropped into
    /// it
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// The first camera, by its name in the file [default: the file's first one; where there is
    /// none or a clip has it right before a wall, a place from which all is seen]
    #[arg(long, value_name = "NAME", help_heading = "Scene")]
    pub camera: Option<String>,
    /// Recorded path of the camera, whose name ends in .txt or has a slash
    #[arg(long, visible_alias = "replay", value_name = "FILE", help_heading = "Scene")]
    #[arg(value_parser = recorded_path, conflicts_with = "camera")]
    pub path: Option<PathBuf>,
    /// Factor of all light before the tone mapping [default: 1, with the lights dimmed where they
    /// would leave nothing but white]
    #[arg(long, value_name = "FACTOR", value_parser = positive, help_heading = "Scene")]
    pub exposure: Option<f32>,
    /// Largest error of surfaces in pixels, for coarser levels of detail [default: the finest
    /// level]
    #[arg(long, value_name = "PIXELS", value_parser = positive, help_heading = "Scene")]
    pub detail: Option<f32>,
    /// Coarser levels of detail also for objects of which few pixels are visible
    #[arg(long, requires = "detail", help_heading = "Scene")]
    pub detail_by_samples: bool,
    /// The options of showing it.
    #[command(flatten)]
    pub show: ShowArguments,
}

impl ViewerArguments {
    /// Returns the source of the scene and the options of showing it. Looks at nothing but the
    /// arguments: files and devices come later.
    ///
    /// # Errors
    /// Arguments about a file where none is named.
    pub fn options(&self) -> Result<(SceneSource, ShowOptions), UsageError> {
        let show = self.show.options();
        let settings = FileSource {
            camera: self.camera.clone(),
            recorded: self.path.clone(),
            exposure: self.exposure,
            detail_pixels: self.detail,
            has_detail_by_samples: self.detail_by_samples,
        };
        match &self.file {
            Some(file) => Ok((SceneSource::File { file: file.clone(), settings }, show)),
            None if show.is_headless => usage(
                "without a window there is nothing to drop a file into: say which, as in `viewer FILE --headless`",
            ),
            None if self.camera.is_some() || self.path.is_some() => usage(
                "--camera and --path are about a file: say which, as in `viewer FILE --camera NAME`",
            ),
            None => Ok((SceneSource::Nothing { settings }, show)),
        }
    }
}

fn recorded_path(text: &str) -> Result<PathBuf, String> {
    path_file(text).ok_or_else(|| {
        "it takes a recorded file, with a name that ends in .txt or has a slash; for a camera of the file say --camera"
            .to_owned()
    })
}

fn positive(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|number| *number > 0.0 && f32::is_finite(*number));
    number.ok_or_else(|| "it takes a number above 0".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use antumbra::import::BrokenParts;
    use clap::CommandFactory;

    use crate::hud::HudLevel;

    fn parse(line: &[&str]) -> Result<(SceneSource, ShowOptions), String> {
        let parsed = ViewerArguments::try_parse_from([&["viewer"], line].concat());
        parsed.map_err(|error| error.to_string())?.options().map_err(|error| error.to_string())
    }

    #[test]
    fn the_declaration_is_consistent() {
        ViewerArguments::command().debug_assert();
    }

    #[test]
    fn a_file_is_enough() {
        let (source, show) = parse(&["a.glb"]).unwrap();
        let settings = FileSource::default();
        assert_eq!(source, SceneSource::File { file: "a.glb".into(), settings: settings.clone() });
        assert_eq!((show.is_headless, show.hud), (false, HudLevel::Compact));
        assert_eq!(parse(&[]).unwrap().0, SceneSource::Nothing { settings });
    }

    #[test]
    fn every_option_arrives() {
        let line = [
            "--camera=walk",
            "--exposure=0.5",
            "--detail=2",
            "--detail-by-samples",
            "a.glb",
            "--headless",
            "--size",
            "3x2",
        ];
        let (source, show) = parse(&line).unwrap();
        let settings = FileSource {
            camera: Some("walk".into()),
            recorded: None,
            exposure: Some(0.5),
            detail_pixels: Some(2.0),
            has_detail_by_samples: true,
        };
        assert_eq!(source, SceneSource::File { file: "a.glb".into(), settings });
        assert_eq!((show.size.width, show.size.height, show.is_headless), (3, 2, true));
        assert_eq!(show.broken_parts, BrokenParts::LeaveOut);
        assert_eq!(parse(&["a.glb", "--strict"]).unwrap().1.broken_parts, BrokenParts::Refuse);
        let (source, _) = parse(&["a.gltf", "--replay", "./p"]).unwrap();
        let settings = FileSource { recorded: Some("./p".into()), ..FileSource::default() };
        assert_eq!(source, SceneSource::File { file: "a.gltf".into(), settings });
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (line, reason) in [
            (&["--headless"][..], "say which"),
            (&["--camera", "walk"], "say which"),
            (&["a.glb", "--exposure", "0"], "a number above 0"),
            (&["a.glb", "--exposure", "NaN"], "a number above 0"),
            (&["a.glb", "--exposure", "bright"], "a number above 0"),
            (&["a.glb", "--detail", "-1"], "a number above 0"),
            (&["a.glb", "--detail-by-samples"], "--detail <PIXELS>"),
            (&["a.glb", "--path", "walk"], "say --camera"),
            (&["a.glb", "--path", "a/b", "--camera", "walk"], "cannot be used with '--camera"),
            (&["a.glb", "--strategy", "ideal"], "see walkthrough"),
        ] {
            let refused = parse(line).unwrap_err();
            assert!(refused.contains(reason), "{line:?}: {refused}");
        }
    }
}
