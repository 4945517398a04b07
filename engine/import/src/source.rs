//! A checked file: the invariants on which later stages rely.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::Path;

use gltf::json::Root;
use scene::Image;

use crate::buffers::{self, Budget};
use crate::elements::{self, Store};
use crate::error::{Fault, Reason};
use crate::images::Images;
use crate::losses::Losses;
use crate::notes::{Note, Notes};
use crate::progress::ReadProgress;
use crate::reach::Reach;
use crate::uri::{self, Wanted};
use crate::verdict::{Verdict, note_broken_animations};
use crate::{
    Cause, ImportError, Instancing, LoadOptions, check, glb, images, json, meshopt, prune, textures,
};

/// A glTF file that was read and checked.
///
/// # Guarantees
/// The shown scene is the scene that the file names, else its first one. A file without scenes gets
/// a scene of all nodes without a parent. Elements that the shown scene does not reach are *empty*.
/// They keep their index, refer to nothing (an empty view refers to the first buffer, if there is
/// one), and are not covered by the list below. Their faults are in the notes. Broken parts of the
/// scene ([`BrokenParts`](crate::BrokenParts)) are in the notes, too: nodes, primitives, textures
/// and animations that are left out are empty, nothing refers to other elements that are left out,
/// and unreadable images are replaced by placeholders. For all other elements:
/// - **Indices.** Every index of core glTF 2.0 and of
///   [`SUPPORTED_EXTENSIONS`](crate::SUPPORTED_EXTENSIONS) is in range: accessors, views, buffers,
///   nodes, meshes, skins, joints, cameras, lights, materials, textures, samplers, images, scenes,
///   targets and samplers of animations. So the methods of `gltf` that look them up do not panic.
///   All enumerated values are known, every camera has the values of its type, and every spot light
///   has its cone. Attributes with names unknown to glTF or of applications (`_NAME`) were removed.
///   So were animation channels without a node or of a node that is not shown, and skins and
///   weights of nodes without a mesh. Joints may be empty nodes.
/// - **Nodes** are a forest: each node is a child of at most one other, and none is its own
///   ancestor. The nodes of the scene's list are roots; the notes say which other nodes the file
///   listed. The forest can be 100,000 levels deep, so do not walk it by recursion. All numbers of
///   nodes, cameras, lights and materials in the JSON are finite. Their meaning is not checked: a
///   matrix may be singular, and a scale, the length of a rotation, or a field of view may be 0.
/// - **Accessors** have at least one element. An accessor lies within its view and the view within
///   its buffer; for sparse accessors, so do both parts. Sparse indices are increasing and below
///   the count. If an accessor has bounds (`min`, `max`), they hold its elements; bounds of
///   normalised elements are integers. An accessor may have no view (zeros), and a sparse one no
///   base. The readers of `gltf` get some of these wrong: use [`Source::floats`] and
///   [`Source::integers`], which support all of them. Compressed views are decompressed.
/// - **Primitives.** All attributes of a primitive and of its morph targets have the same count,
///   and types that the specification or `KHR_mesh_quantization` allows. `POSITION` may be missing:
///   then draw nothing. Indices are unsigned scalars below the count of vertices. The exception is
///   the greatest value of their type: if there is no such vertex, it begins a new strip. The
///   number of indices need not fit the mode: ignore an incomplete last line or triangle. All
///   primitives of a mesh have the same number of morph targets; the weights of a mesh or its node
///   have one number per target. `JOINTS_n` come with `WEIGHTS_n`.
/// - **Skins** have at least one joint. If they have inverse bind matrices (4x4 floats), there is
///   at least one per joint. The values of `JOINTS_n` are below the number of joints of every skin
///   with which the mesh is drawn.
/// - **Animations.** Inputs are float scalars. Outputs have the type of the target's path, and the
///   number of elements that the interpolation and the number of morph targets require.
/// - **Limits.** The parts of the scene are within the limits. The vertices of a primitive are
///   counted as the lesser of its vertices and its indices, so drop vertices to which no index
///   refers. They count once per mesh, but once per *node* if the mesh is posed (by a skin or morph
///   targets). A point and a segment of a line count as a box.
///
/// # Not guaranteed
/// Of the values in buffers, only indices and joints are checked. Positions, normals, weights,
/// matrices and keys may be infinite or NaN, times may decrease, and normals and quaternions may
/// have any length.
pub struct Source {
    /// The file's path, for errors.
    pub file: String,
    /// The checked JSON of the file.
    pub document: gltf::Document,
    /// One entry per image of the document; `None` if no shown material uses it.
    pub images: Vec<Option<Image>>,
    /// The indices of images that could not be read and were replaced by checkers.
    pub placeholders: BTreeSet<usize>,
    /// One entry per texture of the document: the index of its image. `None` for textures that are
    /// not shown, and, with a note, for textures whose images have an unsupported format.
    pub texture_images: Vec<Option<usize>>,
    /// The instancing of each node with an instanced mesh.
    pub instancing: BTreeMap<usize, Instancing>,
    /// The deviations that were tolerated so far.
    pub notes: Vec<Note>,
    pub(crate) store: Store,
    pub(crate) losses: Losses,
}

impl Source {
    /// Returns the bytes of a buffer, with exactly its stated length; empty if it does not exist.
    pub fn buffer(&self, index: usize) -> &[u8] {
        self.store.buffer(index)
    }

    /// Returns all elements of an accessor as floats. Normalised integers are converted by their
    /// meaning, others by their value. `None` if the accessor does not exist or its elements do not
    /// have `N` components. Matrices are in column order, without padding.
    pub fn floats<const N: usize>(&self, accessor: usize) -> Option<Vec<[f32; N]>> {
        self.picked_floats(accessor, None)
    }

    /// Returns all elements of an accessor of unsigned integers. `None` if the accessor does not
    /// exist, its elements do not have `N` components, or they are not unsigned integers.
    pub fn integers<const N: usize>(&self, accessor: usize) -> Option<Vec<[u32; N]>> {
        self.picked_integers(accessor, None)
    }

    /// Returns the elements of [`Source::floats`] whose indices are in an increasing list, or all
    /// without a list. Other elements are not read.
    pub(crate) fn picked_floats<const N: usize>(
        &self,
        accessor: usize,
        picks: Option<&[u32]>,
    ) -> Option<Vec<[f32; N]>> {
        let mut all = Vec::with_capacity(self.count_of(accessor, picks));
        let json = self.document.as_json();
        elements::for_each_floats(json, &self.store, accessor, picks, |each| all.push(each))?;
        Some(all)
    }

    /// Returns the elements of [`Source::integers`] whose indices are in an increasing list, or all
    /// without a list. Other elements are not read.
    pub(crate) fn picked_integers<const N: usize>(
        &self,
        accessor: usize,
        picks: Option<&[u32]>,
    ) -> Option<Vec<[u32; N]>> {
        let mut all = Vec::with_capacity(self.count_of(accessor, picks));
        let json = self.document.as_json();
        elements::for_each_integers(json, &self.store, accessor, picks, |each| all.push(each))?;
        Some(all)
    }

    /// Returns the number of elements of an accessor, or of picked elements.
    pub(crate) fn count_of(&self, accessor: usize, picks: Option<&[u32]>) -> usize {
        let accessor = self.document.as_json().accessors.get(accessor);
        picks.map_or(accessor.map_or(0, |accessor| accessor.count.0 as usize), <[u32]>::len)
    }

    /// Returns an error about an object in this file.
    pub fn error(&self, cause: Cause, object: String, reason: String) -> ImportError {
        ImportError { file: self.file.clone(), object, reason, cause }
    }
}

/// Reads a .gltf or .glb file and all files that it refers to. Only the limits and the treatment of
/// broken parts in the options matter.
///
/// # Errors
/// A file that cannot be read, is not glTF 2.0, requires unsupported features, or exceeds the
/// limits; the first broken part, if broken parts are refused.
pub fn open(path: &Path, options: &LoadOptions) -> Result<Source, ImportError> {
    open_with_progress(path, options, &mut |_| ControlFlow::Continue(()))
}

/// Reads a file like [`open`], with progress reports.
pub(crate) fn open_with_progress(
    path: &Path,
    options: &LoadOptions,
    read_progress: &mut ReadProgress<'_>,
) -> Result<Source, ImportError> {
    let bytes = file_bytes(path, options)?;
    read_file_bytes(path, bytes, options, read_progress)
}

pub(crate) fn file_bytes(path: &Path, options: &LoadOptions) -> Result<Vec<u8>, ImportError> {
    uri::read_file(path, "it", Wanted::All, options.limits.file_bytes)
        .map_err(|reason| reason.of("file").in_file(&path.display().to_string()))
}

/// Reads a file whose bytes are in memory, with the files that it refers to.
pub(crate) fn read_file_bytes(
    path: &Path,
    bytes: Vec<u8>,
    options: &LoadOptions,
    read_progress: &mut ReadProgress<'_>,
) -> Result<Source, ImportError> {
    let file = path.display().to_string();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    read_named(file, bytes, Some(folder.unwrap_or(Path::new("."))), options, read_progress)
}

/// Reads a file from memory. Files that it refers to are read from `folder`; without a folder it
/// must not refer to other files.
///
/// # Errors
/// The errors of [`open`].
pub fn read(
    bytes: Vec<u8>,
    folder: Option<&Path>,
    options: &LoadOptions,
) -> Result<Source, ImportError> {
    read_with_progress(bytes, folder, options, &mut |_| ControlFlow::Continue(()))
}

/// Reads a file like [`read`], with progress reports.
pub(crate) fn read_with_progress(
    bytes: Vec<u8>,
    folder: Option<&Path>,
    options: &LoadOptions,
    read_progress: &mut ReadProgress<'_>,
) -> Result<Source, ImportError> {
    read_named("scene in memory".to_owned(), bytes, folder, options, read_progress)
}

fn read_named(
    file: String,
    bytes: Vec<u8>,
    folder: Option<&Path>,
    options: &LoadOptions,
    read_progress: &mut ReadProgress<'_>,
) -> Result<Source, ImportError> {
    match check_and_decode(bytes, folder, options, read_progress) {
        Ok(parts) => Ok(Source {
            file,
            document: gltf::Document::from_json_without_validation(parts.root),
            placeholders: parts.images.placeholders,
            images: parts.images.list,
            texture_images: parts.texture_images,
            instancing: parts.instancing,
            notes: parts.notes,
            store: parts.store,
            losses: parts.losses,
        }),
        Err(fault) => Err(fault.in_file(&file)),
    }
}

struct Parts {
    root: Root,
    images: Images,
    texture_images: Vec<Option<usize>>,
    instancing: BTreeMap<usize, Instancing>,
    store: Store,
    losses: Losses,
    notes: Vec<Note>,
}

/// Checks by the first bytes that the file may be a scene.
fn check_kind(bytes: &[u8]) -> Result<(), Reason> {
    if bytes.is_empty() {
        return Err(Reason::not_scene("it is empty"));
    }
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    if glb::is_glb(bytes) || text.starts_with(b"{") {
        return Ok(());
    }
    Err(Reason::not_scene("it is neither a GLB nor JSON, which a scene begins as"))
}

fn check_and_decode(
    bytes: Vec<u8>,
    folder: Option<&Path>,
    options: &LoadOptions,
    read_progress: &mut ReadProgress<'_>,
) -> Result<Parts, Fault> {
    let limits = &options.limits;
    let length = bytes.len() as u64;
    if length > limits.file_bytes {
        return Err(Reason::too_large("bytes", length, limits.file_bytes).of("file"));
    }
    check_kind(&bytes).map_err(|reason| reason.of("file"))?;
    let mut notes = Notes::default();
    let (parsed, binary) = if glb::is_glb(&bytes) {
        let parts = glb::split(&bytes)?;
        let json = bytes.get(parts.json).unwrap_or_default();
        (json::parse(json, limits, &mut notes)?, parts.binary)
    } else {
        (json::parse(&bytes, limits, &mut notes)?, None)
    };
    // The text is not needed any more.
    let mut file = if binary.is_some() { bytes } else { Vec::new() };
    let binary = binary.map(|binary| glb::free_text(&mut file, binary));
    let json::Parsed { mut root, faults, extension_names } = parsed;
    // The memory demand of the JSON is bounded at this point, so all of it is checked before any
    // file is opened.
    check::required(&root, &extension_names, &mut notes)?;
    let mut losses = Losses::new(options.broken_parts);
    check::forest(&mut root, &faults, limits, &mut losses, &mut notes)?;
    let mut own_verdict = Verdict::new(Reach::of(&root), losses, notes);
    let verdict = &mut own_verdict;
    for (element, fault) in faults {
        verdict.judge::<()>(element, Err(fault))?;
    }
    check::views_and_accessors(&root, limits, verdict)?;
    let mut instancing = check::structure(&mut root, limits, verdict)?;

    let placeholders = meshopt::placeholders(&root, binary.is_some());
    let compressed = meshopt::compressed(&root, &placeholders, limits, verdict)?;

    let mut budget = Budget::new(limits);
    let given_binary = binary.as_ref();
    let given_placeholders = placeholders.as_slice();
    let buffers =
        buffers::resolve(&root, given_binary, given_placeholders, folder, &mut budget, verdict)?;
    let mut store = Store { file, buffers };
    meshopt::decompress(&root, &compressed, &mut store, verdict)?;
    check::indices_and_joints(&mut root, &store, verdict)?;
    verdict.refuse_empty(&root)?;
    prune::channels(&mut root, verdict);
    note_broken_animations(&root, verdict)?;
    check::bounds(&mut root, &store, verdict);

    let texture_images = textures::images_of(&root, verdict);
    let encoded = images::EncodedImages {
        root: &root,
        store: &store,
        texture_images: &texture_images,
        folder,
        limits,
    };
    let images = images::decode(&encoded, &mut budget, verdict, read_progress)?;
    prune::elements(&mut root, verdict);
    instancing.retain(|node, _| root.nodes.get(*node).is_some_and(|node| node.mesh.is_some()));
    let (losses, notes) = own_verdict.finish();
    Ok(Parts { root, images, texture_images, instancing, store, losses, notes })
}
