//! Files that only contain triangles: STL and OBJ. Both formats are read to the same parts, which
//! the module `convert` turns into a scene.

mod materials;
mod obj;
mod stl;

use std::ops::ControlFlow;
use std::path::Path;

use glam::Vec3;

use crate::error::{Fault, Reason};
use crate::load_options::{BrokenParts, LoadOptions};
use crate::notes::Notes;
use crate::progress::ReadProgress;

pub(crate) use self::materials::{GREY, PartMaterial};

/// The file formats that only contain triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MeshFormat {
    /// STL, binary or text. It has no unit: millimetres are assumed.
    Stl,
    /// Wavefront OBJ, with its MTL files. It has no unit: metres are assumed.
    Obj,
}

impl MeshFormat {
    /// Returns the format of a file; `None` for glTF. The GLB magic decides first, then a known
    /// extension, then whether the length is that of a binary STL.
    pub(crate) fn of(path: &Path, bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(b"glTF") {
            return None;
        }
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("stl") => Some(Self::Stl),
            Some("obj") => Some(Self::Obj),
            Some("glb" | "gltf") => None,
            _ => stl::is_binary(bytes).then_some(Self::Stl),
        }
    }

    /// Returns the assumed unit of the format, in metres.
    pub(crate) fn unit_m(self) -> f32 {
        match self {
            Self::Stl => 0.001,
            Self::Obj => 1.0,
        }
    }
}

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Corner {
    /// The index of the position in the file.
    pub(crate) position: u32,
    /// The index of the normal in the file, if it has one.
    pub(crate) normal: Option<u32>,
}

/// The triangles of one object with one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MeshPart {
    /// The name; empty if the file has none.
    pub(crate) name: String,
    /// The index of its material; `None` if it has none.
    pub(crate) material: Option<usize>,
    /// The triangles; their corners index the lists of the file.
    pub(crate) triangles: Vec<[Corner; 3]>,
}

/// The contents of a file of triangles. All indices are valid, and all numbers are finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MeshFile {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) parts: Vec<MeshPart>,
    pub(crate) materials: Vec<PartMaterial>,
}

/// The state of reading a file: limits, notes, and the progress function.
struct Reading<'a, 'b> {
    options: &'a LoadOptions,
    notes: &'a mut Notes,
    progress: &'a mut ReadProgress<'b>,
    triangles: u64,
}

impl Reading<'_, '_> {
    /// Notes a broken part that is left out, or refuses the file because of it.
    fn leave_out(
        &mut self,
        what: &'static str,
        object: impl FnOnce() -> String,
    ) -> Result<(), Fault> {
        match self.options.broken_parts {
            BrokenParts::Refuse => Err(Reason::malformed(what).of(object())),
            BrokenParts::LeaveOut => {
                self.notes.count(what, 1, object);
                Ok(())
            }
        }
    }

    fn count_triangle(&mut self, fraction: f32) -> Result<(), Fault> {
        const PER_REPORT: u64 = 1 << 16;
        self.triangles += 1;
        let corners = 3 * self.triangles;
        let limit = self.options.limits.corners.min(1 << 30);
        if corners > limit {
            return Err(Reason::too_large("corners of triangles", corners, limit).of("the mesh"));
        }
        if self.triangles.is_multiple_of(PER_REPORT) {
            return self.go_on(fraction);
        }
        Ok(())
    }

    fn check_positions(&self, count: usize) -> Result<(), Fault> {
        let limit = self.options.limits.vertices;
        if count as u64 > limit {
            return Err(Reason::too_large("vertices", count as u64, limit).of("the mesh"));
        }
        Ok(())
    }

    fn go_on(&mut self, fraction: f32) -> Result<(), Fault> {
        match (self.progress)(fraction) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Reason::given_up().of("loading")),
        }
    }
}

/// Reads a file of triangles. Materials that it names are read from `folder`; without a folder
/// there are no materials.
pub(crate) fn read(
    bytes: &[u8],
    format: MeshFormat,
    folder: Option<&Path>,
    options: &LoadOptions,
    notes: &mut Notes,
    progress: &mut ReadProgress<'_>,
) -> Result<MeshFile, Fault> {
    let mut reading = Reading { options, notes, progress, triangles: 0 };
    let file = match format {
        MeshFormat::Stl => stl::read(bytes, &mut reading)?,
        MeshFormat::Obj => obj::read(bytes, folder, &mut reading)?,
    };
    if file.parts.iter().all(|part| part.triangles.is_empty()) {
        return Err(Reason::not_scene("it has no triangles").of("the mesh"));
    }
    Ok(file)
}
