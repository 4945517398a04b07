//! A file that was read and checked: what may be relied on without looking again.

use std::ops::Range;
use std::path::Path;

use render::scene::Image;

use crate::{ImportError, Limits};

/// The extensions that a file may require. Others that it requires are refused by name, others that it
/// merely uses are noted.
pub const SUPPORTED_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Where a node's instances are: `EXT_mesh_gpu_instancing`.
///
/// All accessors that are there have `count` elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instancing {
    /// How many instances there are, at least 1.
    pub count: usize,
    /// The accessor of translations: three floats.
    pub translation: Option<usize>,
    /// The accessor of rotations: four floats or signed normalised integers, a quaternion x, y, z, w.
    pub rotation: Option<usize>,
    /// The accessor of scales: three floats.
    pub scale: Option<usize>,
}

/// A glTF file that was read and checked.
///
/// # What holds
/// For the whole of `document`, whether it is used by a scene or not:
/// - **Indices.** Every index of core glTF 2.0 and of [`SUPPORTED_EXTENSIONS`] is in range: accessors,
///   views, buffers, nodes, meshes, skins, joints, cameras, lights, materials, textures, samplers, images,
///   scenes, targets and samplers of animations. So the methods of `gltf` that look them up do not panic.
///   No enumerated value is unknown, every camera has the values of its type, every spot light its cone.
///   Attributes whose names glTF does not know (and that do not begin with `_`) were removed, and so were
///   animation channels without a node.
/// - **Nodes** are a forest: each is a child of at most one other, none its own ancestor; nodes of scenes are
///   roots. It can be 100,000 deep: do not walk it by recursion. All numbers of nodes, cameras, lights and
///   materials in the JSON are finite; what they mean is not checked (a matrix may be singular, a scale 0, a
///   rotation of length 0, a field of view 0).
/// - **Accessors** have at least one element and, where they have a view, lie within it and the view within
///   its buffer, sparse ones with both their parts; sparse indices are increasing and below the count.
///   An accessor may have no view (zeros), a sparse one no base. The readers of `gltf` get some of these
///   wrong: read them by [`Source::floats`] and [`Source::integers`], which read all.
/// - **Primitives.** All attributes of a primitive and of its morph targets have the same count, and their
///   types are what the specification and `KHR_mesh_quantization` allow. `POSITION` may be missing (draw
///   nothing then). Indices are unsigned scalars, and every one of them is below the count, and none is the
///   highest value of its type. How many there are fits the mode no better than the file says: ignore the
///   incomplete last line or triangle. All primitives of a mesh have the same number of morph targets;
///   weights of a mesh or of a node with it are as many as there are targets. `JOINTS_n` come with
///   `WEIGHTS_n`.
/// - **Skins** have at least one joint, and at least as many inverse bind matrices (4x4 floats) as joints,
///   if they have any. The values of `JOINTS_n` are below the number of joints of every skin that the mesh
///   is drawn with.
/// - **Animations.** Inputs are float scalars; outputs have the type of the target's path, and as many
///   elements as the interpolation and the number of morph targets demand.
/// - **Limits.** What the scene would be made of is within the limits. Vertices are counted as the
///   lesser of a primitive's vertices and its indices, so drop those that no index refers to; once for each
///   mesh that a node has, but once for each *node* where it is deformed (by a skin or morph targets).
///
/// # What does not
/// Values in buffers are not looked at, save indices and joints: positions, normals, weights, matrices and
/// keys can be infinite or not numbers, times can run backwards, normals and quaternions have any length.
pub struct Source {
    /// The file's path, for errors.
    pub file: String,
    /// Its JSON.
    pub document: gltf::Document,
    /// As many as the document has images; `None` where no texture uses it.
    pub images: Vec<Option<Image>>,
    /// As many as the document has textures: the index of its image, which is there; `None` for those whose
    /// image is in a format that is not supported, which are noted.
    pub texture_images: Vec<Option<usize>>,
    /// As many as the document has nodes: where its mesh is instanced.
    pub instancing: Vec<Option<Instancing>>,
    /// What was in the file that is not understood, for people.
    pub notes: Vec<String>,
    pub(crate) bytes: Vec<u8>,
    pub(crate) buffers: Vec<BufferBytes>,
}

/// Where the bytes of a buffer are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum BufferBytes {
    /// Within the file: the binary chunk of a GLB is not held twice.
    InFile(Range<usize>),
    /// By themselves.
    Apart(Vec<u8>),
}

impl Source {
    /// The bytes of a buffer, exactly as many as it says; empty if there is no such buffer.
    pub fn buffer(&self, index: usize) -> &[u8] {
        match self.buffers.get(index) {
            Some(BufferBytes::InFile(range)) => self.bytes.get(range.clone()).unwrap_or_default(),
            Some(BufferBytes::Apart(bytes)) => bytes,
            None => &[],
        }
    }

    /// All elements of an accessor as floats, normalised integers turned into what they mean, others into
    /// themselves. `None` if there is no such accessor or its elements have not `N` components. Matrices
    /// are in column order, without padding.
    pub fn floats<const N: usize>(&self, accessor: usize) -> Option<Vec<[f32; N]>> {
        let _ = accessor;
        None
    }

    /// All elements of an accessor of unsigned integers. `None` if there is no such accessor, its elements
    /// have not `N` components, or they are not unsigned integers.
    pub fn integers<const N: usize>(&self, accessor: usize) -> Option<Vec<[u32; N]>> {
        let _ = accessor;
        None
    }

    /// An error about something in this file.
    pub fn error(&self, cause: crate::Cause, object: String, reason: String) -> ImportError {
        ImportError { file: self.file.clone(), object, reason, cause }
    }
}

/// Reads a .gltf or .glb file and everything it refers to.
///
/// # Errors
/// If anything of it cannot be read, is not what glTF 2.0 says, or is beyond the limits.
pub fn open(path: &Path, limits: &Limits) -> Result<Source, ImportError> {
    let _ = (path, limits);
    Err(ImportError {
        file: path.display().to_string(),
        object: "file".to_owned(),
        reason: "reading is not there yet".to_owned(),
        cause: crate::Cause::Unsupported,
    })
}

/// Reads a file whose bytes are here. What it refers to is looked for in `folder`; without one it must not
/// refer to anything outside of itself.
///
/// # Errors
/// As [`open`].
pub fn read(bytes: Vec<u8>, folder: Option<&Path>, limits: &Limits) -> Result<Source, ImportError> {
    let _ = bytes;
    open(folder.unwrap_or(Path::new("memory")), limits)
}
