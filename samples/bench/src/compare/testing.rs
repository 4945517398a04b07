//! Small made-up reports for tests.

use crate::report::{Report, RunReport, SceneReport, paired_ratios, ratios};
use crate::statistics::TimeSummary;

/// Returns a report whose strategies take these times in every one of 24 frames.
pub fn measured(scene: &str, path: &str, objects: u64, times_ms: &[(&str, f64)]) -> Report {
    let flat: Vec<_> = times_ms.iter().map(|&(name, time)| (name, vec![time; 24])).collect();
    walked(scene, path, objects, &flat)
}

/// Returns a report whose strategies take these times over the path.
pub fn walked(scene: &str, path: &str, objects: u64, times_ms: &[(&str, Vec<f64>)]) -> Report {
    let run = |(name, times): &(&str, Vec<f64>)| RunReport {
        strategy: (*name).to_owned(),
        frame_ms: TimeSummary::of(times.iter().copied()),
        frame_times_ms: times.iter().copied().map(Some).collect(),
        cpu_ms: TimeSummary::of(times.iter().map(|time| time / 10.0)),
        draws: Some(50),
        tests: Some(if *name == "frustum" { 0 } else { 300 }),
        queries: Some(if *name == "frustum" { 0 } else { 120 }),
        nodes_visited: Some(objects / 10),
        ..RunReport::default()
    };
    let runs: Vec<RunReport> = times_ms.iter().map(run).collect();
    let mut measured = Report {
        file: format!("{scene}-{path}-{objects}.json"),
        scene: SceneReport { name: scene.to_owned(), objects, ..SceneReport::default() },
        path: path.to_owned(),
        size: [1280, 720],
        frames: 24,
        frames_in_flight: 2,
        ratios: ratios(&runs),
        paired_ratios: paired_ratios(&runs),
        runs,
        ..Report::default()
    };
    measured.device.name = "llvmpipe".to_owned();
    measured
}

/// Returns a report of strategies with their compared frames and wrong pixels.
pub fn verified(scene: &str, path: &str, objects: u64, runs: &[(&str, u64, u64)]) -> Report {
    let times: Vec<_> = runs.iter().map(|&(name, ..)| (name, 1.0)).collect();
    let mut measured = measured(scene, path, objects, &times);
    for (run, &(_, frames, pixels)) in measured.runs.iter_mut().zip(runs) {
        (run.frames_verified, run.pixels_wrong) = (frames, Some(pixels));
    }
    measured
}
