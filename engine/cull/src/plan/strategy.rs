//! The strategies to decide what to draw, by name.

use std::fmt;

use crate::plan::frame_plan::VisibilityTest;

/// A strategy to decide what to draw: a name, and what to expect of it. Strategies can be switched
/// from frame to frame. Those that a [`Culler`](crate::Culler) plans are constants here; any other
/// is [made](Strategy::new) beside the method that carries it out.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Strategy {
    name: &'static str,
    summary: &'static str,
    tests: Tests,
    culls_occluded: bool,
    is_exact: bool,
    is_blocking: bool,
    has_sample_threshold: bool,
    needs_still_scene: bool,
    is_gpu_driven: bool,
}

impl Default for Strategy {
    /// Returns [`Strategy::ANTUMBRA`].
    fn default() -> Self {
        Self::ANTUMBRA
    }
}

/// The tests in the plans of a strategy.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Tests {
    None,
    /// By the tester that the device has, or by the cheapest.
    Any,
    By(VisibilityTest),
}

impl Strategy {
    /// View-frustum culling only: the baseline and the reference image.
    pub const FRUSTUM: Self =
        Self::new("frustum", "the baseline: all that is in the view frustum").drawing_occluded();
    /// Coherent hierarchical culling whose results come late, made exact by predicates.
    pub const ANTUMBRA: Self =
        Self::new("antumbra", "ours: late answers, made exact by predicates")
            .testing(Tests::Any)
            .with_sample_threshold();
    /// The same with occlusion queries for all tests.
    pub const ANTUMBRA_QUERIES: Self =
        Self::new("antumbra_queries", "ours, with occlusion queries for all tests")
            .testing(Tests::By(VisibilityTest::Query))
            .with_sample_threshold();
    /// The same with flags set by fragments for all tests.
    pub const ANTUMBRA_FLAGS: Self =
        Self::new("antumbra_flags", "ours, with flags set by fragments for all tests")
            .testing(Tests::By(VisibilityTest::Flag));
    /// The same with a compute shader for all tests.
    pub const ANTUMBRA_COMPUTE: Self =
        Self::new("antumbra_compute", "ours, with a compute shader for all tests")
            .testing(Tests::By(VisibilityTest::Compute));

    /// The strategies of [`Culler::plan`](crate::Culler::plan), the baseline first. Those called
    /// `antumbra` share one traversal and one history.
    pub const PLANNED: [Self; 5] = [
        Self::FRUSTUM,
        Self::ANTUMBRA,
        Self::ANTUMBRA_QUERIES,
        Self::ANTUMBRA_FLAGS,
        Self::ANTUMBRA_COMPUTE,
    ];

    /// Creates a strategy of this name on command lines and in reports, with a summary of about
    /// fifty letters. It leaves out occluded objects, is exact, never waits, and works in scenes
    /// that change, unless the following say otherwise.
    #[must_use]
    pub const fn new(name: &'static str, summary: &'static str) -> Self {
        Self {
            name,
            summary,
            tests: Tests::None,
            culls_occluded: true,
            is_exact: true,
            is_blocking: false,
            has_sample_threshold: false,
            needs_still_scene: false,
            is_gpu_driven: false,
        }
    }

    const fn testing(self, tests: Tests) -> Self {
        Self { tests, ..self }
    }

    /// Returns the same strategy, marked: it draws occluded objects, too.
    #[must_use]
    pub const fn drawing_occluded(self) -> Self {
        Self { culls_occluded: false, ..self }
    }

    /// Returns the same strategy, marked: it may miss an object that owns a pixel.
    #[must_use]
    pub const fn inexact(self) -> Self {
        Self { is_exact: false, ..self }
    }

    /// Returns the same strategy, which needs results before a frame can go on.
    #[must_use]
    pub const fn blocking(self) -> Self {
        Self { is_blocking: true, ..self }
    }

    /// Returns the same strategy, which can have a threshold.
    #[must_use]
    pub const fn with_sample_threshold(self) -> Self {
        Self { has_sample_threshold: true, ..self }
    }

    /// Returns the same strategy, marked: it draws objects that were found beforehand.
    #[must_use]
    pub const fn in_still_scenes(self) -> Self {
        Self { needs_still_scene: true, ..self }
    }

    /// Returns the same strategy, whose decisions the GPU makes.
    #[must_use]
    pub const fn gpu_driven(self) -> Self {
        Self { is_gpu_driven: true, ..self }
    }

    /// Returns the name on command lines and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.name
    }

    /// Returns a summary in a few words.
    #[must_use]
    pub const fn summary(self) -> &'static str {
        self.summary
    }

    /// Returns true if it never misses an object with a pixel, and has the image of plain frustum
    /// culling, unless an option gives that up: a threshold, if it [can have
    /// one](Strategy::has_sample_threshold), and
    /// [`FirstPass::DepthOnly`](crate::FirstPass::DepthOnly) of coherent hierarchical culling.
    /// Under the latter some devices choose another of two faces of equal depth.
    #[must_use]
    pub const fn is_exact(self) -> bool {
        self.is_exact
    }

    /// Returns true if it leaves out objects that others hide.
    #[must_use]
    pub const fn culls_occluded(self) -> bool {
        self.culls_occluded
    }

    /// Returns true if it has a history, tests in its plans and a [cost
    /// model](crate::Culler::set_costs): those called `antumbra`.
    #[must_use]
    pub const fn uses_cost_model(self) -> bool {
        !matches!(self.tests, Tests::None)
    }

    /// Returns true if it can take objects that show few samples as hidden, and is not exact then
    /// ([`Culler::set_sample_threshold`](crate::Culler::set_sample_threshold),
    /// [`ChcOptions`](crate::ChcOptions)).
    #[must_use]
    pub const fn has_sample_threshold(self) -> bool {
        self.has_sample_threshold
    }

    /// Returns true if it draws objects that were found beforehand, in a still scene.
    #[must_use]
    pub const fn needs_still_scene(self) -> bool {
        self.needs_still_scene
    }

    /// Returns true if the GPU alone knows what was drawn, so that no frame can be explained.
    #[must_use]
    pub const fn is_gpu_driven(self) -> bool {
        self.is_gpu_driven
    }

    /// Returns true if it needs results before a frame can go on: a
    /// [`BlockingCuller`](crate::BlockingCuller) and no plan.
    #[must_use]
    pub const fn is_blocking(self) -> bool {
        self.is_blocking
    }

    /// Returns the only tester of its plans; `None` for any, or where nothing is tested.
    pub(crate) const fn tester(self) -> Option<VisibilityTest> {
        match self.tests {
            Tests::By(tester) => Some(tester),
            Tests::None | Tests::Any => None,
        }
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name)
    }
}

impl fmt::Debug for Strategy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name)
    }
}
