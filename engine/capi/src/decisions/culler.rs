//! Cullers: the decisions of one view.

use cull::{
    CullConfig, CullView, Culler, DrawPhases, FramePlan, Hierarchy, Strategy, VisibilityTestSupport,
};

use super::camera::AntumbraCamera;
use super::plan::{AntumbraAnswer, AntumbraFramePlan, PlanArrays};
use crate::error::Failure;
use crate::layout::{layout, versioned};
use crate::table::handle;

/// The culler of one view of one hierarchy, with its history of earlier frames.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraCuller {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraCuller = "culler");

/// The host can test by flags that fragments set. These tests take no queries.
pub const ANTUMBRA_HAS_FLAGS: u32 = 1;
/// The host can test by a compute shader that reads the depth buffer.
pub const ANTUMBRA_HAS_COMPUTE: u32 = 2;

/// Answers of earlier frames decide what is drawn first; tests in the same frame make it exact.
pub const ANTUMBRA_STRATEGY_ANTUMBRA: u32 = 0;
/// Everything in the view frustum is drawn, nothing is tested: the reference.
pub const ANTUMBRA_STRATEGY_FRUSTUM: u32 = 1;

/// A budget of no occlusion queries: leaves that no other tester tests are drawn. `cbindgen.toml`
/// declares it, since cbindgen leaves out constants of this type.
pub const ANTUMBRA_NO_QUERIES: usize = usize::MAX;

/// The occlusion queries of a plan whose budget is 0 (`AntumbraPlanDesc::query_budget`).
pub(crate) const QUERY_BUDGET: usize = 4096;

/// Returns the number of queries that a budget other than 0 stands for.
pub(crate) fn queries(budget: usize) -> usize {
    if budget == ANTUMBRA_NO_QUERIES { 0 } else { budget }
}

/// The options of a culler.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraCullerDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The testers that the host has besides occlusion queries: a set of `ANTUMBRA_HAS_..`.
    /// Default: 0, none.
    pub testers: u32,
    /// A box or an object counts as hidden if at most this number of samples pass. Above 0 the
    /// image is not exact, and all tests are precise occlusion queries. Any number. Default: 0.
    pub sample_threshold: u32,
    /// Must be 0.
    pub reserved: u32,
    /// The seed of the random intervals between tests; equal seeds and inputs make equal plans. Any
    /// number. Default: 0.
    pub seed: u64,
}
layout!(AntumbraCullerDesc: struct_size, testers, sample_threshold, reserved, seed);

versioned!(AntumbraCullerDesc: 1, required: [], defaults: {});

/// The input of a plan.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraPlanDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// An `ANTUMBRA_STRATEGY_..`. Default: `ANTUMBRA_STRATEGY_ANTUMBRA`.
    pub strategy: u32,
    /// Required: the camera.
    pub camera: *const AntumbraCamera,
    /// The most occlusion queries of the plan, any number, or `ANTUMBRA_NO_QUERIES`. Leaves for
    /// which no query is left are drawn. Default: 4096.
    pub query_budget: usize,
}
layout!(AntumbraPlanDesc: struct_size, strategy, camera, query_budget);

versioned!(AntumbraPlanDesc: 3, required: [camera], defaults: { query_budget: QUERY_BUDGET });

/// A culler and the plan that C reads.
pub(crate) struct ViewCuller {
    culler: Culler,
    plan: FramePlan,
    arrays: PlanArrays,
}

impl ViewCuller {
    pub fn new(desc: &AntumbraCullerDesc) -> Result<Self, Failure> {
        let AntumbraCullerDesc { testers, sample_threshold, seed, .. } = *desc;
        if testers & !(ANTUMBRA_HAS_FLAGS | ANTUMBRA_HAS_COMPUTE) != 0 {
            let message = "desc.testers has other bits than those of ANTUMBRA_HAS_..";
            return Err(Failure::argument(message));
        }
        let support = VisibilityTestSupport {
            queries: true,
            flags: testers & ANTUMBRA_HAS_FLAGS != 0,
            compute: testers & ANTUMBRA_HAS_COMPUTE != 0,
            // Tests by leaf need the boxes of leaves, which a plan for C does not contain.
            leaf_tests: false,
            draw_phases: DrawPhases::PerRound,
        };
        let mut culler = Culler::with_testers(CullConfig { seed, ..Default::default() }, support);
        culler.set_sample_threshold(sample_threshold);
        Ok(Self { culler, plan: FramePlan::default(), arrays: PlanArrays::default() })
    }

    pub fn reset(&mut self) {
        self.culler.reset();
    }

    /// Takes answers. If one of them is invalid, returns an error and takes no answer.
    pub fn ingest(
        &mut self,
        hierarchy: &Hierarchy,
        answers: &[AntumbraAnswer],
    ) -> Result<(), Failure> {
        for (number, answer) in answers.iter().enumerate() {
            answer.checked(number)?;
        }
        let answers = answers.iter().enumerate();
        let answers = answers.filter_map(|(number, answer)| answer.checked(number).ok());
        self.culler.ingest(hierarchy, answers);
        Ok(())
    }

    /// Plans a frame, and returns the plan with pointers into `self`.
    pub fn plan(
        &mut self,
        hierarchy: &Hierarchy,
        strategy: Strategy,
        view: &CullView,
        query_budget: usize,
    ) -> AntumbraFramePlan {
        let Self { culler, plan, arrays } = self;
        culler.plan(hierarchy, strategy, view, query_budget, plan);
        arrays.fill(hierarchy, plan);
        arrays.frame_plan(plan)
    }
}

/// Returns a strategy by its number in C.
pub(crate) fn strategy(number: u32) -> Result<Strategy, Failure> {
    match number {
        ANTUMBRA_STRATEGY_FRUSTUM => Ok(Strategy::FRUSTUM),
        ANTUMBRA_STRATEGY_ANTUMBRA => Ok(Strategy::ANTUMBRA),
        _ => Err(Failure::argument(format_args!("there is no ANTUMBRA_STRATEGY_.. {number}"))),
    }
}
