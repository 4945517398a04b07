//! The list of shader stages and the hashes of their sources, shared by the compiler and its test.

use std::io::Result;
use std::path::Path;

use sha2::{Digest, Sha256};

/// The endings of the names of stages.
const STAGES: [&str; 6] = [".vert", ".tesc", ".tese", ".geom", ".frag", ".comp"];

/// Returns the names of all stages in `folder`, sorted.
pub fn stages(folder: &Path) -> Result<Vec<String>> {
    let stage = |name: &String| STAGES.iter().any(|end| name.ends_with(end));
    Ok(names(folder)?.into_iter().filter(stage).collect())
}

/// Returns one line for every source, include and SPIR-V file in `folder`: its hash and its name. A
/// source that was changed without compiling it, or a SPIR-V file of another origin, changes a
/// line.
pub fn hashes(folder: &Path) -> Result<String> {
    let mut lines = String::new();
    for name in names(folder)? {
        if STAGES.iter().chain(&[".glsl", ".spv"]).any(|end| name.ends_with(end)) {
            let hash = Sha256::digest(std::fs::read(folder.join(&name))?);
            let hash: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
            lines.push_str(&format!("{hash}  {name}\n"));
        }
    }
    Ok(lines)
}

fn names(folder: &Path) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(folder)?;
    let name = |entry: Result<std::fs::DirEntry>| {
        entry.map(|entry| entry.file_name().to_string_lossy().into_owned())
    };
    let mut names = entries.map(name).collect::<Result<Vec<_>>>()?;
    names.sort();
    Ok(names)
}
