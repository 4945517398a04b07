//! Tests of the report: its keys, its ratios, and that all its numbers are finite.

use super::*;
use crate::measurement::{FrameMeasurement, RunMeasurement};
use crate::shadow_choice::{ShadowChoice, ShadowWay};
use crate::strategy::Strategy;
use antumbra::cull;
use antumbra::render::FrameReport;
use antumbra::shadows::ShadowFilter;
use serde_json::{Value, json};

fn run(strategy: Strategy, frame_ms: &[f64]) -> RunReport {
    let mut run = RunMeasurement::new(strategy);
    for &frame_ms in frame_ms {
        let plan = cull::PlanStats {
            nodes_visited: 9,
            untested_by_cost: 4,
            rounds_by_compute: 1,
            retest_interval_frames: 16,
            expected_saving_ns: 5,
            ..Default::default()
        };
        let corrections = cull::Corrections { tests: 1.5, frames: 7, ..Default::default() };
        let report = FrameReport {
            tests: 3,
            queries: 2,
            predicated_draws: 1,
            plan,
            corrections: Some(corrections),
            oldest_answer_frames: Some(2),
            ..Default::default()
        };
        let cpu_ms = frame_ms / 10.0;
        let counts = FrameMeasurement { draws: 3, triangles: 3000, ..Default::default() };
        run.push(FrameMeasurement { frame_ms, cpu_ms, report, ..counts });
    }
    run.verified(0);
    run.report()
}

pub(crate) fn example() -> Report {
    let runs = vec![run(Strategy::FRUSTUM, &[30.0, 33.0]), run(Strategy::ANTUMBRA, &[10.0, 11.0])];
    Report {
        device: DeviceReport {
            name: "llvmpipe".into(),
            driver: "llvmpipe Mesa 22.3.6".into(),
            api: "1.3.230".into(),
            conditional_rendering: true,
        },
        scene: SceneReport {
            name: "city".into(),
            objects: 10_012,
            triangles: 9_876_543,
            seed: 1,
            file: None,
        },
        path: "street".into(),
        views: 1,
        projection: "perspective".into(),
        moving_percent: 10,
        moving_objects: 1_002,
        frames: 2,
        size: [1280, 720],
        samples_per_pixel: 1,
        frames_in_flight: 2,
        predicates: "conditional".into(),
        skip_ns: [("conditional".to_owned(), Some(50_000.0))].into(),
        tester: "flags".into(),
        reset_ns: [("cpu".to_owned(), None), ("command".to_owned(), Some(2.5))].into(),
        costs_ns: [("draw_ns".to_owned(), Some(1_400.0))].into(),
        memory: MemoryReport { peak_resident_mib: Some(123.4), gpu_allocated_mib: Some(56.0) },
        build_ms: BuildReport { scene: Some(1.5), hierarchy: Some(2.5), upload: Some(3.5) },
        ratios: ratios(&runs),
        paired_ratios: paired_ratios(&runs),
        left_out: vec![LeftOut { strategy: "ideal".into(), reason: "things move".into() }],
        provenance: Provenance { command: vec!["walkthrough".into()], unix_s: 1_795_230_000 },
        runs,
        ..Report::default()
    }
}

#[test]
fn the_keys_are_the_contract() {
    let json: Value = serde_json::from_str(&example().to_json().unwrap()).unwrap();
    let run = |strategy: &str, low: f64, high: f64| {
        let learned = json!({"draws": 1.0, "tests": 1.5, "proportion": 1.0, "frames": 7});
        json!({
            "strategy": strategy,
            "frame_ms": {"median": (low + high) / 2.0, "p95": high, "max": high},
            "frame_times_ms": [low, high],
            "cpu_ms": {"median": (low + high) / 20.0, "p95": high / 10.0, "max": high / 10.0},
            "draws": 3, "triangles": 3000, "tests": 3, "queries": 2, "predicated_draws": 1, "nodes_visited": 9,
            "untested_by_cost": 4, "rounds_by_compute": 1, "retest_interval_frames": 16, "expected_saving_ns": 5,
            "corrections": if strategy == "antumbra" { learned } else { Value::Null },
            "passes_ms": {},
            "result_age_frames": {"median": 2, "max": 2},
            "waits": 0, "blocking_waits": 0, "frames_timed": 2, "frames_verified": 1,
            "warm_up_frames_verified": 0, "pixels_wrong": 0,
            "pixels_wrong_at_most": 0, "samples_below_threshold": 0,
        })
    };
    let expected = json!({
        "device": {
            "name": "llvmpipe", "driver": "llvmpipe Mesa 22.3.6", "api": "1.3.230",
            "conditional_rendering": true,
        },
        "scene": {"name": "city", "objects": 10_012, "triangles": 9_876_543, "seed": 1},
        "path": "street", "views": 1, "projection": "perspective", "moving_percent": 10, "moving_objects": 1_002, "frames": 2, "cut_short": false,
        "size": [1280, 720], "samples_per_pixel": 1, "frames_in_flight": 2, "predicates": "conditional", "skip_ns": { "conditional": 50000.0 },
        "tester": "flags", "reset_ns": { "cpu": null, "command": 2.5 },
        "threshold_pixels": 0,
        "left_out": [{ "strategy": "ideal", "reason": "things move" }],
        "costs_ns": { "draw_ns": 1400.0 }, "validation_messages": 0, "driver_quirks": [],
        "memory": {"peak_resident_mib": 123.4, "gpu_allocated_mib": 56.0},
        "build_ms": {"scene": 1.5, "hierarchy": 2.5, "upload": 3.5},
        "runs": [run("frustum", 30.0, 33.0), run("antumbra", 10.0, 11.0)],
        "ratios": {"frustum/antumbra": 3.0, "antumbra/frustum": 0.3333},
        "paired_ratios": {"frustum/antumbra": 3.0, "antumbra/frustum": 0.3333},
        "provenance": {"command": ["walkthrough"], "unix_s": 1_795_230_000},
    });
    assert_eq!(json, expected);
}

#[test]
fn what_was_not_measured_is_null() {
    let mut report = example();
    report.runs =
        vec![RunMeasurement::new(Strategy::FRUSTUM).report(), run(Strategy::ANTUMBRA, &[f64::NAN])];
    report.ratios = ratios(&report.runs);
    report.paired_ratios = paired_ratios(&report.runs);
    let json: Value = serde_json::from_str(&report.to_json().unwrap()).unwrap();
    assert_eq!(json["ratios"]["frustum/antumbra"], Value::Null);
    assert_eq!(json["paired_ratios"]["frustum/antumbra"], Value::Null);
    assert_eq!(json["runs"][1]["frame_times_ms"], json!([null]));
    assert_eq!(json["runs"][0]["pixels_wrong"], Value::Null);
    assert_eq!(json["runs"][0]["draws"], Value::Null);
    assert_eq!(json["runs"][1]["frame_ms"]["median"], Value::Null);
    assert_eq!(json["runs"][1]["frames_timed"], 1);
}

#[test]
fn runs_with_shadows_say_which_and_have_ratios_by_them() {
    let mut report = example();
    report.lights = Some("sun".to_owned());
    let with = |filter| {
        let choice = ShadowChoice { way: ShadowWay::Maps, filter, ..ShadowChoice::OFF };
        let mut run = RunMeasurement::new(Strategy::ANTUMBRA).with_shadows(Some(choice));
        let mut frame = FrameMeasurement { frame_ms: 2.0, ..Default::default() };
        frame.report.shadows.drawn_faces = 4;
        run.push(frame);
        run.report()
    };
    report.runs = vec![with(ShadowFilter::Pcf3), with(ShadowFilter::Adaptive)];
    report.ratios = ratios(&report.runs);
    let json: Value = serde_json::from_str(&report.to_json().unwrap()).unwrap();
    assert_eq!(json["lights"], "sun");
    let run = &json["runs"][1];
    assert_eq!([&run["shadows"], &run["filter"], &run["bias"]], ["maps", "adaptive", "plane"]);
    assert_eq!((&run["shadow_faces"], &run["shadow_casters"]), (&json!(4), &json!(0)));
    assert_eq!(run["shadow_triangles"], json!(0));
    assert_eq!(json["ratios"]["antumbra maps pcf3/antumbra maps adaptive"], 1.0);
    report.runs.truncate(1);
    assert_eq!(labels(&report.runs), ["antumbra"], "one way needs no name");
}

#[test]
fn one_strategy_has_no_ratios() {
    assert!(ratios(&[run(Strategy::FRUSTUM, &[1.0])]).is_empty());
}
