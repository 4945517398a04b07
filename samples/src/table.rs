//! The table a person reads after a walk: the same numbers as the report.

use std::fmt::{Display, Write};

use comfy_table::{Cell, CellAlignment, ContentArrangement, Table, presets};

use crate::options::LeftOut;
use crate::report::{Report, RunReport};
use crate::statistics::Summary;
use crate::strategy::Strategy;

/// Shown where a number could not be had.
const ABSENT: &str = "-";

const COLUMNS: [&str; 10] = [
    "strategy",
    "frame ms\nmedian",
    "frame ms\n95 %",
    "CPU ms\nmedian",
    "draws",
    "triangles",
    "queries",
    "waits",
    "result age\nframes",
    "pixels\nwrong",
];

/// What was drawn on what, the strategies side by side, their ratios, memory and build times.
pub fn render(report: &Report) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(COLUMNS.map(|column| Cell::new(column).set_alignment(CellAlignment::Center)));
    for run in &report.runs {
        table.add_row(row(run));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let lines = [
        head(report),
        table.trim_fmt(),
        ratio_lines(report),
        cost_lines(report),
        pass_lines(report),
        note_lines(report),
        foot(report),
    ];
    lines.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n") + "\n"
}

fn row(run: &RunReport) -> [String; 10] {
    [
        run.strategy.clone(),
        milliseconds(run.frame_ms.median),
        milliseconds(run.frame_ms.p95),
        milliseconds(run.cpu_ms.median),
        count(run.draws),
        count(run.triangles),
        count(run.queries),
        count(run.waits),
        shown(run.result_age_frames.median),
        count(run.pixels_wrong),
    ]
}

fn head(report: &Report) -> String {
    let Report { device, scene, size: [width, height], .. } = report;
    format!(
        "{} ({}, Vulkan {}), hidden draws skipped by {}\n\
         {} of {} objects, {} triangles, seed {}; path {}, {} frames of {width}x{height}, {} in flight{}",
        device.name,
        device.driver,
        device.api,
        report.predicates,
        scene.name,
        count(Some(scene.objects)),
        count(Some(scene.triangles)),
        scene.seed,
        report.path,
        report.frames,
        report.frames_in_flight,
        more_lines(report),
    )
}

/// Lines of their own where several eyes look, something moves, or a strategy cannot run.
fn more_lines(report: &Report) -> String {
    let mut lines = String::new();
    if report.views > 1 {
        lines += &format!("\n{} eyes side by side, half of the frame each", report.views);
    }
    if report.moving_percent > 0 {
        let moving = count(Some(report.moving_objects));
        lines += &format!("\n{moving} of the objects move ({} %)", report.moving_percent);
    }
    if report.threshold_pixels > 0 {
        let most = count(Some(report.threshold_pixels.into()));
        lines += &format!(
            "\nnot exact: what shows at most {most} pixels counts as hidden in antumbra, antumbra_queries, coherent"
        );
    }
    for LeftOut { strategy, reason } in &report.left_out {
        lines += &format!("\nwithout {strategy}: {reason}");
    }
    lines
}

/// So many runs are compared with each other, one by one.
const FEW_RUNS: usize = 3;

/// What all others are compared with where there are many.
const MEASURES: [Strategy; 3] = [Strategy::Frustum, Strategy::Antumbra, Strategy::Ideal];

/// A sentence for each pair, in the order of the runs; of many, one for each run.
fn ratio_lines(report: &Report) -> String {
    let names: Vec<&str> = report.runs.iter().map(|run| run.strategy.as_str()).collect();
    let ratio = |a: &str, b: &str| report.ratios.get(&format!("{a}/{b}")).copied().flatten();
    if names.len() > FEW_RUNS {
        let line = |name: &&str| {
            let to = |measure: Strategy| Some((ratio(name, measure.name())?, measure));
            let ratios = MEASURES.into_iter().filter_map(to);
            let parts: Vec<String> =
                ratios.map(|(ratio, measure)| format!("{ratio:.2} times {measure}")).collect();
            (!parts.is_empty()).then(|| format!("a frame of {name} takes {}", parts.join(", ")))
        };
        return names.iter().filter_map(line).collect::<Vec<_>>().join("\n");
    }
    let mut lines = Vec::new();
    for (place, a) in names.iter().enumerate() {
        for b in names.iter().skip(place + 1) {
            if let Some(ratio) = ratio(a, b) {
                lines.push(format!("{a} takes {ratio:.2} times as long a frame as {b}"));
            }
        }
    }
    lines.join("\n")
}

/// What in a file is not shown, a line each.
fn note_lines(report: &Report) -> String {
    let notes = report.scene.file.iter().flat_map(|file| &file.notes);
    notes.map(|note| format!("not as in the file: {note}")).collect::<Vec<_>>().join("\n")
}

/// A line for each run with a governor.
fn cost_lines(report: &Report) -> String {
    let line = |run: &RunReport| {
        let learned = run.corrections?;
        let saving_ms = run.expected_saving_ns.map(|saving_ns| saving_ns as f64 * 1e-6);
        let times = match (learned.frames, learned.proportion) {
            (0, _) | (_, None) => "not learned: no frame was timed".to_owned(),
            (frames, Some(times)) => format!("{times:.2}, from {} frames", count(Some(frames))),
        };
        Some(format!(
            "{}, by cost: {} objects untested a frame, {} ms saved (expected); tests times {times}",
            run.strategy,
            count(run.untested_by_cost),
            milliseconds(saving_ms),
        ))
    };
    report.runs.iter().filter_map(line).collect::<Vec<_>>().join("\n")
}

/// A line for each run whose passes were timed.
fn pass_lines(report: &Report) -> String {
    let timed = report.runs.iter().filter(|run| !run.passes_ms.is_empty());
    let line = |run: &RunReport| {
        let pass =
            |(label, time): (&String, &Summary)| format!("{label} {}", milliseconds(time.median));
        let passes: Vec<String> = run.passes_ms.iter().map(pass).collect();
        format!("{}, GPU ms a pass: {}", run.strategy, passes.join(", "))
    };
    timed.map(line).collect::<Vec<_>>().join("\n")
}

fn foot(report: &Report) -> String {
    let waits: u64 = report.runs.iter().map(|run| run.blocking_waits).sum();
    let verified: u64 =
        report.runs.iter().map(|run| run.frames_verified + run.warm_up_frames_verified).sum();
    let (build, memory) = (&report.build_ms, &report.memory);
    let mut text = format!(
        "built in ms: scene {}, hierarchy {}, upload {}; peak memory {} MiB, on the device {} MiB\n\
         frames compared with frustum culling: {verified}; blocking waits: {waits}; validation messages: {}",
        milliseconds(build.scene),
        milliseconds(build.hierarchy),
        milliseconds(build.upload),
        whole(memory.peak_resident_mib),
        whole(memory.gpu_allocated_mib),
        report.validation_messages,
    );
    // Those that promise nothing are counted in their column.
    let promised = |run: &&RunReport| run.strategy.parse().is_ok_and(Strategy::is_exact);
    let unaccounted = |run: &RunReport| {
        run.pixels_wrong.filter(|pixels| *pixels > run.pixels_wrong_at_most.unwrap_or(0))
    };
    let wrong: u64 = report.runs.iter().filter(promised).filter_map(unaccounted).sum();
    if wrong > 0 {
        // Writing to a String cannot fail.
        let _ok = write!(text, "\nWRONG: {wrong} pixels differ from plain frustum culling");
    }
    text + &neglect_lines(report)
}

/// A line for each run that left out what showed little.
fn neglect_lines(report: &Report) -> String {
    let neglecting = report.runs.iter().filter(|run| {
        // Those of frames before the walk are in the second number only.
        run.neglected_samples > 0 || run.pixels_wrong_at_most.is_some_and(|most| most > 0)
    });
    let line = |run: &RunReport| {
        let compared = match (run.pixels_wrong, run.pixels_wrong_at_most) {
            (Some(_), Some(most)) => {
                let [wrong, most] = [run.pixels_wrong, Some(most)].map(count);
                format!("; of those compared {wrong} pixels differ, at most {most} could")
            }
            _ => String::new(),
        };
        let (samples, frames) = (count(Some(run.neglected_samples)), run.frames_timed);
        format!("\n{} left out {samples} samples in {frames} frames{compared}", run.strategy)
    };
    neglecting.map(line).collect()
}

fn milliseconds(value: Option<f64>) -> String {
    value.map_or(ABSENT.to_owned(), |value| format!("{value:.2}"))
}

fn whole(value: Option<f64>) -> String {
    value.map_or(ABSENT.to_owned(), |value| format!("{value:.0}"))
}

fn shown(value: Option<impl Display>) -> String {
    value.map_or(ABSENT.to_owned(), |value| value.to_string())
}

/// A number with a comma between each three digits.
fn count(value: Option<u64>) -> String {
    let Some(value) = value else {
        return ABSENT.to_owned();
    };
    let digits = value.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::RunMeasurement;
    use crate::report::tests::example;

    #[test]
    fn a_person_finds_every_number() {
        let text = render(&example());
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
            "frustum takes 3.00 times as long a frame as antumbra",
            "antumbra, by cost: 4 objects untested a frame, 0.00 ms saved (expected); tests times 1.00, from 7",
            "scene 1.50, hierarchy 2.50, upload 3.50; peak memory 123 MiB, on the device 56 MiB",
            "frames compared with frustum culling: 2; blocking waits: 0; validation messages: 0",
        ] {
            assert!(text.contains(expected), "'{expected}' is missing in\n{text}");
        }
        assert!(!text.contains("WRONG"));
        assert!(text.lines().all(|line| line.chars().count() <= 120), "too wide:\n{text}");
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
        report.runs = Strategy::ALL.iter().zip(1..).map(|(it, ms)| run(*it, ms.into())).collect();
        report.ratios = crate::report::ratios(&report.runs);
        let text = render(&report);
        let lines = text.lines().filter(|line| line.starts_with("a frame of ")).count();
        assert_eq!(lines, Strategy::ALL.len(), "{text}");
        let naive =
            "a frame of naive takes 2.00 times frustum, 0.25 times antumbra, 0.17 times ideal";
        assert!(text.contains(naive) && !text.contains("as long a frame"), "{text}");
    }

    #[test]
    fn what_of_a_file_is_not_shown_is_told() {
        let mut report = example();
        assert!(!render(&report).contains("not as in the file"));
        let notes = vec!["sparks: 3".to_owned(), "orthographic cameras: 1".to_owned()];
        report.scene.file = Some(crate::report::FileReport { notes, ..Default::default() });
        let text = render(&report);
        assert!(text.contains("not as in the file: sparks: 3\nnot as in the file: orthographic"));
    }

    #[test]
    fn what_is_absent_is_a_dash_and_what_is_wrong_is_loud() {
        let mut report = example();
        report.runs = vec![RunMeasurement::new(Strategy::Frustum).report()];
        let text = render(&report);
        let row: Vec<&str> = text
            .lines()
            .find(|line| line.contains("│ frustum"))
            .unwrap()
            .split(['│', '┆'])
            .map(str::trim)
            .filter(|cell| !cell.is_empty())
            .collect();
        assert_eq!(row, ["frustum", "-", "-", "-", "-", "-", "-", "-", "-", "-"]);

        let mut wrong = RunMeasurement::new(Strategy::Antumbra);
        wrong.verified(1234);
        report.runs = vec![wrong.report()];
        assert!(render(&report).contains("WRONG: 1234 pixels differ"));
        let mut loose = RunMeasurement::new(Strategy::NextFrame);
        loose.verified(1234);
        report.runs = vec![loose.report()];
        let text = render(&report);
        assert!(text.contains("1,234") && !text.contains("WRONG"), "{text}");
    }

    #[test]
    fn what_a_threshold_leaves_out_is_told_and_not_called_wrong() {
        let mut report = example();
        assert!(!render(&report).contains("left out"));
        report.threshold_pixels = 12;
        report.runs[1].neglected_samples = 2_500;
        report.runs[1].pixels_wrong = Some(1_234);
        report.runs[1].pixels_wrong_at_most = Some(2_409);
        let text = render(&report);
        for expected in [
            "not exact: what shows at most 12 pixels counts as hidden",
            "antumbra left out 2,500 samples in 2 frames; of those compared 1,234 pixels differ, at most 2,409 could",
        ] {
            assert!(text.contains(expected), "'{expected}' is missing in\n{text}");
        }
        assert!(!text.contains("WRONG"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 120), "too wide:\n{text}");
        report.runs[1].pixels_wrong = Some(2_410);
        assert!(render(&report).contains("WRONG: 2410 pixels differ"));
    }

    #[test]
    fn thousands_are_separated() {
        let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")];
        for (value, text) in cases {
            assert_eq!(count(Some(value)), text);
        }
    }
}
