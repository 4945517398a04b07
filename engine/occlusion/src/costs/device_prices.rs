//! The prices of a device, and what is decided by them before the first frame: the way that hidden
//! draws are skipped, and with it the prices by which tests are weighed.

use std::fmt::Display;

use cull::{
    CostModel, CostTable, Culler, MeasuredSkip, SceneCosts, SkippedWork, Tester, TesterSupport,
};
use gpu::Predication;

/// The source of prices.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Costs {
    /// No prices: everything that may be hidden is tested.
    Ignored,
    /// The given table. The way that hidden draws are skipped is the device's usual one.
    Table(CostTable),
    /// Prices that are measured when the renderer is made: half a second on a software driver.
    #[default]
    Measured,
}

/// The measured prices of a device.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DevicePrices {
    /// The prices of tests and draws, apart from those of the executor.
    pub table: CostTable,
    /// The prices of each executor that may be used, in the order of preference.
    pub executors: Vec<(Predication, MeasuredSkip)>,
    /// The time of the reset of a query by a command on the GPU, and by the CPU (nanoseconds); NaN
    /// where that is not possible.
    pub reset_ns: ResetPrices,
}

/// The prices of the reset of a query (nanoseconds).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResetPrices {
    /// By a command: GPU time.
    pub command_ns: f32,
    /// By the CPU: CPU time.
    pub cpu_ns: f32,
}

impl Default for ResetPrices {
    fn default() -> Self {
        Self { command_ns: f32::NAN, cpu_ns: f32::NAN }
    }
}

/// The decisions about a device and a scene before the first frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PriceChoice {
    /// The way that hidden draws are skipped.
    pub predication: Predication,
    /// The prices that decide about tests; `None` where costs are ignored.
    pub table: Option<CostTable>,
    /// The expected time of skipping in a frame by each executor (nanoseconds); empty where none
    /// was measured.
    pub skip_ns: Vec<(Predication, f64)>,
    /// The measured prices of resets.
    pub reset_ns: ResetPrices,
}

/// A scene on a device, for which is decided.
#[derive(Debug, Clone, Copy)]
pub struct ChoiceRequest<'a> {
    /// The executors that may be used, in the order of preference; the first is the device's usual
    /// one. Prices of others are left aside.
    pub executors: &'a [Predication],
    /// The work of a frame of the scene.
    pub work: SkippedWork,
}

impl PriceChoice {
    /// Decides by prices, which `measure` measures if that is asked for.
    pub fn by<E: Display>(
        costs: Costs,
        request: &ChoiceRequest<'_>,
        measure: impl FnOnce() -> Result<DevicePrices, E>,
    ) -> Self {
        match costs {
            Costs::Ignored => Self::usual(request, None),
            Costs::Table(table) => Self::usual(request, Some(checked(table))),
            Costs::Measured => match measure() {
                Ok(prices) => Self::of_prices(request, &prices),
                Err(error) => {
                    tracing::warn!("the costs of this device could not be measured: {error}");
                    Self::usual(request, Some(CostTable::default()))
                }
            },
        }
    }

    /// Decides by prices that were measured before, on this device.
    pub fn of_prices(request: &ChoiceRequest<'_>, prices: &DevicePrices) -> Self {
        let of = |wanted| prices.executors.iter().find(|(known, _)| known == wanted).cloned();
        let (usable, skips): (Vec<_>, Vec<_>) = request.executors.iter().filter_map(of).unzip();
        let frame_ns = |skip: &MeasuredSkip| skip.prices.frame_ns(&request.work);
        let cheapest = MeasuredSkip::cheapest(&skips, &request.work)
            .and_then(|place| Some((*usable.get(place)?, skips.get(place)?)))
            .filter(|(_, skip)| frame_ns(skip).is_finite());
        let Some((predication, skip)) = cheapest else {
            let table = Some(checked(prices.table));
            return Self { reset_ns: prices.reset_ns, ..Self::usual(request, table) };
        };
        Self {
            predication,
            table: Some(checked(prices.table.skipping_at(&skip.prices))),
            skip_ns: usable.into_iter().zip(skips.iter().map(frame_ns)).collect(),
            reset_ns: prices.reset_ns,
        }
    }

    /// Takes the executor that is usual.
    pub(crate) fn usual(request: &ChoiceRequest<'_>, table: Option<CostTable>) -> Self {
        Self {
            predication: request.executors.first().copied().unwrap_or(Predication::Instances),
            table,
            skip_ns: Vec::new(),
            reset_ns: ResetPrices::default(),
        }
    }

    /// Returns the tester that is expected to cost least in a frame of this work, on an image of
    /// this size in pixels; without prices flags, where there are any, else the one that is left.
    /// [`Strategy::ANTUMBRA`](cull::Strategy::ANTUMBRA) decides again for the boxes of each frame.
    pub fn tester(&self, work: &SkippedWork, size: [u32; 2], testers: TesterSupport) -> Tester {
        let usual = match testers {
            TesterSupport { flags: true, .. } => Tester::Flag,
            TesterSupport { queries: false, compute: true, .. } => Tester::Compute,
            _ => Tester::Query,
        };
        let model = self.table.and_then(|table| CostModel::new(table, SceneCosts::default()).ok());
        model.map_or(usual, |model| model.tester_for(work, size, testers))
    }

    /// Lets the culler of a view weigh tests of a scene by these prices, if there are any.
    pub fn steer(&self, culler: &mut Culler, scene: SceneCosts) {
        if let Some(Err(error)) = self.table.map(|table| culler.set_costs(table, scene)) {
            tracing::warn!("{error}");
        }
    }
}

/// Returns a table without impossible prices.
fn checked(table: CostTable) -> CostTable {
    table.checked().unwrap_or_else(|error| {
        tracing::warn!("{error}");
        CostTable::default()
    })
}

#[cfg(test)]
mod tests {
    use cull::SkipPrices;

    use super::*;

    const EXECUTORS: [Predication; 2] = [Predication::Conditional, Predication::Compacted];

    const WORK: SkippedWork = SkippedWork { rounds: 3, ranges: 200, draws: 10_000 };

    const REQUEST: ChoiceRequest<'_> = ChoiceRequest { executors: &EXECUTORS, work: WORK };

    fn prices(conditional_ns: f32, compacted_ns: f32) -> DevicePrices {
        let at = |range_ns| {
            let prices = SkipPrices { range_ns, round_ns: 9.0, draw_ns: 0.0 };
            MeasuredSkip { prices, rounds: vec![prices; 4] }
        };
        let executors = EXECUTORS.into_iter().zip([at(conditional_ns), at(compacted_ns)]).collect();
        DevicePrices { executors, ..DevicePrices::default() }
    }

    fn choice(prices: DevicePrices) -> PriceChoice {
        PriceChoice::by(Costs::Measured, &REQUEST, || Ok::<_, String>(prices))
    }

    #[test]
    fn a_dear_predicate_gives_way_and_its_price_steers_tests() {
        assert_eq!(choice(prices(50.0, 60.0)).predication, Predication::Conditional);
        let dear = choice(prices(5_000.0, 60.0));
        assert_eq!(dear.predication, Predication::Compacted);
        let table = dear.table.unwrap();
        assert_eq!((table.predicate_ns, table.break_ns), (60.0, 150_009.0));
        assert_eq!(dear.skip_ns[0], (Predication::Conditional, 27.0 + 1.0e6));
    }

    #[test]
    fn without_prices_the_usual_executor_and_flags_are_taken() {
        let failed = || Err::<DevicePrices, _>("no clock");
        for costs in [Costs::Ignored, Costs::Table(CostTable::default()), Costs::Measured] {
            let choice = PriceChoice::by(costs, &REQUEST, failed);
            assert_eq!(choice.predication, Predication::Conditional);
            assert_eq!(choice.table.is_none(), costs == Costs::Ignored);
            assert!(choice.skip_ns.is_empty());
        }
        let ignored = PriceChoice::by(Costs::Ignored, &REQUEST, failed);
        let flags = TesterSupport { flags: true, ..TesterSupport::default() };
        let tester = |testers| ignored.tester(&WORK, [1280, 720], testers);
        assert_eq!(tester(flags), Tester::Flag);
        assert_eq!(tester(TesterSupport::default()), Tester::Query);
        let computed = TesterSupport { queries: false, compute: true, ..TesterSupport::default() };
        assert_eq!(tester(computed), Tester::Compute);
        let request = ChoiceRequest { executors: &[], ..REQUEST };
        let choice = PriceChoice::by(Costs::Ignored, &request, failed);
        assert_eq!(choice.predication, Predication::Instances);
    }

    #[test]
    fn an_executor_that_may_not_be_used_is_not_chosen_at_any_price() {
        let prices = prices(5_000.0, 60.0);
        for (executors, expected) in [
            (&EXECUTORS[..], Predication::Compacted),
            (&EXECUTORS[..1], Predication::Conditional),
            (&[Predication::Counts], Predication::Counts),
        ] {
            let choice = PriceChoice::of_prices(&ChoiceRequest { executors, ..REQUEST }, &prices);
            assert_eq!(choice.predication, expected);
            assert!(choice.skip_ns.iter().all(|(executor, _)| executors.contains(executor)));
            assert!(choice.table.is_some());
        }
    }

    #[test]
    fn an_impossible_table_is_replaced() {
        let nan = CostTable::uniform(f32::NAN);
        let failed = || Err::<DevicePrices, _>("not asked");
        let choice = PriceChoice::by(Costs::Table(nan), &REQUEST, failed);
        assert_eq!(choice.table, Some(CostTable::default()));
        let broken = choice_of_broken_clock();
        assert_eq!(broken.predication, Predication::Conditional);
        assert_eq!(broken.table, Some(CostTable::default()));
    }

    fn choice_of_broken_clock() -> PriceChoice {
        choice(prices(f32::NAN, f32::NAN))
    }
}
