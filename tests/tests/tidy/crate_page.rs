//! Rules about the page of the book on crates: it has the features of the manifests, and their
//! versions of other crates and of Rust.

use std::collections::BTreeSet;

use crate::assert_obeyed;
use crate::files::SourceFile;

const PAGE: &str = "docs/book/src/crates.md";

/// The crates of others whose types are in our interface, or whose version hosts ask for, with the
/// manifest that has it.
const VISIBLE: [(&str, &[&str]); 3] = [
    ("Cargo.toml", &["ash", "glam", "gpu-allocator", "raw-window-handle"]),
    ("examples/hosts/wgpu/Cargo.toml", &["wgpu"]),
    ("samples/Cargo.toml", &["winit"]),
];

/// Finds features of published crates, and versions of visible dependencies, that the page lacks or
/// has without a manifest that says so.
pub fn complete(files: &[SourceFile]) -> Vec<String> {
    let Some(page) = files.iter().find(|file| file.path == PAGE) else {
        return vec![format!("{PAGE}:1: is missing")];
    };
    let mut findings = Vec::new();
    let manifests = files.iter().filter(|file| file.path.ends_with("Cargo.toml"));
    for file in manifests {
        for (name, version) in versions(file) {
            if !page.text.contains(&format!("| `{name}` | {version} |")) {
                findings.push(page.finding(1, &format!("{name} has the version {version}")));
            }
        }
        let name = file.text.lines().find_map(|line| line.strip_prefix("name = \""));
        let name = name.map(|name| name.trim_end_matches('"')).unwrap_or_default();
        let is_published = name.starts_with("antumbra") && !file.text.contains("publish = false");
        if is_published {
            let row = page.text.lines().find(|line| line.starts_with(&format!("| `{name}` |")));
            let last = row.and_then(|row| row.trim_end_matches(" |").rsplit("| ").next());
            let listed: BTreeSet<&str> =
                last.unwrap_or_default().split('`').skip(1).step_by(2).collect();
            if row.is_none() || listed != features(&file.text) {
                let reason = format!("{name} has the features {:?}", features(&file.text));
                findings.push(page.finding(1, &reason));
            }
        }
        // Crates that take the workspace's version are not named.
        let named = if is_published { format!("`{name}`") } else { "all others".to_owned() };
        if let Some(rust) = rust_version(&file.text) {
            let begins = format!("| {rust} | ");
            let is_row = |row: &str| row.starts_with(&begins) && row.contains(&named);
            if !page.text.lines().any(is_row) {
                findings.push(page.finding(1, &format!("Rust {rust} is for {named}")));
            }
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

/// Returns the names and versions of a manifest's visible dependencies.
fn versions(manifest: &SourceFile) -> Vec<(&str, &str)> {
    let visible = VISIBLE.iter().find(|(path, _)| *path == manifest.path);
    let names = visible.map(|(_, names)| *names).unwrap_or_default();
    let lines = manifest.text.lines().filter_map(|line| {
        let (name, rest) = line.split_once(" = ")?;
        let version = rest.split('"').nth(1)?;
        Some((name, version)).filter(|(name, _)| names.contains(name))
    });
    lines.collect()
}

/// Returns the oldest Rust that a manifest itself names.
fn rust_version(manifest: &str) -> Option<&str> {
    let line = manifest.lines().find_map(|line| line.strip_prefix("rust-version = \""))?;
    Some(line.trim_end_matches('"'))
}

#[test]
fn the_page_of_crates_has_their_features() {
    assert_obeyed(complete);
    let manifest = "name = \"antumbra-a\"\nrust-version = \"1.2\"\n\
                    [features]\ndefault = [\"b\"]\n# c = d\nb = []\n";
    let page = "| `antumbra-a` | it | `b` (on) |\n| `ash` | 0.38 |\n\
                | 1.2 | `antumbra-a` |\n| 1.3 | all others |\n";
    let workspace =
        "rust-version = \"1.3\"\n[workspace.dependencies]\nash = { version = \"0.38\" }\n";
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
        of(page, &manifest.replace("1.2", "1.1"), workspace),
        of(page, manifest, &workspace.replace("1.3", "1.2")),
    ] {
        assert!(!wrong.is_empty());
    }
}
