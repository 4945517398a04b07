//! Tables about lights and shadows: filters, the cache of maps, the culling of casters, maps beside
//! volumes, and the number of lights.

use crate::report::{Report, RunReport};
use crate::result_page::{ResultPage, Table, Tone};
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

/// Pairs of ways that cull casters and ways that draw all of them.
const CULLED: [[&str; 2]; 2] =
    [["maps_uncached", "maps_unculled"], ["volumes", "volumes_unculled"]];

/// The ways that draw all maps in every frame.
const AFRESH: [&str; 2] = ["maps_uncached", "maps_unculled"];

/// The filter that others are compared with.
const FIXED: &str = "fixed64";

/// Returns the tables; `None` where no report has lights.
pub fn tables(reports: &[Report]) -> Option<ResultPage> {
    let lit: Vec<&Report> = reports.iter().filter(|report| is_lit(report)).collect();
    let first = lit.first()?;
    let [width, height] = first.size;
    let device = &first.device;
    let mut page = ResultPage::new("Shadows");
    page.text(
        Tone::Plain,
        &format!(
            "{} ({}), {width}x{height}; times in milliseconds are medians.",
            device.name, device.driver
        ),
    );
    let tables = [
        ("Filters", filters(&lit)),
        ("Cached maps and maps drawn afresh", cache(&lit)),
        ("Culled casters and all casters, nothing kept", culling(&lit)),
        ("Maps and volumes", ways(&lit)),
        ("Number of lights", lights(&lit)),
    ];
    for (title, table) in tables.into_iter().filter(|(_, table)| !table.rows.is_empty()) {
        page.heading(title);
        page.table(&table);
    }
    Some(page)
}

fn is_lit(report: &Report) -> bool {
    !report.cut_short && report.runs.iter().any(|run| run.shadows.is_some())
}

/// Returns what was drawn: scene, objects, path, lights.
fn place(report: &Report) -> String {
    let lights = report.light_words().unwrap_or_else(|| "its own lights".to_owned());
    format!("{} of {}, {}, {lights}", report.scene.name, report.scene.objects, report.path)
}

/// A run with shadows, and the report that has it.
#[derive(Clone, Copy)]
struct Lit<'a> {
    report: &'a Report,
    run: &'a RunReport,
}

impl<'a> Lit<'a> {
    fn all(reports: &[&'a Report]) -> impl Iterator<Item = Self> {
        let runs = |report: &&'a Report| {
            let report = *report;
            report.runs.iter().map(move |run| Self { report, run })
        };
        reports.iter().flat_map(runs)
    }

    /// Returns the way in which its shadows are made.
    fn way(&self) -> Option<&'a str> {
        self.run.shadows.as_deref()
    }

    /// Returns the run of the same report, strategy and filter with shadows made in this way.
    /// Without shadows the filter does not matter.
    fn with_way(&self, way: &str) -> Option<&'a RunReport> {
        self.report.runs.iter().find(|other| {
            other.shadows.as_deref() == Some(way)
                && other.strategy == self.run.strategy
                && (way == "off" || other.filter == self.run.filter)
        })
    }

    /// Returns the run of the same report, strategy and way with this filter.
    fn with_filter(&self, filter: &str) -> Option<&'a RunReport> {
        self.report.runs.iter().find(|other| {
            other.filter.as_deref() == Some(filter)
                && other.strategy == self.run.strategy
                && other.shadows == self.run.shadows
        })
    }
}

/// Returns each run with maps, compared with the run of the filter `fixed64`.
fn filters(reports: &[&Report]) -> Table {
    let row = |lit: Lit<'_>| {
        let fixed = lit.with_filter(FIXED)?;
        let without = lit.with_way("off");
        let single = lit.with_filter("single");
        // The time that the filter adds to the frame, and the time of its samples beyond the first.
        let beyond = |run: &RunReport, base: Option<&RunReport>| {
            Some(run.frame_ms.median? - base?.frame_ms.median?)
        };
        let added = |run| beyond(run, without);
        let of_samples = |run| beyond(run, single);
        let run = lit.run;
        Some(vec![
            place(lit.report),
            run.filter.clone().unwrap_or_default(),
            number(run.frame_ms.median, 2),
            number(ratio(fixed.frame_ms.median, run.frame_ms.median), 2),
            number(added(run), 2),
            number(ratio(added(fixed), added(run)), 2),
            number(ratio(of_samples(fixed), of_samples(run).filter(|more| *more > 0.0)), 2),
            number(run.fixed64_difference_mean, 3),
            count(run.fixed64_difference_max),
        ])
    };
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
    let with_maps = Lit::all(reports).filter(|lit| has_maps(lit.run));
    Table::of(&columns, with_maps.filter_map(row).collect())
}

/// Returns the runs with cached maps, compared with runs that draw all maps in every frame: with
/// the casters that matter, and with all.
fn cache(reports: &[&Report]) -> Table {
    let row = |lit: Lit<'_>, way: &str| {
        let afresh = lit.with_way(way)?;
        let run = lit.run;
        let both = |of: fn(&RunReport) -> Option<u64>| {
            format!("{} / {}", count(of(run)), count(of(afresh)))
        };
        Some(vec![
            place(lit.report),
            format!("{} %", lit.report.moving_percent),
            way.to_owned(),
            both(|run| run.shadow_faces),
            both(|run| run.shadow_casters),
            format!("{} / {}", number(shadows_ms(run), 2), number(shadows_ms(afresh), 2)),
            number(ratio(shadows_ms(afresh), shadows_ms(run)), 1),
            number(ratio(afresh.frame_ms.median, run.frame_ms.median), 2),
        ])
    };
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
    let cached = Lit::all(reports).filter(|lit| lit.way() == Some("maps"));
    let rows = cached.flat_map(|lit| AFRESH.into_iter().filter_map(move |way| row(lit, way)));
    Table::of(&columns, rows.collect())
}

/// Returns the runs with the casters that matter, compared with the runs with all casters. Neither
/// keeps maps.
fn culling(reports: &[&Report]) -> Table {
    let row = |lit: Lit<'_>| {
        let [culled, whole] = CULLED.into_iter().find(|[culled, _]| lit.way() == Some(culled))?;
        let all = lit.with_way(whole)?;
        let run = lit.run;
        let triangles = |run: &RunReport| run.shadow_triangles.map(|triangles| triangles as f64);
        Some(vec![
            place(lit.report),
            culled.to_owned(),
            format!("{} / {}", count(run.shadow_triangles), count(all.shadow_triangles)),
            number(ratio(triangles(all), triangles(run)), 1),
            format!("{} / {}", number(shadows_ms(run), 2), number(shadows_ms(all), 2)),
            number(ratio(shadows_ms(all), shadows_ms(run)), 2),
            number(ratio(all.frame_ms.median, run.frame_ms.median), 2),
        ])
    };
    let columns = [
        "scene",
        "shadows",
        "triangles of casters, culled / all",
        "times as few",
        "GPU ms of the shadows",
        "times as fast",
        "whole frame, times as fast",
    ];
    Table::of(&columns, Lit::all(reports).filter_map(row).collect())
}

/// Returns the runs with volumes, compared with the runs with maps, the smallest scenes first.
fn ways(reports: &[&Report]) -> Table {
    let mut sorted = reports.to_vec();
    sorted.sort_by_key(|report| report.scene.objects);
    let row = |lit: Lit<'_>| {
        let time = |way| lit.with_way(way).and_then(|run| run.frame_ms.median);
        let volumes = lit.run.frame_ms.median;
        vec![
            place(lit.report),
            number(time("off"), 2),
            number(time("maps"), 2),
            number(time("maps_uncached"), 2),
            number(volumes, 2),
            number(ratio(volumes, time("maps").or(time("maps_uncached"))), 2),
        ]
    };
    let columns = [
        "scene",
        "frame ms without shadows",
        "cached maps",
        "maps drawn afresh",
        "volumes",
        "volumes take so many times as long as maps",
    ];
    let with_volumes = Lit::all(&sorted).filter(|lit| lit.way() == Some("volumes"));
    Table::of(&columns, with_volumes.map(row).collect())
}

/// Returns the runs with street lamps by their number.
fn lights(reports: &[&Report]) -> Table {
    let lamps = |report: &Report| report.lights.as_deref()?.parse::<u32>().ok();
    let mut sorted: Vec<&Report> =
        reports.iter().copied().filter(|report| lamps(report).is_some()).collect();
    sorted.sort_by_key(|report| lamps(report));
    let row = |Lit { report, run }: Lit<'_>| {
        vec![
            report.lights.clone().unwrap_or_default(),
            place(report),
            run.shadows.clone().unwrap_or_default(),
            run.filter.clone().unwrap_or_default(),
            number(run.frame_ms.median, 2),
            number(run.cpu_ms.median, 2),
            number(shadows_ms(run), 2),
            count(run.shadow_faces),
        ]
    };
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
    // Runs of the other tables have no pass times.
    let is_timed = |lit: &Lit<'_>| has_maps(lit.run) && shadows_ms(lit.run).is_some();
    Table::of(&columns, Lit::all(&sorted).filter(is_timed).map(row).collect())
}

fn has_maps(run: &RunReport) -> bool {
    run.shadows.as_deref().is_some_and(|shadows| shadows.starts_with("maps"))
}

/// Returns the GPU time of drawing shadow maps or volumes per frame, tests of casters included, if
/// passes were timed.
fn shadows_ms(run: &RunReport) -> Option<f64> {
    let times = SHADOW_PASSES.iter().filter_map(|pass| run.passes_ms.get(*pass)?.median);
    times.reduce(|sum, time| sum + time)
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
}

fn count(value: Option<u64>) -> String {
    value.map_or("-".to_owned(), |value| value.to_string())
}

#[cfg(test)]
mod tests {
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

    fn report(lights: &str, runs: &[serde_json::Value]) -> Report {
        let report = json!({
            "device": {"name": "gpu", "driver": "driver 1"}, "lights": lights,
            "scene": {"name": "city", "objects": 100}, "path": "street", "size": [640, 360],
            "moving_percent": 1, "runs": runs,
        });
        Report::parse(&report.to_string()).unwrap()
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
        let tables = tables(&reports).unwrap();
        let text = tables.markdown();
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
