//! The ways in which transparent objects are blended, and the features that a device needs for
//! them.

use std::fmt;

use cull::VisibilityTest;
use gpu::{Device, OptionalFeature, vk};
use occlusion::DriverQuirks;

/// The order in which transparent objects are blended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TransparencyMethod {
    /// By objects, from the farthest on. Objects that pass through each other have one order for
    /// all of their pixels, which is wrong for some pixels.
    #[default]
    SortedObjects,
    /// By fragments: each pixel has a list of fragments, which is sorted by depth. It is exact even
    /// for objects that pass through each other, and does not depend on the order of objects.
    SortedFragments,
}

impl TransparencyMethod {
    /// Returns the name for users.
    pub fn name(self) -> &'static str {
        match self {
            Self::SortedObjects => "sorted objects",
            Self::SortedFragments => "sorted fragments",
        }
    }
}

impl fmt::Display for TransparencyMethod {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// The options of transparent objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TransparencyOptions {
    /// The requested order. A device that lacks a feature for it sorts objects
    /// ([`Renderer::transparency_fallback`](crate::Renderer::transparency_fallback)).
    pub method: TransparencyMethod,
    /// The room for fragments, as an average number per pixel of the image: 16 bytes each, limited
    /// by the size of a storage buffer on the device. Fragments without room are not blended; they
    /// are counted ([`FragmentCounts::without_room`]).
    pub fragments_per_pixel: u32,
    /// The highest number of fragments that are blended at a pixel, at least 1: the nearest ones.
    /// Fragments behind them are counted ([`FragmentCounts::left_out`]).
    pub blended_most: u32,
}

impl Default for TransparencyOptions {
    fn default() -> Self {
        Self { method: TransparencyMethod::default(), fragments_per_pixel: 4, blended_most: 64 }
    }
}

/// The counts of fragments of transparent objects in a frame, for all its views together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FragmentCounts {
    /// The number of fragments that no opaque object hides.
    pub visible: u32,
    /// The number of visible fragments that found no room. They are a random choice, and the image
    /// is wrong at their pixels.
    pub without_room: u32,
    /// The number of visible fragments left out behind [`TransparencyOptions::blended_most`] others
    /// of their pixel, although these let light through.
    pub left_out: u32,
}

impl FragmentCounts {
    /// Returns true if every visible fragment was blended.
    pub fn is_exact(&self) -> bool {
        self.without_room == 0 && self.left_out == 0
    }
}

/// The reason why objects are sorted although sorted fragments were requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransparencyFallback {
    /// The device lacks a feature.
    Lacks(OptionalFeature),
    /// Flags of fragment shaders are [distrusted](crate::RendererOptions::disabled): they may be
    /// written where the depth test fails, or get lost.
    DriverQuirk,
    /// A pixel has several samples, each of which may be covered by other fragments.
    SeveralSamples,
    /// The lists of all pixels do not fit into a storage buffer of the device.
    TooManyPixels,
}

impl fmt::Display for TransparencyFallback {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lacks(missing) => write!(formatter, "the device lacks {}", missing.name()),
            Self::DriverQuirk => {
                formatter.write_str("what fragment shaders of the driver write is not trusted")
            }
            Self::SeveralSamples => formatter.write_str("a pixel has several samples"),
            Self::TooManyPixels => formatter.write_str("the image has too many pixels"),
        }
    }
}

/// Returns the options that a driver can be trusted with: storing fragments has the same needs as
/// flags.
pub(crate) fn usable_transparency(
    quirks: &DriverQuirks,
    wanted: TransparencyOptions,
) -> TransparencyOptions {
    if quirks.allows(VisibilityTest::Flag) {
        wanted
    } else {
        TransparencyOptions { method: TransparencyMethod::SortedObjects, ..wanted }
    }
}

/// Returns the reason why a device cannot sort fragments of images with this number of samples per
/// pixel, independent of their size.
pub(crate) fn fallback_of(
    device: &Device,
    samples: vk::SampleCountFlags,
) -> Option<TransparencyFallback> {
    let needs = [OptionalFeature::FragmentStores, OptionalFeature::SectionBuffers];
    let lacks = |needed: &OptionalFeature| !device.capabilities().has(*needed);
    match needs.into_iter().find(lacks) {
        Some(missing) => Some(TransparencyFallback::Lacks(missing)),
        None if samples != vk::SampleCountFlags::TYPE_1 => {
            Some(TransparencyFallback::SeveralSamples)
        }
        None => None,
    }
}
