//! Decisions about casters on a driver with broken assumptions. Pure: tests need no device.

use ::shadows::{CasterCulling, ShadowOptions};
use cull::Tester;
use gpu::Predication;
use occlusion::Trust;

/// Returns the executor that skips casters where the scene's is the wanted one: each range by
/// itself, of those that `can` skip casters; `None` if none of them can be trusted.
pub(crate) fn caster_executor(
    trust: &Trust,
    wanted: Predication,
    can: impl Fn(Predication) -> bool,
) -> Option<Predication> {
    let wanted = match wanted {
        Predication::Compacted => Predication::Counts,
        other => other,
    };
    trust.executor(wanted, |trust| trust != Predication::Compacted && can(trust))
}

/// Returns the options of shadows: casters are culled by flags, and skipped by one of the executors
/// that `can` skip them.
pub(crate) fn trusted_shadows(
    trust: &Trust,
    wanted: ShadowOptions,
    can: impl Fn(Predication) -> bool,
) -> ShadowOptions {
    let can_skip = caster_executor(trust, Predication::Conditional, can).is_some();
    if can_skip && trust.allows(Tester::Flag) {
        wanted
    } else {
        ShadowOptions { culling: CasterCulling::Unculled, ..wanted }
    }
}

#[cfg(test)]
mod tests {
    use occlusion::Assumption;

    use super::*;

    #[test]
    fn casters_are_skipped_by_what_is_trusted_and_there() {
        use Assumption::{ConditionalRendering, InstanceCounts};
        let culled = ShadowOptions::default();
        let counts = Predication::Counts;
        let compacted = Predication::Compacted;
        assert_eq!(caster_executor(&Trust::default(), compacted, |_| true), Some(counts));
        let trust = Trust::without(&[ConditionalRendering, InstanceCounts]);
        assert_eq!(caster_executor(&trust, Predication::Conditional, |_| true), Some(counts));
        let shadows = trusted_shadows(&trust, culled, |_| true);
        assert_eq!(shadows.culling, CasterCulling::Culled);
        // A device without draw counts, or with too few.
        let can = |predication| predication != counts && predication != compacted;
        assert_eq!(caster_executor(&trust, Predication::Conditional, can), None);
        assert_eq!(trusted_shadows(&trust, culled, can).culling, CasterCulling::Unculled);
    }
}
