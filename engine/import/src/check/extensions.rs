//! Extensions that a file requires or uses.

use gltf::json::Root;

use crate::SUPPORTED_EXTENSIONS;
use crate::error::{Fault, Reason, quoted};
use crate::notes::Notes;

/// Refuses a file that requires what is not supported; notes what it merely uses.
pub(crate) fn required(root: &Root, notes: &mut Notes) -> Result<(), Fault> {
    let unknown = |list: &[String]| {
        let names = list.iter().filter(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str()));
        names.map(|name| quoted(name)).take(16).collect::<Vec<_>>().join(", ")
    };
    let required = unknown(&root.extensions_required);
    if !required.is_empty() {
        let reason = format!("it cannot be shown without {required}, which is not supported");
        return Err(Reason::unsupported(reason).of("extensionsRequired"));
    }
    let used = unknown(&root.extensions_used);
    if !used.is_empty() {
        notes.add(|| format!("extensions that are ignored: {used}"));
    }
    Ok(())
}
