//! Rules about the map of the engine.

use std::collections::HashSet;

use syn::visit::{self, Visit};
use syn::{Field, ImplItem, Item, TraitItem, Type};

use crate::files::SourceFile;
use crate::modules::name_of;
use crate::{assert_catches, assert_obeyed};

const MAP: &str = "engine/ARCHITECTURE.md";

/// The most lines of the map, so that it is read.
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

/// Finds files, folders, types and functions in the map that do not exist.
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

/// Returns true if a file has this name in the map, or lies in a folder that has it.
fn lies_at(path: &str, name: &str) -> bool {
    let path = format!("/{path}");
    if name.ends_with('/') {
        path.contains(&format!("/{name}"))
    } else {
        path.ends_with(&format!("/{name}"))
    }
}

/// The names of the workspace's code.
#[derive(Default)]
struct Names {
    /// Types, functions, modules, constants.
    items: HashSet<String>,
    /// Functions, fields, variants and constants with the type or trait that has them.
    members: HashSet<(String, String)>,
    /// Packages, dependencies, and names that users write, such as `antumbra_queries`.
    others: HashSet<String>,
}

impl Names {
    fn of(files: &[SourceFile]) -> Self {
        let mut names = Self::default();
        for file in files.iter().filter(|file| file.extension() == "toml") {
            let keys = file.text.lines().map(|line| first_word(line.trim_start_matches('[')));
            names.others.extend(keys.chain(file.path.split('/')).map(str::to_owned));
        }
        for file in files.iter().filter(|file| file.is_rust()) {
            names.visit_file(&file.syntax());
            let strings = file.text.lines().flat_map(|line| line.split('"').skip(1).step_by(2));
            names.others.extend(strings.map(str::to_owned));
        }
        names
    }

    fn add_members(&mut self, owner: &str, members: impl Iterator<Item = Option<String>>) {
        self.members.extend(members.flatten().map(|member| (owner.to_owned(), member)));
    }

    /// Returns true if each part of a name such as `Frame::submit` is declared, or the name is not
    /// ours: a name of Vulkan or Rust, or not a name.
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
                self.members.contains(&(owner.to_owned(), name.to_owned()))
            }
            None => {
                self.items.contains(path)
                    || self.others.contains(path)
                    || self.members.iter().any(|(_, name)| name == path)
            }
        }
    }
}

impl<'ast> Visit<'ast> for Names {
    fn visit_item(&mut self, item: &'ast Item) {
        let name = name_of(item).unwrap_or_default();
        match item {
            Item::Struct(item) => self.add_members(&name, item.fields.iter().map(name_of_field)),
            Item::Enum(item) => {
                let variants = item.variants.iter().map(|variant| Some(variant.ident.to_string()));
                self.add_members(&name, variants);
            }
            Item::Trait(item) => {
                self.add_members(
                    &name,
                    item.items.iter().map(|member| match member {
                        TraitItem::Const(member) => Some(member.ident.to_string()),
                        TraitItem::Fn(member) => Some(member.sig.ident.to_string()),
                        TraitItem::Type(member) => Some(member.ident.to_string()),
                        _ => None,
                    }),
                );
            }
            Item::Impl(item) => {
                let Type::Path(owner) = &*item.self_ty else { return };
                let owner = owner.path.segments.last().map(|segment| segment.ident.to_string());
                let members = item.items.iter().map(|member| match member {
                    ImplItem::Const(member) => Some(member.ident.to_string()),
                    ImplItem::Fn(member) => Some(member.sig.ident.to_string()),
                    ImplItem::Type(member) => Some(member.ident.to_string()),
                    _ => None,
                });
                self.add_members(&owner.unwrap_or_default(), members);
            }
            _ => {}
        }
        self.items.insert(name);
        visit::visit_item(self, item);
    }
}

fn name_of_field(field: &Field) -> Option<String> {
    field.ident.as_ref().map(ToString::to_string)
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
