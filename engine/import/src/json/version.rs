//! Versions of the format: MAJOR.MINOR (glTF 2.0, 3.2). A reader of 2.0 reads each 2.x whose
//! `minVersion` is not higher.

use gltf::json::Asset;

use crate::error::{Fault, Reason, quoted};
use crate::notes::{Note, Notes};

/// The version that this reader supports.
const KNOWN: Version = Version { major: 2, minor: 0 };

/// A version of the format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Version {
    major: u32,
    minor: u32,
}

impl Version {
    /// Parses a version of any number of parts, of which the first two matter. A missing or empty
    /// part is 0.
    fn of(text: &str) -> Option<Self> {
        let mut parts = text.split('.');
        let major = number(parts.next()?)?;
        let mut rest = parts.map(|part| if part.is_empty() { Some(0) } else { number(part) });
        let minor = rest.next().unwrap_or(Some(0))?;
        rest.all(|part| part.is_some()).then_some(Self { major, minor })
    }
}

fn number(text: &str) -> Option<u32> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
}

/// Checks the version of a file, and its `minVersion`. Spellings other than MAJOR.MINOR are noted.
pub(super) fn check(asset: &Asset, notes: &mut Notes) -> Result<(), Fault> {
    refuse_older(&asset.version)?;
    let version = read("version", &asset.version, notes)?;
    let least = asset.min_version.as_deref().map(|least| read("minVersion", least, notes));
    let least = least.transpose()?;
    // A `minVersion` below this version has no meaning, since older readers cannot read the file.
    match least.filter(|least| least.major >= KNOWN.major) {
        Some(KNOWN) => Ok(()),
        Some(_) => Err(other(asset.min_version.as_deref().unwrap_or_default())),
        None if version.major == KNOWN.major => Ok(()),
        None => Err(other(&asset.version)),
    }
}

/// Refuses a version before the supported one.
pub(super) fn refuse_older(text: &str) -> Result<(), Fault> {
    match text.split('.').next().and_then(number) {
        Some(major) if major < KNOWN.major => Err(other(text)),
        _ => Ok(()),
    }
}

fn read(key: &str, text: &str, notes: &mut Notes) -> Result<Version, Fault> {
    let Some(version) = Version::of(text) else {
        let reason = format!("its {key} {} is not a version like 2.0", quoted(text));
        return Err(Reason::malformed(reason).of("asset"));
    };
    let mut parts = text.split('.');
    let is_spelled = parts.clone().count() == 2 && parts.all(|part| !part.is_empty());
    if !is_spelled {
        notes.add(|| {
            let Version { major, minor } = version;
            let reason = format!("its {key} {} is read as {major}.{minor}", quoted(text));
            Note::new("asset", reason)
        });
    }
    Ok(version)
}

fn other(wanted: &str) -> Fault {
    Reason::unsupported(format!("it needs glTF {}, only 2.0 is known", quoted(wanted))).of("asset")
}
