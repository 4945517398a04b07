//! Loading: from a file to a scene and its life, telling how far it is.

use std::path::Path;

use crate::load_options::LoadOptions;
use crate::progress::{ProgressFn, ProgressSender, Stage};
use crate::{GltfScene, ImportError, convert, source};

/// Loads the scene of a .gltf or .glb file, with everything it refers to. The scene's name is the
/// file's, without its ending.
///
/// Whatever is in the file, this does not panic and does not read outside of its folder. Reading
/// takes no more memory than [`Limits`](crate::Limits) say; bones
/// ([`Limits::bones`](crate::Limits::bones), some 40 bytes each) come on top of that. Clips that
/// could take something farther than a renderer can draw are left out. What can be shown is shown,
/// and what is shown otherwise than the file says is in [`GltfScene::notes`]. The scene passes
/// [`Scene::validate`](scene::Scene::validate), every object has a usable box, and all numbers are
/// finite.
///
/// # Errors
/// Files that cannot be read, that are not what glTF 2.0 says, that need an extension which is not
/// there, or that are beyond the limits; positions, morph targets and animations with numbers that
/// are not finite; [`Cause::GivenUp`](crate::Cause::GivenUp) if `listener` breaks off. Each names
/// the file, the object in it, and the reason.
pub fn load(
    path: &Path,
    options: &LoadOptions,
    listener: &mut ProgressFn<'_>,
) -> Result<GltfScene, ImportError> {
    let mut teller = ProgressSender { file: path.display().to_string(), listener };
    teller.tell(Stage::Reading, 0.0)?;
    let mut tell = |fraction| teller.go_on(Stage::Reading, fraction);
    let source = source::open_and_tell(path, &options.limits, &mut tell)?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    convert::convert(source, name.unwrap_or_default(), options, &mut teller)
}

/// Loads the scene of a .gltf or .glb file whose bytes are here. What it refers to is looked for in
/// `folder`; without one it must not refer to anything outside of itself.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(
    bytes: Vec<u8>,
    folder: Option<&Path>,
    options: &LoadOptions,
    listener: &mut ProgressFn<'_>,
) -> Result<GltfScene, ImportError> {
    let mut teller = ProgressSender { file: "memory".to_owned(), listener };
    teller.tell(Stage::Reading, 0.0)?;
    let mut tell = |fraction| teller.go_on(Stage::Reading, fraction);
    let source = source::read_and_tell(bytes, folder, &options.limits, &mut tell)?;
    convert::convert(source, "memory".to_owned(), options, &mut teller)
}
