//! The data of a URI: text in the URI (`data:`), or a file below the scene's folder. Nothing else
//! is read.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;
use scene::counted;

use crate::error::{Reason, quoted};
use crate::memory;

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The number of wanted bytes of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// The first bytes of the resource, of which there must be this number.
    First(u64),
    /// All bytes of the resource.
    All,
}

/// Returns the bytes that `uri` refers to, at most `limit`.
pub(crate) fn fetch(
    uri: &str,
    folder: Option<&Path>,
    wanted: Wanted,
    limit: u64,
) -> Result<Vec<u8>, Reason> {
    let bytes = match data_part(uri) {
        Some(part) => inline(&part?, limit)?,
        None => return below(folder, &relative_path(uri)?, wanted, limit),
    };
    cut(bytes, wanted)
}

fn cut(mut bytes: Vec<u8>, wanted: Wanted) -> Result<Vec<u8>, Reason> {
    if let Wanted::First(count) = wanted {
        let there = bytes.len() as u64;
        if there < count {
            return Err(shorter(there, count));
        }
        bytes.truncate(count as usize);
    }
    Ok(bytes)
}

fn shorter(there: u64, wanted: u64) -> Reason {
    let there = counted(there, "byte is", "bytes are");
    Reason::malformed(format!("its byteLength is {wanted}, but only {there} there"))
}

/// Returns the part after `data:`, with a flag for base64.
fn data_part(uri: &str) -> Option<Result<DataPart<'_>, Reason>> {
    let scheme = uri.get(..5)?;
    if !scheme.eq_ignore_ascii_case("data:") {
        return None;
    }
    let Some((header, text)) = uri[5..].split_once(',') else {
        return Some(Err(Reason::malformed("its data URI has no comma")));
    };
    let is_base64 =
        header.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    Some(Ok(DataPart { is_base64: is_base64 && header.contains(';'), text }))
}

/// The text of a data URI, not decoded.
struct DataPart<'a> {
    is_base64: bool,
    text: &'a str,
}

fn inline(part: &DataPart<'_>, limit: u64) -> Result<Vec<u8>, Reason> {
    let DataPart { is_base64, text } = *part;
    let most = if is_base64 { text.len() as u64 / 4 * 3 } else { text.len() as u64 };
    if most > limit {
        return Err(Reason::too_large("bytes in data URIs and files beside this one", most, limit));
    }
    let plain = percent_decode_str(text);
    if !is_base64 {
        return Ok(plain.collect());
    }
    let decoded = if text.contains('%') {
        BASE64.decode(plain.collect::<Vec<u8>>())
    } else {
        BASE64.decode(text)
    };
    decoded.map_err(|error| Reason::malformed(format!("its data URI is not base64: {error}")))
}

/// Returns the path of a URI without a scheme, if it stays below its folder.
fn relative_path(uri: &str) -> Result<PathBuf, Reason> {
    let shown = quoted(uri);
    let refused = |why: &str| Reason::forbidden(format!("its URI {shown} {why}"));
    if let Some(scheme) = scheme(uri) {
        return Err(refused(&format!("has the scheme {}, only data: is allowed", quoted(scheme))));
    }
    let path = percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| Reason::malformed(format!("its URI {shown} is not UTF-8")))?;
    if path.is_empty() {
        return Err(Reason::malformed("its URI is empty"));
    }
    if path.starts_with('/') {
        return Err(refused("is absolute"));
    }
    if path.contains('\\') || path.chars().any(char::is_control) {
        return Err(refused("has a backslash or a control character in it"));
    }
    if cfg!(windows) && path.contains(':') {
        return Err(refused("has a colon in it"));
    }
    let mut relative = PathBuf::new();
    for segment in path.split('/') {
        match segment {
            "" | "." => {}
            ".." if relative.pop() => {}
            ".." => return Err(refused("leads out of the scene's folder")),
            name => relative.push(name),
        }
    }
    Ok(relative)
}

/// Returns the scheme of a URI by RFC 3986; a drive letter counts as a scheme.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let is_scheme = scheme.starts_with(|first: char| first.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'));
    is_scheme.then_some(scheme)
}

fn below(
    folder: Option<&Path>,
    relative: &Path,
    wanted: Wanted,
    limit: u64,
) -> Result<Vec<u8>, Reason> {
    let shown = quoted(&relative.display().to_string());
    let folder = folder.ok_or_else(|| {
        Reason::forbidden(format!(
            "it is in the file {shown}, but this scene was read without a folder"
        ))
    })?;
    let unreadable =
        |error: std::io::Error| Reason::unreadable(format!("{shown} cannot be read: {error}"));
    let folder = folder.canonicalize().map_err(unreadable)?;
    // Resolves symbolic links, so that the path that is checked is the path that is opened.
    let path = folder.join(relative).canonicalize().map_err(unreadable)?;
    if !path.starts_with(&folder) {
        return Err(Reason::forbidden(format!(
            "{shown} is a link that leads out of the scene's folder"
        )));
    }
    read_file(&path, &shown, wanted, limit)
}

/// The beginning of a Git LFS pointer, which stands for a file that is stored elsewhere.
const LFS_POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";

fn lfs_pointer(shown: &str) -> Reason {
    Reason::unreadable(format!(
        "{shown} is a Git LFS pointer, not the file itself: run `git lfs pull` in its folder"
    ))
}

/// Reads a regular file, named `shown` in errors. Pipes and devices are refused, since they may
/// never end.
pub(crate) fn read_file(
    path: &Path,
    shown: &str,
    wanted: Wanted,
    limit: u64,
) -> Result<Vec<u8>, Reason> {
    let unreadable =
        |error: std::io::Error| Reason::unreadable(format!("{shown} cannot be read: {error}"));
    let about = path.metadata().map_err(unreadable)?;
    if !about.is_file() {
        let what = if about.is_dir() { "a folder" } else { "a device or a pipe" };
        return Err(Reason::unreadable(format!("{shown} is not a file, but {what}")));
    }
    let count = match wanted {
        Wanted::First(count) if about.len() < count => {
            let mut start = Vec::new();
            let most = LFS_POINTER.len() as u64;
            File::open(path)
                .map_err(unreadable)?
                .take(most)
                .read_to_end(&mut start)
                .map_err(unreadable)?;
            return Err(if start == LFS_POINTER {
                lfs_pointer(shown)
            } else {
                shorter(about.len(), count)
            });
        }
        Wanted::First(count) => count,
        Wanted::All => about.len(),
    };
    if count > limit {
        return Err(Reason::too_large("bytes of the file", count, limit));
    }
    memory::ask(count)?;
    let mut bytes = Vec::with_capacity(count as usize);
    // The file may have grown in the meantime. Recognising a pointer takes more bytes than a small
    // buffer may have.
    File::open(path)
        .map_err(unreadable)?
        .take(count.max(LFS_POINTER.len() as u64))
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.starts_with(LFS_POINTER) {
        return Err(lfs_pointer(shown));
    }
    cut(bytes, wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pointer_of_git_lfs_is_known_however_little_is_wanted() {
        let path = std::env::temp_dir().join(format!("antumbra-pointer-{}", std::process::id()));
        std::fs::write(&path, [LFS_POINTER, b"v1\noid sha256:4d7a\nsize 9\n"].concat()).unwrap();
        for wanted in [Wanted::First(8), Wanted::First(60), Wanted::First(1000), Wanted::All] {
            let error = read_file(&path, "it", wanted, 1 << 20).unwrap_err();
            assert!(format!("{error:?}").contains("Git LFS pointer"), "{error:?}");
        }
        std::fs::write(&path, b"0123456789").unwrap();
        assert_eq!(read_file(&path, "it", Wanted::First(8), 1 << 20).unwrap(), b"01234567");
        std::fs::remove_file(&path).unwrap();
    }
}
