//! Decisions about casters on a driver with broken assumptions. Pure: tests need no device.

use ::shadows::{CasterCulling, ShadowOptions};
use cull::VisibilityTest;
use gpu::PredicationMode;
use occlusion::DriverQuirks;

/// Returns the executor that skips ranges of casters individually: `wanted`, the executor of the
/// scene, if possible, else another that `can` skip casters. `None` if none can be trusted. Casters
/// are never compacted.
pub(crate) fn caster_executor(
    quirks: &DriverQuirks,
    wanted: PredicationMode,
    can: impl Fn(PredicationMode) -> bool,
) -> Option<PredicationMode> {
    let wanted = match wanted {
        PredicationMode::Compacted => PredicationMode::Counts,
        other => other,
    };
    quirks.executor(wanted, |quirks| quirks != PredicationMode::Compacted && can(quirks))
}

/// Returns the usable options of shadows. Culling casters needs flags, and an executor that `can`
/// skip them.
pub(crate) fn usable_shadows(
    quirks: &DriverQuirks,
    wanted: ShadowOptions,
    can: impl Fn(PredicationMode) -> bool,
) -> ShadowOptions {
    let can_skip = caster_executor(quirks, PredicationMode::Conditional, can).is_some();
    if can_skip && quirks.allows(VisibilityTest::Flag) {
        wanted
    } else {
        ShadowOptions { culling: CasterCulling::Unculled, ..wanted }
    }
}

#[cfg(test)]
mod tests {
    use occlusion::DriverAssumption;

    use super::*;

    #[test]
    fn casters_are_skipped_by_what_is_trusted_and_there() {
        use DriverAssumption::{ConditionalRendering, InstanceCounts};
        let culled = ShadowOptions::default();
        let counts = PredicationMode::Counts;
        let compacted = PredicationMode::Compacted;
        assert_eq!(caster_executor(&DriverQuirks::default(), compacted, |_| true), Some(counts));
        let quirks = DriverQuirks::new(&[ConditionalRendering, InstanceCounts]);
        assert_eq!(caster_executor(&quirks, PredicationMode::Conditional, |_| true), Some(counts));
        let shadows = usable_shadows(&quirks, culled, |_| true);
        assert_eq!(shadows.culling, CasterCulling::Culled);
        // A device without draw counts, or with a limit that is too low.
        let can = |predication| predication != counts && predication != compacted;
        assert_eq!(caster_executor(&quirks, PredicationMode::Conditional, can), None);
        assert_eq!(usable_shadows(&quirks, culled, can).culling, CasterCulling::Unculled);
    }
}
