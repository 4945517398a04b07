//! What keys and scripts can have done.

use gpu::PresentMode;

use crate::choices::parse_named;
use crate::options::MAX_FRAMES_IN_FLIGHT;
use crate::strategy::Strategy;

/// Something to be done between two frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// Go on with the next strategy that the device can.
    NextStrategy,
    /// Go on with this one.
    Strategy(Strategy),
    /// One more frame in flight, or one only after the most.
    NextFramesInFlight,
    /// So many.
    FramesInFlight(u32),
    /// Go on with the next present mode.
    NextPresentMode,
    /// Go on with this one.
    PresentMode(PresentMode),
    /// The culling stands still while the camera flies on, or goes on.
    Freeze,
    /// The view from above in a corner.
    BirdsEye,
    /// The boxes that are tested, coloured by what is known of them.
    Boxes,
    /// The edges of all triangles.
    Wires,
    /// The GPU time of every pass.
    TimePasses,
    /// A picture of what is on the screen.
    Screenshot,
    /// The camera's path goes into a file, or that is written.
    Record,
    /// All that is written over the picture.
    Hud,
    /// Time in the scene stands still, or goes on.
    Pause,
    /// One step of time further.
    Step,
    /// The next clip plays alone.
    NextClip,
    /// All clips play.
    AllClips,
    /// The camera of the scene's file with this number, from 1 on.
    Camera(u32),
    /// The end.
    Quit,
}

/// The keys: how they are called, what they do, as text and as a deed.
pub const KEYS: [(&str, &str, Deed); 12] = [
    ("Tab", "next strategy", Deed::NextStrategy),
    ("F", "frames in flight", Deed::NextFramesInFlight),
    ("P", "present mode", Deed::NextPresentMode),
    ("C", "freeze the culling", Deed::Freeze),
    ("B", "bird's-eye view", Deed::BirdsEye),
    ("X", "boxes that are tested", Deed::Boxes),
    ("G", "wires", Deed::Wires),
    ("T", "GPU time of passes", Deed::TimePasses),
    ("K", "screenshot", Deed::Screenshot),
    ("R", "record the path", Deed::Record),
    ("H", "all this text", Deed::Hud),
    ("Esc", "quit", Deed::Quit),
];

/// More keys, for scenes out of files. Numbers look through their cameras.
pub const FILE_KEYS: [(&str, &str, Deed); 4] = [
    ("Space", "pause, go on", Deed::Pause),
    (".", "one step", Deed::Step),
    ("N", "next clip", Deed::NextClip),
    ("L", "all clips", Deed::AllClips),
];

/// What the numbers do.
pub const CAMERA_KEYS: (&str, &str) = ("1 to 9", "cameras of the file");

/// What the camera is steered with.
pub const STEERING: [(&str, &str); 4] = [
    ("WASD QE", "fly, down, up"),
    ("Shift", "faster"),
    ("Wheel", "how fast"),
    ("Mouse", "look, a button held"),
];

impl Deed {
    /// What the key of that name does: `Tab`, `Esc`, `Space`, a digit, or a letter of any case.
    pub fn of_key(name: &str) -> Option<Self> {
        let same = |(key, _, _): &&(&str, &str, Deed)| key.eq_ignore_ascii_case(name);
        if let Some(number) = name.parse().ok().filter(|number| (1..=9).contains(number)) {
            return Some(Self::Camera(number));
        }
        KEYS.iter().chain(&FILE_KEYS).find(same).map(|(_, _, deed)| *deed)
    }

    /// A deed as scripts write it.
    ///
    /// # Errors
    /// A sentence, where there is no such deed or value.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut words = text.split_ascii_whitespace();
        let (name, value) = (words.next().unwrap_or_default(), words.next());
        if let Some(more) = words.next() {
            return Err(format!("'{more}' is one word too many"));
        }
        let deed =
            match (name, value) {
                ("strategy", None) => Self::NextStrategy,
                ("strategy", Some(name)) => Self::Strategy(parse_named(name)?),
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
                ("birds_eye", None) => Self::BirdsEye,
                ("boxes", None) => Self::Boxes,
                ("wires", None) => Self::Wires,
                ("time_passes", None) => Self::TimePasses,
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
                ("quit", None) => Self::Quit,
                (name, Some(value)) if NAMES.contains(&name) => {
                    return Err(format!("{name} takes no '{value}'"));
                }
                (name, _) => {
                    return Err(format!("unknown deed '{name}': there is {}", NAMES.join(", ")));
                }
            };
        Ok(deed)
    }
}

const NAMES: [&str; 17] = [
    "strategy",
    "frames_in_flight",
    "present_mode",
    "freeze",
    "birds_eye",
    "boxes",
    "wires",
    "time_passes",
    "screenshot",
    "record",
    "hud",
    "pause",
    "step",
    "next_clip",
    "all_clips",
    "camera",
    "quit",
];

/// The present mode of that name.
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
    use super::*;

    #[test]
    fn every_deed_has_a_key_and_a_name() {
        let keys = || KEYS.iter().chain(&FILE_KEYS);
        for (key, _, deed) in keys() {
            assert_eq!(Deed::of_key(&key.to_lowercase()), Some(*deed));
        }
        assert_eq!(Deed::of_key("3"), Some(Deed::Camera(3)));
        assert_eq!((Deed::of_key("0"), Deed::of_key("12")), (None, None));
        for name in NAMES.into_iter().filter(|name| *name != "camera") {
            let deed = Deed::parse(name).unwrap();
            assert_eq!(keys().filter(|(_, _, of_key)| *of_key == deed).count(), 1, "{name}");
        }
        assert_eq!(Deed::of_key("w"), None);
    }

    #[test]
    fn values_are_checked() {
        assert_eq!(Deed::parse("strategy pyramid"), Ok(Deed::Strategy(Strategy::Pyramid)));
        assert_eq!(Deed::parse("frames_in_flight 4"), Ok(Deed::FramesInFlight(4)));
        assert_eq!(Deed::parse("camera 2"), Ok(Deed::Camera(2)));
        assert_eq!(Deed::parse("present_mode fifo"), Ok(Deed::PresentMode(PresentMode::Fifo)));
        for (text, reason) in [
            ("strategy pyramide", "did you mean 'pyramid'?"),
            ("frames_in_flight 5", "1 to 4"),
            ("present_mode vsync", "fifo_relaxed, mailbox"),
            ("hud off", "hud takes no 'off'"),
            ("camera", "takes its number"),
            ("camera walk", "takes its number"),
            ("jump", "unknown deed 'jump'"),
            ("", "unknown deed ''"),
            ("strategy pyramid now", "'now' is one word too many"),
        ] {
            let refused = Deed::parse(text).unwrap_err();
            assert!(refused.contains(reason), "{text}: {refused}");
        }
    }
}
