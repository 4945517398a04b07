//! Where a file is written, by what stands there already: files are replaced whole, where links lead;
//! pipes, devices and our own output are written into as they are.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;

/// The most links that are followed, one after the other.
const LINKS_MAX: usize = 40;

/// What a name stands for when something is to be written there.
#[derive(Debug)]
pub enum Destination {
    /// A file, there already or not, under the name that is its own and no link. It is replaced whole.
    File(PathBuf),
    /// What this process writes to by itself, such as `/dev/stdout`: it goes on where that stands.
    Output(File),
    /// Anything else that is written into: a pipe, a terminal, a device.
    Stream(PathBuf),
}

impl Destination {
    /// Finds out what `path` stands for. Opens nothing and changes nothing.
    ///
    /// # Errors
    /// A folder, or a name that is none; links that lead in a circle; whatever the system refuses.
    pub fn of(path: &Path) -> io::Result<Self> {
        match fs::metadata(path) {
            Ok(found) => Self::there(path, &found),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let file = end_of_links(path)?;
                let is_name = file.file_name().is_some() && !ends_open(&file);
                if is_name { Ok(Self::File(file)) } else { Err(no_file()) }
            }
            Err(error) => Err(error),
        }
    }

    fn there(path: &Path, found: &Metadata) -> io::Result<Self> {
        if found.is_dir() {
            return Err(no_file());
        }
        if let Some(output) = own_output(found) {
            return Ok(Self::Output(output));
        }
        if found.is_file() {
            return Ok(Self::File(fs::canonicalize(path)?));
        }
        Ok(Self::Stream(path.to_owned()))
    }

    /// Writes `bytes`. A file is the old one or the whole new one, whatever goes wrong.
    ///
    /// # Errors
    /// When the folder or the disk refuses, or nobody reads any more.
    pub fn write(self, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::File(path) => replace(&path, bytes),
            Self::Output(mut output) => output.write_all(bytes),
            // Neither made nor emptied: it is there, and has no end.
            Self::Stream(path) => OpenOptions::new().write(true).open(path)?.write_all(bytes),
        }
    }
}

/// The folder in which a file lies.
pub fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn no_file() -> io::Error {
    io::Error::new(io::ErrorKind::IsADirectory, "it is not the name of a file")
}

fn ends_open(path: &Path) -> bool {
    path.as_os_str().to_string_lossy().ends_with('/')
}

/// The name at the end of links that lead to nothing yet.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..LINKS_MAX {
        match fs::read_link(&path) {
            Ok(target) => path = folder_of(&path).join(target),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("its links lead in a circle"))
}

/// Our standard output or error, if that is what was found: a file behind it must not be replaced
/// under the feet of what is written there next.
#[cfg(unix)]
fn own_output(found: &Metadata) -> Option<File> {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;

    let (stdout, stderr) = (io::stdout(), io::stderr());
    [stdout.as_fd(), stderr.as_fd()].into_iter().find_map(|stream| {
        let file = File::from(stream.try_clone_to_owned().ok()?);
        let own = file.metadata().ok()?;
        ((own.dev(), own.ino()) == (found.dev(), found.ino())).then_some(file)
    })
}

#[cfg(not(unix))]
fn own_output(_: &Metadata) -> Option<File> {
    None
}

/// Writes a file under another name beside it, then renames.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let name = path.file_name().ok_or_else(no_file)?;
    let partial_name = format!(".{}.{}.partial", name.to_string_lossy(), process::id());
    let partial = folder_of(path).join(partial_name);
    let written = File::create(&partial)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&partial, path));
    written.inspect_err(|_| {
        let _absent = fs::remove_file(&partial);
    })
}

#[cfg(test)]
#[path = "destination_tests.rs"]
mod tests;
