//! Hosts that drop frames, submit them twice, or in another order.

use gpu::Resubmission;
use tests::drivers;

use super::host::{HostOptions, Submits, compare};

#[test]
fn frames_that_are_never_submitted_leave_no_answers() {
    for driver in drivers() {
        // Among them the first frame, which uploads everything.
        let is_dropped = |frame: u64| frame.is_multiple_of(5) || frame % 7 == 3;
        let submits = |frame| if is_dropped(frame) { Submits::Never } else { Submits::Once };
        let draws = compare(driver, &HostOptions::default(), submits);
        assert!(draws.culled > 1, "{driver:?}: {draws:?}");
    }
}

#[test]
fn frames_that_are_submitted_twice_are_exact() {
    for driver in drivers() {
        let options = HostOptions { resubmission: Resubmission::Allowed, ..HostOptions::default() };
        compare(driver, &options, |frame| match frame % 4 {
            1 => Submits::Twice,
            _ => Submits::Once,
        });
    }
}

#[test]
fn frames_in_another_order_are_exact() {
    for driver in drivers() {
        compare(
            driver,
            &HostOptions { first: 1_000, ..HostOptions::default() },
            |frame| match frame % 6 {
                0 | 3 => Submits::Late,
                _ => Submits::Once,
            },
        );
    }
}
