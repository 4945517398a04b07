//! Rules about the map of the engine.

use std::collections::HashSet;

use crate::files::SourceFile;
use crate::{assert_catches, assert_obeyed};

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

/// Finds the files, folders, types and functions that the map names and nobody has.
pub fn names(files: &[SourceFile]) -> Vec<String> {
    let Some(map) = files.iter().find(|file| file.path == MAP) else { return Vec::new() };
    let names = Names::of(files);
    let mut findings = Vec::new();
    let mut is_listing = false;
    for (number, line) in (1..).zip(map.text.lines()) {
        is_listing ^= line.starts_with("```");
        if is_listing || line.starts_with("```") {
            continue;
        }
        for span in line.split('`').skip(1).step_by(2) {
            let is_there = if span.ends_with(".rs") || span.ends_with('/') {
                files.iter().any(|file| lies_at(&file.path, span))
            } else {
                names.has(span)
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

/// The names of the workspace's code.
struct Names<'a> {
    /// Types, functions, modules, constants.
    items: HashSet<&'a str>,
    /// Functions, fields, variants and constants with the type or trait that has them.
    members: HashSet<(&'a str, &'a str)>,
    /// Packages, dependencies, and names that users write, such as those of strategies.
    others: HashSet<&'a str>,
}

impl<'a> Names<'a> {
    fn of(files: &'a [SourceFile]) -> Self {
        let mut names =
            Self { items: HashSet::new(), members: HashSet::new(), others: HashSet::new() };
        for file in files.iter().filter(|file| file.extension() == "toml") {
            let keys = file.text.lines().map(|line| first_word(line.trim_start_matches('[')));
            names.others.extend(keys);
            names.others.extend(file.path.split('/'));
        }
        for file in files.iter().filter(|file| file.is_rust()) {
            let mut owner = "";
            for line in file.text.lines() {
                names.items.extend(item(line));
                names.others.extend(line.split('"').skip(1).step_by(2));
                let indented = line.strip_prefix("    ");
                match indented.filter(|rest| !rest.starts_with([' ', '/', '#', '}'])) {
                    Some(_) if owner.is_empty() => {}
                    Some(rest) => names.members.extend(member(rest).map(|name| (owner, name))),
                    None if line.starts_with("where") => {}
                    None if line.starts_with(char::is_alphabetic) => owner = owner_of(line),
                    None => {}
                }
            }
        }
        names
    }

    /// Returns true if each part of a name such as `Frame::submit` is declared, or the name is none
    /// of ours: Vulkan's, the language's, or no name at all.
    fn has(&self, span: &str) -> bool {
        let is_name = span.chars().all(|c| c.is_alphanumeric() || "_:<>".contains(c));
        let path = span.split('<').next().unwrap_or_default();
        let is_lower = |c: char| c.is_lowercase() || c.is_numeric() || "_:".contains(c);
        let is_ours = if path.starts_with(char::is_uppercase) {
            path.contains(char::is_lowercase) && !path.starts_with("Vk") && path != "Drop"
        } else {
            path.chars().all(is_lower) && path != "unsafe"
        };
        if !is_name || !is_ours {
            return true;
        }
        match path.rsplit_once("::") {
            Some((owner, name)) => {
                let owner = owner.rsplit("::").next().unwrap_or(owner);
                self.members.contains(&(owner, name))
            }
            None => {
                self.items.contains(path)
                    || self.others.contains(path)
                    || self.members.iter().any(|(_, name)| *name == path)
            }
        }
    }
}

/// Returns a line without its visibility.
fn without_visibility(line: &str) -> &str {
    let line = line.trim_start();
    let Some(rest) = line.strip_prefix("pub") else { return line };
    let scope = if rest.starts_with('(') { rest.split_once(')') } else { None };
    scope.map_or(rest, |(_, rest)| rest).trim_start()
}

/// Returns the name of the item that a line declares.
fn item(line: &str) -> Option<&str> {
    let rest = without_visibility(line);
    let kinds = [
        "fn ",
        "const fn ",
        "unsafe fn ",
        "const unsafe fn ",
        "struct ",
        "enum ",
        "trait ",
        "type ",
        "static ",
        "const ",
        "mod ",
    ];
    kinds.iter().find_map(|kind| rest.strip_prefix(kind)).map(first_word)
}

/// Returns the name of the member that a line declares, if it lies directly in a type, in an
/// implementation or in a trait.
fn member(line: &str) -> Option<&str> {
    item(line).or_else(|| {
        let rest = without_visibility(line);
        let name = first_word(rest);
        let after = &rest[name.len()..];
        let is_variant = name.starts_with(char::is_uppercase)
            && (after.is_empty() || after.starts_with([',', '(']) || after.starts_with(" {"));
        (is_variant || after.starts_with(": ")).then_some(name)
    })
}

/// Returns the type or trait whose members follow a line at the left margin; an empty text if it
/// begins something else.
fn owner_of(line: &str) -> &str {
    let rest = without_visibility(line);
    let types = ["struct ", "enum ", "trait "];
    if let Some(name) = types.iter().find_map(|kind| rest.strip_prefix(kind)) {
        return first_word(name);
    }
    let Some(header) = rest.strip_prefix("impl") else { return "" };
    let mut depth = 0_i32;
    let end = header.char_indices().find(|&(_, c)| {
        depth += i32::from(c == '<') - i32::from(c == '>');
        depth == 0 && c != '>'
    });
    let subject = end.map_or("", |(at, _)| &header[at..]);
    let subject = subject.split_once(" for ").map_or(subject, |(_, subject)| subject);
    let path = subject.trim_start().split(['<', ' ']).next().unwrap_or_default();
    path.rsplit("::").next().unwrap_or_default()
}

/// Returns the name that a text begins with.
fn first_word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// Code that declares some names, and uses others.
const CODE: &str = r#"
pub struct Frame {
    pub slot: u32,
}
impl<'a> Frame {
    pub const fn submit() {
        other();
    }
}
impl Drop for crate::E {
    fn end() {}
}
enum E {
    Leaf,
}
fn free() {
    E::called();
    let local = "strategy_b";
}
mod place;
"#;

#[test]
fn the_map_is_short_and_names_what_there_is() {
    assert_obeyed(length);
    assert_obeyed(names);
    let long = "\n".repeat(200);
    assert_catches(length, &[("engine/ARCHITECTURE.md", &long)]);
    let with = |name: &str| {
        let map = SourceFile::new(MAP, &format!("A `{name}`."));
        let code = SourceFile::new("engine/gpu/src/frame.rs", CODE);
        names(&[map, code, SourceFile::new("engine/gpu/Cargo.toml", "")])
    };
    let wrong = "Fame frames.rs gpu/src/query/ Frame::submits Frame::Leaf Frame::other E::Leaves \
                 E::submit E::called local called free_it cull";
    for wrong in wrong.split(' ') {
        assert_eq!(with(wrong).len(), 1, "{wrong}");
    }
    let right = "Frame gpu/src/frame.rs gpu/src/ Frame::submit Frame::slot Frame<T> a::E::end E::Leaf \
                 free slot place strategy_b gpu VkDevice vkWait unsafe";
    for right in right.split(' ').chain(["a -> b"]) {
        assert_eq!(with(right), [""; 0], "{right}");
    }
}
