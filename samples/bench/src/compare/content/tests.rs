//! Tests of the content: headline, rows, missing measurements, warnings.

use super::super::testing::{measured, verified};
use super::*;

fn example() -> Vec<Measured> {
    vec![
        measured("city", "street", 2_000, &[("ideal", 1.0), ("antumbra", 1.2), ("naive", 90.0)]),
        measured("city", "street", 10_000, &[("ideal", 1.0), ("antumbra", 1.25)]),
        measured("city", "street", 10_000, &[("frustum", 13.0), ("ideal", 1.0)]),
        verified("city", "street", 500, &[("frustum", 9, 0), ("antumbra", 9, 0), ("ideal", 9, 0)]),
    ]
}

#[test]
fn the_headline_says_the_ratio() {
    let content = Content::of(&example()).unwrap();
    assert_eq!(
        content.headline().unwrap(),
        "In a city of 10,000 objects at street level, antumbra takes 1.25 times the frame time of \
         ideal; plain frustum culling takes 13.0 times."
    );
    assert_eq!(Content::of(&example()[3..]).unwrap().yardstick, IDEAL);
}

#[test]
fn every_method_has_a_row() {
    let content = Content::of(&example()).unwrap();
    let names: Vec<&str> = content.methods.iter().map(|row| row.strategy.as_str()).collect();
    assert_eq!(names, ["frustum", "naive", "antumbra", "ideal"]);
    assert_eq!(content.sizes, [2_000, 10_000]);
    let naive = &content.methods[1];
    assert_eq!(naive.ratios[1], None);
    assert_eq!(naive.ratios[0].as_ref().unwrap().median(), 90.0);
    assert_eq!((naive.pixels_wrong, content.methods[2].pixels_wrong), (None, Some(0)));
}

#[test]
fn what_beats_the_ideal_is_marked() {
    let times = [("ideal", 1.0), ("antumbra", 1.2), ("chc", 0.7), ("hzb", 0.95)];
    let content = Content::of(&[measured("city", "street", 10_000, &times)]).unwrap();
    for row in &content.methods {
        assert_eq!(row.impossible, [row.strategy == "chc"], "{}", row.strategy);
    }
    assert_eq!(super::super::page::render(&content).matches("\"missed\">impossible<").count(), 1);
    assert_eq!(super::super::markdown::render(&content).matches("(impossible)").count(), 1);
}

#[test]
fn what_is_left_out_is_said_with_its_time() {
    let content = Content::of(&example()).unwrap();
    assert_eq!(content.left_out[0], "naive: left out above 2,000 objects: 90.0 ms per frame there");
    let few = [measured("city", "fly", 10_000, &[("mystery", 1.0)])];
    let left_out = Content::of(&few).unwrap().left_out;
    for strategy in crate::strategy::strategies() {
        assert!(left_out.contains(&format!("{strategy}: not measured in any report")));
    }
}

#[test]
fn smaller_frames_and_old_reports_are_warned_of() {
    assert_eq!(Content::of(&example()).unwrap().warnings, [""; 0]);
    let mut reports = example();
    reports[0].size = [640, 360];
    reports[1].runs[0].frame_times_ms.clear();
    let warnings = Content::of(&reports).unwrap().warnings;
    assert!(warnings[0].contains("1 of 3 timed walks have frames of 640x360"), "{warnings:?}");
    assert!(warnings[1].contains("city-street-10000.json"), "{warnings:?}");
}

#[test]
fn verdicts_are_counted() {
    let content = Content::of(&example()).unwrap();
    let count =
        |wanted| content.verdicts().into_iter().find(|(verdict, _)| *verdict == wanted).unwrap().1;
    assert!(count(Verdict::Missed) >= 2, "1.2 and 1.25 are more than asked");
    let counted: usize = content.verdicts().iter().map(|(_, count)| count).sum();
    let shown = content.figures.iter().filter(|f| f.verdict() == Verdict::Shown).count();
    assert_eq!(counted + shown, content.figures.len());
}
