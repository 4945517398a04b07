//! The table of `walkthrough --self-test`: the assumptions about a driver, and the results.

use antumbra::render::{CheckResult, SelfTest};
use comfy_table::{ContentArrangement, Table, presets};

/// Returns a line for each assumption: its name, the verdict, the observation and the consequence.
pub fn render(device: &str, found: &SelfTest) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(["assumption", "verdict", "what was seen", "what is done"]);
    for (assumption, verdict) in &found.findings {
        let remedy = match verdict {
            CheckResult::Failed(_) => assumption.remedy(),
            CheckResult::Passed | CheckResult::Skipped(_) => "",
        };
        table.add_row([assumption.name(), verdict.word(), verdict.detail(), remedy]);
    }
    let safest = match found.safest {
        Some(strategy) => format!("safest strategy: {strategy}"),
        None => "no tester is safe: use frustum".to_owned(),
    };
    format!("{device}\n{}\n{safest}\n", table.trim_fmt())
}

/// Returns a sentence if nothing but plain frustum culling is safe.
pub fn complaint(found: &SelfTest) -> Option<String> {
    let names: Vec<&str> = found.broken().into_iter().map(|broken| broken.name()).collect();
    found.safest.is_none().then(|| {
        format!("this driver cannot be trusted with {}: only frustum is safe", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use antumbra::Strategy;
    use antumbra::render::DriverAssumption;

    use super::*;

    #[test]
    fn each_assumption_has_a_line_with_what_was_seen_and_is_done() {
        let seen = CheckResult::Failed("3 of 9 are lost".to_owned());
        let why = CheckResult::Skipped("it has none".to_owned());
        let mut found = SelfTest {
            findings: vec![
                (DriverAssumption::QueryCounts, CheckResult::Passed),
                (DriverAssumption::EarlyTests, seen),
                (DriverAssumption::DrawCounts, why),
            ],
            safest: Some(Strategy::ANTUMBRA_QUERIES),
        };
        let table = render("a device", &found);
        assert!(table.starts_with("a device\n") && table.ends_with("antumbra_queries\n"));
        let line = |name: &str| table.lines().find(|line| line.contains(name)).unwrap();
        assert!(line("query counts").contains("held"));
        assert!(line("early tests").contains("3 of 9 are lost"));
        assert!(line("early tests").contains("BROKEN") && line("early tests").contains("another"));
        assert!(line("draw counts").contains("it has none"));
        assert_eq!(complaint(&found), None);
        found.safest = None;
        assert!(render("", &found).contains("use frustum"));
        assert!(complaint(&found).unwrap().contains("early tests"));
    }
}
