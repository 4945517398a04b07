//! The modules of a crate: the file that defines a name, and the files that import it.

use std::collections::{BTreeMap, BTreeSet};

use crate::code::{without_comments_and_strings, without_tests};
use crate::files::SourceFile;
use crate::tokens::{Import, Token, imports, tokens};

/// The contents of one file, as a module.
struct Module<'a> {
    path: &'a str,
    parent: Option<usize>,
    children: BTreeMap<&'a str, usize>,
    /// The names at its outermost level.
    items: BTreeSet<&'a str>,
    uses: Vec<Import<'a>>,
    tokens: Vec<Token<'a>>,
    /// The type of each block `impl X`.
    impls: Vec<Vec<&'a str>>,
}

/// The modules of one library or program, its root first.
pub struct Modules<'a> {
    modules: Vec<Module<'a>>,
}

/// The names that a file takes from another one, by the indices of both.
pub type Ties<'a> = BTreeMap<(usize, usize), BTreeSet<&'a str>>;

/// The target of a path: a module, or an item that a module's file defines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Module(usize),
    Item(usize),
}

/// Returns the code of each file but tests, without items that are compiled for tests alone.
pub fn product_code(files: &[SourceFile]) -> BTreeMap<&str, String> {
    let product = files.iter().filter(|file| file.is_rust() && !file.is_test());
    let code = |file: &SourceFile| without_tests(&without_comments_and_strings(&file.text));
    product.map(|file| (file.path.as_str(), code(file))).collect()
}

impl<'a> Modules<'a> {
    /// Reads the modules below the crate root at `root`.
    pub fn read(root: &'a str, code: &'a BTreeMap<&str, String>) -> Self {
        let mut all = Self { modules: Vec::new() };
        let folder = root.rsplit_once('/').map_or("", |(folder, _)| folder);
        all.add(root, folder, None, code);
        all
    }

    fn add(
        &mut self,
        path: &'a str,
        folder: &str,
        parent: Option<usize>,
        code: &'a BTreeMap<&str, String>,
    ) -> usize {
        let own = self.modules.len();
        let (module, declared) = read_module(path, parent, &code[path]);
        self.modules.push(module);
        for name in declared {
            let beside = format!("{folder}/{name}.rs");
            let inside = format!("{folder}/{name}/mod.rs");
            let found =
                [beside, inside].into_iter().find_map(|path| code.get_key_value(path.as_str()));
            if let Some((child, _)) = found {
                let child = self.add(child, &format!("{folder}/{name}"), Some(own), code);
                self.modules[own].children.insert(name, child);
            }
        }
        own
    }

    pub fn path(&self, file: usize) -> &'a str {
        self.modules[file].path
    }

    pub fn len(&self) -> usize {
        self.modules.len()
    }

    /// Returns the names that each file takes from each other one. Names of a re-export come from
    /// the file that defines them; a child that is declared is not taken.
    pub fn ties(&self) -> Ties<'a> {
        let mut ties = Ties::new();
        for own in 0..self.modules.len() {
            let module = &self.modules[own];
            let written = module.uses.iter().map(|usage| usage.path.clone());
            for path in written.chain(paths(&module.tokens)) {
                if let Some(Place::Item(file)) = self.resolve(own, &path, &mut Vec::new())
                    && file != own
                {
                    let name = path.iter().rfind(|name| name.starts_with(char::is_uppercase));
                    let name = name.or(path.last()).copied().unwrap_or_default();
                    ties.entry((own, file)).or_default().insert(name);
                }
            }
        }
        ties
    }

    /// Returns each type with blocks `impl X` as its file and name, with the files of the blocks.
    pub fn inherent_impls(&self) -> BTreeMap<(usize, &'a str), BTreeSet<usize>> {
        let mut found: BTreeMap<_, BTreeSet<usize>> = BTreeMap::new();
        for (own, module) in self.modules.iter().enumerate() {
            for path in &module.impls {
                let place = self.resolve(own, path, &mut Vec::new());
                if let (Some(Place::Item(file)), Some(&name)) = (place, path.last()) {
                    found.entry((file, name)).or_default().insert(own);
                }
            }
        }
        found
    }

    fn resolve(
        &self,
        from: usize,
        path: &[&str],
        seen: &mut Vec<(usize, String)>,
    ) -> Option<Place> {
        let mut here = from;
        let mut is_ours = false;
        for (at, &name) in path.iter().enumerate() {
            match name {
                "crate" => here = 0,
                "super" => here = self.modules[here].parent?,
                "self" | "*" => {}
                _ => match self.look_up(here, name, seen) {
                    Some(Place::Module(module)) => here = module,
                    // An item made by a macro is found nowhere: it belongs to the module named.
                    None if is_ours && at > 0 => return Some(Place::Item(here)),
                    other => return other,
                },
            }
            is_ours = true;
        }
        Some(Place::Module(here))
    }

    /// Finds the target of a name in a module; names of other crates are found nowhere.
    fn look_up(&self, module: usize, name: &str, seen: &mut Vec<(usize, String)>) -> Option<Place> {
        let key = (module, name.to_owned());
        if seen.contains(&key) {
            return None;
        }
        seen.push(key);
        let here = &self.modules[module];
        if let Some(&child) = here.children.get(name) {
            return Some(Place::Module(child));
        }
        if here.items.contains(name) {
            return Some(Place::Item(module));
        }
        let named = here.uses.iter().filter(|usage| usage.name == name);
        let path = named.map(|named| named.path.clone()).next();
        path.and_then(|path| self.resolve(module, &path, seen))
    }
}

/// Returns the paths of more than one name in code outside of `use`.
fn paths<'a>(tokens: &[Token<'a>]) -> Vec<Vec<&'a str>> {
    let mut paths = Vec::new();
    let mut path = Vec::new();
    let mut joined = false;
    for token in tokens.iter().chain([&Token::Mark(';')]) {
        match *token {
            Token::Word(word) if joined || path.is_empty() => {
                path.push(word);
                joined = false;
                continue;
            }
            Token::Path if !path.is_empty() => {
                joined = true;
                continue;
            }
            _ => {}
        }
        if path.len() > 1 || (path.len() == 1 && joined) {
            paths.push(path.clone());
        }
        path.clear();
        joined = false;
        if let Token::Word(word) = *token {
            path.push(word);
        }
    }
    paths
}

/// Reads one file; returns also the modules that it declares to be in files of their own.
fn read_module<'a>(
    path: &'a str,
    parent: Option<usize>,
    code: &'a str,
) -> (Module<'a>, Vec<&'a str>) {
    let all = tokens(code);
    let mut items = BTreeSet::new();
    let mut uses = Vec::new();
    let mut rest = Vec::new();
    let mut declared = Vec::new();
    let mut impls = Vec::new();
    let mut depth = 0_usize;
    let mut at = 0;
    while at < all.len() {
        match (all[at], all.get(at + 1).copied()) {
            (Token::Word("use"), Some(Token::Word(_) | Token::Mark('{'))) => {
                let (found, length) = imports(&all[at + 1..]);
                uses.extend(found);
                at += length;
            }
            (Token::Word("mod"), Some(Token::Word(name))) if depth == 0 => {
                if all.get(at + 2) == Some(&Token::Mark(';')) {
                    declared.push(name);
                }
                items.insert(name);
            }
            (Token::Word(kind), Some(Token::Word(name)))
                if depth == 0 && DEFINES.contains(&kind) && !DEFINES.contains(&name) =>
            {
                items.insert(name);
            }
            (Token::Word("macro_rules"), _) if depth == 0 => {
                if let Some(&Token::Word(name)) = all.get(at + 2) {
                    items.insert(name);
                }
            }
            (Token::Word("impl"), _) if depth == 0 && begins_item(&all[..at]) => {
                impls.extend(implemented(&all[at + 1..]));
            }
            (Token::Mark('{'), _) => depth += 1,
            (Token::Mark('}'), _) => depth = depth.saturating_sub(1),
            _ => {}
        }
        rest.push(all[at]);
        at += 1;
    }
    let children = BTreeMap::new();
    (Module { path, parent, children, items, uses, tokens: rest, impls }, declared)
}

/// Words that a definition begins with.
const DEFINES: [&str; 8] = ["struct", "enum", "union", "trait", "type", "fn", "const", "static"];

/// Returns true if an item can begin behind these tokens, and not a type.
fn begins_item(before: &[Token<'_>]) -> bool {
    let last = before.last().copied().unwrap_or(Token::Mark(';'));
    matches!(last, Token::Mark('}' | ';' | ']') | Token::Word("unsafe"))
}

/// Returns the type whose own block begins behind `impl`; none if a trait is implemented.
fn implemented<'a>(tokens: &[Token<'a>]) -> Option<Vec<&'a str>> {
    let mut path = Vec::new();
    let mut angles = 0_usize;
    let mut before = Token::Mark(' ');
    for &token in tokens {
        match token {
            Token::Mark('<') => angles += 1,
            Token::Mark('>') if before != Token::Mark('-') => angles = angles.saturating_sub(1),
            Token::Mark('{') | Token::Word("where") if angles == 0 => return Some(path),
            Token::Word("for") if angles == 0 => return None,
            Token::Word(word) if angles == 0 => {
                if before != Token::Path {
                    path.clear();
                }
                path.push(word);
            }
            _ => {}
        }
        before = token;
    }
    None
}

#[test]
fn names_come_from_the_file_that_defines_them() {
    let files = [
        ("a/src/lib.rs", "mod b; mod c; mod d; pub use b::B; pub use c::make;"),
        ("a/src/b.rs", "use crate::make; pub struct B; impl B {} impl Clone for B {}"),
        ("a/src/c/mod.rs", "mod e; use super::d; pub fn make() -> d::D { std::d::f() }"),
        ("a/src/c/e.rs", "use crate::b::{self}; impl<T: Fn() -> u8> b::B where T: A {}"),
        ("a/src/d.rs", "pub struct D; #[cfg(test)] mod tests { use crate::B; }"),
    ];
    let files = files.map(|(path, text)| SourceFile::new(path, text));
    let code = product_code(&files);
    let modules = Modules::read("a/src/lib.rs", &code);
    let short = |file: usize| modules.path(file).trim_start_matches("a/src/");
    let impls = modules.inherent_impls();
    let of_b: Vec<_> = impls.values().flatten().map(|file| short(*file)).collect();
    assert_eq!(of_b, ["b.rs", "c/e.rs"]);
    let ties = modules.ties();
    let ties = ties.iter().map(|((from, to), names)| {
        let names: Vec<_> = names.iter().copied().collect();
        format!("{} -> {}: {}", short(*from), short(*to), names.join(", "))
    });
    let mut ties: Vec<_> = ties.collect();
    ties.sort();
    assert_eq!(
        ties,
        [
            "b.rs -> c/mod.rs: make",
            "c/e.rs -> b.rs: B",
            "c/mod.rs -> d.rs: D",
            "lib.rs -> b.rs: B",
            "lib.rs -> c/mod.rs: make"
        ]
    );
}
