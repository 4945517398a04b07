//! The keys of the window, for `--help`.

use super::actions::{Action, CAMERA_KEYS, KEYS, STEERING};

/// Returns examples followed by all keys: the keys for all scenes, and the keys `of_files` with the
/// cameras if there are any.
pub fn help_with_keys(examples: &str, of_files: &[(&str, &str, Action)]) -> String {
    let cameras = (!of_files.is_empty()).then_some(CAMERA_KEYS);
    let named = |(key, what, _): &(&'static str, &'static str, Action)| (*key, *what);
    let of_files: Vec<(&str, &str)> = of_files.iter().map(|(key, what, _)| (*key, *what)).collect();
    let keys = STEERING.into_iter().chain(KEYS.iter().map(named)).chain(of_files).chain(cameras);
    let lines: String = keys.map(|(key, what)| format!("  {key:<7}  {what}\n")).collect();
    format!("Keys in the window:\n{lines}\n{examples}")
}

#[cfg(test)]
mod tests {
    use super::super::actions::FILE_KEYS;
    use super::*;

    #[test]
    fn every_key_is_in_the_help() {
        let help = help_with_keys("Examples: none", &FILE_KEYS);
        for (key, what, _) in KEYS.iter().chain(&FILE_KEYS) {
            let has = |line: &str| line.trim_start().starts_with(key) && line.ends_with(what);
            assert!(help.lines().any(has), "{key} is missing in\n{help}");
        }
        assert!(help.contains(CAMERA_KEYS.0) && help.ends_with("Examples: none"), "{help}");
        assert!(!help_with_keys("", &[]).contains(CAMERA_KEYS.0));
    }
}
