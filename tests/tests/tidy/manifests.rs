//! Rules about the manifests of crates.

use crate::files::SourceFile;

/// Finds published crates whose manifest lacks a description for registries.
pub fn published(files: &[SourceFile]) -> Vec<String> {
    const SHOWN: [&str; 5] = ["description", "license", "readme", "keywords", "categories"];
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.path.ends_with("Cargo.toml")) {
        let Some((_, package)) = file.text.split_once("[package]\n") else { continue };
        let lines = || package.lines().take_while(|line| !line.starts_with('['));
        if lines().any(|line| line == "publish = false") {
            continue;
        }
        for key in SHOWN {
            let has = |line: &str| {
                line.strip_prefix(key).is_some_and(|after| after.starts_with([' ', '.']))
            };
            if !lines().any(has) {
                let reason = format!("is published and has no {key}; else say `publish = false`");
                findings.push(file.finding(1, &reason));
            }
        }
    }
    findings
}
