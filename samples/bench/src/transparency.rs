//! Transparent objects: the choice of their order, and the report about it.

use antumbra::render::{FragmentCounts, Renderer, TransparencyMethod, TransparencyOptions};
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// The order in which transparent objects are blended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TransparencyChoice {
    /// By objects, the farthest first.
    #[default]
    Objects,
    /// By the fragments of each pixel: exact where objects pass through each other.
    Fragments,
}

impl TransparencyChoice {
    /// Returns the options of transparent objects.
    pub fn options(self) -> TransparencyOptions {
        let method = match self {
            Self::Objects => TransparencyMethod::SortedObjects,
            Self::Fragments => TransparencyMethod::SortedFragments,
        };
        TransparencyOptions { method, ..TransparencyOptions::default() }
    }
}

/// The order in which transparent objects were blended, where fragments were asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct TransparencyReport {
    /// The order.
    pub method: String,
    /// The reason why it is by objects; absent where it is by fragments.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fallback: Option<String>,
}

impl TransparencyReport {
    /// Returns the order of a renderer; `None` where fragments were not asked for.
    pub fn of(renderer: &Renderer) -> Option<Self> {
        let is_asked = renderer.transparency().method == TransparencyMethod::SortedFragments;
        is_asked.then(|| Self {
            method: renderer.transparency_method().to_string(),
            fallback: renderer.transparency_fallback().map(|reason| reason.to_string()),
        })
    }

    /// Returns it in words.
    pub fn text(&self) -> String {
        match &self.fallback {
            Some(reason) => format!("{}: {reason}", self.method),
            None => self.method.clone(),
        }
    }
}

/// The sorted fragments of a frame, or the most of each kind in one of several frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct FragmentsReport {
    /// Fragments of transparent objects that nothing opaque hides.
    pub visible: u32,
    /// Visible fragments beyond the capacity, which were not blended.
    pub without_room: u32,
    /// Visible fragments beyond the limit per pixel, which were not blended.
    pub left_out: u32,
}

impl FragmentsReport {
    /// Returns the most of each kind in one frame; `None` where none were sorted.
    pub fn most(frames: impl Iterator<Item = FragmentCounts>) -> Option<Self> {
        let most = frames.fold(Self::default(), |most, counts| Self {
            visible: most.visible.max(counts.visible),
            without_room: most.without_room.max(counts.without_room),
            left_out: most.left_out.max(counts.left_out),
        });
        (most.visible > 0).then_some(most)
    }

    /// Returns the counts that were not blended in words, if there are any.
    pub fn lost(&self) -> Option<String> {
        let Self { without_room, left_out, .. } = *self;
        let is_exact = without_room == 0 && left_out == 0;
        (!is_exact).then(|| format!("{without_room} without room, {left_out} left out"))
    }
}
