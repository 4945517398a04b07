//! The ways in which transparent objects are blended, and what a device needs for them.

use std::fmt;

use cull::VisibilityTest;
use gpu::{Device, OptionalFeature, vk};
use occlusion::DriverQuirks;

/// The order in which transparent objects are blended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TransparencyMethod {
    /// By objects, the farthest first. Objects that pass through each other have one order for all
    /// of their pixels, which is wrong for some.
    #[default]
    SortedObjects,
    /// By fragments: each pixel has a list of them, which is sorted by depth. Exact for whatever
    /// passes through each other, and the same in any order of objects.
    SortedFragments,
}

impl TransparencyMethod {
    /// Returns the name shown to the user.
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
    /// The order that is wanted. A device that lacks something for it sorts objects
    /// ([`Renderer::transparency_fallback`](crate::Renderer::transparency_fallback)).
    pub method: TransparencyMethod,
    /// Room for fragments, as many per pixel of the image on average: 16 bytes each, at most what
    /// a storage buffer of the device holds. Fragments without room are not blended, and are
    /// counted ([`FragmentCounts::without_room`]).
    pub fragments_per_pixel: u32,
    /// The most fragments that are blended at a pixel, the nearest ones; at least 1. Those behind
    /// them are counted ([`FragmentCounts::left_out`]).
    pub blended_most: u32,
}

impl Default for TransparencyOptions {
    fn default() -> Self {
        Self { method: TransparencyMethod::default(), fragments_per_pixel: 4, blended_most: 64 }
    }
}

/// The fragments of transparent objects in a frame, of all its views together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FragmentCounts {
    /// Fragments that nothing opaque hides.
    pub visible: u32,
    /// Those of them that found no room: which ones is a matter of chance, and the image is wrong
    /// where they are.
    pub without_room: u32,
    /// Those of them behind [`TransparencyOptions::blended_most`] others of their pixel, where
    /// these let light through.
    pub left_out: u32,
}

impl FragmentCounts {
    /// Returns true if every fragment that shows was blended.
    pub fn is_exact(&self) -> bool {
        self.without_room == 0 && self.left_out == 0
    }
}

/// The reason why objects are sorted though sorted fragments were wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransparencyFallback {
    /// The device lacks something.
    Lacks(OptionalFeature),
    /// Flags of fragment shaders are [distrusted](crate::RendererOptions::disabled): they may be
    /// written where the depth test fails, or be lost.
    DriverQuirk,
    /// A pixel has several samples, each of which may be covered by other fragments.
    SeveralSamples,
    /// The lists of so many pixels do not fit into a storage buffer of the device.
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

/// Returns the options that a driver is trusted with: fragments are stored where flags would be.
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

/// Returns the reason why a device cannot sort fragments of images with so many samples per pixel,
/// whatever their size.
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
