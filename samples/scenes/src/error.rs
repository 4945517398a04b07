//! The reasons why a scene, a path or a motion cannot be generated.

use scene::SceneError;

/// The most objects that a generated scene can have. Devices differ in how many they take.
pub const MAX_OBJECTS: u32 = 1 << 25;

/// The most street lamps in a set of lights.
pub const MAX_LAMPS: u32 = 64;

/// The reason why a scene, a path or a motion cannot be generated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeneratorError {
    /// Zero objects, or more than a generated scene can hold.
    #[error("a scene has 1 to {MAX_OBJECTS} objects, not {asked}: choose a number in that range")]
    ObjectCount {
        /// The requested number.
        asked: u32,
    },
    /// Not enough memory for the objects.
    #[error("there is no memory for a scene of {count} objects: use fewer, or end other programs")]
    NoMemory {
        /// The number of objects.
        count: u32,
    },
    /// A motion that cannot be generated.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A name that no camera path has.
    #[error("there is no camera path named \"{name}\": choose street, fly or cut")]
    UnknownPath {
        /// The requested name.
        name: String,
    },
    /// A walk in a scene without streets.
    #[error("the scene has no streets to walk along: choose the path fly")]
    NoStreets,
    /// A text that is not an hour of the day.
    #[error("'{text}' is not an hour of the day: it takes 0 to 24, as in 17.5 or 17:30")]
    Hour {
        /// The requested hour.
        text: String,
    },
    /// A name that no set of lights has.
    #[error(
        "there are no lights '{name}': choose sun, torches or a number of street lamps, 1 to {MAX_LAMPS}"
    )]
    UnknownLights {
        /// The requested name.
        name: String,
    },
    /// More lamps than the scene has.
    #[error("the scene has {found} street lamps, not {asked}: ask for fewer, or for more objects")]
    TooFewLamps {
        /// The requested number.
        asked: u32,
        /// The number of lamps in the scene.
        found: usize,
    },
    /// Torches in a file without any.
    #[error("the scene has neither point nor spot lights: choose the lights sun")]
    NoTorches,
    /// A scene that cannot be drawn, so it cannot have a motion.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// The reason why a motion cannot be generated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// A percentage above 100.
    #[error("{percent} percent of the objects cannot move: choose 0 to 100")]
    Percent {
        /// The requested percentage.
        percent: u32,
    },
}
