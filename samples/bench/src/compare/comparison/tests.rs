//! Tests of the comparison: headline, rows, missing measurements, warnings.

use super::super::page::{self, swatches};
use super::super::testing::{measured, verified};
use super::*;

fn example() -> Vec<Report> {
    vec![
        measured("city", "street", 2_000, &[("ideal", 1.0), ("antumbra", 1.2), ("naive", 90.0)]),
        measured("city", "street", 10_000, &[("ideal", 1.0), ("antumbra", 1.25)]),
        measured("city", "street", 10_000, &[("frustum", 13.0), ("ideal", 1.0)]),
        verified("city", "street", 500, &[("frustum", 9, 0), ("antumbra", 9, 0), ("ideal", 9, 0)]),
    ]
}

#[test]
fn the_headline_says_the_ratio() {
    let reports = example();
    assert_eq!(
        ReportComparison::of(&reports).headline().unwrap(),
        "In a city of 10,000 objects at street level, antumbra takes 1.25 times the frame time of \
         ideal; plain frustum culling takes 13.0 times."
    );
    assert_eq!(ReportComparison::of(&example()[3..]).yardstick, IDEAL);
}

#[test]
fn every_method_has_a_row() {
    let reports = example();
    let comparison = ReportComparison::of(&reports);
    assert_eq!(comparison.sizes, [2_000, 10_000]);
    let table = page::methods(&comparison);
    let texts = |column: usize| table.rows.iter().map(move |row| row[column].text.as_str());
    assert!(texts(0).eq(["`frustum`", "`naive`", "`antumbra`", "`ideal`"]));
    assert!(texts(1).eq(["-", "90.0", "1.20", "1.00"]));
    assert!(texts(2).eq(["13.0", "-", "1.25", "1.00"]));
    assert!(texts(7).eq(["0", "not compared", "0", "0"]));
}

#[test]
fn what_beats_the_ideal_is_marked() {
    let times = [("ideal", 1.0), ("antumbra", 1.2), ("chc", 0.7), ("hzb", 0.95)];
    let reports = [measured("city", "street", 10_000, &times)];
    let page = page::page(&ReportComparison::of(&reports)).unwrap();
    for text in [page.html(&swatches()).as_str(), page.markdown()] {
        let row = text.lines().find(|line| line.contains("(impossible)")).unwrap();
        assert!(row.contains("chc") && text.matches("(impossible)").count() == 1);
    }
}

#[test]
fn what_is_left_out_is_said_with_its_time() {
    assert_eq!(
        ReportComparison::of(&example()).left_out[0],
        "naive: left out above 2,000 objects: 90.0 ms per frame there"
    );
    let few = [measured("city", "fly", 10_000, &[("mystery", 1.0)])];
    let left_out = ReportComparison::of(&few).left_out;
    for strategy in crate::strategy::strategies() {
        assert!(left_out.contains(&format!("{strategy}: not measured in any report")));
    }
}

#[test]
fn smaller_frames_and_old_reports_are_warned_of() {
    assert_eq!(ReportComparison::of(&example()).warnings(), [""; 0]);
    let mut reports = example();
    reports[0].size = [640, 360];
    reports[1].runs[0].frame_times_ms.clear();
    let warnings = ReportComparison::of(&reports).warnings();
    assert!(warnings[0].contains("1 of 3 timed walks have frames of 640x360"), "{warnings:?}");
    assert!(warnings[1].contains("city-street-10000.json"), "{warnings:?}");
}

#[test]
fn verdicts_are_counted() {
    let reports = example();
    let comparison = ReportComparison::of(&reports);
    let count = |wanted| {
        comparison.verdicts().into_iter().find(|(verdict, _)| *verdict == wanted).unwrap().1
    };
    assert!(count(Verdict::Missed) >= 2, "1.2 and 1.25 are more than asked");
    let counted: usize = comparison.verdicts().iter().map(|(_, count)| count).sum();
    let shown = comparison.figures.iter().filter(|f| f.verdict() == Verdict::Shown).count();
    assert_eq!(counted + shown, comparison.figures.len());
}
