//! The modules of a crate: the file that defines a name, and the files that import it.

use std::collections::{BTreeMap, BTreeSet};

use syn::punctuated::Punctuated;
use syn::visit::{self, Visit};
use syn::{Expr, Item, ItemImpl, ItemUse, Macro, Path, Token, Type, UseTree};

use crate::code::{without_comments_and_strings, without_tests};
use crate::files::SourceFile;

/// A name that a `use` defines, with its path.
struct Import {
    name: String,
    path: Vec<String>,
}

/// The contents of one file, as a module.
#[derive(Default)]
struct Module<'a> {
    path: &'a str,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    /// The names at its outermost level.
    items: BTreeSet<String>,
    uses: Vec<Import>,
    /// The paths of more than one name outside of `use`.
    paths: Vec<Vec<String>>,
    /// The type of each block `impl X`.
    impls: Vec<Vec<String>>,
}

/// The modules of one library or program, its root first.
pub struct Modules<'a> {
    modules: Vec<Module<'a>>,
}

/// The names that a file takes from another one, by the indices of both.
pub type Ties = BTreeMap<(usize, usize), BTreeSet<String>>;

/// The target of a path: a module, or an item that a module's file defines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Module(usize),
    Item(usize),
}

/// Returns the code of each file that is not a test, without items that are compiled for tests
/// alone.
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
        let file = syn::parse_file(&code[path]).unwrap_or_else(|error| panic!("{path}: {error}"));
        let mut module = Module { path, parent, ..Module::default() };
        module.items.extend(file.items.iter().filter_map(name_of));
        module.visit_file(&file);
        self.modules.push(module);
        for name in file.items.iter().filter_map(declared) {
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
    /// the file that defines them. The declaration of a child module does not count.
    pub fn ties(&self) -> Ties {
        let mut ties = Ties::new();
        for own in 0..self.modules.len() {
            let module = &self.modules[own];
            let imported = module.uses.iter().map(|usage| &usage.path);
            for path in imported.chain(&module.paths) {
                if let Some(Place::Item(file)) = self.resolve(own, path, &mut Vec::new())
                    && file != own
                {
                    let name = path.iter().rfind(|name| name.starts_with(char::is_uppercase));
                    let name = name.or(path.last()).cloned().unwrap_or_default();
                    ties.entry((own, file)).or_default().insert(name);
                }
            }
        }
        ties
    }

    /// Returns each type with blocks `impl X` as its file and name, with the files of the blocks.
    pub fn inherent_impls(&self) -> BTreeMap<(usize, &str), BTreeSet<usize>> {
        let mut found: BTreeMap<_, BTreeSet<usize>> = BTreeMap::new();
        for (own, module) in self.modules.iter().enumerate() {
            for path in &module.impls {
                let place = self.resolve(own, path, &mut Vec::new());
                if let (Some(Place::Item(file)), Some(name)) = (place, path.last()) {
                    found.entry((file, name.as_str())).or_default().insert(own);
                }
            }
        }
        found
    }

    fn resolve(
        &self,
        from: usize,
        path: &[String],
        seen: &mut Vec<(usize, String)>,
    ) -> Option<Place> {
        let mut here = from;
        let mut is_ours = false;
        for (at, name) in path.iter().enumerate() {
            match name.as_str() {
                "crate" => here = 0,
                "super" => here = self.modules[here].parent?,
                "self" | "*" => {}
                _ => match self.look_up(here, name, seen) {
                    Some(Place::Module(module)) => here = module,
                    // An item that a macro makes is not found: it belongs to the module in the
                    // path.
                    None if is_ours && at > 0 => return Some(Place::Item(here)),
                    other => return other,
                },
            }
            is_ours = true;
        }
        Some(Place::Module(here))
    }

    /// Finds the target of a name in a module; names of other crates have none.
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
        named.map(|named| &named.path).next().and_then(|path| self.resolve(module, path, seen))
    }
}

impl<'ast> Visit<'ast> for Module<'_> {
    fn visit_item_use(&mut self, import: &'ast ItemUse) {
        self.add_imports(&import.tree, Vec::new());
    }

    fn visit_item_impl(&mut self, block: &'ast ItemImpl) {
        if let (None, Type::Path(subject)) = (&block.trait_, &*block.self_ty) {
            self.impls.push(names_of(&subject.path));
        }
        visit::visit_item_impl(self, block);
    }

    fn visit_path(&mut self, path: &'ast Path) {
        if path.segments.len() > 1 {
            self.paths.push(names_of(path));
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast Macro) {
        // Only macros whose arguments are expressions are searched.
        let list = Punctuated::<Expr, Token![,]>::parse_terminated;
        for expression in call.parse_body_with(list).into_iter().flatten() {
            self.visit_expr(&expression);
        }
        visit::visit_macro(self, call);
    }
}

impl Module<'_> {
    /// Adds the names that a tree of a `use` defines below a path.
    fn add_imports(&mut self, tree: &UseTree, above: Vec<String>) {
        let mut path = above;
        let name = match tree {
            UseTree::Path(below) => {
                path.push(below.ident.to_string());
                return self.add_imports(&below.tree, path);
            }
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.add_imports(tree, path.clone()));
            }
            UseTree::Glob(_) => {
                path.push("*".to_owned());
                "*".to_owned()
            }
            UseTree::Name(named) if named.ident == "self" => {
                path.last().cloned().unwrap_or_default()
            }
            UseTree::Name(named) => {
                path.push(named.ident.to_string());
                named.ident.to_string()
            }
            UseTree::Rename(renamed) => {
                path.push(renamed.ident.to_string());
                renamed.rename.to_string()
            }
        };
        self.uses.push(Import { name, path });
    }
}

fn names_of(path: &Path) -> Vec<String> {
    path.segments.iter().map(|segment| segment.ident.to_string()).collect()
}

/// Returns the name that an item defines.
pub fn name_of(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Mod(item) => &item.ident,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}

/// Returns the name of a module that has its own file.
fn declared(item: &Item) -> Option<String> {
    let Item::Mod(module) = item else { return None };
    module.content.is_none().then(|| module.ident.to_string())
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
        let names: Vec<_> = names.iter().map(String::as_str).collect();
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
