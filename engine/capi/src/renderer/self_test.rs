//! The outcome of a self-test of a driver.

use render::{CheckResult, DriverAssumption, SelfTest};

use crate::executor::quirks::BITS;
use crate::layout::{Versioned, layout, versioned};

/// The outcome of a self-test: sets of `ANTUMBRA_ASSUMPTION_..`. Assumptions in neither set hold.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraSelfTest {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The assumptions that do not hold, for `AntumbraRendererDesc::disabled` and
    /// `AntumbraSceneDesc::disabled`.
    pub broken: u32,
    /// The assumptions that could not be tested, since the device lacks the features that rely on
    /// them.
    pub not_tested: u32,
    /// 1 if a tester and a way to skip draws are left. 0 if only `ANTUMBRA_STRATEGY_FRUSTUM` draws
    /// correct images, which renderers then use.
    pub can_cull: u32,
}
layout!(AntumbraSelfTest: struct_size, broken, not_tested, can_cull);

versioned!(AntumbraSelfTest: 4, required: [], defaults: {});

impl From<&SelfTest> for AntumbraSelfTest {
    fn from(test: &SelfTest) -> Self {
        let bits_of = |is_in: fn(&CheckResult) -> bool| {
            let of = |(bit, assumption): &(u32, DriverAssumption)| {
                test.verdict(*assumption).filter(|finding| is_in(finding)).map_or(0, |_| *bit)
            };
            BITS.iter().map(of).sum()
        };
        Self {
            broken: bits_of(|finding| matches!(finding, CheckResult::Failed(_))),
            not_tested: bits_of(|finding| matches!(finding, CheckResult::Skipped(_))),
            can_cull: test.safest.is_some().into(),
            ..Self::INIT
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::executor::quirks::{
        ANTUMBRA_ASSUMPTION_DRAW_COUNTS, ANTUMBRA_ASSUMPTION_EARLY_TESTS, assumptions,
    };

    #[test]
    fn an_outcome_becomes_bits() {
        let findings = vec![
            (DriverAssumption::QueryCounts, CheckResult::Passed),
            (DriverAssumption::EarlyTests, CheckResult::Failed("3 of 4 lie".to_owned())),
            (DriverAssumption::DrawCounts, CheckResult::Skipped("none here".to_owned())),
        ];
        let found = AntumbraSelfTest::from(&SelfTest { findings, safest: None });
        assert_eq!(found.broken, ANTUMBRA_ASSUMPTION_EARLY_TESTS);
        assert_eq!((found.not_tested, found.can_cull), (ANTUMBRA_ASSUMPTION_DRAW_COUNTS, 0));
        assert_eq!(assumptions(found.broken).unwrap(), [DriverAssumption::EarlyTests]);
    }
}
