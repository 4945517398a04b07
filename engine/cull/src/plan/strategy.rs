//! The strategies to decide what to draw, by name.

use std::fmt;

use crate::plan::frame_plan::VisibilityTest;

/// A strategy to decide what to draw: its name and its properties. Strategies can be switched from
/// frame to frame. The strategies that a [`Culler`](crate::Culler) plans are constants of this
/// type; the others are [created](Strategy::new) next to the methods that execute them.
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
    /// Any tester that the device has, or the cheapest of them.
    Any,
    By(VisibilityTest),
}

impl Strategy {
    /// View-frustum culling only: the baseline and the reference image.
    pub const FRUSTUM: Self =
        Self::new("frustum", "the baseline: all that is in the view frustum").drawing_occluded();
    /// Coherent hierarchical culling with late results, made exact by predicates.
    pub const ANTUMBRA: Self =
        Self::new("antumbra", "ours: late answers, made exact by predicates")
            .testing(Tests::Any)
            .with_sample_threshold();
    /// [`Strategy::ANTUMBRA`] with occlusion queries for all tests.
    pub const ANTUMBRA_QUERIES: Self =
        Self::new("antumbra_queries", "ours, with occlusion queries for all tests")
            .testing(Tests::By(VisibilityTest::Query))
            .with_sample_threshold();
    /// [`Strategy::ANTUMBRA`] with flags set by fragments for all tests.
    pub const ANTUMBRA_FLAGS: Self =
        Self::new("antumbra_flags", "ours, with flags set by fragments for all tests")
            .testing(Tests::By(VisibilityTest::Flag));
    /// [`Strategy::ANTUMBRA`] with a compute shader for all tests.
    pub const ANTUMBRA_COMPUTE: Self =
        Self::new("antumbra_compute", "ours, with a compute shader for all tests")
            .testing(Tests::By(VisibilityTest::Compute));

    /// The strategies of [`Culler::plan`](crate::Culler::plan), the baseline first. All strategies
    /// named `antumbra...` share one traversal and one history.
    pub const PLANNED: [Self; 5] = [
        Self::FRUSTUM,
        Self::ANTUMBRA,
        Self::ANTUMBRA_QUERIES,
        Self::ANTUMBRA_FLAGS,
        Self::ANTUMBRA_COMPUTE,
    ];

    /// Creates a strategy with its name on command lines and in reports, and a summary of about
    /// fifty letters. It culls occluded objects, is exact, never waits, and works in changing
    /// scenes, unless a method below marks it otherwise.
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

    /// Returns the same strategy, marked as one that also draws occluded objects.
    #[must_use]
    pub const fn drawing_occluded(self) -> Self {
        Self { culls_occluded: false, ..self }
    }

    /// Returns the same strategy, marked as one that may miss a visible object.
    #[must_use]
    pub const fn inexact(self) -> Self {
        Self { is_exact: false, ..self }
    }

    /// Returns the same strategy, marked as one that must wait for results within a frame.
    #[must_use]
    pub const fn blocking(self) -> Self {
        Self { is_blocking: true, ..self }
    }

    /// Returns the same strategy, marked as one that supports a sample threshold.
    #[must_use]
    pub const fn with_sample_threshold(self) -> Self {
        Self { has_sample_threshold: true, ..self }
    }

    /// Returns the same strategy, marked as one that draws objects found visible beforehand.
    #[must_use]
    pub const fn in_still_scenes(self) -> Self {
        Self { needs_still_scene: true, ..self }
    }

    /// Returns the same strategy, marked as one whose decisions the GPU makes.
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

    /// Returns true if it never misses a visible object, so that its image is the image of plain
    /// frustum culling. Two options give exactness up: a threshold, if it is
    /// [supported](Strategy::has_sample_threshold), and
    /// [`FirstPass::DepthOnly`](crate::FirstPass::DepthOnly) of coherent hierarchical culling, with
    /// which some devices choose another of two faces of equal depth.
    #[must_use]
    pub const fn is_exact(self) -> bool {
        self.is_exact
    }

    /// Returns true if it does not draw objects that others hide.
    #[must_use]
    pub const fn culls_occluded(self) -> bool {
        self.culls_occluded
    }

    /// Returns true if it has a history, tests in its plans and a [cost
    /// model](crate::Culler::set_costs), as all strategies named `antumbra...` have.
    #[must_use]
    pub const fn uses_cost_model(self) -> bool {
        !matches!(self.tests, Tests::None)
    }

    /// Returns true if it can treat objects that show few samples as hidden, which makes it inexact
    /// ([`Culler::set_sample_threshold`](crate::Culler::set_sample_threshold),
    /// [`ChcOptions`](crate::ChcOptions)).
    #[must_use]
    pub const fn has_sample_threshold(self) -> bool {
        self.has_sample_threshold
    }

    /// Returns true if it draws objects that were found visible beforehand, in a still scene.
    #[must_use]
    pub const fn needs_still_scene(self) -> bool {
        self.needs_still_scene
    }

    /// Returns true if only the GPU knows what was drawn, so that no frame can be explained.
    #[must_use]
    pub const fn is_gpu_driven(self) -> bool {
        self.is_gpu_driven
    }

    /// Returns true if it must wait for results within a frame: a
    /// [`BlockingCuller`](crate::BlockingCuller) executes it, not a plan.
    #[must_use]
    pub const fn is_blocking(self) -> bool {
        self.is_blocking
    }

    /// Returns the only tester of its plans; `None` if any tester will do or nothing is tested.
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
