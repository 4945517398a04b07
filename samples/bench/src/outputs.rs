//! Files that a walk writes: checked to be writable before any work, and never left half written.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::args::Options;
use crate::destination::{self, Destination, folder_of};
use crate::options::UsageError;
use crate::terminal::shown;

/// A file that could not be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// A file, or the folder it belongs in.
    #[error("cannot write '{path}': {reason}; is there space, and may you write there?")]
    File {
        /// The file's path, escaped.
        path: String,
        /// The system's reason.
        reason: String,
    },
    /// Standard output, which may be a full disk.
    #[error("cannot write to standard output: {0}; is there space where it leads?")]
    StandardOutput(String),
}

impl WriteError {
    /// Creates the error for a file from its cause.
    pub fn new(path: &Path, reason: impl ToString) -> Self {
        Self::File { path: shown(path).to_string(), reason: reason.to_string() }
    }
}

/// The number of attempts to make a folder that others remove.
const TRIES_MAX: u32 = 100;

/// The folders that were made for a walk. Dropping it removes the empty ones, so that a failed walk
/// leaves nothing behind.
#[derive(Debug)]
pub struct Outputs {
    made: Vec<PathBuf>,
}

/// A file that an option names.
#[derive(Clone, Copy, Debug)]
pub struct OutputFile<'a> {
    /// The option, such as `--report`.
    pub option: &'static str,
    /// The file.
    pub path: &'a Path,
}

impl<'a> OutputFile<'a> {
    /// Returns the file of an option, if it was given.
    pub fn of(option: &'static str, path: Option<&'a Path>) -> Option<Self> {
        path.map(|path| Self { option, path })
    }

    /// Checks that it is the name of a file in a folder that exists and takes files.
    fn check(&self) -> Result<(), UsageError> {
        let Self { option, path } = *self;
        let file = match Destination::of(path) {
            Ok(Destination::File(file)) => file,
            // Opened when there is something to write: a reader takes the end of the first writer
            // for the end of all.
            Ok(Destination::Output(_) | Destination::Stream(_)) => return Ok(()),
            Err(error) => {
                let what = format!("cannot write '{}' ({error})", shown(path));
                return Err(no_place(option, &what));
            }
        };
        let folder = folder_of(&file);
        if !folder.is_dir() {
            let file = shown(path);
            let folder = shown(folder);
            return Err(UsageError(format!(
                "{option}: cannot write '{file}', there is no folder '{folder}'; make it first, or choose another place"
            )));
        }
        probe(folder).map_err(|Refused { what, error }| {
            no_place(option, &format!("{what} '{}' ({error})", shown(folder)))
        })
    }
}

/// Returns the error of an option whose place takes no files.
fn no_place(option: &str, what: &str) -> UsageError {
    UsageError(format!("{option}: {what}; choose a place you can write"))
}

impl Outputs {
    /// Makes the folder `out`, if it is missing, and checks that files can be written there and at
    /// the places of `files`, whose folders exist by then.
    ///
    /// # Errors
    /// The option whose file or folder cannot be written, and the reason.
    pub fn prepare<'a>(
        out: Option<&Path>,
        files: impl IntoIterator<Item = OutputFile<'a>>,
    ) -> Result<Self, UsageError> {
        let mut outputs = Self { made: Vec::new() };
        out.map_or(Ok(()), |folder| outputs.prepare_folder("--out", folder))?;
        files.into_iter().try_for_each(|file| file.check())?;
        Ok(outputs)
    }

    /// Prepares the folder and the file of a walk in the same way, and checks its folder of
    /// shaders.
    ///
    /// # Errors
    /// As [`Outputs::prepare`] and [`check_shaders`].
    pub fn of_walk(options: &Options) -> Result<Self, UsageError> {
        options.asked.device.shaders.as_deref().map_or(Ok(()), check_shaders)?;
        let report = OutputFile::of("--report", options.asked.report.as_deref());
        Self::prepare(options.asked.out.as_deref(), report)
    }

    fn prepare_folder(&mut self, option: &str, folder: &Path) -> Result<(), UsageError> {
        let refuse = |what: &str, error: &dyn std::fmt::Display| {
            no_place(option, &format!("{what} '{}' ({error})", shown(folder)))
        };
        // One call: between two calls the folder could be removed.
        if fs::metadata(folder).is_ok_and(|found| !found.is_dir()) {
            return Err(refuse("cannot use", &"it is not a folder"));
        }
        let mut tries = 1..=TRIES_MAX;
        loop {
            // Another program that ends may remove its empty folders at any time between our steps.
            match self.make(folder).and_then(|()| probe(folder)) {
                Ok(()) => return Ok(()),
                // Creating a file fails in a folder that is being removed.
                Err(Refused { error, .. }) if may_pass(&error) && tries.next().is_some() => {}
                Err(Refused { what, error }) => return Err(refuse(what, &error)),
            }
        }
    }

    fn make(&mut self, folder: &Path) -> Result<(), Refused> {
        let missing: Vec<&Path> =
            folder.ancestors().take_while(|ancestor| !ancestor.exists()).collect();
        for &ancestor in missing.iter().rev() {
            if ancestor.as_os_str().is_empty() {
                continue;
            }
            match fs::create_dir(ancestor) {
                Ok(()) => self.made.push(ancestor.to_owned()),
                // Another program made the folder, and removes it if it stays empty.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(Refused { what: "cannot make the folder", error }),
            }
        }
        Ok(())
    }
}

/// An attempt at a folder that the system refused.
struct Refused {
    /// The words of the error that precede the name of the folder.
    what: &'static str,
    error: io::Error,
}

/// Returns true for an error that occurs while another program removes the folder.
fn may_pass(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied)
}

/// Checks that files can be written into a folder.
fn probe(folder: &Path) -> Result<(), Refused> {
    // The file has a name: for a file without one, some systems confuse a folder that was made
    // again with the removed one.
    let file = tempfile::Builder::new().prefix(".antumbra-").tempfile_in(folder);
    file.and_then(tempfile::NamedTempFile::close)
        .map_err(|error| Refused { what: "cannot write into the folder", error })
}

impl Drop for Outputs {
    fn drop(&mut self) {
        for folder in self.made.iter().rev() {
            // Refuses where something was written, which is what we want.
            let _refused = fs::remove_dir(folder);
        }
    }
}

/// Checks that the shaders are in a folder, and that this build can compile them.
///
/// # Errors
/// A path that is not a folder; a build without a compiler.
pub fn check_shaders(folder: &Path) -> Result<(), UsageError> {
    if cfg!(not(feature = "shader-compiler")) {
        return Err(UsageError(
            "--shaders: this build has no shader compiler; build it with --features shader-compiler"
                .to_owned(),
        ));
    }
    if folder.is_dir() {
        return Ok(());
    }
    Err(UsageError(format!("--shaders: there is no folder '{}'", shown(folder))))
}

/// Writes `bytes` where `path` leads: after a failure, a file has its old contents or all of the
/// new ones; a pipe or a device is written into.
///
/// # Errors
/// When the folder or the disk refuses.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let written = Destination::of(path).and_then(|destination| destination.write(bytes));
    written.map_err(|error| WriteError::new(path, error))
}

/// Writes a file that did not exist: under the name of `path`, or with a number appended if that is
/// taken. Returns its path.
///
/// # Errors
/// When the folder or the disk refuses.
pub fn write_new(path: &Path, bytes: &[u8]) -> Result<PathBuf, WriteError> {
    destination::create(path, bytes).map_err(|error| WriteError::new(path, error))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::args::Arguments;
    use clap::Parser;
    use std::process;

    /// A folder of the test's own that is removed afterwards.
    pub(crate) struct Scratch(pub PathBuf);

    impl Scratch {
        pub(crate) fn new(name: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("antumbra-{name}-{}", process::id()));
            fs::create_dir_all(&folder).unwrap();
            Self(folder)
        }

        pub(crate) fn names(&self) -> Vec<String> {
            let entries = fs::read_dir(&self.0).unwrap();
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            fs::remove_dir_all(&self.0).unwrap();
        }
    }

    fn options(line: &[&str]) -> Options {
        Arguments::try_parse_from([&["walkthrough"], line].concat()).unwrap().options().unwrap()
    }

    #[test]
    fn folders_that_stay_empty_go_again() {
        let scratch = Scratch::new("empty");
        let out = scratch.0.join("a/b");
        // In a folder that is made for the images.
        let report = scratch.0.join("a/report.json");
        let options =
            options(&["--out", out.to_str().unwrap(), "--report", report.to_str().unwrap()]);
        let outputs = Outputs::of_walk(&options).unwrap();
        assert!(out.is_dir() && !report.exists());
        drop(outputs);
        assert!(scratch.names().is_empty());
    }

    #[test]
    fn nobody_asks_for_the_folder_of_a_file() {
        let scratch = Scratch::new("no-folder");
        let report = scratch.0.join("reprots/report.json");
        let refused = Outputs::of_walk(&options(&["--report", report.to_str().unwrap()]));
        let message = refused.unwrap_err().to_string();
        assert!(message.starts_with("--report: cannot write "), "{message}");
        assert!(
            message.contains("there is no folder") && message.contains("reprots'"),
            "{message}"
        );
        assert!(scratch.names().is_empty());
    }

    #[test]
    fn folders_with_something_in_them_stay() {
        let scratch = Scratch::new("kept");
        let out = scratch.0.join("a/b");
        let outputs = Outputs::of_walk(&options(&["--out", out.to_str().unwrap()])).unwrap();
        write_file(&out.join("x"), b"new").unwrap();
        drop(outputs);
        assert_eq!(fs::read(out.join("x")).unwrap(), b"new");
    }

    #[test]
    fn a_file_is_replaced_whole_or_not_at_all() {
        let scratch = Scratch::new("replace");
        let file = scratch.0.join("file");
        write_file(&file, b"old").unwrap();
        write_file(&file, b"new").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(scratch.names(), ["file"]);

        let folder = scratch.0.join("folder");
        fs::create_dir(&folder).unwrap();
        let message = write_file(&folder, b"x").unwrap_err().to_string();
        assert!(message.starts_with("cannot write"), "{message}");
        assert_eq!(scratch.names().len(), 2);
    }

    #[test]
    fn many_programs_may_have_the_same_new_folder() {
        let scratch = Scratch::new("shared");
        let out = scratch.0.join("a/b/c");
        let options = options(&["--out", out.to_str().unwrap()]);
        let begin = std::sync::Barrier::new(8);
        for _ in 0..50 {
            std::thread::scope(|scope| {
                for _ in 0..8 {
                    scope.spawn(|| {
                        begin.wait();
                        // No file is written, so each thread removes the folders that it made, at
                        // any time.
                        drop(Outputs::of_walk(&options).unwrap());
                    });
                }
            });
            // A folder remains if its thread tried to remove it before the folders in it were gone.
            let _gone = fs::remove_dir_all(scratch.0.join("a"));
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_may_take_the_report_wherever_it_lies() {
        let scratch = Scratch::new("pipe");
        let pipe = scratch.0.join("pipe");
        assert!(process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        // Preparing does not open the pipe, which has no reader, and its folder need not be
        // writable.
        for place in [pipe.to_str().unwrap(), "/dev/zero"] {
            drop(Outputs::of_walk(&options(&["--report", place])).unwrap());
        }
        assert_eq!(scratch.names(), ["pipe"]);
    }

    #[test]
    fn what_cannot_be_written_is_refused_and_leaves_nothing() {
        let scratch = Scratch::new("refused");
        let file = scratch.0.join("file");
        fs::write(&file, b"kept").unwrap();
        let below = file.join("below");
        let everywhere = [
            ("--out", file.as_path()),
            ("--out", below.as_path()),
            ("--report", below.as_path()),
            ("--report", scratch.0.as_path()),
            ("--report", Path::new("folder/")),
            ("--report", Path::new("..")),
        ];
        // Elsewhere this is a name as any other.
        let on_linux =
            [("--out", Path::new("/proc")), ("--report", Path::new("/proc/report.json"))];
        let on_linux = on_linux.into_iter().filter(|_| cfg!(target_os = "linux"));
        for (option, path) in everywhere.into_iter().chain(on_linux) {
            let refused = Outputs::of_walk(&options(&[option, path.to_str().unwrap()]));
            let message = refused.unwrap_err().to_string();
            assert!(message.starts_with(option) && !message.contains('\n'), "{message}");
        }
        assert_eq!(scratch.names(), ["file"]);
        assert_eq!(fs::read(&file).unwrap(), b"kept");
    }
}
