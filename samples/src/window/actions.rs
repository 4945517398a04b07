//! The actions of keys and scripts.

use antumbra::gpu::PresentMode;
use antumbra::shadows::ShadowFilter;

use bench::choices::parse_strategy;
use bench::options::MAX_FRAMES_IN_FLIGHT;
use bench::shadow_choice::{ShadowWay, parse_filter};
use bench::strategy::Strategy;
use scenes::{GeneratorError, Hour};

/// An action between two frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Changes to the next strategy that the device supports.
    NextStrategy,
    /// Changes to this strategy.
    Strategy(Strategy),
    /// Adds a frame in flight; after the most, goes back to one.
    NextFramesInFlight,
    /// Sets this number of frames in flight.
    FramesInFlight(u32),
    /// Changes to the next present mode.
    NextPresentMode,
    /// Changes to this present mode.
    PresentMode(PresentMode),
    /// Freezes the culling while the camera flies on, or ends the freeze.
    Freeze,
    /// Compares alternating frames with and without culling, and counts the pixels that differ.
    Compare,
    /// Identifies the object at a pixel, or in the middle, and explains why it is drawn or not.
    Identify(Option<[u32; 2]>),
    /// Changes to the next hour of the day.
    NextHour,
    /// Changes to this hour of the day.
    Hour(Hour),
    /// Changes to the next method of shadows.
    NextShadows,
    /// Changes to this method of shadows.
    Shadows(ShadowWay),
    /// Changes to the next filter of shadow maps.
    NextFilter,
    /// Changes to this filter of shadow maps.
    Filter(ShadowFilter),
    /// Switches lens flares on or off.
    Flares,
    /// Switches between pictures projected by spots and white light.
    Pictures,
    /// Switches between levels of detail by distance and visible samples, and only by distance.
    DetailBySamples,
    /// Switches the view from above in a corner.
    TopDown,
    /// Switches the display of tested boxes, coloured by their history.
    Boxes,
    /// Switches the display of the edges of all triangles.
    Wireframe,
    /// Switches the display of the number of surfaces drawn at each pixel.
    DepthComplexity,
    /// Switches timing of all GPU passes.
    TimePasses,
    /// Continues on the next device that can show the scene, or on the same one opened again.
    AnotherDevice,
    /// Takes a screenshot.
    Screenshot,
    /// Starts recording the camera's path, or ends it and writes the file.
    Record,
    /// Changes to the next amount of text over the image.
    Hud,
    /// Stops the time in the scene, or resumes it.
    Pause,
    /// Advances the time by one step.
    Step,
    /// Plays only the next clip.
    NextClip,
    /// Plays all clips at once.
    AllClips,
    /// Looks through the camera of the scene's file with this number, from 1 on.
    Camera(u32),
    /// Opens the list of strategies.
    ListStrategies,
    /// Opens the list of scenes.
    ListScenes,
    /// Opens the field for the path of a file.
    OpenPath,
    /// Opens the page of all keys.
    Help,
    /// Switches between full screen and a window.
    FullScreen,
    /// Captures the mouse to look around without holding a button, or frees it.
    CaptureMouse,
    /// The Esc key: closes the open page, frees the mouse, or quits when pressed twice.
    Escape,
    /// Quits the program.
    Quit,
}

/// The keys: their names, descriptions and actions, in the order of [`GROUPS`].
pub const KEYS: [(&str, &str, Action); 27] = [
    ("O", "list of scenes", Action::ListScenes),
    ("Ctrl+O", "open a file by its path", Action::OpenPath),
    ("F11", "full screen", Action::FullScreen),
    ("M", "capture the mouse", Action::CaptureMouse),
    ("H", "more text, or none", Action::Hud),
    ("F1", "all keys", Action::Help),
    ("Esc", "close, free the mouse; twice: quit", Action::Escape),
    ("Tab", "next strategy", Action::NextStrategy),
    ("U", "list of strategies", Action::ListStrategies),
    ("V", "compare with no culling", Action::Compare),
    ("C", "freeze the culling", Action::Freeze),
    ("I", "identify the middle", Action::Identify(None)),
    ("B", "view from above", Action::TopDown),
    ("X", "boxes that are tested", Action::Boxes),
    ("G", "wireframe", Action::Wireframe),
    ("F5", "depth complexity", Action::DepthComplexity),
    ("T", "GPU time of passes", Action::TimePasses),
    ("J", "an hour later", Action::NextHour),
    ("Y", "shadows: maps, volumes, off", Action::NextShadows),
    ("Z", "filter of shadows", Action::NextFilter),
    ("F2", "lens flares", Action::Flares),
    ("F3", "pictures of spots", Action::Pictures),
    ("F4", "detail by visible samples", Action::DetailBySamples),
    ("F", "frames in flight", Action::NextFramesInFlight),
    ("P", "present mode", Action::NextPresentMode),
    ("K", "screenshot", Action::Screenshot),
    ("R", "record the path", Action::Record),
];

/// The titles of groups of keys, and the number of keys in each.
pub const GROUPS: [(&str, usize); 5] = [
    ("Scene and window", 7),
    ("Culling", 4),
    ("Explanations", 6),
    ("Light", 3),
    ("Pictures and frames", 7),
];

/// Additional keys for scenes from files. Digits select their cameras.
pub const FILE_KEYS: [(&str, &str, Action); 4] = [
    ("Space", "pause, go on", Action::Pause),
    (".", "one step", Action::Step),
    ("N", "next clip", Action::NextClip),
    ("L", "all clips", Action::AllClips),
];

/// The description of the digit keys.
pub const CAMERA_KEYS: (&str, &str) = ("1 to 9", "cameras of the file");

/// The keys that steer the camera.
pub const STEERING: [(&str, &str); 5] = [
    ("WASD QE", "fly, down, up"),
    ("Shift", "faster"),
    ("Wheel", "how fast"),
    ("Click", "identify an object"),
    ("Mouse", "look, a button held; right click: capture"),
];

impl Action {
    /// Returns the action of the key with this name: `F1`, `Tab`, `Esc`, `Space`, `Ctrl+O`, a
    /// digit, or a letter of any case.
    pub fn of_key(name: &str) -> Option<Self> {
        let same = |(key, _, _): &&(&str, &str, Action)| key.eq_ignore_ascii_case(name);
        if let Some(number) = name.parse().ok().filter(|number| (1..=9).contains(number)) {
            return Some(Self::Camera(number));
        }
        KEYS.iter().chain(&FILE_KEYS).find(same).map(|(_, _, action)| *action)
    }

    /// Parses an action in the syntax of scripts.
    ///
    /// # Errors
    /// A sentence, if there is no such action or value.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut words = text.split_ascii_whitespace();
        let name = words.next().unwrap_or_default();
        let value = words.next();
        if let Some(more) = words.next() {
            return Err(format!("'{more}' is one word too many"));
        }
        let action =
            match (name, value) {
                ("strategy", None) => Self::NextStrategy,
                ("strategy", Some(name)) => Self::Strategy(parse_strategy(name)?),
                ("frames_in_flight", None) => Self::NextFramesInFlight,
                ("frames_in_flight", Some(count)) => {
                    let within = |count: &u32| (1..=MAX_FRAMES_IN_FLIGHT).contains(count);
                    let count = count.parse().ok().filter(within);
                    Self::FramesInFlight(count.ok_or_else(|| {
                        format!("frames_in_flight takes 1 to {MAX_FRAMES_IN_FLIGHT}")
                    })?)
                }
                ("present_mode", None) => Self::NextPresentMode,
                ("present_mode", Some(name)) => Self::PresentMode(present_mode(name)?),
                ("freeze", None) => Self::Freeze,
                ("compare", None) => Self::Compare,
                ("identify", None) => Self::Identify(None),
                ("identify", Some(pixel)) => Self::Identify(Some(parse_pixel(pixel)?)),
                ("hour", None) => Self::NextHour,
                ("hour", Some(hour)) => {
                    Self::Hour(hour.parse().map_err(|error: GeneratorError| error.to_string())?)
                }
                ("shadows", None) => Self::NextShadows,
                ("shadows", Some(way)) => Self::Shadows(way.parse()?),
                ("filter", None) => Self::NextFilter,
                ("filter", Some(name)) => Self::Filter(parse_filter(name)?),
                ("flares", None) => Self::Flares,
                ("pictures", None) => Self::Pictures,
                ("detail_by_samples", None) => Self::DetailBySamples,
                ("top_down", None) => Self::TopDown,
                ("boxes", None) => Self::Boxes,
                ("wireframe", None) => Self::Wireframe,
                ("depth_complexity", None) => Self::DepthComplexity,
                ("time_passes", None) => Self::TimePasses,
                ("another_device", None) => Self::AnotherDevice,
                ("screenshot", None) => Self::Screenshot,
                ("record", None) => Self::Record,
                ("hud", None) => Self::Hud,
                ("pause", None) => Self::Pause,
                ("step", None) => Self::Step,
                ("next_clip", None) => Self::NextClip,
                ("all_clips", None) => Self::AllClips,
                ("camera", Some(number)) => Self::Camera(
                    number.parse().map_err(|_| "camera takes its number, from 1 on".to_owned())?,
                ),
                ("camera", None) => return Err("camera takes its number, from 1 on".to_owned()),
                ("list_strategies", None) => Self::ListStrategies,
                ("list_scenes", None) => Self::ListScenes,
                ("open_path", None) => Self::OpenPath,
                ("help", None) => Self::Help,
                ("full_screen", None) => Self::FullScreen,
                ("capture_mouse", None) => Self::CaptureMouse,
                ("escape", None) => Self::Escape,
                ("quit", None) => Self::Quit,
                (name, Some(value)) if NAMES.contains(&name) => {
                    return Err(format!("{name} takes no '{value}'"));
                }
                (name, _) => {
                    return Err(format!("unknown action '{name}': there is {}", NAMES.join(", ")));
                }
            };
        Ok(action)
    }
}

const NAMES: [&str; 34] = [
    "strategy",
    "frames_in_flight",
    "present_mode",
    "freeze",
    "compare",
    "identify",
    "hour",
    "shadows",
    "filter",
    "flares",
    "pictures",
    "detail_by_samples",
    "top_down",
    "boxes",
    "wireframe",
    "depth_complexity",
    "time_passes",
    "another_device",
    "screenshot",
    "record",
    "hud",
    "pause",
    "step",
    "next_clip",
    "all_clips",
    "camera",
    "list_strategies",
    "list_scenes",
    "open_path",
    "help",
    "full_screen",
    "capture_mouse",
    "escape",
    "quit",
];

/// Parses a pixel `X,Y`, counted from the upper left.
fn parse_pixel(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(',').map(|(x, y)| [x.parse().ok(), y.parse().ok()]);
    match sides {
        Some([Some(x), Some(y)]) => Ok([x, y]),
        _ => Err(format!("identify takes a pixel, as in 'identify 160,90', not '{text}'")),
    }
}

/// Returns the present mode with this name.
///
/// # Errors
/// A sentence with all names.
pub fn present_mode(name: &str) -> Result<PresentMode, String> {
    PresentMode::from_name(name).ok_or_else(|| {
        let names = PresentMode::ALL.map(PresentMode::name).join(", ");
        format!("unknown present mode '{name}': there is {names}")
    })
}

#[cfg(test)]
mod tests {
    use antumbra::methods;

    use super::*;

    #[test]
    fn every_action_has_a_key_and_a_name() {
        let keys = || KEYS.iter().chain(&FILE_KEYS);
        for (key, _, action) in keys() {
            assert_eq!(Action::of_key(&key.to_lowercase()), Some(*action));
        }
        assert_eq!(Action::of_key("3"), Some(Action::Camera(3)));
        assert_eq!((Action::of_key("0"), Action::of_key("12")), (None, None));
        // Esc quits in two steps, a script in one; devices change in scripts only.
        let without_key = ["camera", "quit", "another_device"];
        for name in NAMES.into_iter().filter(|name| !without_key.contains(name)) {
            let action = Action::parse(name).unwrap();
            assert_eq!(keys().filter(|(_, _, of_key)| *of_key == action).count(), 1, "{name}");
        }
        assert_eq!(Action::of_key("w"), None);
    }

    #[test]
    fn every_key_is_in_a_group() {
        assert_eq!(GROUPS.iter().map(|(_, count)| count).sum::<usize>(), KEYS.len());
    }

    /// Checks that every key of the window is in the README.
    #[test]
    fn the_readme_lists_every_key() {
        let readme = include_str!("../../README.md");
        let table: String = readme.lines().filter(|line| line.starts_with("| ")).collect();
        for (key, _, _) in KEYS {
            let words = table.split(['|', ',', ' ']).any(|word| word == key);
            assert!(words, "{key} is not in the table of keys of samples/README.md");
        }
        for (key, _, _) in FILE_KEYS {
            let is_there = readme.split([' ', ',', ';', '(', '`', '\n']).any(|word| word == key);
            assert!(is_there, "{key} is not in samples/README.md");
        }
    }

    #[test]
    fn values_are_checked() {
        assert_eq!(Action::parse("strategy hzb"), Ok(Action::Strategy(methods::HZB)));
        assert_eq!(Action::parse("frames_in_flight 4"), Ok(Action::FramesInFlight(4)));
        assert_eq!(Action::parse("camera 2"), Ok(Action::Camera(2)));
        assert_eq!(Action::parse("hour 22"), Ok(Action::Hour(Hour::NIGHT)));
        assert_eq!(Action::parse("shadows maps"), Ok(Action::Shadows(ShadowWay::Maps)));
        assert_eq!(Action::parse("filter pcf3"), Ok(Action::Filter(ShadowFilter::Pcf3)));
        assert_eq!(Action::parse("identify 3,40"), Ok(Action::Identify(Some([3, 40]))));
        assert_eq!(Action::parse("present_mode fifo"), Ok(Action::PresentMode(PresentMode::Fifo)));
        for (text, reason) in [
            ("strategy chcc", "did you mean 'chc'?"),
            ("frames_in_flight 5", "1 to 4"),
            ("present_mode vsync", "fifo_relaxed, mailbox"),
            ("hud off", "hud takes no 'off'"),
            ("camera", "takes its number"),
            ("camera walk", "takes its number"),
            ("identify 160", "takes a pixel"),
            ("identify -1,2", "takes a pixel"),
            ("hour 25", "'25' is not an hour"),
            ("shadows volume", "did you mean 'volumes'?"),
            ("filter soft", "unknown filter 'soft'"),
            ("jump", "unknown action 'jump'"),
            ("", "unknown action ''"),
            ("strategy hzb now", "'now' is one word too many"),
        ] {
            let refused = Action::parse(text).unwrap_err();
            assert!(refused.contains(reason), "{text}: {refused}");
        }
    }
}
