//! Rules about the map of the engine.

use std::collections::HashSet;

use crate::files::SourceFile;

const MAP: &str = "engine/ARCHITECTURE.md";

/// A map that is longer is not read.
const MAX_LINES: usize = 199;

/// Finds a map that is missing or too long.
pub fn length(files: &[SourceFile]) -> Vec<String> {
    let Some(map) = files.iter().find(|file| file.path == MAP) else {
        return vec![format!("{MAP}:1: is missing")];
    };
    let lines = map.text.lines().count();
    let reason = format!("at most {MAX_LINES} lines");
    if lines > MAX_LINES { vec![map.finding(lines, &reason)] } else { Vec::new() }
}

/// Finds the files, folders, types and functions that the map names and nobody has. Names of other
/// places (Vulkan's, options, crates) are no types of ours: they are lower case or begin with `Vk`.
pub fn names(files: &[SourceFile]) -> Vec<String> {
    let Some(map) = files.iter().find(|file| file.path == MAP) else { return Vec::new() };
    let code = || files.iter().filter(|file| file.is_rust()).flat_map(|file| file.text.lines());
    let words: HashSet<&str> = code().filter_map(declared).collect();
    let mut findings = Vec::new();
    let mut is_listing = false;
    for (number, line) in (1..).zip(map.text.lines()) {
        is_listing ^= line.starts_with("```");
        if is_listing || line.starts_with("```") {
            continue;
        }
        for span in line.split('`').skip(1).step_by(2) {
            let is_there = match span.ends_with(".rs") || span.ends_with('/') {
                true => files.iter().any(|file| lies_at(&file.path, span)),
                false => is_declared(span, &words),
            };
            if !is_there {
                findings.push(map.finding(number, &format!("there is no `{span}`")));
            }
        }
    }
    findings
}

/// Returns true if a file is, or lies in, what the map calls `name`.
fn lies_at(path: &str, name: &str) -> bool {
    let path = format!("/{path}");
    if name.ends_with('/') {
        path.contains(&format!("/{name}"))
    } else {
        path.ends_with(&format!("/{name}"))
    }
}

/// Returns true if each part of a path such as `Frame::submit` is declared, or is none of ours.
fn is_declared(span: &str, words: &HashSet<&str>) -> bool {
    let is_path = span.chars().all(|c| c.is_alphanumeric() || "_:<>".contains(c));
    let is_ours = span.starts_with(|c: char| c.is_uppercase())
        && span.contains(|c: char| c.is_lowercase())
        && !span.starts_with("Vk");
    let name = span.split('<').next().unwrap_or_default();
    let traits = ["Drop"];
    !is_path || !is_ours || traits.contains(&name) || name.split("::").all(|it| words.contains(it))
}

/// Returns the name that a line declares: of an item, a variant or a field.
fn declared(line: &str) -> Option<&str> {
    let mut rest = line.trim_start();
    for prefix in ["pub(crate) ", "pub(super) ", "pub ", "const ", "unsafe "] {
        rest = rest.strip_prefix(prefix).unwrap_or(rest);
    }
    let kinds = ["fn ", "struct ", "enum ", "trait ", "type ", "static "];
    for kind in kinds {
        rest = rest.strip_prefix(kind).unwrap_or(rest);
    }
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    (end > 0).then(|| &rest[..end])
}
