//! Rules about the structure of a crate: files do not import each other in long cycles, and the
//! methods of a type are in its file or in one folder `api/`.

use std::collections::BTreeMap;

use crate::files::SourceFile;
use crate::modules::{Modules, Ties, product_code};

/// The largest cycle of files that import each other: they must be read as one, and more than three
/// are too much for that.
const MAX_CIRCLE: usize = 3;

/// Returns the root of each library and program among the files.
fn roots<'a>(code: &BTreeMap<&'a str, String>) -> Vec<&'a str> {
    let is_root = |path: &str| {
        let Some((_, inside)) = path.rsplit_once("src/") else { return false };
        let program = inside.strip_prefix("bin/");
        ["lib.rs", "main.rs"].contains(&inside)
            || program
                .is_some_and(|program| !program.contains('/') || program.ends_with("/main.rs"))
    };
    code.keys().copied().filter(|path| is_root(path)).collect()
}

/// Finds files of a crate that import each other in a cycle of more than three.
pub fn circles(files: &[SourceFile]) -> Vec<String> {
    let code = product_code(files);
    let mut findings = Vec::new();
    for root in roots(&code) {
        let modules = Modules::read(root, &code);
        let ties = modules.ties();
        for circle in large_circles(modules.len(), &ties) {
            let arrows = arrows(&circle, &modules, &ties);
            let what = format!("a circle of {} files, at most {MAX_CIRCLE} may be", circle.len());
            findings.push(format!("{root}:1: {what}:\n{arrows}"));
        }
    }
    findings
}

/// Returns the imports within a cycle, each with the names that are imported.
fn arrows(circle: &[usize], modules: &Modules<'_>, ties: &Ties) -> String {
    let inside = ties.iter().filter(|((a, b), _)| circle.contains(a) && circle.contains(b));
    let arrows = inside.map(|((from, to), names)| {
        let names: Vec<_> = names.iter().map(String::as_str).collect();
        format!("  {} -> {}: {}", modules.path(*from), modules.path(*to), names.join(", "))
    });
    arrows.collect::<Vec<_>>().join("\n")
}

/// Returns the sets of strongly connected files that are too large.
fn large_circles(count: usize, ties: &Ties) -> Vec<Vec<usize>> {
    let reached = |from: usize| {
        let mut reached = vec![false; count];
        let mut waiting = vec![from];
        while let Some(here) = waiting.pop() {
            let next = ties.range((here, 0)..(here + 1, 0)).map(|((_, to), _)| *to);
            for to in next {
                if !std::mem::replace(&mut reached[to], true) {
                    waiting.push(to);
                }
            }
        }
        reached
    };
    let reached: Vec<Vec<bool>> = (0..count).map(reached).collect();
    let mut circles = Vec::new();
    for (file, from_file) in reached.iter().enumerate() {
        let both = |other: &usize| from_file[*other] && reached[*other][file];
        let circle: Vec<usize> = (0..count).filter(both).collect();
        if circle.len() > MAX_CIRCLE && circle.first() == Some(&file) {
            circles.push(circle);
        }
    }
    circles
}

/// Finds blocks `impl X` outside of X's file, unless they are all in one folder `api/`.
pub fn scattered_impls(files: &[SourceFile]) -> Vec<String> {
    let code = product_code(files);
    let mut findings = Vec::new();
    for root in roots(&code) {
        let modules = Modules::read(root, &code);
        for ((definition, name), impls) in modules.inherent_impls() {
            let elsewhere = impls.iter().filter(|file| **file != definition);
            let elsewhere: Vec<&str> = elsewhere.map(|file| modules.path(*file)).collect();
            let folder = |path: &str| path.rsplit_once('/').map(|(folder, _)| folder.to_owned());
            let first = elsewhere.first().and_then(|path| folder(path)).unwrap_or_default();
            let is_in_api = first.ends_with("/api")
                && elsewhere.iter().all(|path| folder(path).as_ref() == Some(&first));
            if !is_in_api && !elsewhere.is_empty() {
                let at = modules.path(definition);
                let where_else = elsewhere.join(", ");
                findings.push(format!("{at}:1: impl {name} stands in {where_else}"));
            }
        }
    }
    findings
}
