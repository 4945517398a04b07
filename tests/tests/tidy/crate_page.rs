//! Rules about the page of the book on crates: it has the features and versions of the manifests.

use std::collections::BTreeSet;

use crate::assert_obeyed;
use crate::files::SourceFile;

const PAGE: &str = "docs/book/src/crates.md";

/// The crates of others whose types are in our interface, or whose version hosts ask for.
const VISIBLE: [&str; 4] = ["ash", "glam", "gpu-allocator", "raw-window-handle"];

/// Finds features of published crates, and versions of visible dependencies, that the page lacks or
/// has without a manifest that says so.
pub fn complete(files: &[SourceFile]) -> Vec<String> {
    let Some(page) = files.iter().find(|file| file.path == PAGE) else {
        return vec![format!("{PAGE}:1: is missing")];
    };
    let mut findings = Vec::new();
    let is_published = |file: &&SourceFile| !file.text.contains("publish = false");
    let manifests = files.iter().filter(|file| file.path.ends_with("Cargo.toml"));
    for file in manifests.filter(is_published) {
        let name = file.text.lines().find_map(|line| line.strip_prefix("name = \""));
        let name = name.map(|name| name.trim_end_matches('"')).unwrap_or_default();
        if name.starts_with("antumbra") {
            let row = page.text.lines().find(|line| line.starts_with(&format!("| `{name}` |")));
            let last = row.and_then(|row| row.trim_end_matches(" |").rsplit("| ").next());
            let listed: BTreeSet<&str> =
                last.unwrap_or_default().split('`').skip(1).step_by(2).collect();
            if row.is_none() || listed != features(&file.text) {
                let reason = format!("{name} has the features {:?}", features(&file.text));
                findings.push(page.finding(1, &reason));
            }
        }
        if file.path == "Cargo.toml" {
            findings.extend(versions(&file.text).into_iter().filter_map(|(name, version)| {
                let table = format!("| `{name}` | {version} |");
                let sentence = format!("`{name}` {version} ");
                let is_there = page.text.contains(&table) || page.text.contains(&sentence);
                (!is_there).then(|| page.finding(1, &format!("{name} has the version {version}")))
            }));
        }
    }
    findings
}

/// Returns the features of a manifest, without `default`.
fn features(manifest: &str) -> BTreeSet<&str> {
    let lines = manifest.lines().skip_while(|line| *line != "[features]").skip(1);
    let lines = lines.take_while(|line| !line.starts_with('['));
    let names = lines.filter_map(|line| Some(line.split_once(" = ")?.0));
    names.filter(|name| *name != "default" && !name.starts_with('#')).collect()
}

/// Returns the names and versions of the visible dependencies in the workspace's manifest.
fn versions(manifest: &str) -> Vec<(&str, &str)> {
    let lines = manifest.lines().filter_map(|line| {
        let (name, rest) = line.split_once(" = ")?;
        let version = rest.split('"').nth(1)?;
        Some((name, version)).filter(|(name, _)| VISIBLE.contains(name))
    });
    lines.collect()
}

#[test]
fn the_page_of_crates_has_their_features() {
    assert_obeyed(complete);
    let manifest = "name = \"antumbra-a\"\n[features]\ndefault = [\"b\"]\n# c = d\nb = []\n";
    let page = "| `antumbra-a` | it | `b` (on) |\n| `ash` | 0.38 |\n";
    let workspace = "[workspace.dependencies]\nash = { version = \"0.38\" }\n";
    let of = |page: &str, manifest: &str, workspace: &str| {
        complete(&[
            SourceFile::new(PAGE, page),
            SourceFile::new("engine/a/Cargo.toml", manifest),
            SourceFile::new("Cargo.toml", workspace),
        ])
    };
    assert_eq!(of(page, manifest, workspace), Vec::<String>::new());
    let more = format!("{manifest}c = []\n");
    for wrong in [
        of(page, &more, workspace),
        of("", manifest, workspace),
        of(page, "name = \"antumbra-a\"\n", workspace),
        of(page, manifest, &workspace.replace("0.38", "0.39")),
    ] {
        assert!(!wrong.is_empty());
    }
}
