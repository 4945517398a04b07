//! The options of loading a file.

use crate::Limits;

/// The treatment of parts of the shown scene that violate glTF: for example of a node, a primitive,
/// an image, or an animation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BrokenParts {
    /// The part is left out or repaired, a note names it, and the rest is shown. A file that shows
    /// nothing without its broken parts is refused.
    #[default]
    LeaveOut,
    /// The file is refused at its first broken part.
    Refuse,
}

/// The place of a loaded scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScenePlace {
    /// The place in the file.
    #[default]
    AsInFile,
    /// Near the origin, where single precision does not round positions of parts and cameras. The
    /// scene is moved along each axis on which all nodes with meshes of a glTF file are at least 16
    /// m away, and at least twice as far as the extent between them. It moves by whole metres
    /// ([`GltfScene::origin_m`](crate::GltfScene::origin_m)), which needs no rounding. A scene with
    /// animated root nodes is not moved.
    NearOrigin,
}

/// The options of loading a file.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// The limits on the file's demands.
    pub limits: Limits,
    /// The number of triangles above which a rigid mesh with a single object is cut into spatial
    /// pieces. Each piece is an object with between a sixteenth and an eighth of this number of
    /// triangles. `None` cuts no mesh. Default: 65,536.
    pub cut_above_triangles: Option<usize>,
    /// The factor of all light before tone mapping, as
    /// [`Surfaces::exposure`](scene::Surfaces::exposure). With `None`, the default, it is 1, and
    /// lights that would make most of the lit objects white are dimmed, with a note.
    pub exposure: Option<f32>,
    /// The treatment of broken parts. Default: they are left out.
    pub broken_parts: BrokenParts,
    /// The length in metres of the unit of STL and OBJ files, which do not specify it. With `None`,
    /// the default, it is a millimetre for STL and a metre for OBJ. glTF files are in metres.
    pub unit_m: Option<f32>,
    /// The place of the scene. Default: as in the file.
    pub place: ScenePlace,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            cut_above_triangles: Some(1 << 16),
            exposure: None,
            broken_parts: BrokenParts::default(),
            unit_m: None,
            place: ScenePlace::default(),
        }
    }
}
