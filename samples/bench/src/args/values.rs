//! The values of single arguments.

use std::str::FromStr;

use crate::choices::parse_strategy;
use crate::strategy::Strategy;

/// Strategies to compare.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StrategyList {
    /// All that can run.
    All,
    /// These, each of them once.
    These(Vec<Strategy>),
}

impl FromStr for StrategyList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::All);
        }
        let mut strategies = Vec::new();
        for name in text.split(',') {
            let strategy = parse_strategy(name.trim())?;
            if strategies.contains(&strategy) {
                return Err(format!("it names '{strategy}' twice: name each once"));
            }
            strategies.push(strategy);
        }
        Ok(Self::These(strategies))
    }
}

/// The frame that is shown from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopDown {
    /// No frame is shown from above.
    Off,
    /// The frame of this number.
    Frame(u32),
}

impl FromStr for TopDown {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "off" => Ok(Self::Off),
            _ => text.parse().map(Self::Frame).map_err(|_| "it takes a frame, or off".to_owned()),
        }
    }
}
