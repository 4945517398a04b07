//! Tables about lights and shadows: filters, the cache of maps, the culling of casters, maps beside
//! volumes, and the number of lights.

use super::input::{Measured, MeasuredRun};
use crate::statistics::ratio;

/// The labels of the passes that draw shadow maps, or count volumes.
const SHADOW_PASSES: [&str; 6] = [
    "shadow maps",
    "shadow midpoints",
    "test shadows",
    "resolve shadow tests",
    "culled shadow maps",
    "count shadow volumes",
];

/// The ways that leave casters out, and those with all of them.
const CULLED: [[&str; 2]; 2] =
    [["maps_uncached", "maps_unculled"], ["volumes", "volumes_unculled"]];

/// The ways that keep no map.
const AFRESH: [&str; 2] = ["maps_uncached", "maps_unculled"];

/// The filter that others are compared with.
const FIXED: &str = "fixed64";

/// Returns the tables as Markdown; `None` where no report has lights.
pub fn tables(reports: &[Measured]) -> Option<String> {
    let lit: Vec<&Measured> = reports.iter().filter(|report| is_lit(report)).collect();
    let first = lit.first()?;
    let [width, height] = first.size;
    let device = &first.device;
    let head = format!(
        "# Shadows\n\n{} ({}), {width}x{height}; times in milliseconds are medians.\n",
        device.name, device.driver
    );
    let parts = [filters(&lit), cache(&lit), culling(&lit), ways(&lit), lights(&lit)];
    Some(parts.into_iter().flatten().fold(head, |text, part| text + "\n" + &part))
}

fn is_lit(report: &Measured) -> bool {
    !report.cut_short && report.runs.iter().any(|run| run.shadows.is_some())
}

/// Returns what was drawn: scene, objects, path, lights.
fn place(report: &Measured) -> String {
    let lights = report.light_words().unwrap_or_else(|| "its own lights".to_owned());
    format!("{} of {}, {}, {lights}", report.scene.name, report.scene.objects, report.path)
}

/// Returns the runs of one filter for each with the run of 64 samples beside it.
fn filters(reports: &[&Measured]) -> Option<String> {
    let mut rows = Vec::new();
    for report in reports {
        for run in report.runs.iter().filter(|run| has_maps(run)) {
            let is_fixed = |other: &&MeasuredRun| {
                other.filter.as_deref() == Some(FIXED)
                    && (&other.strategy, &other.shadows) == (&run.strategy, &run.shadows)
            };
            let Some(fixed) = report.runs.iter().find(is_fixed) else { continue };
            let without = report.runs.iter().find(|other| {
                other.shadows.as_deref() == Some("off") && other.strategy == run.strategy
            });
            let is_single = |other: &&MeasuredRun| {
                other.filter.as_deref() == Some("single")
                    && (&other.strategy, &other.shadows) == (&run.strategy, &run.shadows)
            };
            let single = report.runs.iter().find(is_single);
            // What the filter adds to the frame, and what its samples beyond the first one add.
            let beyond = |run: &MeasuredRun, base: Option<&MeasuredRun>| {
                Some(run.frame_ms.median? - base?.frame_ms.median?)
            };
            let added = |run| beyond(run, without);
            let of_samples = |run| beyond(run, single);
            rows.push(vec![
                place(report),
                run.filter.clone().unwrap_or_default(),
                number(run.frame_ms.median, 2),
                number(ratio(fixed.frame_ms.median, run.frame_ms.median), 2),
                number(added(run), 2),
                number(ratio(added(fixed), added(run)), 2),
                number(ratio(of_samples(fixed), of_samples(run).filter(|more| *more > 0.0)), 2),
                number(run.fixed64_difference_mean, 3),
                run.fixed64_difference_max.map_or("-".to_owned(), |most| most.to_string()),
            ]);
        }
    }
    let columns = [
        "scene",
        "filter",
        "frame ms",
        "times as fast as fixed64",
        "ms more than without shadows",
        "these times as few as of fixed64",
        "the same, more than with single",
        "mean difference, of 255",
        "greatest difference, of 255",
    ];
    table("Filters", &columns, rows)
}

/// Returns the runs with a cache beside those without: with the casters that matter, and with all.
fn cache(reports: &[&Measured]) -> Option<String> {
    let mut rows = Vec::new();
    for report in reports {
        for run in report.runs.iter().filter(|run| run.shadows.as_deref() == Some("maps")) {
            let is_afresh = |other: &&MeasuredRun| {
                let way = other.shadows.as_deref();
                AFRESH.iter().any(|afresh| way == Some(afresh))
                    && (&other.strategy, &other.filter) == (&run.strategy, &run.filter)
            };
            for afresh in report.runs.iter().filter(is_afresh) {
                let both = |of: fn(&MeasuredRun) -> Option<f64>, digits| {
                    format!("{} / {}", number(of(run), digits), number(of(afresh), digits))
                };
                rows.push(vec![
                    place(report),
                    format!("{} %", report.moving_percent),
                    afresh.shadows.clone().unwrap_or_default(),
                    both(|run| run.shadow_faces.map(|faces| faces as f64), 0),
                    both(|run| run.shadow_casters.map(|casters| casters as f64), 0),
                    both(shadows_ms, 2),
                    number(ratio(shadows_ms(afresh), shadows_ms(run)), 1),
                    number(ratio(afresh.frame_ms.median, run.frame_ms.median), 2),
                ]);
            }
        }
    }
    let columns = [
        "scene",
        "objects that move",
        "beside",
        "maps drawn, cached / afresh",
        "casters drawn",
        "GPU ms of the maps",
        "times as fast",
        "whole frame, times as fast",
    ];
    table("Cached maps and maps drawn afresh", &columns, rows)
}

/// Returns the runs with the casters that matter beside those with all casters, nothing kept.
fn culling(reports: &[&Measured]) -> Option<String> {
    let mut rows = Vec::new();
    for report in reports {
        for run in &report.runs {
            let way = run.shadows.as_deref();
            let pair = CULLED.iter().find(|[culled, _]| way == Some(culled));
            let Some([_, whole]) = pair else { continue };
            let has_all = |other: &&MeasuredRun| {
                other.shadows.as_deref() == Some(whole)
                    && (&other.strategy, &other.filter) == (&run.strategy, &run.filter)
            };
            let Some(all) = report.runs.iter().find(has_all) else { continue };
            let triangles = |run: &MeasuredRun| {
                run.shadow_triangles.map(|shadow_triangle| shadow_triangle as f64)
            };
            rows.push(vec![
                place(report),
                run.shadows.clone().unwrap_or_default(),
                format!("{} / {}", number(triangles(run), 0), number(triangles(all), 0)),
                number(ratio(triangles(all), triangles(run)), 1),
                format!("{} / {}", number(shadows_ms(run), 2), number(shadows_ms(all), 2)),
                number(ratio(shadows_ms(all), shadows_ms(run)), 2),
                number(ratio(all.frame_ms.median, run.frame_ms.median), 2),
            ]);
        }
    }
    let columns = [
        "scene",
        "shadows",
        "triangles of casters, culled / all",
        "times as few",
        "GPU ms of the shadows",
        "times as fast",
        "whole frame, times as fast",
    ];
    table("Culled casters and all casters, nothing kept", &columns, rows)
}

/// Returns the runs with maps beside those with volumes, the smallest scenes first.
fn ways(reports: &[&Measured]) -> Option<String> {
    let mut sorted = reports.to_vec();
    sorted.sort_by_key(|report| report.scene.objects);
    let mut rows = Vec::new();
    for report in sorted {
        for volumes in report.runs.iter().filter(|run| run.shadows.as_deref() == Some("volumes")) {
            let of_way = |way: &str| {
                report.runs.iter().find(|other| {
                    other.shadows.as_deref() == Some(way)
                        && (&other.strategy, &other.filter) == (&volumes.strategy, &volumes.filter)
                })
            };
            let time = |way| of_way(way).and_then(|run| run.frame_ms.median);
            // Without shadows all filters are one.
            let without = report.runs.iter().find(|run| {
                run.shadows.as_deref() == Some("off") && run.strategy == volumes.strategy
            });
            let maps = time("maps").or(time("maps_uncached"));
            rows.push(vec![
                place(report),
                number(without.and_then(|run| run.frame_ms.median), 2),
                number(time("maps"), 2),
                number(time("maps_uncached"), 2),
                number(volumes.frame_ms.median, 2),
                number(ratio(volumes.frame_ms.median, maps), 2),
            ]);
        }
    }
    let columns = [
        "scene",
        "frame ms without shadows",
        "cached maps",
        "maps drawn afresh",
        "volumes",
        "volumes take so many times as long as maps",
    ];
    table("Maps and volumes", &columns, rows)
}

/// Returns the runs with street lamps by their number.
fn lights(reports: &[&Measured]) -> Option<String> {
    let mut numbered: Vec<(u32, &Measured)> = Vec::new();
    for report in reports {
        numbered.extend(
            report.lights.as_deref().and_then(|lights| lights.parse().ok()).zip(Some(*report)),
        );
    }
    numbered.sort_by_key(|(lamps, _)| *lamps);
    let mut rows = Vec::new();
    for (lamps, report) in numbered {
        // Those of the other tables have no pass times, or other filters.
        let is_timed = |run: &&MeasuredRun| has_maps(run) && shadows_ms(run).is_some();
        for run in report.runs.iter().filter(is_timed) {
            rows.push(vec![
                lamps.to_string(),
                place(report),
                run.shadows.clone().unwrap_or_default(),
                run.filter.clone().unwrap_or_default(),
                number(run.frame_ms.median, 2),
                number(run.cpu_ms.median, 2),
                number(shadows_ms(run), 2),
                number(run.shadow_faces.map(|faces| faces as f64), 0),
            ]);
        }
    }
    let columns = [
        "lamps",
        "scene",
        "shadows",
        "filter",
        "frame ms",
        "CPU ms",
        "GPU ms of the maps",
        "maps drawn",
    ];
    table("Number of lights", &columns, rows)
}

fn has_maps(run: &MeasuredRun) -> bool {
    run.shadows.as_deref().is_some_and(|shadows| shadows.starts_with("maps"))
}

/// Returns the GPU time of drawing shadow maps or volumes per frame, tests of casters included, if
/// passes were timed.
fn shadows_ms(run: &MeasuredRun) -> Option<f64> {
    let times = SHADOW_PASSES.iter().filter_map(|pass| run.passes_ms.get(*pass)?.median);
    times.reduce(|sum, time| sum + time)
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
}

/// Returns a table under its title; `None` without rows.
fn table(title: &str, columns: &[&str], rows: Vec<Vec<String>>) -> Option<String> {
    if rows.is_empty() {
        return None;
    }
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head: Vec<String> = columns.iter().map(|&column| column.to_owned()).collect();
    let rule = vec!["---".to_owned(); columns.len()];
    let lines = [head, rule].into_iter().chain(rows).map(|cells| line(&cells));
    Some(format!("## {title}\n\n{}", lines.collect::<String>()))
}

#[cfg(test)]
mod tests {
    use super::super::input::parse;
    use super::*;
    use serde_json::json;

    fn run(shadows: &str, filter: &str, frame_ms: f64, maps_ms: f64) -> serde_json::Value {
        let summary = |time: f64| json!({"median": time, "p95": time, "max": time});
        json!({
            "strategy": "antumbra", "shadows": shadows, "filter": filter,
            "frame_ms": summary(frame_ms), "cpu_ms": summary(1.0),
            "shadow_faces": 4, "shadow_casters": 200,
            "shadow_triangles": if shadows.ends_with("unculled") { 9000 } else { 1500 },
            "fixed64_difference_mean": 0.25, "fixed64_difference_max": 9,
            "passes_ms": {"shadow maps": summary(maps_ms)},
        })
    }

    fn report(lights: &str, runs: &[serde_json::Value]) -> Measured {
        let report = json!({
            "device": {"name": "gpu", "driver": "driver 1"}, "lights": lights,
            "scene": {"name": "city", "objects": 100}, "path": "street", "size": [640, 360],
            "moving_percent": 1, "runs": runs,
        });
        parse(&report.to_string()).unwrap()
    }

    #[test]
    fn filters_caches_and_lights_have_tables() {
        let reports = [
            report("16", &[run("maps", "adaptive", 10.0, 2.0)]),
            report(
                "8",
                &[
                    run("off", "adaptive", 1.0, 0.0),
                    run("maps", "single", 3.0, 1.0),
                    run("maps", "adaptive", 5.0, 1.0),
                    run("maps", "fixed64", 15.0, 1.0),
                ],
            ),
            report(
                "sun",
                &[
                    run("maps", "pcf3", 4.0, 0.5),
                    run("maps_uncached", "pcf3", 8.0, 4.0),
                    run("maps_unculled", "pcf3", 12.0, 6.0),
                    run("volumes", "pcf3", 6.0, 3.0),
                    run("volumes_unculled", "pcf3", 18.0, 15.0),
                ],
            ),
        ];
        let text = tables(&reports).unwrap();
        for expected in [
            "gpu (driver 1), 640x360",
            "| city of 100, street, 8 lamps | adaptive | 5.00 | 3.00 | 4.00 | 3.50 | 6.00 | 0.250 | 9 |",
            "| city of 100, street, sun | 1 % | maps_uncached | 4 / 4 | 200 / 200 | 0.50 / 4.00 | 8.0 | 2.00 |",
            "| city of 100, street, sun | 1 % | maps_unculled | 4 / 4 | 200 / 200 | 0.50 / 6.00 | 12.0 | 3.00 |",
            "| city of 100, street, sun | maps_uncached | 1500 / 9000 | 6.0 | 4.00 / 6.00 | 1.50 | 1.50 |",
            "| city of 100, street, sun | volumes | 1500 / 9000 | 6.0 | 3.00 / 15.00 | 5.00 | 3.00 |",
            "| city of 100, street, sun | - | 4.00 | 8.00 | 6.00 | 1.50 |",
        ] {
            assert!(text.contains(expected), "{expected}\n{text}");
        }
        let [few, many] = ["| 8 | city", "| 16 | city"].map(|row| text.find(row).unwrap());
        assert!(few < many, "{text}");
    }

    #[test]
    fn reports_without_lights_have_no_tables() {
        let mut plain = report("sun", &[run("maps", "pcf3", 4.0, 0.5)]);
        plain.runs[0].shadows = None;
        assert_eq!(tables(&[plain]), None);
    }
}
