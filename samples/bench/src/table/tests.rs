//! Tests of the table: every number is there, and it fits.

use super::*;
use crate::measurement::RunMeasurement;
use crate::report::tests::example;
use antumbra::methods;

#[test]
fn a_person_finds_every_number() {
    let text = render(&example(), 120);
    for expected in [
        "llvmpipe (llvmpipe Mesa 22.3.6, Vulkan 1.3.230), hidden draws skipped by conditional",
        "city of 10,012 objects, 9,876,543 triangles, seed 1",
        "path street, 2 frames of 1280x720, 2 in flight",
        "31.50",
        "33.00",
        "10.50",
        "3.15",
        "1.05",
        "3,000",
        "frustum takes 3.00 times as long per frame as antumbra",
        "antumbra, by cost: 4 objects untested per frame, 0.00 ms saved (expected); tests times 1.00, from 7",
        "scene 1.50, hierarchy 2.50, upload 3.50; peak memory 123 MiB, on the device 56 MiB",
        "frames compared with frustum culling: 2; blocking waits: 0; validation messages: 0",
    ] {
        assert!(text.contains(expected), "'{expected}' is missing in\n{text}");
    }
    assert!(!text.contains("WRONG"));
    assert!(text.lines().all(|line| line.chars().count() <= 120), "too wide:\n{text}");
}

#[test]
fn it_fits_terminals_of_any_width() {
    let mut report = example();
    for run in &mut report.runs {
        run.frame_ms.median = Some(123_456.78);
        run.triangles = Some(123_456_789);
        run.strategy = "antumbra_compute".to_owned();
    }
    report.cut_short = true;
    for width in [40, 60, 80, 100, 120, 200] {
        let text = render(&report, width);
        let widest = text.lines().map(|line| line.chars().count()).max().unwrap();
        assert!(widest <= width, "{widest} columns of {width}:\n{text}");
        for column in COLUMNS.iter().flat_map(|column| column.lines()) {
            assert!(text.contains(column), "{column} is missing in\n{text}");
        }
        let rows = text.lines().filter(|line| line.contains("\u{2502} antumbra_compute")).count();
        assert_eq!(rows == report.runs.len(), width >= 120, "{width} columns:\n{text}");
        assert!(text.contains("CUT SHORT by a signal"), "{text}");
    }
}

#[test]
fn of_many_runs_each_is_compared_with_three() {
    let mut report = example();
    let run = |strategy: Strategy, frame_ms: f64| {
        let mut run = report.runs[0].clone();
        run.strategy = strategy.name().to_owned();
        run.frame_ms.median = Some(frame_ms);
        run
    };
    report.runs = crate::strategy::strategies()
        .iter()
        .zip(1..)
        .map(|(strategy, ms)| run(*strategy, ms.into()))
        .collect();
    report.ratios = crate::report::ratios(&report.runs);
    let text = render(&report, 120);
    let lines = text.lines().filter(|line| line.starts_with("a frame of ")).count();
    assert_eq!(lines, crate::strategy::strategies().len(), "{text}");
    let naive = "a frame of naive takes 2.00 times frustum, 0.25 times antumbra, 0.17 times ideal";
    assert!(text.contains(naive) && !text.contains("as long per frame"), "{text}");
}

#[test]
fn what_of_a_file_is_not_shown_is_told() {
    let mut report = example();
    assert!(!render(&report, 120).contains("not as in the file"));
    let notes = vec!["sparks: 3".to_owned(), "orthographic cameras: 1".to_owned()];
    report.scene.file = Some(crate::report::FileReport { notes, ..Default::default() });
    let text = render(&report, 120);
    assert!(text.contains("not as in the file: sparks: 3\nnot as in the file: orthographic"));
}

#[test]
fn what_is_absent_is_a_dash_and_what_is_wrong_is_loud() {
    let mut report = example();
    report.runs = vec![RunMeasurement::new(Strategy::FRUSTUM).report()];
    let text = render(&report, 120);
    let row: Vec<&str> = text
        .lines()
        .find(|line| line.contains("│ frustum"))
        .unwrap()
        .split(['│', '┆'])
        .map(str::trim)
        .filter(|cell| !cell.is_empty())
        .collect();
    assert_eq!(row, ["frustum", "-", "-", "-", "-", "-", "-", "-", "-", "-"]);

    let mut wrong = RunMeasurement::new(Strategy::ANTUMBRA);
    wrong.verified(1234);
    report.runs = vec![wrong.report()];
    assert!(render(&report, 120).contains("WRONG: 1234 pixels differ"));
    let mut loose = RunMeasurement::new(methods::NEXT_FRAME);
    loose.verified(1234);
    report.runs = vec![loose.report()];
    let text = render(&report, 120);
    assert!(text.contains("1,234") && !text.contains("WRONG"), "{text}");
}

#[test]
fn what_a_threshold_leaves_out_is_told_and_not_called_wrong() {
    let mut report = example();
    assert!(!render(&report, 120).contains("left out"));
    report.threshold_pixels = 12;
    report.runs[1].samples_below_threshold = 2_500;
    report.runs[1].pixels_wrong = Some(1_234);
    report.runs[1].pixels_wrong_at_most = Some(2_409);
    let text = render(&report, 120);
    for expected in [
        "not exact: objects that show at most 12 pixels count as hidden",
        "antumbra left out 2,500 samples in 2 frames; of those compared 1,234 pixels differ, at most 2,409 could",
    ] {
        assert!(text.contains(expected), "'{expected}' is missing in\n{text}");
    }
    assert!(!text.contains("WRONG"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 120), "too wide:\n{text}");
    report.runs[1].pixels_wrong = Some(2_410);
    assert!(render(&report, 120).contains("WRONG: 2410 pixels differ"));
}

#[test]
fn thousands_are_separated() {
    let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")];
    for (value, text) in cases {
        assert_eq!(count(Some(value)), text);
    }
}
