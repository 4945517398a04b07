//! Decisions about what is used on a driver with broken assumptions. Pure, but for the question
//! what a device has: tests need none.

mod assumption;

use cull::{Tester, TesterSupport};
use gpu::{Device, Predication};

pub use assumption::Assumption;
use assumption::Support;

use crate::error::Error;

/// The parts of a driver that may be used, given the assumptions about it that do not hold. By
/// default all of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trust {
    broken: Vec<Assumption>,
}

impl Trust {
    /// Creates the trust that is left without `broken`, which a self-test found.
    pub fn without(broken: &[Assumption]) -> Self {
        Self { broken: broken.to_vec() }
    }

    /// Returns true if the results of a tester may decide.
    pub fn allows(&self, tester: Tester) -> bool {
        let rests = |assumption: &Assumption| match assumption.support() {
            Support::Testers(testers) => testers.contains(&tester),
            _ => false,
        };
        !self.broken.iter().any(rests)
    }

    /// Returns true if draws may be skipped by an executor.
    pub fn allows_executor(&self, executor: Predication) -> bool {
        let rests = |assumption: &Assumption| match assumption.support() {
            Support::Executors(executors) => executors.contains(&executor),
            _ => false,
        };
        !self.broken.iter().any(rests)
    }

    /// Returns true if boxes of leaves may enable draws: their fragments write how many instances
    /// there are.
    pub(crate) fn allows_leaf_boxes(&self) -> bool {
        self.allows(Tester::Flag) && self.allows_executor(Predication::Instances)
    }

    /// Returns the executors that may be used, out of those that the device `has`: the wanted one
    /// first, then the others in their order. None if none can be trusted.
    pub fn executors(
        &self,
        wanted: Predication,
        has: impl Fn(Predication) -> bool,
    ) -> Vec<Predication> {
        let others = Predication::ALL.into_iter().filter(|predication| *predication != wanted);
        let all = std::iter::once(wanted).chain(others);
        all.filter(|executor| self.allows_executor(*executor) && has(*executor)).collect()
    }

    /// Returns the first of them.
    pub fn executor(
        &self,
        wanted: Predication,
        has: impl Fn(Predication) -> bool,
    ) -> Option<Predication> {
        self.executors(wanted, has).first().copied()
    }

    /// Returns the executors that may be used on a device for so many draws with a threshold: the
    /// wanted one, or all, the device's usual one first. Where none can be trusted that one stays:
    /// nothing is put under a predicate then, since [`Trust::testers`] leaves no tester.
    ///
    /// # Errors
    /// Those of [`Predication::choose`].
    pub fn usable_executors(
        &self,
        device: &Device,
        wanted: Option<Predication>,
        draws: u64,
        threshold_samples: u32,
    ) -> Result<Vec<Predication>, Error> {
        let first = Predication::choose(device, wanted, draws, threshold_samples)?;
        let has = |predication| {
            Predication::choose(device, Some(predication), draws, threshold_samples).is_ok()
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
    pub fn testers(&self, offered: TesterSupport, executor: Predication) -> TesterSupport {
        if self.allows_executor(executor) {
            TesterSupport {
                queries: offered.queries && self.allows(Tester::Query),
                flags: offered.flags && self.allows(Tester::Flag),
                compute: offered.compute && self.allows(Tester::Compute),
                leaf_tests: offered.leaf_tests && self.allows_leaf_boxes(),
                draw_phases: offered.draw_phases,
            }
        } else {
            TesterSupport { draw_phases: offered.draw_phases, ..TesterSupport::NONE }
        }
    }

    /// Returns a sentence for each broken assumption, for people.
    pub fn texts(&self) -> Vec<String> {
        let text = |assumption: &Assumption| {
            format!("this driver cannot be trusted with {assumption}: {}", assumption.remedy())
        };
        self.broken.iter().map(text).collect()
    }
}

#[cfg(test)]
mod tests {
    use cull::{DrawPhases, Strategy};

    use super::*;

    const ALL: TesterSupport = TesterSupport {
        queries: true,
        flags: true,
        compute: true,
        leaf_tests: true,
        draw_phases: DrawPhases::PerRound,
    };

    fn testers(broken: &[Assumption]) -> TesterSupport {
        Trust::without(broken).testers(ALL, Predication::Conditional)
    }

    #[test]
    fn a_sound_driver_is_used_as_it_is_wanted() {
        let trust = Trust::default();
        assert!(trust.texts().is_empty());
        for wanted in Predication::ALL {
            assert_eq!(trust.testers(ALL, wanted), ALL);
            let executors = trust.executors(wanted, |_| true);
            assert_eq!((executors.len(), executors[0]), (Predication::ALL.len(), wanted));
        }
    }

    #[test]
    fn a_broken_tester_is_replaced_by_the_safest() {
        use Assumption::{ComputedDepths, EarlyTests, ProxyDepth, QueryCounts};
        let ours = Strategy::ANTUMBRA;
        let flags = Strategy::ANTUMBRA_FLAGS;
        let queries = Strategy::ANTUMBRA_QUERIES;
        let compute = Strategy::ANTUMBRA_COMPUTE;
        let strategy = |broken: &[Assumption], wanted| testers(broken).strategy(wanted);
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
        let expected = TesterSupport { flags: false, leaf_tests: false, ..ALL };
        assert_eq!(testers(&[Assumption::FlagWrites]), expected);
        let expected = TesterSupport { leaf_tests: false, ..ALL };
        assert_eq!(testers(&[Assumption::InstanceCounts]), expected, "they write such counts");
        let expected = TesterSupport { compute: false, ..ALL };
        assert_eq!(testers(&[Assumption::ComputedWalk]), expected);
    }

    #[test]
    fn nothing_is_tested_that_only_a_broken_executor_would_skip() {
        let trust = Trust::without(&[Assumption::DrawCounts]);
        for executor in [Predication::Counts, Predication::Compacted] {
            assert_eq!(trust.testers(ALL, executor), TesterSupport::NONE);
        }
        assert_eq!(trust.testers(ALL, Predication::Instances), ALL);
    }

    #[test]
    fn a_broken_executor_is_replaced_by_one_that_the_device_has() {
        use Assumption::{ConditionalRendering, DrawCounts, InstanceCounts};
        let trust = Trust::without(&[ConditionalRendering]);
        let wanted = Predication::Conditional;
        let counts = Predication::Counts;
        let instances = Predication::Instances;
        let compacted = Predication::Compacted;
        assert_eq!(trust.executors(wanted, |_| true), [counts, instances, compacted]);
        let has = |predication| predication != Predication::Counts;
        assert_eq!(trust.executors(wanted, has), [instances, compacted]);
        let nothing = Trust::without(&[ConditionalRendering, DrawCounts, InstanceCounts]);
        assert!(nothing.executors(wanted, |_| true).is_empty());
        let trust = Trust::without(&[DrawCounts]);
        let compacted = Predication::Compacted;
        assert_eq!(trust.executor(compacted, |_| true), Some(wanted), "it counts, too");
        let trust = Trust::without(&[Assumption::CompactedLists]);
        assert_eq!(trust.executor(compacted, |_| true), Some(wanted));
        assert_eq!(trust.executor(Predication::Counts, |_| true), Some(Predication::Counts));
        let trust = Trust::without(&[ConditionalRendering, InstanceCounts]);
        assert_eq!(trust.executor(wanted, |trust| trust == compacted), Some(compacted));
    }

    #[test]
    fn every_assumption_says_what_is_done() {
        for assumption in Assumption::ALL {
            let text = Trust::without(&[assumption]).texts().concat();
            assert!(text.contains(assumption.name()) && text.contains(assumption.remedy()));
        }
        let names: std::collections::BTreeSet<_> = Assumption::ALL.map(Assumption::name).into();
        assert_eq!(names.len(), Assumption::ALL.len());
    }

    #[test]
    fn what_is_slower_or_cannot_be_replaced_takes_no_tester() {
        use Assumption::{DrawOrder, LateResults, RepeatedDepth};
        assert_eq!(testers(&[LateResults, DrawOrder, RepeatedDepth]), ALL);
    }
}
