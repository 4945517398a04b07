//! The table that a person reads after a walk: the same numbers as the report.

use std::fmt::{Display, Write};

use antumbra::methods;
use comfy_table::{Cell, CellAlignment, ContentArrangement, Table, presets};

use crate::choices::ProjectionChoice;
use crate::options::LeftOut;
use crate::report::{Report, RunReport, labels};
use crate::statistics::{TimeSummary, thousands};
use crate::strategy::Strategy;

/// The text for a missing number.
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

/// Returns the device and the scene, the strategies side by side, their ratios, memory and build
/// times, in lines of at most `width` columns where words are no longer.
pub fn render(report: &Report, width: usize) -> String {
    let above = [head(report)];
    let below = [
        ratio_lines(report),
        shadow_lines(report),
        cost_lines(report),
        pass_lines(report),
        note_lines(report),
        foot(report),
    ];
    let wrapped = |parts: &[String]| {
        let lines = parts.iter().flat_map(|part| part.lines());
        lines.map(|line| wrapped(line, width) + "\n").collect::<String>()
    };
    wrapped(&above) + &blocks(report, width) + &wrapped(&below)
}

/// Returns a line, wrapped to `width` and indented after the first break.
fn wrapped(line: &str, width: usize) -> String {
    let options = textwrap::Options::new(width)
        .subsequent_indent("  ")
        .break_words(false)
        .word_splitter(textwrap::WordSplitter::NoHyphenation);
    textwrap::fill(line, options)
}

/// Returns the table in as few blocks of columns as fit one under the other, each with the
/// strategies' names.
fn blocks(report: &Report, width: usize) -> String {
    let numbers: Vec<usize> = (1..COLUMNS.len()).collect();
    for count in 1..=numbers.len() {
        let blocks: Vec<String> = numbers
            .chunks(numbers.len().div_ceil(count))
            .map(|columns| block(report, columns))
            .collect();
        let fits = |block: &String| block.lines().all(|line| line.chars().count() <= width);
        if blocks.iter().all(fits) || count == numbers.len() {
            return blocks.concat();
        }
    }
    String::new()
}

/// Returns a table of these columns.
fn block(report: &Report, columns: &[usize]) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_content_arrangement(ContentArrangement::Disabled);
    let centred = |column: &usize| Cell::new(COLUMNS[*column]).set_alignment(CellAlignment::Center);
    table.set_header([0].iter().chain(columns).map(centred));
    for (run, label) in report.runs.iter().zip(labels(&report.runs)) {
        let cells = row(run, label);
        table.add_row([0].iter().chain(columns).map(|column| cells[*column].clone()));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt() + "\n"
}

fn row(run: &RunReport, label: String) -> [String; 10] {
    [
        label,
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
        "{} ({}, Vulkan {}), hidden draws skipped by {}, boxes cheapest by {}\n\
         {} of {} objects, {} triangles, seed {}; path {}, {} frames of {width}x{height}, {} in flight{}",
        device.name,
        device.driver,
        device.api,
        report.predicates,
        report.tester,
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

/// Returns additional lines where there are several eyes, something moves, or a strategy cannot
/// run.
fn more_lines(report: &Report) -> String {
    let mut lines = String::new();
    if report.skip_ns.len() > 1 {
        let ways = report.skip_ns.iter();
        let ways = ways.filter_map(|(way, ns)| Some(format!("{way} {:.0}", (*ns)? / 1_000.0)));
        lines += "\nskipping in a frame would take, in us: ";
        lines += &ways.collect::<Vec<_>>().join(", ");
    }
    if report.cut_short {
        let frames =
            |run: &RunReport| format!("{} {}", run.strategy, count(Some(run.frames_timed)));
        let frames = report.runs.iter().map(frames).collect::<Vec<_>>().join(", ");
        lines += &format!("\nCUT SHORT by a signal; frames timed: {frames}");
    }
    if let Some(lights) = &report.lights {
        lines += &match lights.parse::<u32>() {
            Ok(lamps) => format!("\nat night, under {lamps} street lamps"),
            Err(_) => format!("\nlights: {lights}"),
        };
    }
    if report.projection != ProjectionChoice::Perspective.to_string() {
        lines += &format!("\n{} cameras", report.projection);
    }
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
            "\nnot exact: objects that show at most {most} pixels count as hidden in antumbra, antumbra_queries, chc"
        );
    }
    if let Some(transparency) = &report.transparency {
        lines += &format!("\ntransparent objects: {}", transparency.text());
    }
    for driver_quirks in &report.driver_quirks {
        lines += &format!("\n{driver_quirks}");
    }
    for LeftOut { strategy, reason } in &report.left_out {
        lines += &format!("\nwithout {strategy}: {reason}");
    }
    lines
}

/// Returns these lines, one under the other.
fn joined(lines: impl Iterator<Item = String>) -> String {
    lines.collect::<Vec<_>>().join("\n")
}

fn shadow_lines(report: &Report) -> String {
    let line = |(run, label): (&RunReport, String)| {
        let drawn = run.shadow_faces.filter(|faces| *faces > 0 || run.shadow_casters > Some(0));
        drawn.map(|faces| {
            let [casters, triangles] = [run.shadow_casters, run.shadow_triangles].map(count);
            let faces = count(Some(faces));
            format!(
                "{label}: {faces} shadow maps drawn per frame, with {casters} casters in them and \
                 {triangles} triangles drawn"
            )
        })
    };
    joined(report.runs.iter().zip(labels(&report.runs)).filter_map(line))
}

/// The most runs of which each pair is compared.
const FEW_RUNS: usize = 3;

/// The strategies that all runs are compared with if there are many.
const MEASURES: [Strategy; 3] = [Strategy::FRUSTUM, Strategy::ANTUMBRA, methods::IDEAL];

/// Returns a sentence for each pair, in the order of the runs; if there are many, one for each run.
fn ratio_lines(report: &Report) -> String {
    let labels = labels(&report.runs);
    let names: Vec<&str> = labels.iter().map(String::as_str).collect();
    let ratio = |a: &str, b: &str| report.ratios.get(&format!("{a}/{b}")).copied().flatten();
    if names.len() > FEW_RUNS {
        let line = |name: &&str| {
            // A run with shadows is compared with runs that have the same shadows.
            let shadows = name.find(' ').map_or("", |end| &name[end..]);
            let to =
                |measure: Strategy| Some((ratio(name, &format!("{measure}{shadows}"))?, measure));
            let ratios = MEASURES.into_iter().filter_map(to);
            let parts: Vec<String> =
                ratios.map(|(ratio, measure)| format!("{ratio:.2} times {measure}")).collect();
            (!parts.is_empty()).then(|| format!("a frame of {name} takes {}", parts.join(", ")))
        };
        return joined(names.iter().filter_map(line));
    }
    let mut lines = Vec::new();
    for (place, a) in names.iter().enumerate() {
        for b in names.iter().skip(place + 1) {
            if let Some(ratio) = ratio(a, b) {
                lines.push(format!("{a} takes {ratio:.2} times as long per frame as {b}"));
            }
        }
    }
    lines.join("\n")
}

/// Returns the parts of a file that are not shown, a line each.
fn note_lines(report: &Report) -> String {
    let notes = report.scene.file.iter().flat_map(|file| &file.notes);
    joined(notes.map(|note| format!("not as in the file: {note}")))
}

/// Returns a line for each run with a cost model.
fn cost_lines(report: &Report) -> String {
    let line = |run: &RunReport| {
        let learned = run.corrections?;
        let saving_ms = run.expected_saving_ns.map(|saving_ns| saving_ns as f64 * 1e-6);
        let times = match (learned.frames, learned.proportion) {
            (0, _) | (_, None) => "not learned: no frame was timed".to_owned(),
            (frames, Some(times)) => format!("{times:.2}, from {} frames", count(Some(frames))),
        };
        Some(format!(
            "{}, by cost: {} objects untested per frame, {} ms saved (expected); tests times {times}",
            run.strategy,
            count(run.untested_by_cost),
            milliseconds(saving_ms),
        ))
    };
    joined(report.runs.iter().filter_map(line))
}

/// Returns a line for each run whose passes were timed.
fn pass_lines(report: &Report) -> String {
    let timed = report.runs.iter().filter(|run| !run.passes_ms.is_empty());
    let line = |run: &RunReport| {
        let pass = |(label, time): (&String, &TimeSummary)| {
            format!("{label} {}", milliseconds(time.median))
        };
        let passes: Vec<String> = run.passes_ms.iter().map(pass).collect();
        format!("{}, GPU ms per pass: {}", run.strategy, passes.join(", "))
    };
    joined(timed.map(line))
}

fn foot(report: &Report) -> String {
    let waits: u64 = report.runs.iter().map(|run| run.blocking_waits).sum();
    let verified: u64 =
        report.runs.iter().map(|run| run.frames_verified + run.warm_up_frames_verified).sum();
    let build = &report.build_ms;
    let memory = &report.memory;
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
    // Wrong pixels of strategies that are not exact are only in their column.
    let wrong: u64 = report.runs.iter().filter_map(RunReport::broken_promise).sum();
    if wrong > 0 {
        // Writing to a String cannot fail.
        let _ok = write!(text, "\nWRONG: {wrong} pixels differ from plain frustum culling");
    }
    text + &threshold_lines(report) + &fragment_lines(report)
}

/// Returns a line for each run some of whose fragments were not blended.
fn fragment_lines(report: &Report) -> String {
    let line = |run: &RunReport| {
        let lost = run.fragments?.lost()?;
        Some(format!("\n{}: fragments that were not blended in a frame: {lost}", run.strategy))
    };
    report.runs.iter().filter_map(line).collect()
}

/// Returns a line for each run whose threshold left visible samples out.
fn threshold_lines(report: &Report) -> String {
    let runs = report.runs.iter().filter(|run| {
        // Samples of warm-up frames are in the second number only.
        run.samples_below_threshold > 0 || run.pixels_wrong_at_most.is_some_and(|most| most > 0)
    });
    let line = |run: &RunReport| {
        let compared = match (run.pixels_wrong, run.pixels_wrong_at_most) {
            (Some(_), Some(most)) => {
                let [wrong, most] = [run.pixels_wrong, Some(most)].map(count);
                format!("; of those compared {wrong} pixels differ, at most {most} could")
            }
            _ => String::new(),
        };
        let samples = count(Some(run.samples_below_threshold));
        let frames = run.frames_timed;
        format!("\n{} left out {samples} samples in {frames} frames{compared}", run.strategy)
    };
    runs.map(line).collect()
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

/// Returns a number with a comma between each three digits.
fn count(value: Option<u64>) -> String {
    value.map_or(ABSENT.to_owned(), |value| thousands(value as f64))
}

#[cfg(test)]
mod tests;
