//! The destination of a file: files are replaced whole, at the end of links; pipes, devices and the
//! process's own output are written into as they are.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::time::Duration;

/// The most links that are followed, one after the other.
const LINKS_MAX: usize = 40;

/// The time within which the reader of a pipe may open it: as long as a person takes to start one.
#[cfg(unix)]
const READER_WAIT: Duration = Duration::from_secs(10);
/// The interval at which readers are looked for.
#[cfg(unix)]
const READER_POLL: Duration = Duration::from_millis(50);

/// The destination that a path leads to.
#[derive(Debug)]
pub enum Destination {
    /// A file, existing or not, under its own name and not by a link. It is replaced whole.
    File(PathBuf),
    /// The output of this process itself, such as `/dev/stdout`: writing continues at its position.
    Output(File),
    /// Anything else that is written into: a pipe, a terminal, a device.
    Stream(PathBuf),
}

impl Destination {
    /// Resolves `path`. Opens nothing and changes nothing.
    ///
    /// # Errors
    /// A folder, or a name that no file can have; links that form a cycle; any error of the system.
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

    /// Writes `bytes`. After a failure, a file has its old contents or all of the new ones.
    ///
    /// # Errors
    /// When the folder or the disk refuses, the reader is gone, or no reader opens a pipe within
    /// seconds.
    pub fn write(self, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::File(path) => replace(&path, bytes),
            Self::Output(mut output) => output.write_all(bytes),
            // Opened without creating or truncating it: it exists, and has no length.
            Self::Stream(path) => open_stream(&path)?.write_all(bytes),
        }
    }
}

/// Opens a stream that exists already. Opening a pipe without a reader would block for ever.
#[cfg(unix)]
fn open_stream(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;

    use rustix::fs::{OFlags, fcntl_setfl};
    use rustix::io::Errno;

    let flags = i32::try_from(OFlags::NONBLOCK.bits()).unwrap_or_default();
    let began = std::time::Instant::now();
    loop {
        match OpenOptions::new().write(true).custom_flags(flags).open(path) {
            Ok(file) => {
                fcntl_setfl(&file, OFlags::empty())?;
                return Ok(file);
            }
            Err(error) if error.raw_os_error() != Some(Errno::NXIO.raw_os_error()) => {
                return Err(error);
            }
            Err(_) if began.elapsed() > READER_WAIT => {
                return Err(io::Error::new(io::ErrorKind::TimedOut, "this pipe has no reader"));
            }
            Err(_) => std::thread::sleep(READER_POLL),
        }
    }
}

#[cfg(not(unix))]
fn open_stream(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).open(path)
}

/// Returns the folder in which a file lies.
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
    path.as_os_str().to_string_lossy().ends_with(std::path::is_separator)
}

/// Returns the path that links lead to if nothing exists there yet.
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

/// Returns our standard output or error if it has the same metadata: its file must not be replaced
/// while this process writes to it.
#[cfg(unix)]
fn own_output(found: &Metadata) -> Option<File> {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;

    let stdout = io::stdout();
    let stderr = io::stderr();
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

/// The longest name that a file can have, in bytes.
const NAME_BYTES_MAX: usize = 255;
/// The most names that are tried for a new file.
const NAMES_MAX: u32 = 100_000;

/// Writes a temporary file in the same folder, then renames it.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    partial(folder_of(path), bytes)?.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// Writes a file that did not exist, whole or not at all. Where `path` is taken, its name gets a
/// number: `street.png`, `street-2.png`. Returns the path that was free, also among other
/// processes.
///
/// # Errors
/// When the folder or the disk refuses.
pub fn create(path: &Path, bytes: &[u8]) -> io::Result<PathBuf> {
    let folder = folder_of(path);
    // Another process may have made it, and removed it since.
    fs::create_dir_all(folder)?;
    let mut file = partial(folder, bytes)?;
    for number in 1..=NAMES_MAX {
        let free = folder.join(numbered(path, number)?);
        if fs::symlink_metadata(&free).is_ok() {
            continue;
        }
        match file.persist_noclobber(&free) {
            Ok(_) => return Ok(free),
            Err(taken) if taken.error.kind() == io::ErrorKind::AlreadyExists => file = taken.file,
            Err(refused) => return Err(refused.error),
        }
    }
    Err(io::Error::new(io::ErrorKind::AlreadyExists, "all names like it are taken"))
}

/// Returns a temporary file, which is removed when dropped. Its permissions follow the umask of the
/// process.
fn partial(folder: &Path, bytes: &[u8]) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".antumbra-").suffix(".partial");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map(|()| file)
}

/// Returns the name of a path, with a number from 2 on, short enough for a file system.
fn numbered(path: &Path, number: u32) -> io::Result<OsString> {
    let lossy = |part: Option<&OsStr>| part.map(|part| part.to_string_lossy().into_owned());
    let name = path.file_name().ok_or_else(no_file)?;
    if number == 1 && name.len() <= NAME_BYTES_MAX {
        return Ok(name.to_owned());
    }
    let suffix = match (number, lossy(path.extension())) {
        (1, extension) => extension.map(|extension| format!(".{extension}")).unwrap_or_default(),
        (_, None) => format!("-{number}"),
        (_, Some(extension)) => format!("-{number}.{extension}"),
    };
    let mut stem = lossy(path.file_stem()).unwrap_or_default();
    stem.truncate(stem.floor_char_boundary(NAME_BYTES_MAX.saturating_sub(suffix.len())));
    Ok(OsString::from(stem + &suffix))
}

#[cfg(test)]
mod tests;
