//! The walks on the page of a device: those that were compared, and those that were timed.

use super::text::{head, row};
use crate::compare::input::{Measured, MeasuredRun};
use crate::strategy::strategies;

/// Returns the section about the walks that were compared; nothing where none was. `left_out` says
/// which walks the device cannot do.
pub(super) fn exactness(reports: &[Measured], left_out: &[String]) -> String {
    let verified: Vec<&Measured> = reports.iter().filter(|report| report.is_verified()).collect();
    if verified.is_empty() {
        return String::new();
    }
    let mut text = "\n## Exactness\n\nFrames compared bit for bit with plain frustum culling, shadows \
                    with those of all casters drawn afresh, under the validation layer's checks; any \
                    message would have ended this. A city is walked through at eye level (street), \
                    flown over (fly), or seen from another place every tenth frame (cut); a field \
                    hides little; `fences.gltf` is walls and fences with textures, which cut holes \
                    into the fences.\n\n"
        .to_owned();
    text += &head(&[
        "walk",
        "objects",
        "draws skipped by",
        "checks",
        "strategies",
        "frames",
        "wrong pixels",
    ]);
    for report in &verified {
        let checks = match report.argument("--validation") {
            Some("sync") => "core and synchronization",
            Some("on") => "core",
            _ => "none",
        };
        let mut names: Vec<&str> = report.runs.iter().map(|run| run.strategy.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        let [frames, wrong] = compared(report.runs.iter());
        text += &row(&[
            words(report),
            report.scene.objects.to_string(),
            report.predicates.clone(),
            checks.to_owned(),
            names.len().to_string(),
            frames.to_string(),
            wrong.to_string(),
        ]);
    }
    text + &of_strategies(&verified) + &lacking(reports, left_out)
}

/// Returns the table of what was compared of each strategy.
fn of_strategies(verified: &[&Measured]) -> String {
    let mut text = "\nThe same by strategy:\n\n".to_owned();
    text += &head(&["strategy", "", "frames", "wrong pixels"]);
    for strategy in strategies() {
        let runs = verified.iter().flat_map(|report| &report.runs);
        let cells = match compared(runs.filter(|run| run.strategy == strategy.name())) {
            _ if !strategy.is_exact() => ["promises no exactness", ""].map(str::to_owned),
            [0, _] => ["none", ""].map(str::to_owned),
            counts => counts.map(|count| count.to_string()),
        };
        let [frames, wrong] = cells;
        let name = format!("`{}`", strategy.name());
        text += &row(&[name, strategy.summary().to_owned(), frames, wrong]);
    }
    text
}

/// Returns the frames of these runs that were compared, and the wrong pixels in them.
fn compared<'a>(runs: impl Iterator<Item = &'a MeasuredRun>) -> [u64; 2] {
    runs.fold([0, 0], |[frames, wrong], run| {
        let compared = run.frames_verified + run.warm_up_frames_verified;
        [frames + compared, wrong + run.pixels_wrong.unwrap_or(0)]
    })
}

/// Returns a sentence for each walk that the device cannot do, and for each that it does with fewer
/// strategies.
fn lacking(reports: &[Measured], left_out: &[String]) -> String {
    let fewer = reports.iter().filter_map(|report| {
        let first = report.left_out.first()?;
        let names: Vec<String> =
            report.left_out.iter().map(|row| format!("`{}`", row.strategy)).collect();
        Some(format!("{} without {}: {}", words(report), names.join(", "), first.reason))
    });
    let all: Vec<String> = left_out.iter().cloned().chain(fewer).collect();
    if all.is_empty() {
        return String::new();
    }
    format!("\nLeft out on this device:\n\n- {}\n", all.join("\n- "))
}

/// Returns the section about the walks that were timed; nothing where none was.
pub(super) fn timed(reports: &[Measured]) -> String {
    let timed: Vec<&Measured> = reports.iter().filter(|report| !report.is_verified()).collect();
    if timed.is_empty() {
        return String::new();
    }
    let mut text =
        "\n## Scenes and strategies\n\nMedian times of a frame, and ratios frame by frame. \
                    `ideal` draws exactly what shows, found beforehand: nobody can be faster.\n\n"
            .to_owned();
    text +=
        &head(&["walk", "objects", "size", "strategy", "ms", "times the ideal", "times frustum"]);
    for report in timed {
        for run in &report.runs {
            let [width, height] = report.size;
            let ratio = |other: &str| {
                if run.strategy == other {
                    return "1".to_owned();
                }
                let ratio = report.paired_ratios.get(&format!("{}/{other}", run.strategy));
                ratio.copied().flatten().map_or("-".to_owned(), |ratio| format!("{ratio:.2}"))
            };
            let ms = run.frame_ms.median.map_or("-".to_owned(), |ms| format!("{ms:.2}"));
            text += &row(&[
                words(report),
                report.scene.objects.to_string(),
                format!("{width}x{height}"),
                format!("`{}`", run.strategy),
                ms,
                ratio("ideal"),
                ratio("frustum"),
            ]);
        }
    }
    text
}

/// Returns a walk in words: its scene and path, and what is more than plain objects that stand.
fn words(report: &Measured) -> String {
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
