//! The costs of a device, and what is decided by them before the first frame: the way that hidden
//! draws are skipped, and with it the costs by which tests are weighed.

use cull::{
    CostTable, Culler, LearnedCosts, MeasuredSkip, SceneCosts, SkippedWork, VisibilityTest,
    VisibilityTestSupport,
};
use gpu::PredicationMode;

/// The source of costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CostModel {
    /// No costs: everything that may be hidden is tested.
    Off,
    /// The given table; the default is the built-in one. The predication mode is the device's usual
    /// one.
    Table(CostTable),
    /// Costs that are measured when the renderer is made, which takes half a second on a software
    /// driver. They also choose the predication mode.
    Measured,
}

impl Default for CostModel {
    /// Returns the built-in table, which needs no measurement.
    fn default() -> Self {
        Self::Table(CostTable::default())
    }
}

/// The measured costs of a device.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DeviceCosts {
    /// The costs of tests and draws, apart from those of the executor.
    pub table: CostTable,
    /// The costs of each executor that may be used, in the order of preference.
    pub executors: Vec<(PredicationMode, MeasuredSkip)>,
    /// The time of the reset of a query by a command on the GPU, and by the CPU (nanoseconds); NaN
    /// where that is not possible.
    pub reset_ns: QueryResetCosts,
}

/// The costs of the reset of a query (nanoseconds).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QueryResetCosts {
    /// The GPU time of a reset by a command.
    pub command_ns: f32,
    /// The CPU time of a reset by the CPU.
    pub cpu_ns: f32,
}

impl Default for QueryResetCosts {
    fn default() -> Self {
        Self { command_ns: f32::NAN, cpu_ns: f32::NAN }
    }
}

/// The decisions about a device and a scene before the first frame.
#[derive(Debug, Clone, PartialEq)]
pub struct CullingSetup {
    /// The way that hidden draws are skipped.
    pub predication: PredicationMode,
    /// The costs that decide about tests; `None` where costs are ignored.
    pub table: Option<CostTable>,
    /// The expected time of skipping in a frame by each executor (nanoseconds); empty where none
    /// was measured.
    pub skip_ns: Vec<(PredicationMode, f64)>,
    /// The measured costs of resets.
    pub reset_ns: QueryResetCosts,
}

/// A scene on a device, for which is decided.
#[derive(Debug, Clone, Copy)]
pub struct ChoiceRequest<'a> {
    /// The executors that may be used, in the order of preference; the first is the device's usual
    /// one. Costs of others are left aside.
    pub executors: &'a [PredicationMode],
    /// The work of a frame of the scene.
    pub work: SkippedWork,
}

impl CullingSetup {
    /// Decides by costs, which `measure` measures if that is asked for. If it returns `None`, the
    /// costs could not be measured, and the built-in table decides.
    ///
    /// # Errors
    /// That of `measure`.
    pub fn by<E>(
        cost_model: CostModel,
        request: &ChoiceRequest<'_>,
        measure: impl FnOnce() -> Result<Option<DeviceCosts>, E>,
    ) -> Result<Self, E> {
        Ok(match cost_model {
            CostModel::Off => Self::usual(request, None),
            CostModel::Table(table) => Self::usual(request, Some(checked(table))),
            CostModel::Measured => match measure()? {
                Some(device_costs) => Self::of_costs(request, &device_costs),
                None => Self::usual(request, Some(CostTable::default())),
            },
        })
    }

    /// Decides by costs that were measured before, on this device.
    pub fn of_costs(request: &ChoiceRequest<'_>, device_costs: &DeviceCosts) -> Self {
        let of = |wanted| device_costs.executors.iter().find(|(known, _)| known == wanted).cloned();
        let (usable, skips): (Vec<_>, Vec<_>) = request.executors.iter().filter_map(of).unzip();
        let frame_ns = |skip: &MeasuredSkip| skip.costs.frame_ns(&request.work);
        let cheapest = MeasuredSkip::cheapest(&skips, &request.work)
            .and_then(|place| Some((*usable.get(place)?, skips.get(place)?)))
            .filter(|(_, skip)| frame_ns(skip).is_finite());
        let Some((predication, skip)) = cheapest else {
            let table = Some(checked(device_costs.table));
            return Self { reset_ns: device_costs.reset_ns, ..Self::usual(request, table) };
        };
        Self {
            predication,
            table: Some(checked(device_costs.table.skipping_at(&skip.costs))),
            skip_ns: usable.into_iter().zip(skips.iter().map(frame_ns)).collect(),
            reset_ns: device_costs.reset_ns,
        }
    }

    /// Takes the executor that is usual.
    pub(crate) fn usual(request: &ChoiceRequest<'_>, table: Option<CostTable>) -> Self {
        Self {
            predication: request.executors.first().copied().unwrap_or(PredicationMode::Instances),
            table,
            skip_ns: Vec::new(),
            reset_ns: QueryResetCosts::default(),
        }
    }

    /// Returns the tester that is expected to cost least in a frame of this work, on an image of
    /// this size in pixels; without costs flags, where there are any, else the one that is left.
    /// [`Strategy::ANTUMBRA`](cull::Strategy::ANTUMBRA) decides again for the boxes of each frame.
    pub fn tester(
        &self,
        work: &SkippedWork,
        size: [u32; 2],
        testers: VisibilityTestSupport,
    ) -> VisibilityTest {
        let usual = match testers {
            VisibilityTestSupport { flags: true, .. } => VisibilityTest::Flag,
            VisibilityTestSupport { queries: false, compute: true, .. } => VisibilityTest::Compute,
            _ => VisibilityTest::Query,
        };
        let model =
            self.table.and_then(|table| LearnedCosts::new(table, SceneCosts::default()).ok());
        model.map_or(usual, |model| model.tester_for(work, size, testers))
    }

    /// Lets the culler of a view weigh tests of a scene by these costs, if there are any.
    pub fn steer(&self, culler: &mut Culler, scene: SceneCosts) {
        if let Some(Err(error)) = self.table.map(|table| culler.set_costs(table, scene)) {
            tracing::warn!("{error}");
        }
    }
}

/// Returns a table without impossible costs.
fn checked(table: CostTable) -> CostTable {
    table.checked().unwrap_or_else(|error| {
        tracing::warn!("{error}");
        CostTable::default()
    })
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use cull::PredicationCosts;

    use super::*;

    const EXECUTORS: [PredicationMode; 2] =
        [PredicationMode::Conditional, PredicationMode::Compacted];

    const WORK: SkippedWork = SkippedWork { rounds: 3, ranges: 200, draws: 10_000 };

    const REQUEST: ChoiceRequest<'_> = ChoiceRequest { executors: &EXECUTORS, work: WORK };

    fn device_costs(conditional_ns: f32, compacted_ns: f32) -> DeviceCosts {
        let at = |range_ns| {
            let costs = PredicationCosts { range_ns, round_ns: 9.0, draw_ns: 0.0 };
            MeasuredSkip { costs, rounds: vec![costs; 4] }
        };
        let executors = EXECUTORS.into_iter().zip([at(conditional_ns), at(compacted_ns)]).collect();
        DeviceCosts { executors, ..DeviceCosts::default() }
    }

    fn choice(device_costs: DeviceCosts) -> CullingSetup {
        let measured = || Ok::<_, Infallible>(Some(device_costs));
        CullingSetup::by(CostModel::Measured, &REQUEST, measured).unwrap()
    }

    #[test]
    fn a_dear_predicate_gives_way_and_its_cost_steers_tests() {
        assert_eq!(choice(device_costs(50.0, 60.0)).predication, PredicationMode::Conditional);
        let dear = choice(device_costs(5_000.0, 60.0));
        assert_eq!(dear.predication, PredicationMode::Compacted);
        let table = dear.table.unwrap();
        assert_eq!((table.predicate_ns, table.break_ns), (60.0, 150_009.0));
        assert_eq!(dear.skip_ns[0], (PredicationMode::Conditional, 27.0 + 1.0e6));
    }

    #[test]
    fn without_costs_the_usual_executor_and_flags_are_taken() {
        let failed = || Ok::<_, Infallible>(None);
        for costs in [CostModel::Off, CostModel::Table(CostTable::default()), CostModel::Measured] {
            let choice = CullingSetup::by(costs, &REQUEST, failed).unwrap();
            assert_eq!(choice.predication, PredicationMode::Conditional);
            assert_eq!(choice.table.is_none(), costs == CostModel::Off);
            assert!(choice.skip_ns.is_empty());
        }
        let ignored = CullingSetup::by(CostModel::Off, &REQUEST, failed).unwrap();
        let flags = VisibilityTestSupport { flags: true, ..VisibilityTestSupport::default() };
        let tester = |testers| ignored.tester(&WORK, [1280, 720], testers);
        assert_eq!(tester(flags), VisibilityTest::Flag);
        assert_eq!(tester(VisibilityTestSupport::default()), VisibilityTest::Query);
        let computed = VisibilityTestSupport {
            queries: false,
            compute: true,
            ..VisibilityTestSupport::default()
        };
        assert_eq!(tester(computed), VisibilityTest::Compute);
        let request = ChoiceRequest { executors: &[], ..REQUEST };
        let choice = CullingSetup::by(CostModel::Off, &request, failed).unwrap();
        assert_eq!(choice.predication, PredicationMode::Instances);
    }

    #[test]
    fn an_executor_that_may_not_be_used_is_not_chosen_at_any_cost() {
        let device_costs = device_costs(5_000.0, 60.0);
        for (executors, expected) in [
            (&EXECUTORS[..], PredicationMode::Compacted),
            (&EXECUTORS[..1], PredicationMode::Conditional),
            (&[PredicationMode::Counts], PredicationMode::Counts),
        ] {
            let choice =
                CullingSetup::of_costs(&ChoiceRequest { executors, ..REQUEST }, &device_costs);
            assert_eq!(choice.predication, expected);
            assert!(choice.skip_ns.iter().all(|(executor, _)| executors.contains(executor)));
            assert!(choice.table.is_some());
        }
    }

    #[test]
    fn an_impossible_table_is_replaced() {
        let nan = CostTable::uniform(f32::NAN);
        let failed = || Ok::<_, Infallible>(None);
        let choice = CullingSetup::by(CostModel::Table(nan), &REQUEST, failed).unwrap();
        assert_eq!(choice.table, Some(CostTable::default()));
        let broken = choice_of_broken_clock();
        assert_eq!(broken.predication, PredicationMode::Conditional);
        assert_eq!(broken.table, Some(CostTable::default()));
    }

    fn choice_of_broken_clock() -> CullingSetup {
        choice(device_costs(f32::NAN, f32::NAN))
    }
}
