//! Tests of the figures: reached, missed, not measured.

use super::super::testing::{measured, verified, walked};
use super::*;
use crate::report::Report;

fn find<'a>(figures: &'a [Figure], case: &str, what: &str) -> &'a Figure {
    let fits = |figure: &&Figure| figure.case == case && figure.what.starts_with(what);
    figures.iter().find(fits).unwrap_or_else(|| panic!("no {what} of {case}"))
}

fn figures(reports: &[Report]) -> Vec<Figure> {
    all(&Cases::of(reports))
}

#[test]
fn without_reports_nothing_is_claimed() {
    let figures = figures(&[]);
    assert!(figures.len() > 25);
    for figure in &figures {
        assert_eq!(figure.verdict(), Verdict::NotMeasured, "{figure:?}");
        assert_eq!(figure.found_words(), "not measured");
    }
}

#[test]
fn every_repetition_counts_for_the_mark() {
    let walk = |antumbra| measured("city", "street", 10_000, &[(ANTUMBRA, antumbra), (IDEAL, 1.0)]);
    let verdict = |times: [f64; 3]| {
        let figures = figures(&times.map(walk));
        find(&figures, "street 10k", "antumbra / ideal").verdict()
    };
    assert_eq!(verdict([1.20, 1.22, 1.19]), Verdict::Reached);
    assert_eq!(verdict([1.20, 1.22, 1.23]), Verdict::ReachedInMedian);
    assert_eq!(verdict([1.20, 1.23, 1.24]), Verdict::Missed);
    let figures = figures(&[1.1, 1.3, 1.2].map(walk));
    let figure = find(&figures, "street 10k", "antumbra / ideal");
    assert_eq!(
        (figure.found_words().as_str(), figure.asked_words().as_str()),
        ("1.20 (1.10 to 1.30)", "at most 1.22")
    );
    let figures_near = self::figures(&[1.221, 1.224, 1.223].map(walk));
    let near = find(&figures_near, "street 10k", "antumbra / ideal");
    assert_eq!(near.found_words(), "1.223 (1.221 to 1.224)", "1.22 would look reached");
    assert_eq!(find(&figures, "street 10k", "95th").verdict(), Verdict::Reached);
    assert_eq!(find(&figures, "street 40k", "antumbra / ideal").verdict(), Verdict::NotMeasured);
}

#[test]
fn a_busy_machine_is_not_judged_and_the_impossible_neither() {
    let walk = |[ideal, antumbra]: [f64; 2]| {
        measured("city", "street", 10_000, &[(ANTUMBRA, antumbra), ("chc", 4.0), (IDEAL, ideal)])
    };
    let verdicts = |times: &[[f64; 2]]| {
        let reports: Vec<Report> = times.iter().copied().map(walk).collect();
        let figures = figures(&reports);
        ["antumbra / ideal", "95th"].map(|what| find(&figures, "street 10k", what).verdict())
    };
    assert_eq!(verdicts(&[[1.0, 1.1], [1.05, 1.2]]), [Verdict::Reached; 2]);
    assert_eq!(verdicts(&[[1.0, 1.1], [1.3, 1.4]]), [Verdict::TooNoisy; 2]);
    assert_eq!(verdicts(&[[1.0, 1.1], [1.3, 1.4], [1.01, 1.1]]), [Verdict::Reached; 2]);
    // No strategy is faster than the ideal: a lower time is noise or, beyond the noise, a mistake.
    assert_eq!(verdicts(&[[1.0, 0.97], [1.05, 1.02]]), [Verdict::Reached; 2]);
    assert_eq!(verdicts(&[[1.0, 0.8], [1.01, 0.8]]), [Verdict::Impossible; 2]);
    assert_eq!(verdicts(&[[1.0, 0.8]]), [Verdict::Impossible; 2], "also measured once");
    let words = Verdict::Impossible.words();
    assert!(words.contains("more than the noise"), "{words}");
}

#[test]
fn the_nearest_rival_decides_and_a_missing_one_leaves_it_open() {
    let times = [(ANTUMBRA, 2.0), ("chc", 3.0), ("hzb", 2.2), ("stop_and_wait", 9.0)];
    let complete: Vec<_> = times.into_iter().chain([("next_frame", 2.5)]).collect();
    let all = figures(&[measured("city", "street", 2_000, &complete)]);
    let figure = find(&all, "street 2k", "nearest rival");
    assert_eq!(figure.verdict(), Verdict::Reached);
    assert_eq!(
        (figure.found_words().as_str(), figure.note.as_str()),
        ("1.10", "nearest of chc, hzb, stop_and_wait, next_frame: hzb")
    );

    let partial = figures(&[measured("city", "street", 2_000, &times)]);
    let figure = find(&partial, "street 2k", "nearest rival");
    assert_eq!(figure.verdict(), Verdict::NotMeasured);
    assert!(figure.note.contains("not measured: next_frame"), "{}", figure.note);

    let slower = figures(&[measured("city", "street", 2_000, &[(ANTUMBRA, 4.0), times[1]])]);
    assert_eq!(find(&slower, "street 2k", "nearest rival").verdict(), Verdict::Missed);
}

#[test]
fn frustum_culling_is_tied_and_the_note_says_so() {
    let reports = [
        measured("city", "street", 10_000, &[(IDEAL, 1.0), (ANTUMBRA, 1.25)]),
        measured("city", "street", 10_000, &[(FRUSTUM, 13.0), (IDEAL, 1.0)]),
        measured("field", "fly", 10_000, &[(FRUSTUM, 10.0), (ANTUMBRA, 10.1)]),
        measured("field", "street", 10_000, &[(FRUSTUM, 10.0), (ANTUMBRA, 11.0)]),
    ];
    let figures = figures(&reports);
    let frustum = find(&figures, "street 10k", "frustum / antumbra");
    assert_eq!((frustum.verdict(), frustum.found_words().as_str()), (Verdict::Reached, "10.4"));
    assert!(frustum.note.contains("tied through ideal"));
    let above = find(&figures, "field 10k, from above", "antumbra / frustum");
    assert_eq!((above.verdict(), above.note.as_str()), (Verdict::Reached, ""));
    let side = find(&figures, "field 10k, from the side", "antumbra / frustum");
    assert_eq!(side.verdict(), Verdict::Missed);
}

#[test]
fn cuts_and_growth_have_their_rows() {
    let mut times = vec![1.1; 40];
    (times[12], times[22], times[32]) = (2.8, 2.6, 2.7);
    let mut large = measured("city", "street", 1_000_000, &[(ANTUMBRA, 12.0)]);
    large.runs[0].nodes_visited = Some(1_500);
    let reports = [
        walked("city", "cut", 10_000, &[(ANTUMBRA, times), (IDEAL, vec![1.0; 40])]),
        measured("city", "street", 10_000, &[(ANTUMBRA, 10.0)]),
        large,
    ];
    let figures = figures(&reports);
    assert_eq!(find(&figures, "cut 10k", "antumbra / ideal").verdict(), Verdict::Reached);
    let after = find(&figures, "cut 10k", "frame after a cut");
    assert_eq!((after.verdict(), after.found_words().as_str()), (Verdict::Missed, "2.70"));
    let growth = find(&figures, "street 10k to 1M", "CPU");
    assert_eq!((growth.verdict(), growth.found_words().as_str()), (Verdict::Reached, "1.20"));
    assert_eq!(growth.note, "1.00 ms to 1.20 ms; nodes looked at: 1,000 to 1,500");
}

#[test]
fn wrong_pixels_are_never_nearly_none() {
    let exact =
        |pixels| verified("city", "street", 500, &[("frustum", 9, 0), (ANTUMBRA, 9, pixels)]);
    let all = figures(&[exact(0)]);
    let still = find(&all, "still scenes", "wrong pixels of all");
    assert_eq!((still.verdict(), still.found_words().as_str()), (Verdict::Reached, "0"));
    assert_eq!(still.note, "18 frames compared");
    assert_eq!(find(&all, "several views", "wrong").verdict(), Verdict::NotMeasured);

    let moving = |names: &[(&str, u64, u64)]| {
        let mut report = verified("city", "street", 500, names);
        report.provenance.command = vec!["--moving-percent=10".to_owned()];
        let still = verified("city", "street", 500, &[(ANTUMBRA, 9, 0), (IDEAL, 9, 0)]);
        figures(&[still, report])
    };
    // The ideal cannot run where objects move; a missing antumbra is a gap.
    let reached = moving(&[(ANTUMBRA, 9, 0)]);
    assert_eq!(find(&reached, "moving objects", "wrong").verdict(), Verdict::Reached);
    let gap = moving(&[("frustum", 9, 0)]);
    assert_eq!(find(&gap, "moving objects", "wrong").verdict(), Verdict::NotMeasured);
    assert!(find(&gap, "moving objects", "wrong").note.ends_with("not compared: antumbra"));

    let one = figures(&[exact(0), exact(1), exact(0)]);
    assert_eq!(find(&one, "still scenes", "wrong pixels of all").verdict(), Verdict::Missed);

    let uncompared = measured("city", "street", 2_000, &[("frustum", 1.0), (ANTUMBRA, 1.0)]);
    let partly = figures(&[uncompared, verified("city", "fly", 500, &[(ANTUMBRA, 9, 0)])]);
    let still = find(&partly, "still scenes", "wrong pixels of all");
    assert_eq!(still.verdict(), Verdict::NotMeasured);
    assert!(still.note.contains("not compared: frustum"), "{}", still.note);

    let counted = figures(&[verified("city", "street", 500, &[("guesses", 9, 1_234)])]);
    let guesses = find(&counted, "still scenes", "wrong pixels of guesses");
    assert_eq!((guesses.verdict(), guesses.found_words().as_str()), (Verdict::Shown, "1,234"));
}
