//! Rules about the names of types.

use std::collections::BTreeMap;

use crate::files::SourceFile;

/// Finds public types of two packages with the same name: in a third package a reader cannot
/// distinguish them. Each crate of the engine has an `Error` of its own, as Rust's crates do.
pub fn one_name_one_type(files: &[SourceFile]) -> Vec<String> {
    let mut known = BTreeMap::<&str, &str>::new();
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.is_rust()) {
        let Some(package) = package_of(&file.path) else { continue };
        for (number, line) in (1..).zip(file.text.lines()) {
            let Some(name) = public_type(line).filter(|name| *name != "Error") else { continue };
            let first = *known.entry(name).or_insert(package);
            if first != package {
                let reason = format!("`{name}` is a public type of `{first}`, too: rename one");
                findings.push(file.finding(number, &reason));
            }
        }
    }
    findings
}

/// Returns the package whose library a file is part of; `None` for unit tests and for files outside
/// of `src`.
fn package_of(path: &str) -> Option<&str> {
    let (package, file) = path.split_once("/src/")?;
    let is_unit_test =
        file.starts_with("tests/") || file.contains("/tests/") || file.ends_with("tests.rs");
    (!is_unit_test).then_some(package)
}

/// Returns the name of a public type that a line at the left margin declares.
fn public_type(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("pub ")?;
    let rest = rest.strip_prefix("unsafe ").unwrap_or(rest);
    let kinds = ["struct ", "enum ", "trait ", "type ", "union "];
    let rest = kinds.iter().find_map(|kind| rest.strip_prefix(kind))?;
    rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()
}
