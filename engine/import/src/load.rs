//! Loads a scene and its animation from a file, with progress reports.

use std::path::Path;

use crate::load_options::LoadOptions;
use crate::notes::Notes;
use crate::progress::{ProgressFn, ProgressSender, Stage};
use crate::{GltfScene, ImportError, MeshFormat, convert, mesh_files, source};

/// Loads the scene of a .gltf, .glb, .stl or .obj file, with all files that it refers to. The name
/// of the scene is the file name without its extension. A file that begins with the GLB magic is
/// read as glTF whatever its name. A binary STL file is recognised by its length if its extension
/// is unknown.
///
/// Whatever the file contains, this does not panic and does not read outside of the file's folder.
/// Reading takes no more memory than the [`Limits`](crate::Limits) allow; bones
/// ([`Limits::bones`](crate::Limits::bones), some 40 bytes each) are in addition. Clips that could
/// move something farther than a renderer can draw are left out. Everything else that can be shown
/// is shown, and [`GltfScene::notes`] lists the deviations from the file. The scene passes
/// [`Scene::validate`](scene::Scene::validate), every object has a usable box, and all numbers are
/// finite.
///
/// # Errors
/// A file that is unreadable, is not valid glTF 2.0 as a whole, requires unsupported extensions, or
/// exceeds the limits; a file that shows nothing without its broken parts; a file with broken parts
/// if these are refused ([`BrokenParts`](crate::BrokenParts));
/// [`Cause::GivenUp`](crate::Cause::GivenUp) if `progress_fn` stops loading. Each error names the
/// file, the object in it, and the reason.
pub fn load(
    path: &Path,
    options: &LoadOptions,
    progress_fn: &mut ProgressFn<'_>,
) -> Result<GltfScene, ImportError> {
    let mut progress_sender = ProgressSender { file: path.display().to_string(), progress_fn };
    progress_sender.report(Stage::Reading, 0.0)?;
    let bytes = source::file_bytes(path, options)?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = name.unwrap_or_default();
    if let Some(format) = MeshFormat::of(path, &bytes) {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = Some(folder.unwrap_or(Path::new(".")));
        return load_triangles(&bytes, format, folder, name, options, &mut progress_sender);
    }
    let mut read_progress = |fraction| progress_sender.go_on(Stage::Reading, fraction);
    let source = source::read_file_bytes(path, bytes, options, &mut read_progress)?;
    convert::convert(source, name, options, &mut progress_sender)
}

/// Loads the scene of an STL or OBJ file from memory. The materials of an OBJ file are read from
/// `folder`; without a folder everything is grey.
///
/// # Errors
/// The errors of [`load`].
pub fn load_mesh_bytes(
    bytes: &[u8],
    format: MeshFormat,
    folder: Option<&Path>,
    options: &LoadOptions,
    progress_fn: &mut ProgressFn<'_>,
) -> Result<GltfScene, ImportError> {
    let mut progress_sender = ProgressSender { file: "memory".to_owned(), progress_fn };
    progress_sender.report(Stage::Reading, 0.0)?;
    load_triangles(bytes, format, folder, "memory".to_owned(), options, &mut progress_sender)
}

fn load_triangles(
    bytes: &[u8],
    format: MeshFormat,
    folder: Option<&Path>,
    name: String,
    options: &LoadOptions,
    progress_sender: &mut ProgressSender<'_>,
) -> Result<GltfScene, ImportError> {
    let file = progress_sender.file.clone();
    let mut notes = Notes::default();
    let mut read_progress = |fraction| progress_sender.go_on(Stage::Reading, fraction);
    let read = mesh_files::read(bytes, format, folder, options, &mut notes, &mut read_progress);
    let read = read.map_err(|fault| fault.in_file(&file))?;
    convert::convert_mesh_file(read, format, name, options, notes, progress_sender)
}

/// Loads the scene of a .gltf or .glb file from memory. Files that it refers to are read from
/// `folder`; without a folder it must not refer to other files.
///
/// # Errors
/// The errors of [`load`].
pub fn load_bytes(
    bytes: Vec<u8>,
    folder: Option<&Path>,
    options: &LoadOptions,
    progress_fn: &mut ProgressFn<'_>,
) -> Result<GltfScene, ImportError> {
    let mut progress_sender = ProgressSender { file: "memory".to_owned(), progress_fn };
    progress_sender.report(Stage::Reading, 0.0)?;
    let mut read_progress = |fraction| progress_sender.go_on(Stage::Reading, fraction);
    let source = source::read_with_progress(bytes, folder, options, &mut read_progress)?;
    convert::convert(source, "memory".to_owned(), options, &mut progress_sender)
}
