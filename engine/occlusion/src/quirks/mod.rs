//! Decisions about what is used on a driver with broken assumptions. Pure, but for the question
//! what a device has: tests need none.

mod driver_assumption;

use cull::{VisibilityTest, VisibilityTestSupport};
use gpu::{Device, PredicationMode};

pub use driver_assumption::DriverAssumption;
use driver_assumption::Support;

use crate::error::Error;

/// The assumptions about a driver that do not hold, and what may be used all the same. By default
/// all of them hold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DriverQuirks {
    broken: Vec<DriverAssumption>,
}

impl DriverQuirks {
    /// Creates the quirks of a driver of which a self-test found `broken`.
    pub fn new(broken: &[DriverAssumption]) -> Self {
        Self { broken: broken.to_vec() }
    }

    /// Returns true if the results of a tester may decide.
    pub fn allows(&self, tester: VisibilityTest) -> bool {
        let rests = |assumption: &DriverAssumption| match assumption.support() {
            Support::Testers(testers) => testers.contains(&tester),
            _ => false,
        };
        !self.broken.iter().any(rests)
    }

    /// Returns true if draws may be skipped by an executor.
    pub fn allows_executor(&self, executor: PredicationMode) -> bool {
        let rests = |assumption: &DriverAssumption| match assumption.support() {
            Support::Executors(executors) => executors.contains(&executor),
            _ => false,
        };
        !self.broken.iter().any(rests)
    }

    /// Returns true if boxes of leaves may enable draws: their fragments write how many instances
    /// there are.
    pub(crate) fn allows_leaf_boxes(&self) -> bool {
        self.allows(VisibilityTest::Flag) && self.allows_executor(PredicationMode::Instances)
    }

    /// Returns the executors that may be used, out of those that the device `has`: the wanted one
    /// first, then the others in their order. None if none can be trusted.
    pub fn executors(
        &self,
        wanted: PredicationMode,
        has: impl Fn(PredicationMode) -> bool,
    ) -> Vec<PredicationMode> {
        let others = PredicationMode::ALL.into_iter().filter(|predication| *predication != wanted);
        let all = std::iter::once(wanted).chain(others);
        all.filter(|executor| self.allows_executor(*executor) && has(*executor)).collect()
    }

    /// Returns the first of them.
    pub fn executor(
        &self,
        wanted: PredicationMode,
        has: impl Fn(PredicationMode) -> bool,
    ) -> Option<PredicationMode> {
        self.executors(wanted, has).first().copied()
    }

    /// Returns the executors that may be used on a device for so many draws with a threshold: the
    /// wanted one, or all, the device's usual one first. Where none can be trusted that one stays:
    /// nothing is put under a predicate then, since [`DriverQuirks::testers`] leaves no tester.
    ///
    /// # Errors
    /// Those of [`PredicationMode::choose`].
    pub fn usable_executors(
        &self,
        device: &Device,
        wanted: Option<PredicationMode>,
        draws: u64,
        threshold_samples: u32,
    ) -> Result<Vec<PredicationMode>, Error> {
        let first = PredicationMode::choose(device, wanted, draws, threshold_samples)?;
        let has = |predication| {
            PredicationMode::choose(device, Some(predication), draws, threshold_samples).is_ok()
        };
        let mut usable = self.executors(first, has);
        if wanted.is_some() {
            usable.truncate(1);
        }
        if usable.is_empty() {
            usable.push(first);
        }
        Ok(usable)
    }

    /// Returns the testers that may be used, out of those that a device offers, where an executor
    /// skips what they find hidden: none if that one cannot be trusted.
    pub fn testers(
        &self,
        offered: VisibilityTestSupport,
        executor: PredicationMode,
    ) -> VisibilityTestSupport {
        if self.allows_executor(executor) {
            VisibilityTestSupport {
                queries: offered.queries && self.allows(VisibilityTest::Query),
                flags: offered.flags && self.allows(VisibilityTest::Flag),
                compute: offered.compute && self.allows(VisibilityTest::Compute),
                leaf_tests: offered.leaf_tests && self.allows_leaf_boxes(),
                draw_phases: offered.draw_phases,
            }
        } else {
            VisibilityTestSupport {
                draw_phases: offered.draw_phases,
                ..VisibilityTestSupport::NONE
            }
        }
    }

    /// Returns a sentence for each broken assumption, for people.
    pub fn texts(&self) -> Vec<String> {
        let text = |assumption: &DriverAssumption| {
            format!("this driver cannot be trusted with {assumption}: {}", assumption.remedy())
        };
        self.broken.iter().map(text).collect()
    }
}

#[cfg(test)]
mod tests {
    use cull::{DrawPhases, Strategy};

    use super::*;

    const ALL: VisibilityTestSupport = VisibilityTestSupport {
        queries: true,
        flags: true,
        compute: true,
        leaf_tests: true,
        draw_phases: DrawPhases::PerRound,
    };

    fn testers(broken: &[DriverAssumption]) -> VisibilityTestSupport {
        DriverQuirks::new(broken).testers(ALL, PredicationMode::Conditional)
    }

    #[test]
    fn a_sound_driver_is_used_as_it_is_wanted() {
        let quirks = DriverQuirks::default();
        assert!(quirks.texts().is_empty());
        for wanted in PredicationMode::ALL {
            assert_eq!(quirks.testers(ALL, wanted), ALL);
            let executors = quirks.executors(wanted, |_| true);
            assert_eq!((executors.len(), executors[0]), (PredicationMode::ALL.len(), wanted));
        }
    }

    #[test]
    fn a_broken_tester_is_replaced_by_the_safest() {
        use DriverAssumption::{ComputedDepths, EarlyTests, ProxyDepth, QueryCounts};
        let ours = Strategy::ANTUMBRA;
        let flags = Strategy::ANTUMBRA_FLAGS;
        let queries = Strategy::ANTUMBRA_QUERIES;
        let compute = Strategy::ANTUMBRA_COMPUTE;
        let strategy = |broken: &[DriverAssumption], wanted| testers(broken).strategy(wanted);
        assert_eq!(strategy(&[QueryCounts], ours), flags);
        assert_eq!(strategy(&[QueryCounts], queries), flags);
        assert_eq!(strategy(&[QueryCounts], compute), compute);
        assert_eq!(strategy(&[EarlyTests], flags), queries);
        assert_eq!(strategy(&[EarlyTests], ours), ours, "with the testers that are left");
        assert_eq!(strategy(&[ProxyDepth], ours), compute);
        assert_eq!(strategy(&[ProxyDepth, ComputedDepths], ours), Strategy::FRUSTUM);
        let counting = testers(&[QueryCounts]).counting(4);
        assert_eq!(counting.strategy(ours), Strategy::FRUSTUM, "only queries count");
    }

    #[test]
    fn flags_that_lie_enable_no_draws_either() {
        let expected = VisibilityTestSupport { flags: false, leaf_tests: false, ..ALL };
        assert_eq!(testers(&[DriverAssumption::FlagWrites]), expected);
        let expected = VisibilityTestSupport { leaf_tests: false, ..ALL };
        assert_eq!(
            testers(&[DriverAssumption::InstanceCounts]),
            expected,
            "they write such counts"
        );
        let expected = VisibilityTestSupport { compute: false, ..ALL };
        assert_eq!(testers(&[DriverAssumption::ComputedWalk]), expected);
    }

    #[test]
    fn nothing_is_tested_that_only_a_broken_executor_would_skip() {
        let quirks = DriverQuirks::new(&[DriverAssumption::DrawCounts]);
        for executor in [PredicationMode::Counts, PredicationMode::Compacted] {
            assert_eq!(quirks.testers(ALL, executor), VisibilityTestSupport::NONE);
        }
        assert_eq!(quirks.testers(ALL, PredicationMode::Instances), ALL);
    }

    #[test]
    fn a_broken_executor_is_replaced_by_one_that_the_device_has() {
        use DriverAssumption::{ConditionalRendering, DrawCounts, InstanceCounts};
        let quirks = DriverQuirks::new(&[ConditionalRendering]);
        let wanted = PredicationMode::Conditional;
        let counts = PredicationMode::Counts;
        let instances = PredicationMode::Instances;
        let compacted = PredicationMode::Compacted;
        assert_eq!(quirks.executors(wanted, |_| true), [counts, instances, compacted]);
        let has = |predication| predication != PredicationMode::Counts;
        assert_eq!(quirks.executors(wanted, has), [instances, compacted]);
        let nothing = DriverQuirks::new(&[ConditionalRendering, DrawCounts, InstanceCounts]);
        assert!(nothing.executors(wanted, |_| true).is_empty());
        let quirks = DriverQuirks::new(&[DrawCounts]);
        let compacted = PredicationMode::Compacted;
        assert_eq!(quirks.executor(compacted, |_| true), Some(wanted), "it counts, too");
        let quirks = DriverQuirks::new(&[DriverAssumption::CompactedLists]);
        assert_eq!(quirks.executor(compacted, |_| true), Some(wanted));
        assert_eq!(
            quirks.executor(PredicationMode::Counts, |_| true),
            Some(PredicationMode::Counts)
        );
        let quirks = DriverQuirks::new(&[ConditionalRendering, InstanceCounts]);
        assert_eq!(quirks.executor(wanted, |quirks| quirks == compacted), Some(compacted));
    }

    #[test]
    fn every_assumption_says_what_is_done() {
        for assumption in DriverAssumption::ALL {
            let text = DriverQuirks::new(&[assumption]).texts().concat();
            assert!(text.contains(assumption.name()) && text.contains(assumption.remedy()));
        }
        let names: std::collections::BTreeSet<_> =
            DriverAssumption::ALL.map(DriverAssumption::name).into();
        assert_eq!(names.len(), DriverAssumption::ALL.len());
    }

    #[test]
    fn what_is_slower_or_cannot_be_replaced_takes_no_tester() {
        use DriverAssumption::{DrawOrder, LateResults, RepeatedDepth};
        assert_eq!(testers(&[LateResults, DrawOrder, RepeatedDepth]), ALL);
    }
}
