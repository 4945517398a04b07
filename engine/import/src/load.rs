//! Loading: from a file to a scene and its life, telling how far it is.

use std::ops::ControlFlow;
use std::path::Path;

use crate::{Cause, GltfScene, ImportError, Limits, convert, source};

/// How a file is loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// What it may at most ask for.
    pub limits: Limits,
    /// Meshes of more triangles than this that are seen once and keep their form are cut into pieces that
    /// lie side by side, of at most a quarter as many triangles, each an object. `None` leaves all whole.
    /// Default: 65,536.
    pub cut_above_triangles: Option<usize>,
    /// Factor of all light before tone mapping, as
    /// [`Surfaces::exposure`](scene::Surfaces::exposure). `None`, the default, is 1; lights that would
    /// leave most of what they shine on white are dimmed then, which is noted.
    pub exposure: Option<f32>,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { limits: Limits::default(), cut_above_triangles: Some(1 << 16), exposure: None }
    }
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// The file and all that it refers to are read and checked, images are decoded.
    Reading,
    /// Meshes and objects are made.
    Meshes,
}

/// How far loading has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub stage: Stage,
    /// How much of that is done, 0 to 1.
    pub fraction: f32,
}

/// Who is told how far loading has come, and says whether it shall go on.
pub type Listener<'a> = dyn FnMut(Progress) -> ControlFlow<()> + 'a;

/// Tells, and stops when nobody wants it any more.
pub(crate) struct Teller<'a> {
    pub(crate) file: String,
    pub(crate) listener: &'a mut Listener<'a>,
}

impl Teller<'_> {
    fn go_on(&mut self, stage: Stage, fraction: f32) -> ControlFlow<()> {
        (self.listener)(Progress { stage, fraction })
    }

    pub(crate) fn tell(&mut self, stage: Stage, fraction: f32) -> Result<(), ImportError> {
        match self.go_on(stage, fraction) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(ImportError {
                file: self.file.clone(),
                object: "loading".to_owned(),
                reason: "it was given up".to_owned(),
                cause: Cause::GivenUp,
            }),
        }
    }
}

/// Loads the scene of a .gltf or .glb file, with everything it refers to. The scene's name is the file's,
/// without its ending.
///
/// Whatever is in the file, this does not panic and does not read outside of its folder. Reading takes no more
/// memory than [`Limits`] say; boxes of what changes its form (at most 40 MB) and bones ([`Limits::bones`], some
/// 40 bytes each) come on top of that. Clips that could take something farther than a renderer can draw are left
/// out. What can be shown is shown, and what is shown otherwise than the file says is
/// in [`GltfScene::notes`]. The scene passes [`Scene::validate`](scene::Scene::validate), every
/// object has a usable box, and all numbers are finite.
///
/// # Errors
/// Files that cannot be read, that are not what glTF 2.0 says, that need an extension which is not there, or
/// that are beyond the limits; positions, morph targets and animations with numbers that are not finite;
/// [`Cause::GivenUp`] if `listener` breaks off. Each names the file, the object in it, and the reason.
pub fn load(
    path: &Path,
    options: &LoadOptions,
    listener: &mut Listener<'_>,
) -> Result<GltfScene, ImportError> {
    let mut teller = Teller { file: path.display().to_string(), listener };
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
    listener: &mut Listener<'_>,
) -> Result<GltfScene, ImportError> {
    let mut teller = Teller { file: "memory".to_owned(), listener };
    teller.tell(Stage::Reading, 0.0)?;
    let mut tell = |fraction| teller.go_on(Stage::Reading, fraction);
    let source = source::read_and_tell(bytes, folder, &options.limits, &mut tell)?;
    convert::convert(source, "memory".to_owned(), options, &mut teller)
}
