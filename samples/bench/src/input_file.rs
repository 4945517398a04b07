//! Small files that a user names: read up to a limit, and only if they are regular files.

use std::fs::{File, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

/// Opens a regular file, to be read up to `bytes_max` bytes.
///
/// # Errors
/// A folder, a pipe or a device, whose length is unknown; a file that is larger; any error of the
/// system.
pub fn open(path: &Path, bytes_max: u64) -> io::Result<io::Take<File>> {
    let file = open_at_once(path)?;
    // The opened file is checked, since the name may come to refer to another file.
    let found = file.metadata()?;
    let refuse = |reason: String| Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    if found.is_dir() {
        return refuse("it is a folder".to_owned());
    }
    if !found.is_file() {
        return refuse("it is not a regular file but a pipe or a device".to_owned());
    }
    if found.len() > bytes_max {
        return refuse(format!("it has {} bytes; at most {bytes_max} are read", found.len()));
    }
    Ok(file.take(bytes_max))
}

/// Reads all of a regular file of at most `bytes_max` bytes.
///
/// # Errors
/// As [`open`].
pub fn read(path: &Path, bytes_max: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path, bytes_max)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads a regular file of at most `bytes_max` bytes that is text.
///
/// # Errors
/// As [`open`]; bytes that are not UTF-8.
pub fn read_text(path: &Path, bytes_max: u64) -> io::Result<String> {
    let text = String::from_utf8(read(path, bytes_max)?);
    text.map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not text"))
}

/// Opens without waiting for the other end of a pipe.
fn open_at_once(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;

        let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOCTTY;
        options.custom_flags(flags.bits().cast_signed());
    }
    options.open(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outputs::tests::Scratch;

    #[cfg(unix)]
    #[test]
    fn what_has_no_known_end_is_refused_at_once() {
        let scratch = Scratch::new("input-endless");
        let pipe = scratch.0.join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let sparse = scratch.0.join("sparse");
        File::create(&sparse).unwrap().set_len(3 << 30).unwrap();
        for (path, reason) in [
            (pipe.as_path(), "not a regular file"),
            (Path::new("/dev/zero"), "not a regular file"),
            (Path::new("/dev/tty"), ""),
            (scratch.0.as_path(), "it is a folder"),
            (sparse.as_path(), "it has 3221225472 bytes; at most 1000"),
            (&scratch.0.join("none"), "No such file"),
        ] {
            let refused = read_text(path, 1000).unwrap_err().to_string();
            assert!(refused.contains(reason), "{path:?}: {refused}");
        }
    }

    #[test]
    fn files_are_read_to_the_limit() {
        let scratch = Scratch::new("input-small");
        let file = scratch.0.join("file");
        std::fs::write(&file, b"1234").unwrap();
        assert_eq!(read_text(&file, 4).unwrap(), "1234");
        assert!(read_text(&file, 3).is_err());
        std::fs::write(&file, b"\xff").unwrap();
        assert_eq!(read_text(&file, 4).unwrap_err().to_string(), "it is not text");
    }
}
