//! Rules against knots: files of a crate lie above each other, and the methods of a type are in one
//! of them.

use std::collections::BTreeMap;

use crate::files::SourceFile;
use crate::modules::{Modules, Ties, product_code};

/// The largest circle of files that import each other: these are read as one, and more than three
/// are too much to read.
const MAX_CIRCLE: usize = 3;

/// The sizes of the larger circles that are left, largest first. Numbers here only fall: a crate
/// that is not here has none, and a change that makes a circle smaller lowers its number.
const CIRCLES_LEFT: [(&str, &[usize]); 0] = [];

/// Types whose blocks `impl X` are in several files, with the number of files. Numbers here only
/// fall.
const SCATTERED_LEFT: [(&str, &str, usize); 9] = [
    ("engine/animation", "Clip", 2),
    ("engine/animation", "Rig", 2),
    ("engine/animation", "Track", 2),
    ("engine/import", "Assembly", 3),
    ("engine/import", "GltfScene", 2),
    ("engine/import", "Primitive", 2),
    ("engine/import", "SceneAnimator", 2),
    ("engine/scene", "Mesh", 2),
    ("engine/scene", "Scene", 2),
];

/// Returns the root of each library and program among the files.
fn roots<'a>(code: &BTreeMap<&'a str, String>) -> Vec<&'a str> {
    let is_root = |path: &str| {
        let Some((_, inside)) = path.rsplit_once("src/") else { return false };
        let program = inside.strip_prefix("bin/");
        ["lib.rs", "main.rs"].contains(&inside)
            || program.is_some_and(|it| !it.contains('/') || it.ends_with("/main.rs"))
    };
    code.keys().copied().filter(|path| is_root(path)).collect()
}

/// Returns the folder of the crate that a root belongs to.
fn crate_of(root: &str) -> &str {
    root.rsplit_once("/src/").map_or(root, |(folder, _)| folder)
}

/// Finds files of a crate that import each other in a circle of more than three.
pub fn circles(files: &[SourceFile]) -> Vec<String> {
    circles_but(files, &CIRCLES_LEFT)
}

/// Finds circles as [`circles`] does, except for `left` old ones.
pub fn circles_but(files: &[SourceFile], left: &[(&str, &[usize])]) -> Vec<String> {
    let code = product_code(files);
    let mut findings = Vec::new();
    for root in roots(&code) {
        let modules = Modules::read(root, &code);
        let ties = modules.ties();
        let circles = large_circles(modules.len(), &ties);
        let sizes: Vec<usize> = circles.iter().map(Vec::len).collect();
        let of_crate = left.iter().find(|(name, _)| *name == crate_of(root));
        let of_crate = of_crate.filter(|_| root.ends_with("/lib.rs"));
        let allowed = of_crate.map_or(&[][..], |(_, sizes)| *sizes);
        if sizes == allowed {
            continue;
        }
        if sizes.iter().le(allowed.iter()) {
            let what =
                format!("circles of {sizes:?} files are left, lower the numbers of the rule");
            findings.push(format!("{root}:1: {what} from {allowed:?}"));
            continue;
        }
        let what =
            format!("circles of {sizes:?} files, at most {MAX_CIRCLE} or {allowed:?} may be");
        findings.push(format!("{root}:1: {what}"));
        findings.extend(circles.iter().map(|circle| shown(circle, &modules, &ties)));
    }
    findings
}

/// Returns a circle's arrows, each with the names that are imported.
fn shown(circle: &[usize], modules: &Modules<'_>, ties: &Ties<'_>) -> String {
    let inside = ties.iter().filter(|((a, b), _)| circle.contains(a) && circle.contains(b));
    let arrows = inside.map(|((from, to), names)| {
        let names: Vec<_> = names.iter().copied().collect();
        format!("  {} -> {}: {}", modules.path(*from), modules.path(*to), names.join(", "))
    });
    let arrows: Vec<_> = arrows.collect();
    format!("circle of {}:\n{}", circle.len(), arrows.join("\n"))
}

/// Returns the strongly connected files in sets that are too large, the largest first.
fn large_circles(count: usize, ties: &Ties<'_>) -> Vec<Vec<usize>> {
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
    circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
    circles
}

/// Finds blocks `impl X` outside of one file, or of X's file and one folder `api/`.
pub fn scattered_impls(files: &[SourceFile]) -> Vec<String> {
    scattered_impls_but(files, &SCATTERED_LEFT)
}

/// Finds blocks as [`scattered_impls`] does, except for `left` old ones.
pub fn scattered_impls_but(files: &[SourceFile], left: &[(&str, &str, usize)]) -> Vec<String> {
    let code = product_code(files);
    let mut findings = Vec::new();
    let mut gone: Vec<_> = left.to_vec();
    gone.retain(|(path, ..)| roots(&code).iter().any(|root| crate_of(root) == *path));
    for root in roots(&code) {
        let modules = Modules::read(root, &code);
        for ((definition, name), impls) in modules.inherent_impls() {
            let elsewhere: Vec<&str> = impls
                .iter()
                .filter(|file| impls.len() > 1 && **file != definition)
                .map(|file| modules.path(*file))
                .collect();
            let folder = |path: &str| path.rsplit_once('/').map(|(folder, _)| folder.to_owned());
            let first = elsewhere.first().and_then(|path| folder(path)).unwrap_or_default();
            let in_api = first.ends_with("/api")
                && elsewhere.iter().all(|path| folder(path).as_ref() == Some(&first));
            let found = if in_api || elsewhere.is_empty() { 1 } else { impls.len() };
            let of_type = left.iter().find(|(path, it, _)| *path == crate_of(root) && *it == name);
            let allowed = of_type.map_or(1, |(_, _, count)| *count);
            gone.retain(|it| Some(it) != of_type);
            let at = modules.path(definition);
            if found > allowed {
                let where_else = elsewhere.join(", ");
                findings.push(format!("{at}:1: impl {name} stands also in {where_else}"));
            } else if found < allowed {
                let what = "lower the number of the rule";
                findings.push(format!("{at}:1: impl {name} stands in {found} files, {what}"));
            }
        }
    }
    let is_gone = |(path, name, _): &(&str, &str, usize)| {
        format!("{path}/src/lib.rs:1: there is no impl {name}, take it out of the rule")
    };
    findings.extend(gone.iter().map(is_gone));
    findings
}
