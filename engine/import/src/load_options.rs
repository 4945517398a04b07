//! The options of loading a file.

use crate::Limits;

/// The treatment of a part of the shown scene that breaks a rule of glTF: of a node, a primitive,
/// an image, or an animation, for example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BrokenParts {
    /// The part is left out or repaired, a note names it, and all else is shown. A file of which
    /// nothing is left to see is refused.
    #[default]
    LeaveOut,
    /// The file is refused for its first broken part.
    Refuse,
}

/// The place of a loaded scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScenePlace {
    /// The place that the file gives it.
    #[default]
    AsInFile,
    /// Near the origin, along each axis in which a glTF file has its nodes with meshes at least 16
    /// m away, and twice as far as they are apart: single precision would round places of parts and
    /// cameras there. The scene is moved by whole metres
    /// ([`GltfScene::origin_m`](crate::GltfScene::origin_m)), which rounds nothing. A scene whose
    /// root nodes are animated stays where the file has it.
    NearOrigin,
}

/// The options of loading a file.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// The limits on the file's demands.
    pub limits: Limits,
    /// The number of triangles above which a rigid mesh with a single object is cut into spatial
    /// pieces, each an object of at most an eighth and at least a sixteenth as many triangles.
    /// `None` leaves all meshes whole. Default: 65,536.
    pub cut_above_triangles: Option<usize>,
    /// The factor of all light before tone mapping, as
    /// [`Surfaces::exposure`](scene::Surfaces::exposure). `None`, the default, is 1; lights that
    /// would turn most of the lit objects white are dimmed then, with a note.
    pub exposure: Option<f32>,
    /// The treatment of broken parts. Default: they are left out.
    pub broken_parts: BrokenParts,
    /// The length in metres of the unit of STL and OBJ files, which do not say it. `None`, the
    /// default, takes millimetres for STL and metres for OBJ. glTF files are in metres.
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
