//! Tests of the cases: grouping, ratios, also through third strategies, and cuts.

use super::super::testing::{measured, verified, walked};
use super::*;

fn at<'a>(reports: &'a [Report], path: &str, objects: u64) -> Case<'a> {
    Cases::of(reports).at(&Place::still("city", path, objects))
}

#[test]
fn repetitions_come_together_and_other_places_stay_apart() {
    let mut two_views = measured("city", "street", 10_012, &[(ANTUMBRA, 9.0), (IDEAL, 1.0)]);
    two_views.provenance.command = vec!["walkthrough".into(), "--views=2".into()];
    let reports = [
        measured("city", "street", 10_012, &[(ANTUMBRA, 3.0), (IDEAL, 2.0)]),
        measured("city", "street", 9_990, &[(ANTUMBRA, 2.4), (IDEAL, 2.0)]),
        measured("city", "street", 2_001, &[(ANTUMBRA, 9.0), (IDEAL, 1.0)]),
        measured("city", "fly", 10_012, &[(ANTUMBRA, 9.0), (IDEAL, 1.0)]),
        two_views,
    ];
    let ratio = at(&reports, "street", 10_000).ratio(ANTUMBRA, IDEAL).unwrap();
    assert_eq!(ratio.spread, Spread::of([1.5, 1.2]).unwrap());
    assert_eq!(ratio.through, None);
    assert_eq!(Cases::of(&reports).sizes("city", "street"), [2_000, 10_000]);
    assert_eq!(at(&reports, "street", 40_000).ratio(ANTUMBRA, IDEAL), None);
}

#[test]
fn what_was_asked_for_names_the_size() {
    let mut report = measured("city", "street", 1_940, &[(ANTUMBRA, 1.0)]);
    report.provenance.command = ["walkthrough", "--objects", "2000"].map(str::to_owned).to_vec();
    assert_eq!(Place::of(&report).objects, 2_000);
    // The caller of a script repeated the option: the last value counts.
    report.provenance.command.push("--objects=3000".to_owned());
    assert_eq!(Place::of(&report).objects, 3_000);
    assert_eq!([7, 99, 104, 1_949, 99_600].map(two_digits), [7, 99, 100, 1_900, 100_000]);
}

#[test]
fn strategies_of_different_walks_are_tied_through_a_third() {
    let reports = [
        measured("city", "street", 10_000, &[(IDEAL, 2.0), (ANTUMBRA, 3.0), ("chc", 4.0)]),
        // The machine was half as fast.
        measured("city", "street", 10_000, &[(FRUSTUM, 40.0), (IDEAL, 4.0)]),
    ];
    let case = at(&reports, "street", 10_000);
    let ratio = case.ratio(FRUSTUM, ANTUMBRA).unwrap();
    assert!((ratio.spread.median() - 10.0 * 2.0 / 3.0).abs() < 1e-3, "{ratio:?}");
    assert_eq!(ratio.through.as_deref(), Some(IDEAL));
    assert_eq!(case.ratio(FRUSTUM, "hzb"), None);
    assert_eq!(case.ratio(FRUSTUM, FRUSTUM).unwrap().spread.median(), 1.0);
    assert_eq!(case.strategies(), [IDEAL, ANTUMBRA, "chc", FRUSTUM]);
    // The time of the ideal comes from the walk with the most strategies.
    assert_eq!(case.frame_ms(IDEAL).unwrap().median(), 2.0);
}

#[test]
fn without_frame_by_frame_ratios_those_of_the_medians_will_do() {
    let mut report = measured("city", "street", 10_000, &[(ANTUMBRA, 3.0), (IDEAL, 2.0)]);
    report.paired_ratios.clear();
    let reports = [report];
    let ratio = at(&reports, "street", 10_000).ratio(ANTUMBRA, IDEAL).unwrap();
    assert_eq!(ratio.spread.median(), 1.5);
}

#[test]
fn times_of_compared_walks_do_not_count_beside_others() {
    let mut slow = verified("city", "street", 10_000, &[(ANTUMBRA, 9, 0), (IDEAL, 9, 0)]);
    slow.paired_ratios.insert("antumbra/ideal".into(), Some(7.0));
    let both = [slow, measured("city", "street", 10_000, &[(ANTUMBRA, 3.0), (IDEAL, 2.0)])];
    let ratio = |reports: &[Report]| {
        at(reports, "street", 10_000).ratio(ANTUMBRA, IDEAL).unwrap().spread.median()
    };
    assert_eq!(ratio(&both), 1.5);
    assert_eq!(ratio(&both[..1]), 7.0, "unless there are none");
}

#[test]
fn the_frame_after_a_cut_is_found_although_it_shows_late() {
    // Jumps at 10, 20 and 30; with two frames in flight their work shows at 12, 22 and 32.
    let mut times = vec![2.0; 40];
    (times[12], times[22], times[32], times[35]) = (4.0, 6.0, 5.0, 90.0);
    let reports = [walked("city", "cut", 10_000, &[(ANTUMBRA, times), (IDEAL, vec![2.0; 40])])];
    let case = at(&reports, "cut", 10_000);
    assert_eq!(case.after_cut_ratio(ANTUMBRA, IDEAL).unwrap().median(), 2.5);
    assert_eq!(case.after_cut_ratio(ANTUMBRA, FRUSTUM), None);
    let short = [measured("city", "cut", 10_000, &[(ANTUMBRA, 1.0), (IDEAL, 1.0)])];
    let mut short = short;
    short[0].runs.iter_mut().for_each(|run| run.frame_times_ms.truncate(8));
    assert_eq!(at(&short, "cut", 10_000).after_cut_ratio(ANTUMBRA, IDEAL), None, "no jump");
}

#[test]
fn cpu_times_come_from_walks_alone_where_there_are_such() {
    let reports = [
        measured("city", "street", 10_000, &[(ANTUMBRA, 30.0), (IDEAL, 2.0)]),
        measured("city", "street", 10_000, &[(ANTUMBRA, 10.0)]),
    ];
    let case = at(&reports, "street", 10_000);
    assert_eq!(case.cpu_ms(ANTUMBRA).unwrap().median(), 1.0);
    assert_eq!(case.cpu_ms(IDEAL).unwrap().median(), 0.2);
    assert_eq!(case.cpu_ms(FRUSTUM), None);
}

#[test]
fn frame_times_are_the_median_of_the_repetitions() {
    let walk = |times: [f64; 3]| walked("city", "street", 10_000, &[(ANTUMBRA, times.to_vec())]);
    let reports = [walk([1.0, 5.0, 9.0]), walk([2.0, 4.0, 9.0]), walk([3.0, 60.0, 9.0])];
    let times = at(&reports, "street", 10_000).frame_times_ms(ANTUMBRA);
    assert_eq!(times, [Some(2.0), Some(5.0), Some(9.0)]);
}
