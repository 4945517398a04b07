//! The reasons why a scene, a path or a motion cannot be made.

use scene::SceneError;

/// The most objects that a generated scene can have.
pub const MAX_OBJECTS: u32 = 2_000_000;

/// The most street lamps of a set of lights.
pub const MAX_LAMPS: u32 = 64;

/// The reasons why a scene, a path or a motion cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeneratorError {
    /// Zero objects, or more than a generated scene can hold.
    #[error("a scene has 1 to {MAX_OBJECTS} objects, not {asked}: choose a number in that range")]
    ObjectCount {
        /// The number that was asked for.
        asked: u32,
    },
    /// Too little memory for the objects.
    #[error("there is no memory for a scene of {count} objects: use fewer, or end other programs")]
    NoMemory {
        /// The number of objects.
        count: u32,
    },
    /// A motion that cannot be made.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A name that no camera path has.
    #[error("there is no camera path named \"{name}\": choose street, fly or cut")]
    UnknownPath {
        /// The name that was asked for.
        name: String,
    },
    /// A walk in a scene that has no streets.
    #[error("the scene has no streets to walk along: choose the path fly")]
    NoStreets,
    /// An hour that no day has.
    #[error("'{text}' is no hour of the day: it takes 0 to 24, as in 17.5 or 17:30")]
    Hour {
        /// The hour that was asked for.
        text: String,
    },
    /// A name that no set of lights has.
    #[error(
        "there are no lights '{name}': choose sun, torches or a number of street lamps, 1 to {MAX_LAMPS}"
    )]
    UnknownLights {
        /// The name that was asked for.
        name: String,
    },
    /// More lamps than the scene has.
    #[error("the scene has {found} street lamps, not {asked}: ask for fewer, or for more objects")]
    TooFewLamps {
        /// The number that was asked for.
        asked: u32,
        /// The number of the scene's.
        found: usize,
    },
    /// Torches of a file that has none.
    #[error("the scene has neither point nor spot lights: choose the lights sun")]
    NoTorches,
    /// A scene that cannot be drawn: it has no motion.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// The reasons why a motion cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// A percentage above 100.
    #[error("{percent} percent of the objects cannot move: choose 0 to 100")]
    Percent {
        /// The percentage that was asked for.
        percent: u32,
    },
}
