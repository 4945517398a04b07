//! The steadiness of the machine: the spread of the ideal's own time over the repetitions of a
//! walk.
//!
//! The goals are multiples of the ideal's time, and the ideal draws the same each time.

use std::collections::BTreeMap;

use super::cases::{Case, Cases, IDEAL, Place};
use crate::report::Report;

/// The largest spread of the ideal's time, as a fraction of its median, with which figures are
/// judged.
pub const NOISE_MAX: f64 = 0.1;

/// Returns the width of the narrowest range that holds more than half of the times, as a fraction
/// of its middle. So one disturbed repetition of three does not count. `None` for fewer than two
/// times.
fn noise(times: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = times.filter(|time| time.is_finite() && *time > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    if sorted.len() < 2 {
        return None;
    }
    let width = |near: &[f64]| match near {
        [least, .., most] => (most - least) / ((most + least) / 2.0),
        _ => f64::INFINITY,
    };
    sorted.windows(sorted.len() / 2 + 1).map(width).min_by(f64::total_cmp)
}

/// Returns the noise of each walk of a case. Reports with the same strategies are repetitions of
/// one walk; reports without the ideal are left out.
fn walks<'a>(case: &Case<'a>) -> Vec<(&'a Report, Option<f64>)> {
    let mut walks = BTreeMap::<Vec<&str>, Vec<&Report>>::new();
    for report in case.timed().into_iter().filter(|report| report.run(IDEAL).is_some()) {
        let names = report.runs.iter().map(|run| run.strategy.as_str()).collect();
        walks.entry(names).or_default().push(report);
    }
    let of = |reports: Vec<&'a Report>| {
        let times = reports.iter().filter_map(|report| report.run(IDEAL)?.frame_ms.median);
        Some((*reports.first()?, noise(times)))
    };
    walks.into_values().filter_map(of).collect()
}

/// Returns the noise of a case: the noise of its least steady walk. `None` if no walk was repeated.
pub fn of_case(case: &Case<'_>) -> Option<f64> {
    walks(case).into_iter().filter_map(|(_, noise)| noise).max_by(f64::total_cmp)
}

/// Returns the least multiple of the ideal's time that is plausible in a case.
pub fn least_possible(case: &Case<'_>) -> f64 {
    1.0 - of_case(case).unwrap_or(NOISE_MAX)
}

/// Returns true if a strategy was measured to be faster than the ideal by more than the noise.
pub fn is_below_ideal(case: &Case<'_>, strategy: &str) -> bool {
    let ratio = case.ratio(strategy, IDEAL);
    ratio.is_some_and(|ratio| ratio.spread.median() < least_possible(case))
}

/// Returns the names of the walks to repeat: too noisy to judge, or measured once. A name is the
/// name of the report's file without the number of the repetition.
pub fn to_repeat(cases: &Cases<'_>) -> Vec<String> {
    let walks = cases.iter().flat_map(|(_, case)| walks(case));
    let noisy = walks.filter(|(_, noise)| noise.is_none_or(|noise| noise >= NOISE_MAX));
    noisy.map(|(report, _)| stem_of(&report.file).to_owned()).collect()
}

/// Returns the name of a report's file without its extension and the number of the repetition:
/// `street-2000.1.json` is `street-2000`.
fn stem_of(file: &str) -> &str {
    let stem = file.strip_suffix(".json").unwrap_or(file);
    match stem.rsplit_once('.') {
        Some((name, number)) if number.parse::<u32>().is_ok() => name,
        _ => stem,
    }
}

/// Returns a sentence about the noise of the machine, for the reader.
pub fn verdict(cases: &Cases<'_>) -> String {
    let known = |(place, case): (&Place, &Case<'_>)| Some((place.name(), of_case(case)?));
    let mut noises: Vec<(String, f64)> = cases.iter().filter_map(known).collect();
    noises.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let percent = |noise: f64| format!("{:.0} %", noise * 100.0);
    let most = percent(NOISE_MAX);
    let Some((case, worst)) = noises.first() else {
        return "No case with the ideal was measured twice: the steadiness of the machine is unknown"
            .to_owned();
    };
    let noisy: Vec<String> = noises
        .iter()
        .filter(|(_, noise)| *noise >= NOISE_MAX)
        .map(|(case, noise)| format!("{case} ({})", percent(*noise)))
        .collect();
    if noisy.is_empty() {
        let worst = percent(*worst);
        return format!(
            "The machine was steady: the ideal's own time spreads by {worst} at most ({case}), and \
             up to {most} is judged"
        );
    }
    format!(
        "The machine was too busy to judge {} of {} cases, in which the ideal's own time spreads by \
         {most} or more: {}",
        noisy.len(),
        noises.len(),
        noisy.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::super::testing::measured;
    use super::*;

    fn repeated(times: &[f64]) -> Vec<Report> {
        let report = |(number, time): (usize, &f64)| {
            let walked = [(IDEAL, *time), ("antumbra", 1.1 * time)];
            let mut report = measured("city", "street", 10_000, &walked);
            report.file = format!("street.{}.json", number + 1);
            report
        };
        times.iter().enumerate().map(report).collect()
    }

    #[test]
    fn most_of_the_repetitions_must_agree() {
        let noise = |times: &[f64]| noise(times.iter().copied());
        assert_eq!(noise(&[1.0]), None);
        assert_eq!(noise(&[3.0, 1.0]), Some(1.0));
        assert_eq!(noise(&[1.0, 9.0, 1.0]), Some(0.0), "one was disturbed");
        assert_eq!(noise(&[1.0, 9.0, 1.0, 9.0]), Some(1.6), "half were: nobody knows which");
        assert!(noise(&[1.0, 1.05, 9.0]).unwrap() < NOISE_MAX);
    }

    #[test]
    fn what_is_too_noisy_or_measured_once_is_repeated() {
        for (times, is_repeated, says) in [
            (&[1.0][..], true, "is unknown"),
            (&[1.0, 1.3], true, "too busy to judge 1 of 1 cases"),
            (&[1.0, 1.04], false, "steady: the ideal's own time spreads by 4 %"),
            (&[1.0, 1.3, 1.01], false, "spreads by 1 % at most (street 10k)"),
        ] {
            let reports = repeated(times);
            let cases = Cases::of(&reports);
            assert_eq!(to_repeat(&cases) == ["street"], is_repeated, "{times:?}");
            assert!(verdict(&cases).contains(says), "{}", verdict(&cases));
        }
        let alone = [measured("city", "street", 10_000, &[("antumbra", 1.0)])];
        assert_eq!(to_repeat(&Cases::of(&alone)), [""; 0], "there is no ideal");
    }
}
