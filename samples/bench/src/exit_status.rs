//! The exit status of a walk that ran to its end: failure where its result is wrong.

use crate::report::Report;

/// Returns a sentence about a result that must not be in a report: wrong pixels of a strategy that
/// promises none, more of them than the threshold accounts for, or any message of the validation
/// layer. `None` if there is no such result.
pub fn complaint(report: &Report) -> Option<String> {
    let mut found = Vec::new();
    for run in &report.runs {
        if let Some(pixels) = run.broken_promise() {
            found.push(format!(
                "{} has {pixels} pixels that differ from plain frustum culling, in {} frames",
                run.strategy,
                run.frames_verified + run.warm_up_frames_verified
            ));
        }
    }
    if report.validation_messages > 0 {
        let messages = report.validation_messages;
        found.push(format!("the validation layer had {messages} messages (they are in the log)"));
    }
    if found.is_empty() {
        return None;
    }
    Some(format!("the walk went wrong: {}; please report it", found.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::example;

    #[test]
    fn a_walk_without_wrong_pixels_and_messages_is_fine() {
        let mut report = example();
        assert_eq!(complaint(&report), None);
        for run in &mut report.runs {
            run.pixels_wrong = None;
        }
        assert_eq!(complaint(&report), None, "nothing compared is nothing wrong");
    }

    #[test]
    fn wrong_pixels_are_told_by_strategy() {
        let mut report = example();
        report.runs[1].pixels_wrong = Some(12);
        let sentence = complaint(&report).unwrap();
        assert!(sentence.contains("antumbra has 12 pixels"), "{sentence}");
        assert!(
            !sentence.contains("frustum has") && !sentence.contains("validation"),
            "{sentence}"
        );
    }

    #[test]
    fn a_strategy_that_promises_nothing_breaks_no_promise() {
        let mut report = example();
        report.runs[1].pixels_wrong = Some(12);
        report.runs[1].strategy = "next_frame".to_owned();
        assert_eq!(complaint(&report), None);
    }

    #[test]
    fn a_threshold_accounts_for_as_many_pixels_as_it_left_out() {
        let mut report = example();
        report.threshold_pixels = 4;
        report.runs[1].pixels_wrong = Some(12);
        report.runs[1].pixels_wrong_at_most = Some(12);
        assert_eq!(complaint(&report), None);
        report.runs[1].pixels_wrong = Some(13);
        assert!(complaint(&report).unwrap().contains("antumbra has 13 pixels"));
    }

    #[test]
    fn messages_are_told_beside_wrong_pixels_in_one_line() {
        let mut report = example();
        report.validation_messages = 3;
        assert!(complaint(&report).unwrap().contains("3 messages"));
        report.runs[0].pixels_wrong = Some(1);
        let sentence = complaint(&report).unwrap();
        assert!(sentence.contains("frustum has 1 pixels") && sentence.contains("3 messages"));
        assert!(!sentence.contains('\n'));
    }
}
