//! Runs a program as a user does, in a folder of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of the test's own, removed when dropped.
pub struct Scratch(pub PathBuf);

impl Scratch {
    /// Creates the folder, empty.
    pub fn new(name: &str) -> Self {
        let folder = tests_folder().join(name);
        let _absent = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("the target folder is writable");
        Self(folder)
    }

    /// Returns the names of its entries, sorted.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.0.join(folder)).expect("it exists");
        let name = |entry: std::io::Result<fs::DirEntry>| entry.expect("it is read").file_name();
        let mut names: Vec<_> =
            entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _gone = fs::remove_dir_all(&self.0);
    }
}

/// Returns a program in `folder`, with its pipeline cache in the target folder.
pub fn program(name: &str, folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(name);
    command.current_dir(folder).args(arguments).env("XDG_CACHE_HOME", cache());
    command
}

/// Returns the same for a program that is to be sent signals. A program that ignored them from its
/// start would go on ignoring them. So do the programs of a background job in a shell without job
/// control.
pub fn signalled_program(name: &str, folder: &Path, arguments: &[&str]) -> Command {
    program("env", folder, &[&["--default-signal=INT,TERM,HUP", name], arguments].concat())
}

/// Returns the folder of pipeline caches: no test may write into the user's own.
pub fn cache() -> PathBuf {
    tests_folder().join("cache")
}

/// Returns Cargo's folder for files of tests: beside the folder of the profile, in which `deps` has
/// this program.
fn tests_folder() -> PathBuf {
    let this = std::env::current_exe().expect("a program");
    this.ancestors().nth(3).expect("a target folder").join("tmp")
}

/// Returns the text that a program wrote to standard error.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Writes a copy of the engine's GLSL in which `name` has `to` instead of `from`.
pub fn edited_shaders(scratch: &Scratch, name: &str, from: &str, to: &str) {
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
    for entry in fs::read_dir(committed).expect("the shaders") {
        let entry = entry.expect("it is read");
        if entry.path().is_file() {
            fs::copy(entry.path(), scratch.0.join(entry.file_name())).expect("a copy");
        }
    }
    let file = scratch.0.join(name);
    let text = fs::read_to_string(&file).expect("the shader");
    assert!(text.contains(from), "{name} has changed: adapt this test");
    fs::write(&file, text.replace(from, to)).expect("a copy to edit");
}
