//! The files of the workspace, read once per test.

use std::fs;
use std::path::Path;

/// A file, with its path from the workspace's root.
pub struct SourceFile {
    /// The path, such as "engine/gpu/src/lib.rs", with `/` on every system.
    pub path: String,
    /// The contents; empty for a file that is not text.
    pub text: String,
}

impl SourceFile {
    pub fn new(path: &str, text: &str) -> Self {
        Self { path: path.to_owned(), text: text.to_owned() }
    }

    /// Returns the part after the last dot of its name, or an empty text.
    pub fn extension(&self) -> &str {
        let name = self.path.rsplit('/').next().unwrap_or_default();
        name.rsplit_once('.').map_or("", |(_, extension)| extension)
    }

    pub fn is_rust(&self) -> bool {
        self.extension() == "rs"
    }

    /// Returns the syntax tree of a Rust file.
    pub fn syntax(&self) -> syn::File {
        syn::parse_file(&self.text).unwrap_or_else(|error| panic!("{}: {error}", self.path))
    }

    /// Returns true for a shader of one stage, false for an include.
    pub fn is_stage(&self) -> bool {
        ["vert", "frag", "comp", "geom", "tesc", "tese"].contains(&self.extension())
    }

    /// Returns true for a script, or a file that scripts read.
    pub fn is_script(&self) -> bool {
        self.path.starts_with("ci/") || self.path.starts_with(".ci/") || self.extension() == "sh"
    }

    /// Returns true if all of it is compiled for tests and benchmarks alone.
    pub fn is_test(&self) -> bool {
        let path = self.path.as_str();
        path.starts_with("tests/")
            || path.contains("/tests/")
            || path.contains("/benches/")
            || path.ends_with("/tests.rs")
            || path.ends_with("_tests.rs")
    }

    /// Returns a finding in a line, counted from 1.
    pub fn finding(&self, line: usize, reason: &str) -> String {
        format!("{}:{line}: {reason}", self.path)
    }
}

/// Returns every file except build outputs and git's own, in the order of their paths.
pub fn workspace() -> Vec<SourceFile> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ lies in the root");
    let mut files = Vec::new();
    collect(root, "", &mut files);
    files.sort_by(|a, b| a.path.cmp(&b.path));
    files
}

fn collect(folder: &Path, prefix: &str, files: &mut Vec<SourceFile>) {
    for entry in fs::read_dir(folder).expect("a folder of the workspace") {
        let entry = entry.expect("an entry of the workspace");
        let name = entry.file_name().into_string().expect("names are UTF-8");
        let kind = entry.file_type().expect("a kind of file");
        let skipped = prefix.is_empty() && ["target", "out", ".git"].contains(&name.as_str());
        let path = format!("{prefix}{name}");
        if kind.is_dir() && !skipped {
            collect(&entry.path(), &format!("{path}/"), files);
        } else if kind.is_file() && !skipped {
            let bytes = fs::read(entry.path()).expect("readable");
            files.push(SourceFile { path, text: String::from_utf8(bytes).unwrap_or_default() });
        }
    }
}
