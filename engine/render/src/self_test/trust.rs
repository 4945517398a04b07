//! Decisions about what is used on a driver with broken assumptions. Pure: tests need no device.

use ::shadows::{CasterCulling, ShadowOptions};
use cull::{Strategy, Tester, TesterSupport};
use gpu::Predication;

use super::assumption::{Assumption, Support};

/// The testers, the preferred one first, with the strategy that uses each alone.
const TESTERS: [(Tester, Strategy); 3] = [
    (Tester::Flag, Strategy::ANTUMBRA_FLAGS),
    (Tester::Query, Strategy::ANTUMBRA_QUERIES),
    (Tester::Compute, Strategy::ANTUMBRA_COMPUTE),
];

/// Executors of predicates, the preferred one first.
pub(crate) const EXECUTORS: [Predication; 4] =
    [Predication::Conditional, Predication::Counts, Predication::Instances, Predication::Compacted];

/// The parts of a driver that may be used, given the assumptions about it that do not hold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Trust {
    broken: Vec<Assumption>,
}

impl Trust {
    /// Creates the trust that is left without `broken`.
    pub(crate) fn without(broken: &[Assumption]) -> Self {
        Self { broken: broken.to_vec() }
    }

    /// Returns true if the results of a tester may decide.
    pub(crate) fn allows(&self, tester: Tester) -> bool {
        let rests = |assumption: &Assumption| match assumption.support() {
            Support::Testers(testers) => testers.contains(&tester),
            _ => false,
        };
        !self.broken.iter().any(rests)
    }

    /// Returns true if draws may be skipped by an executor.
    pub(crate) fn allows_executor(&self, executor: Predication) -> bool {
        let rests = |assumption: &Assumption| match assumption.support() {
            Support::Executors(executors) => executors.contains(&executor),
            _ => false,
        };
        !self.broken.iter().any(rests)
    }

    /// Returns the executors that may be used, out of those that the device `has`: the wanted one
    /// first, then the others in their order. None if none can be trusted.
    pub(crate) fn executors(
        &self,
        wanted: Predication,
        has: impl Fn(Predication) -> bool,
    ) -> Vec<Predication> {
        let others = EXECUTORS.into_iter().filter(|it| *it != wanted);
        let all = std::iter::once(wanted).chain(others);
        all.filter(|executor| self.allows_executor(*executor) && has(*executor)).collect()
    }

    /// Returns the first of them.
    pub(crate) fn executor(
        &self,
        wanted: Predication,
        has: impl Fn(Predication) -> bool,
    ) -> Option<Predication> {
        self.executors(wanted, has).first().copied()
    }

    /// Returns the testers of the device that may be used.
    pub(crate) fn testers(&self, offered: TesterSupport) -> TesterSupport {
        let flags = self.allows(Tester::Flag);
        TesterSupport {
            flags: offered.flags && flags,
            compute: offered.compute && self.allows(Tester::Compute),
            // Boxes of leaves enable draws by what their fragments write.
            leaf_tests: offered.leaf_tests && flags,
            ..offered
        }
    }

    /// Returns the executor that skips casters where the scene's is the wanted one: each range by
    /// itself, of those that `can` skip casters; `None` if none of them can be trusted.
    pub(crate) fn caster_executor(
        &self,
        wanted: Predication,
        can: impl Fn(Predication) -> bool,
    ) -> Option<Predication> {
        let wanted = match wanted {
            Predication::Compacted => Predication::Counts,
            other => other,
        };
        self.executor(wanted, |it| it != Predication::Compacted && can(it))
    }

    /// Returns the options of shadows: casters are culled by flags, and skipped by one of the
    /// executors that `can` skip them.
    pub(crate) fn shadows(
        &self,
        wanted: ShadowOptions,
        can: impl Fn(Predication) -> bool,
    ) -> ShadowOptions {
        let can_skip = self.caster_executor(Predication::Conditional, can).is_some();
        match can_skip && self.allows(Tester::Flag) {
            true => wanted,
            false => ShadowOptions { culling: CasterCulling::Unculled, ..wanted },
        }
    }

    /// Returns the strategy to use in place of the wanted one: the same if its tests can be
    /// trusted, else that of the safest tester that the device offers, else plain frustum culling.
    /// Methods of the literature stay as they are. With a threshold all tests are queries.
    pub(crate) fn strategy(
        &self,
        wanted: Strategy,
        offered: TesterSupport,
        threshold_samples: u32,
    ) -> Strategy {
        if !wanted.uses_cost_model() || self.is_trusted(wanted, threshold_samples) {
            return wanted;
        }
        let usable = |(tester, _): &(Tester, Strategy)| {
            let is_there = match tester {
                Tester::Query | Tester::SharedProxy(_) => true,
                Tester::Flag => offered.flags && threshold_samples == 0,
                Tester::Compute => offered.compute && threshold_samples == 0,
            };
            is_there && self.allows(*tester)
        };
        TESTERS.iter().find(|it| usable(it)).map_or(Strategy::FRUSTUM, |(_, strategy)| *strategy)
    }

    /// Returns true if no test of a strategy rests on a broken assumption. `antumbra` may use any
    /// tester but those that [`Trust::testers`] takes away, so it needs queries.
    fn is_trusted(&self, strategy: Strategy, threshold_samples: u32) -> bool {
        let only = TESTERS.iter().find(|(_, it)| *it == strategy).map(|(tester, _)| *tester);
        match only {
            Some(tester) if threshold_samples == 0 => self.allows(tester),
            _ => self.allows(Tester::Query),
        }
    }

    /// Returns a sentence for each broken assumption, for people.
    pub(crate) fn texts(&self) -> Vec<String> {
        let text =
            |it: &Assumption| format!("this driver cannot be trusted with {it}: {}", it.remedy());
        self.broken.iter().map(text).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: TesterSupport = TesterSupport {
        flags: true,
        compute: true,
        leaf_tests: true,
        draw_phases: cull::DrawPhases::PerRound,
    };

    fn strategy(broken: &[Assumption], wanted: Strategy) -> Strategy {
        Trust::without(broken).strategy(wanted, ALL, 0)
    }

    #[test]
    fn a_sound_driver_is_used_as_it_is_wanted() {
        let trust = Trust::default();
        assert!(trust.texts().is_empty());
        for wanted in Strategy::PLANNED {
            for threshold in [0, 4] {
                assert_eq!(trust.strategy(wanted, ALL, threshold), wanted);
            }
        }
        assert_eq!(trust.testers(ALL), ALL);
        for wanted in EXECUTORS {
            let executors = trust.executors(wanted, |_| true);
            assert_eq!((executors.len(), executors[0]), (EXECUTORS.len(), wanted));
        }
    }

    #[test]
    fn a_broken_tester_is_replaced_by_the_safest() {
        use Assumption::{ComputedDepths, EarlyTests, ProxyDepth, QueryCounts};
        let (ours, flags) = (Strategy::ANTUMBRA, Strategy::ANTUMBRA_FLAGS);
        let (queries, compute) = (Strategy::ANTUMBRA_QUERIES, Strategy::ANTUMBRA_COMPUTE);
        assert_eq!(strategy(&[QueryCounts], ours), flags);
        assert_eq!(strategy(&[QueryCounts], queries), flags);
        assert_eq!(strategy(&[QueryCounts], compute), compute);
        assert_eq!(strategy(&[EarlyTests], flags), queries);
        assert_eq!(strategy(&[EarlyTests], ours), ours, "with the testers that are left");
        assert_eq!(strategy(&[ProxyDepth], ours), compute);
        assert_eq!(strategy(&[ProxyDepth, ComputedDepths], ours), Strategy::FRUSTUM);
        let plain = TesterSupport { flags: false, compute: false, ..ALL };
        let trust = Trust::without(&[QueryCounts]);
        assert_eq!(trust.strategy(ours, plain, 0), Strategy::FRUSTUM);
        assert_eq!(trust.strategy(ours, ALL, 4), Strategy::FRUSTUM, "only queries count");
    }

    #[test]
    fn flags_that_lie_enable_no_draws_either() {
        let testers = Trust::without(&[Assumption::FlagWrites]).testers(ALL);
        assert_eq!(testers, TesterSupport { flags: false, leaf_tests: false, ..ALL });
        let testers = Trust::without(&[Assumption::ComputedWalk]).testers(ALL);
        assert_eq!(testers, TesterSupport { compute: false, ..ALL });
    }

    #[test]
    fn casters_are_skipped_by_what_is_trusted_and_there() {
        use Assumption::{ConditionalRendering, InstanceCounts};
        let culled = ShadowOptions::default();
        let (counts, compacted) = (Predication::Counts, Predication::Compacted);
        assert_eq!(Trust::default().caster_executor(compacted, |_| true), Some(counts));
        let trust = Trust::without(&[ConditionalRendering, InstanceCounts]);
        assert_eq!(trust.caster_executor(Predication::Conditional, |_| true), Some(counts));
        assert_eq!(trust.shadows(culled, |_| true).culling, CasterCulling::Culled);
        // A device without draw counts, or with too few.
        let can = |it| it != counts && it != compacted;
        assert_eq!(trust.caster_executor(Predication::Conditional, can), None);
        assert_eq!(trust.shadows(culled, can).culling, CasterCulling::Unculled);
    }

    #[test]
    fn a_broken_executor_is_replaced_by_one_that_the_device_has() {
        use Assumption::{ConditionalRendering, DrawCounts, InstanceCounts};
        let trust = Trust::without(&[ConditionalRendering]);
        let wanted = Predication::Conditional;
        let (counts, instances) = (Predication::Counts, Predication::Instances);
        let compacted = Predication::Compacted;
        assert_eq!(trust.executors(wanted, |_| true), [counts, instances, compacted]);
        let has = |it| it != Predication::Counts;
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
        assert_eq!(trust.executor(wanted, |it| it == compacted), Some(compacted));
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
    fn what_is_slower_or_cannot_be_replaced_changes_no_strategy() {
        let broken = [Assumption::LateResults, Assumption::DrawOrder, Assumption::RepeatedDepth];
        for wanted in Strategy::PLANNED {
            assert_eq!(strategy(&broken, wanted), wanted);
        }
    }
}
