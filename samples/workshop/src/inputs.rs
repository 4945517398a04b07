//! The files that a run reads and must not overwrite.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use bench::options::UsageError;
use bench::outputs::OutputFile;
use bench::terminal::shown;
use percent_encoding::percent_decode_str;

/// The most bytes of a model in which file names are searched. In glTF they are at the beginning.
const MOST_BYTES: u64 = 1 << 28;

/// Returns the file of a model and the files that it refers to: buffers and images of glTF, and
/// materials of OBJ. Unreadable files have no references.
pub fn files_of(model: &Path) -> Vec<PathBuf> {
    let folder = model.parent().unwrap_or(Path::new(""));
    let extension = model.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let names = match extension.to_ascii_lowercase().as_str() {
        "gltf" | "glb" => uris(json_of(&beginning(model))),
        "obj" => libraries(&beginning(model)),
        _ => Vec::new(),
    };
    let named = names.into_iter().map(|name| folder.join(name));
    std::iter::once(model.to_owned()).chain(named).collect()
}

/// Returns the beginning of a file; empty if it cannot be read.
fn beginning(file: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    let read = File::open(file).and_then(|file| file.take(MOST_BYTES).read_to_end(&mut bytes));
    if read.is_err() {
        bytes.clear();
    }
    bytes
}

/// Returns the JSON of a glTF file: the whole file, or the first chunk of a binary one.
fn json_of(file: &[u8]) -> &[u8] {
    if !file.starts_with(b"glTF") {
        return file;
    }
    // The header has 12 bytes. The chunk's header has 8 bytes and begins with the chunk's length.
    let length = file.get(12..16).and_then(|bytes| <[u8; 4]>::try_from(bytes).ok());
    let length = length.map_or(0, u32::from_le_bytes) as usize;
    file.get(20..20_usize.saturating_add(length)).unwrap_or_default()
}

/// Returns the file names of a glTF file's buffers and images.
fn uris(json: &[u8]) -> Vec<String> {
    let Ok(root) = serde_json::from_slice::<serde_json::Value>(json) else { return Vec::new() };
    let lists = ["buffers", "images"].into_iter().filter_map(|list| root[list].as_array());
    let uris = lists.flatten().filter_map(|element| element["uri"].as_str());
    let files = uris.filter(|uri| !uri.starts_with("data:"));
    files.map(|uri| percent_decode_str(uri).decode_utf8_lossy().into_owned()).collect()
}

/// Returns the material files that an OBJ file refers to.
fn libraries(obj: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(obj);
    let names = text.lines().filter_map(|line| line.trim().strip_prefix("mtllib "));
    names.map(|name| name.trim().to_owned()).collect()
}

/// Refuses to overwrite input files.
///
/// # Errors
/// The option that names such a file.
pub fn keep_inputs(outputs: &[OutputFile<'_>], inputs: &[PathBuf]) -> Result<(), UsageError> {
    let inputs: Vec<PathBuf> =
        inputs.iter().filter_map(|input| input.canonicalize().ok()).collect();
    for OutputFile { option, path } in outputs {
        if path.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
            let path = shown(path);
            return Err(UsageError(format!(
                "{option}: '{path}' is read by this run and would be lost; choose another name"
            )));
        }
    }
    Ok(())
}

/// Refuses to write the report over another output file of the same run.
///
/// # Errors
/// The name of the report.
pub fn keep_outputs(report: Option<&Path>, written: &[&Path]) -> Result<(), UsageError> {
    let Some(report) = report else { return Ok(()) };
    let place = |file: &Path| {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
        Some(folder.join(file.file_name()?))
    };
    if place(report).is_some() && written.iter().any(|file| place(file) == place(report)) {
        let report = shown(report);
        return Err(UsageError(format!(
            "--report: the script writes '{report}', too; choose another name"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_a_model_names_are_its_inputs() {
        let gltf = br#"{ "buffers": [{ "uri": "a%20%C3%BCb.bin" }, { "uri": "data:," }, {}],
                         "images": [{ "uri": "c.png" }] }"#;
        assert_eq!(uris(gltf), ["a \u{fc}b.bin", "c.png"]);
        let length = (gltf.len() as u32).to_le_bytes();
        let binary = [&b"glTF\x02\0\0\0\0\0\0\0"[..], &length, b"JSON", gltf, b"rest"].concat();
        assert_eq!(uris(json_of(&binary)), uris(gltf));
        assert_eq!(uris(json_of(&binary[..30])), [""; 0]);
        assert_eq!(uris(b"no json"), [""; 0]);
        assert_eq!(libraries(b"o x\n mtllib a b.mtl \nusemtl c\n"), ["a b.mtl"]);
        assert_eq!(files_of(Path::new("d/e.stl")), [PathBuf::from("d/e.stl")]);
    }

    #[test]
    fn a_report_over_an_image_is_refused_however_it_is_written() {
        let refused = |report: &str, file: &str| {
            keep_outputs(Some(Path::new(report)), &[Path::new(file)]).is_err()
        };
        assert!(refused("a.png", "./a.png") && refused("./src/../a.png", "a.png"));
        assert!(!refused("a.json", "a.png") && !refused("nowhere/a", "nowhere/b"));
    }
}
