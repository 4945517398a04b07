//! Predicated ranges: the source of a result, the draws that depend on it, and the executors that
//! skip these draws.

use crate::core::capabilities::{Capabilities, OptionalFeature};
use crate::core::device::Device;
use crate::core::error::Error;
use crate::memory::buffer::BufferSlice;
use crate::record::access::Access;
use crate::record::indirect::DrawRange;

/// The writer of the results on which draws depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ResultSource {
    /// The copies of query results.
    Queries,
    /// Fragment shaders of proxies.
    Fragments,
    /// A compute shader.
    Compute,
}

impl ResultSource {
    /// All sources, in the order of their lists of predicates.
    pub const ALL: [ResultSource; 3] =
        [ResultSource::Queries, ResultSource::Fragments, ResultSource::Compute];

    /// Returns the access that writes the results.
    pub fn access(self) -> Access {
        match self {
            ResultSource::Queries => Access::CopyWrite,
            ResultSource::Fragments => Access::FragmentWrite,
            ResultSource::Compute => Access::ComputeWrite,
        }
    }
}

/// The effect of a non-zero result on its range. The order mirrors `predicate.glsl`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Reveal {
    /// The whole range is drawn ([`Predicates::draw`](crate::Predicates::draw)).
    #[default]
    Draws,
    /// A box per leaf of the range is drawn
    /// ([`Predicates::draw_boxes`](crate::Predicates::draw_boxes)). Its fragments enable the draws
    /// of the leaf.
    Boxes,
    /// The draws of the range that fragments of boxes enabled are drawn
    /// ([`Predicates::draw_enabled`](crate::Predicates::draw_enabled)).
    EnabledDraws,
}

/// A range of draws or boxes that depends on a result. Several ranges may depend on one result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PredicatedRange {
    /// The index of the result among the results of its source.
    pub result: u32,
    /// The draws that depend on the result, or the leaves whose boxes depend on it.
    pub range: DrawRange,
    /// The effect of a non-zero result.
    pub reveal: Reveal,
}

/// The result on which a range of leaves depends, for a compute shader that processes only these
/// leaves: they may be drawn if the result is above the threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicate {
    /// The results of the source.
    pub results: BufferSlice,
    /// The index of the result in `results`.
    pub result: u32,
    /// The number of samples that a result must exceed.
    pub threshold_samples: u32,
    /// The leaves that depend on the result.
    pub leaves: DrawRange,
}

/// The executor that keeps the GPU from drawing hidden objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PredicationMode {
    /// `VK_EXT_conditional_rendering`: the GPU skips the draws without a compute pass.
    Conditional,
    /// Draw counts written by a compute pass; needs `drawIndirectCount`.
    Counts,
    /// Instance counts written by a compute pass; works on every device.
    Instances,
    /// [`PredicationMode::Counts`], and in addition the executor of plans copies the draws that a
    /// round reveals into one list per pipeline, in order. One call draws a list. Needs
    /// `drawIndirectCount`.
    Compacted,
}

impl PredicationMode {
    /// All executors.
    pub const ALL: [PredicationMode; 4] = [
        PredicationMode::Conditional,
        PredicationMode::Counts,
        PredicationMode::Instances,
        PredicationMode::Compacted,
    ];

    /// Returns the best executor for a device.
    pub fn best(capabilities: &Capabilities) -> Self {
        if capabilities.has(OptionalFeature::ConditionalRendering) {
            PredicationMode::Conditional
        } else if capabilities.has(OptionalFeature::DrawIndirectCount) {
            PredicationMode::Counts
        } else {
            PredicationMode::Instances
        }
    }

    /// Returns the name of the executor on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            PredicationMode::Conditional => "conditional",
            PredicationMode::Counts => "counts",
            PredicationMode::Instances => "instances",
            PredicationMode::Compacted => "compacted",
        }
    }

    /// Returns true if draws use a count that a compute pass wrote.
    pub(super) fn is_counted(self) -> bool {
        matches!(self, PredicationMode::Counts | PredicationMode::Compacted)
    }

    /// Returns the executor for `draws` draws: `wanted`, or otherwise the best of the device for
    /// this number. The number is limited as a whole, because any range may become one call with a
    /// draw count. With a threshold above 0 the executor must be able to compare: query results up
    /// to `threshold_samples` count as zero ([`Predicates::resolve`](crate::Predicates::resolve)).
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device lacks a feature of `wanted`, or precise queries for a
    /// threshold above 0; [`Error::TooLarge`] for more draws than a draw count can hold;
    /// [`Error::CannotCompare`] for conditional rendering with a threshold above 0.
    pub fn choose(
        device: &Device,
        wanted: Option<PredicationMode>,
        draws: u64,
        threshold_samples: u32,
    ) -> Result<PredicationMode, Error> {
        let capabilities = device.capabilities();
        let compares = threshold_samples > 0;
        if compares && wanted == Some(PredicationMode::Conditional) {
            return Err(Error::CannotCompare { threshold_samples });
        }
        if compares {
            device.require(OptionalFeature::PreciseQueries, "a visibility threshold")?;
        }
        let limit = u64::from(device.adapter().limits.max_draw_indirect_count);
        let is_too_much = |predication: PredicationMode| predication.is_counted() && draws > limit;
        let Some(wanted) = wanted else {
            let best = match PredicationMode::best(capabilities) {
                PredicationMode::Conditional if compares => {
                    if capabilities.has(OptionalFeature::DrawIndirectCount) {
                        PredicationMode::Counts
                    } else {
                        PredicationMode::Instances
                    }
                }
                best => best,
            };
            return Ok(if is_too_much(best) { PredicationMode::Instances } else { best });
        };
        if let Some(needed) = wanted.needs() {
            device.require(needed, "this way to skip hidden draws")?;
        }
        if is_too_much(wanted) {
            let what = "the number of draws under draw counts".to_owned();
            return Err(Error::TooLarge { what, wanted: draws, limit });
        }
        Ok(wanted)
    }

    /// Returns true if the device supports the executor, for some number of draws.
    pub fn is_supported(self, device: &Device) -> bool {
        self.needs().is_none_or(|optional| device.capabilities().has(optional))
    }

    fn needs(self) -> Option<OptionalFeature> {
        match self {
            PredicationMode::Conditional => Some(OptionalFeature::ConditionalRendering),
            PredicationMode::Counts | PredicationMode::Compacted => {
                Some(OptionalFeature::DrawIndirectCount)
            }
            PredicationMode::Instances => None,
        }
    }
}
