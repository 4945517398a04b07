//! The provenance of a report: the command line that made it, and the time.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

/// The command line and the time of a report.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// The words of the command line; the program without its folder.
    pub command: Vec<String>,
    /// The time when the walk was over, in seconds since 1970; 0 if the machine's clock is earlier.
    pub unix_s: u64,
}

impl Provenance {
    /// Returns the provenance of this process, now.
    pub fn of_this_process() -> Self {
        let mut command: Vec<String> =
            std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
        if let Some(program) = command.first_mut() {
            let name = Path::new(program.as_str()).file_name();
            if let Some(name) = name.map(|name| name.to_string_lossy().into_owned()) {
                *program = name;
            }
        }
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        Self { command, unix_s: since.map_or(0, |since| since.as_secs()) }
    }

    /// Returns the day in universal time, as "2026-11-21".
    pub fn day(&self) -> String {
        let (year, month, day) = civil_day(self.unix_s / 86_400);
        format!("{year:04}-{month:02}-{day:02}")
    }
}

/// Returns year, month and day of a day counted from 1970-01-01, in the Gregorian calendar.
fn civil_day(day: u64) -> (u64, u64, u64) {
    // Counted from the first of March of the year 0, so that a leap day ends its year; 400 years
    // have 146,097 days.
    let day = day + 719_468;
    let era = day / 146_097;
    let day_of_era = day % 146_097;
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    // From March on, every five months have 153 days.
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day_of_month = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    (era * 400 + year_of_era + u64::from(month <= 2), month, day_of_month)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_have_their_dates() {
        let cases = [
            (0, "1970-01-01"),
            (951_782_400, "2000-02-29"),
            (951_868_800, "2000-03-01"),
            (1_709_164_800, "2024-02-29"),
            (1_735_689_599, "2024-12-31"),
            (4_102_444_800, "2100-01-01"),
        ];
        for (unix_s, day) in cases {
            assert_eq!(Provenance { command: vec![], unix_s }.day(), day);
        }
    }

    #[test]
    fn a_process_knows_its_program_without_its_folder() {
        let made = Provenance::of_this_process();
        assert!(!made.command[0].contains('/'), "{:?}", made.command);
        assert!(made.unix_s > 1_600_000_000);
    }
}
