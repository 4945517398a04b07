//! Files of scenes as a host names them, and what is in them.

use std::ffi::c_char;

use crate::decisions::hierarchy::AntumbraAabb;
use crate::layout::{layout, versioned};
use crate::table::handle;

/// A file of a scene, in memory: meshes, materials, textures, lights, cameras and clips.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraSceneFile {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraSceneFile = "scene file");

/// A part that violates glTF is left out or repaired, a note names it, and the rest is shown.
pub const ANTUMBRA_BROKEN_PARTS_LEFT_OUT: u32 = 0;
/// The file is refused at its first part that violates glTF.
pub const ANTUMBRA_BROKEN_PARTS_REFUSED: u32 = 1;

/// The scene is where the file says.
pub const ANTUMBRA_SCENE_PLACE_AS_IN_FILE: u32 = 0;
/// A scene far from the origin is moved there by whole metres, so that positions of parts and
/// cameras are not rounded. `AntumbraSceneFileInfo::origin` says by how many.
pub const ANTUMBRA_SCENE_PLACE_NEAR_ORIGIN: u32 = 1;

/// A number of clips: all clips of a file that can play together. `cbindgen.toml` declares it,
/// since cbindgen leaves out constants of this type.
pub const ANTUMBRA_ALL_CLIPS: usize = usize::MAX;

/// The camera that shows everything at rest, diagonally from the front and above.
pub const ANTUMBRA_CAMERA_OVERVIEW: u32 = u32::MAX;

/// A file and the way to read it: `path`, or `bytes`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraSceneFileDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// An `ANTUMBRA_BROKEN_PARTS_..`. Default: `ANTUMBRA_BROKEN_PARTS_LEFT_OUT`.
    pub broken_parts: u32,
    /// The path of a .gltf, .glb, .stl or .obj file, in UTF-8 with a 0 at the end. Files that it
    /// refers to are read from its folder. Default: null, for a file in memory.
    pub path: *const c_char,
    /// The bytes of a .gltf or .glb file. Default: null, with a `byte_count` of 0.
    pub bytes: *const u8,
    /// The number of bytes. Default: 0.
    pub byte_count: usize,
    /// The folder of the files that `bytes` refer to, as `path`. Default: null, and then they must
    /// not refer to files.
    pub folder: *const c_char,
    /// An `ANTUMBRA_SCENE_PLACE_..`. Default: `ANTUMBRA_SCENE_PLACE_AS_IN_FILE`.
    pub place: u32,
    /// The factor of all light. Default: 0, for a factor of 1, with lights that are dimmed if they
    /// would make most objects white.
    pub exposure: f32,
    /// The length of the unit of .stl and .obj files (metres). Default: 0, for a millimetre in .stl
    /// and a metre in .obj files.
    pub unit: f32,
    /// Must be 0.
    pub reserved: u32,
}
layout!(AntumbraSceneFileDesc: struct_size, broken_parts, path, bytes, byte_count, folder, place,
    exposure, unit, reserved);

versioned!(AntumbraSceneFileDesc: 10, required: [], defaults: {});

/// The contents of a file.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraSceneFileInfo {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The cameras.
    pub cameras: u32,
    /// The clips.
    pub clips: u32,
    /// The lights, with the numbers that `antumbra_renderer_set_light_shadow` takes. A file without
    /// lights is lit by one.
    pub lights: u32,
    /// The notes: deviations from the file, and what is not shown.
    pub notes: u32,
    /// Is 0.
    pub reserved: u32,
    /// The objects, without transparent ones. Their ids in a renderer are their indices.
    pub objects: u64,
    /// The triangles of these objects.
    pub triangles: u64,
    /// The box around everything visible at rest (metres).
    pub bounds: AntumbraAabb,
    /// The point of the file that is the origin of the scene (metres): 0 unless the scene was moved
    /// by `ANTUMBRA_SCENE_PLACE_NEAR_ORIGIN`.
    pub origin: [f64; 3],
}
layout!(AntumbraSceneFileInfo: struct_size, cameras, clips, lights, notes, reserved, objects,
    triangles, bounds, origin);

versioned!(AntumbraSceneFileInfo: 10, required: [], defaults: {});

/// A camera of a file.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraSceneFileCamera {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The width of its image divided by the height; 0 if the file does not say.
    pub aspect_ratio: f32,
    /// The name, in UTF-8 with a 0 at the end, valid until the file is destroyed.
    pub name: *const c_char,
}
layout!(AntumbraSceneFileCamera: struct_size, aspect_ratio, name);

versioned!(AntumbraSceneFileCamera: 3, required: [], defaults: {});

/// A clip of a file: an animation of its nodes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraSceneFileClip {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The duration, after which it repeats (seconds).
    pub duration: f32,
    /// The name, in UTF-8 with a 0 at the end, valid until the file is destroyed.
    pub name: *const c_char,
}
layout!(AntumbraSceneFileClip: struct_size, duration, name);

versioned!(AntumbraSceneFileClip: 3, required: [], defaults: {});

/// A note about a file.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraSceneFileNote {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Is 0.
    pub reserved: u32,
    /// The object in the file and the reason, in UTF-8 with a 0 at the end, valid until the file is
    /// destroyed.
    pub text: *const c_char,
}
layout!(AntumbraSceneFileNote: struct_size, reserved, text);

versioned!(AntumbraSceneFileNote: 3, required: [], defaults: {});
