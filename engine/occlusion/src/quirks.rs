//! Decisions about the parts of a driver with broken assumptions that are used. Except for the
//! features of a device, tests need no device.

mod driver_assumption;

use cull::{VisibilityTest, VisibilityTestSupport};
use gpu::{Device, PredicationMode};

pub use driver_assumption::DriverAssumption;
use driver_assumption::Support;

use crate::error::Error;

/// The broken assumptions about a driver, and the parts of the driver that may be used
/// nevertheless. By default no assumption is broken.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DriverQuirks {
    broken: Vec<DriverAssumption>,
}

impl DriverQuirks {
    /// Creates the quirks of a driver for which a self-test found these broken assumptions.
    pub fn new(broken: &[DriverAssumption]) -> Self {
        Self { broken: broken.to_vec() }
    }

    /// Returns true if the results of a tester can be trusted.
    pub fn allows(&self, tester: VisibilityTest) -> bool {
        let rests = |assumption: &DriverAssumption| match assumption.support() {
            Support::Testers(testers) => testers.contains(&tester),
            _ => false,
        };
        !self.broken.iter().any(rests)
    }

    /// Returns true if an executor may skip draws.
    pub fn allows_executor(&self, executor: PredicationMode) -> bool {
        let rests = |assumption: &DriverAssumption| match assumption.support() {
            Support::Executors(executors) => executors.contains(&executor),
            _ => false,
        };
        !self.broken.iter().any(rests)
    }

    /// Returns true if boxes of leaves may enable draws: their fragments write instance counts.
    pub(crate) fn allows_leaf_boxes(&self) -> bool {
        self.allows(VisibilityTest::Flag) && self.allows_executor(PredicationMode::Instances)
    }

    /// Returns the executors that may be used, out of the executors that the device `has`: the
    /// wanted executor first, then the others in their order. Empty if none can be trusted.
    pub fn executors(
        &self,
        wanted: PredicationMode,
        has: impl Fn(PredicationMode) -> bool,
    ) -> Vec<PredicationMode> {
        let others = PredicationMode::ALL.into_iter().filter(|predication| *predication != wanted);
        let all = std::iter::once(wanted).chain(others);
        all.filter(|executor| self.allows_executor(*executor) && has(*executor)).collect()
    }

    /// Returns the first executor of [`DriverQuirks::executors`].
    pub fn executor(
        &self,
        wanted: PredicationMode,
        has: impl Fn(PredicationMode) -> bool,
    ) -> Option<PredicationMode> {
        self.executors(wanted, has).first().copied()
    }

    /// Returns the executors that may be used on a device for this number of draws and this
    /// threshold. With a `wanted` executor it is the only one; otherwise the device's usual
    /// executor comes first. If no executor can be trusted, the usual one is returned nevertheless:
    /// [`DriverQuirks::testers`] then allows no tester, so nothing is skipped.
    ///
    /// # Errors
    /// The errors of [`PredicationMode::choose`].
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

    /// Returns the testers that may be used, out of the testers that a device offers. `executor`
    /// skips the draws that they find hidden; if it cannot be trusted, no tester may be used.
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

    /// Returns a sentence for each broken assumption, for users.
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
