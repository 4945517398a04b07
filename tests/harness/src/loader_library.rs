//! Vulkan loaders in C, for programs that find their loader themselves.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::Scratch;

/// A folder with a loader that calls the real one, as `LD_LIBRARY_PATH` takes it.
pub(crate) struct LoaderLibrary {
    pub(crate) folder: Scratch,
    real: String,
}

impl LoaderLibrary {
    /// Compiles the source into a folder of this name.
    pub(crate) fn compile(name: &str, source: &str) -> Self {
        let folder = Scratch::new(name);
        let file = folder.0.join("loader.c");
        fs::write(&file, source).expect("the target folder is writable");
        let compiled = Command::new("cc")
            .args(["-std=c11", "-Wall", "-Werror", "-shared", "-fPIC", "-o"])
            .arg(folder.0.join("libvulkan.so.1"))
            .arg(file)
            .status();
        assert!(compiled.expect("a C compiler").success());
        let found = Command::new("cc").arg("-print-file-name=libvulkan.so.1").output();
        let real = String::from_utf8(found.expect("a C compiler").stdout).expect("a path");
        let real = real.trim_end().to_owned();
        assert!(Path::new(&real).is_absolute(), "needs `ci/setup`: {real}");
        Self { folder, real }
    }

    /// Gives the library to a program.
    pub(crate) fn give(&self, program: &mut Command) {
        program.env("LD_LIBRARY_PATH", &self.folder.0).env("REAL_LOADER", &self.real);
    }
}
