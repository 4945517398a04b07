//! The walks on the page of a device: those that were compared, and those that were timed.

use crate::report::{Report, RunReport};
use crate::result_page::{ResultPage, Table, Tone};
use crate::strategy::{Strategy, strategies};

/// Adds the section about the walks that were compared, if any was. `left_out` says which walks the
/// device cannot do.
pub(super) fn exactness(page: &mut ResultPage, reports: &[Report], left_out: &[String]) {
    let verified: Vec<&Report> = reports.iter().filter(|report| report.is_verified()).collect();
    if verified.is_empty() {
        return;
    }
    page.heading("Exactness");
    page.text(
        Tone::Plain,
        "Frames compared bit for bit with plain frustum culling, shadows with those of all casters \
         drawn afresh, under the validation layer's checks; any message would have ended this. A \
         city is walked through at eye level (street), flown over (fly), or seen from another place \
         every tenth frame (cut); a field hides little; `fences.gltf` is walls and fences with \
         textures, which cut holes into the fences.",
    );
    let row = |report: &&Report| {
        let checks = match report.argument("--validation") {
            Some("sync") => "core and synchronization",
            Some("on") => "core",
            _ => "none",
        };
        let mut names: Vec<&str> = report.runs.iter().map(|run| run.strategy.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        let [frames, wrong] = compared(report.runs.iter());
        vec![
            words(report),
            report.scene.objects.to_string(),
            report.predicates.clone(),
            checks.to_owned(),
            names.len().to_string(),
            frames.to_string(),
            wrong.to_string(),
        ]
    };
    let columns =
        ["walk", "objects", "draws skipped by", "checks", "strategies", "frames", "wrong pixels"];
    page.table(&Table::of(&columns, verified.iter().map(row).collect()));
    page.text(Tone::Plain, "The same by strategy:");
    let rows = strategies().into_iter().map(|strategy| of_strategy(&verified, strategy));
    page.table(&Table::of(&["strategy", "", "frames", "wrong pixels"], rows.collect()));
    lacking(page, reports, left_out);
}

/// Returns the row of a strategy: its compared frames, and its wrong pixels.
fn of_strategy(verified: &[&Report], strategy: Strategy) -> Vec<String> {
    let runs = verified.iter().flat_map(|report| &report.runs);
    let [frames, wrong] = match compared(runs.filter(|run| run.strategy == strategy.name())) {
        _ if !strategy.is_exact() => ["promises no exactness", ""].map(str::to_owned),
        [0, _] => ["none", ""].map(str::to_owned),
        counts => counts.map(|count| count.to_string()),
    };
    vec![format!("`{}`", strategy.name()), strategy.summary().to_owned(), frames, wrong]
}

/// Returns the frames of these runs that were compared, and the wrong pixels in them.
fn compared<'a>(runs: impl Iterator<Item = &'a RunReport>) -> [u64; 2] {
    runs.fold([0, 0], |[frames, wrong], run| {
        let compared = run.frames_verified + run.warm_up_frames_verified;
        [frames + compared, wrong + run.pixels_wrong.unwrap_or(0)]
    })
}

/// Adds a sentence for each walk that the device cannot do, and for each that it does with fewer
/// strategies.
fn lacking(page: &mut ResultPage, reports: &[Report], left_out: &[String]) {
    let fewer = reports.iter().filter_map(|report| {
        let first = report.left_out.first()?;
        let names: Vec<String> =
            report.left_out.iter().map(|row| format!("`{}`", row.strategy)).collect();
        Some(format!("{} without {}: {}", words(report), names.join(", "), first.reason))
    });
    let all: Vec<String> = left_out.iter().cloned().chain(fewer).collect();
    if !all.is_empty() {
        page.text(Tone::Plain, &format!("Left out on this device:\n\n- {}", all.join("\n- ")));
    }
}

/// Adds the section about the walks that were timed, if any was.
pub(super) fn timed(page: &mut ResultPage, reports: &[Report]) {
    let timed = reports.iter().filter(|report| !report.is_verified());
    let row = |(report, run): (&Report, &RunReport)| {
        let [width, height] = report.size;
        let number =
            |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
        let ratio = |other: &str| {
            if run.strategy == other {
                return "1".to_owned();
            }
            let ratio = report.paired_ratios.get(&format!("{}/{other}", run.strategy));
            number(ratio.copied().flatten())
        };
        vec![
            words(report),
            report.scene.objects.to_string(),
            format!("{width}x{height}"),
            format!("`{}`", run.strategy),
            number(run.frame_ms.median),
            ratio("ideal"),
            ratio("frustum"),
        ]
    };
    let runs = timed.flat_map(|report| report.runs.iter().map(move |run| (report, run)));
    let rows: Vec<Vec<String>> = runs.map(row).collect();
    if rows.is_empty() {
        return;
    }
    page.heading("Scenes and strategies");
    page.text(
        Tone::Plain,
        "Median times of a frame, and ratios frame by frame. `ideal` draws exactly what shows, \
         found beforehand: nobody can be faster.",
    );
    let columns = ["walk", "objects", "size", "strategy", "ms", "times the ideal", "times frustum"];
    page.table(&Table::of(&columns, rows));
}

/// Returns a walk in words: its scene and path, and all that differs from plain objects at rest.
fn words(report: &Report) -> String {
    let mut words = vec![format!("{} {}", report.scene.name, report.path)];
    if report.moving_percent > 0 {
        words.push(format!("{} % of the objects move", report.moving_percent));
    }
    if report.views > 1 {
        words.push(format!("{} eyes", report.views));
    }
    if report.samples_per_pixel > 1 {
        words.push(format!("{} samples per pixel", report.samples_per_pixel));
    }
    if let Some(section) = &report.section {
        words.push(format!("cut by {} planes ({})", section.planes.len(), section.mode));
    }
    words.extend(report.light_words());
    let mut ways: Vec<&str> = report.runs.iter().filter_map(|run| run.shadows.as_deref()).collect();
    ways.dedup();
    words.extend(ways.iter().filter(|way| **way != "off").map(|way| format!("shadow {way}")));
    words.join(", ")
}
