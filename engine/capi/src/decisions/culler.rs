//! Cullers: the decisions of one view.

use cull::{CullConfig, Culler, DrawPhases, FramePlan, Hierarchy, Strategy, TesterSupport, View};

use super::camera::AntumbraCamera;
use super::plan::{AntumbraAnswer, AntumbraFramePlan, PlanArrays};
use crate::error::Failure;
use crate::layout::{Versioned, layout};
use crate::table::handle;

/// The culler of one view of one hierarchy, with what it knows from earlier frames.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraCuller {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraCuller = "culler");

/// Tests by flags that fragments set: they take no queries.
pub const ANTUMBRA_HAS_FLAGS: u32 = 1;
/// Tests by a compute shader that reads the depth buffer.
pub const ANTUMBRA_HAS_COMPUTE: u32 = 2;

/// Everything in the view frustum is drawn, nothing is tested: the reference.
pub const ANTUMBRA_STRATEGY_FRUSTUM: u32 = 0;
/// Late answers, made exact by tests in the same frame.
pub const ANTUMBRA_STRATEGY_ANTUMBRA: u32 = 1;

/// The options of a culler.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraCullerDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The ways to test boxes that the host has besides occlusion queries: `ANTUMBRA_HAS_..`.
    /// Default: 0.
    pub testers: u32,
    /// The most samples with which a box or an object counts as hidden. Above 0 the image is not
    /// exact, and all tests are queries that count. Default: 0.
    pub sample_threshold: u32,
    /// Must be 0.
    pub reserved: u32,
    /// The seed of the random intervals between tests; equal seeds and inputs make equal plans.
    /// Default: 0.
    pub seed: u64,
}
layout!(AntumbraCullerDesc: struct_size, testers, sample_threshold, reserved, seed);

// SAFETY: the first field is the size.
unsafe impl Versioned for AntumbraCullerDesc {
    const REQUIRED_FIELDS: usize = 1;
    const DEFAULT: Self = Self {
        struct_size: size_of::<Self>() as u32,
        testers: 0,
        sample_threshold: 0,
        reserved: 0,
        seed: 0,
    };
}

/// The input of a plan.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraPlanDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// An `ANTUMBRA_STRATEGY_..`.
    pub strategy: u32,
    /// The camera.
    pub camera: *const AntumbraCamera,
    /// The most occlusion queries of the plan; leaves for which none is left are drawn. Default:
    /// 4096.
    pub query_budget: usize,
}
layout!(AntumbraPlanDesc: struct_size, strategy, camera, query_budget);

// SAFETY: the first field is the size.
unsafe impl Versioned for AntumbraPlanDesc {
    const REQUIRED_FIELDS: usize = 3;
    const DEFAULT: Self = Self {
        struct_size: size_of::<Self>() as u32,
        strategy: ANTUMBRA_STRATEGY_ANTUMBRA,
        camera: std::ptr::null(),
        query_budget: 4096,
    };
}

/// A culler and the plan that C reads.
pub(crate) struct ViewCuller {
    culler: Culler,
    plan: FramePlan,
    arrays: PlanArrays,
}

impl ViewCuller {
    pub fn new(desc: &AntumbraCullerDesc) -> Result<Self, Failure> {
        let AntumbraCullerDesc { testers, sample_threshold, reserved, seed, .. } = *desc;
        if testers & !(ANTUMBRA_HAS_FLAGS | ANTUMBRA_HAS_COMPUTE) != 0 || reserved != 0 {
            let message = "desc.testers has ANTUMBRA_HAS_.. alone, and desc.reserved is 0";
            return Err(Failure::argument(message));
        }
        let support = TesterSupport {
            queries: true,
            flags: testers & ANTUMBRA_HAS_FLAGS != 0,
            compute: testers & ANTUMBRA_HAS_COMPUTE != 0,
            // A plan would have boxes of leaves that the plan does not list.
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

    /// Takes answers, or none of them if one is none.
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

    /// Plans a frame, and returns the plan with pointers into this.
    pub fn plan(
        &mut self,
        hierarchy: &Hierarchy,
        strategy: Strategy,
        view: &View,
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
