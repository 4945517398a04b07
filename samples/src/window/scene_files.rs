//! The files in the list of scenes: files that were opened, and files beside them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The most entries of a folder that are read.
const MOST_ENTRIES: usize = 10_000;

/// Returns the opened scene files, the newest first, followed by the scene files in the folder of
/// the newest. If none was opened, the working folder is used.
pub fn to_choose(opened: &[PathBuf]) -> Vec<PathBuf> {
    let newest = opened.last().and_then(|file| file.parent());
    let folder = newest.filter(|folder| !folder.as_os_str().is_empty());
    let beside = beside(folder.unwrap_or(Path::new(".")), folder.is_some());
    let mut files: Vec<PathBuf> = Vec::new();
    for file in opened.iter().rev().cloned().chain(beside) {
        if !files.contains(&file) {
            files.push(file);
        }
    }
    files
}

/// Returns the scene files in a folder, sorted by name; none if it cannot be read.
fn beside(folder: &Path, is_named: bool) -> BTreeSet<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().take(MOST_ENTRIES).flatten();
    let files =
        entries.map(|entry| if is_named { entry.path() } else { PathBuf::from(entry.file_name()) });
    let is_scene = |file: &PathBuf| {
        let extension = file.extension().map(|extension| extension.to_ascii_lowercase());
        let is_known = |known: &str| extension.as_ref().is_some_and(|extension| extension == known);
        ["glb", "gltf", "stl", "obj"].into_iter().any(is_known)
    };
    files.filter(is_scene).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opened_files_come_first_and_each_once() {
        let folder = std::env::temp_dir().join(format!("scene-files-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        for name in ["b.glb", "a.GLTF", "c.png", "glb", "d.stl"] {
            fs::write(folder.join(name), "").unwrap();
        }
        let opened = [PathBuf::from("/elsewhere/z.glb"), folder.join("b.glb")];
        let files = to_choose(&opened);
        fs::remove_dir_all(&folder).unwrap();
        let opened = [folder.join("b.glb"), "/elsewhere/z.glb".into()];
        assert_eq!(files[..2], opened);
        assert_eq!(files[2..], [folder.join("a.GLTF"), folder.join("d.stl")]);
        assert!(to_choose(&["/no/such/folder/a.glb".into()]).len() == 1);
    }
}
