//! Converts primitives from a file's attributes to geometry that can be packed.

use glam::Affine3A;
use gltf::json;
use gltf::json::validation::Checked;
use gltf::mesh::{Mode, Semantic};

use super::budget::Budget;
use super::geometry::Geometry;
use super::initial_view::InitialView;
use super::materials::MaterialUse;
use super::numbers::mirrors;
use super::sidedness::{Backs, mirror, with_backs};
use super::topology::Elements;
use super::vertices::Vertices;
use super::{normals, solids, tangents, weld};
use crate::elements::restart_index;
use crate::error::quoted;
use crate::memory;
use crate::notes::Notes;
use crate::{Cause, ImportError, Source};

/// The most memory per vertex and per corner of a triangle during conversion, in bytes: attributes
/// as read, welded, split at edges, and packed.
const VERTEX_BYTES: u64 = 320;
const CORNER_BYTES: u64 = 32;

/// The variant of a primitive to create.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Variant {
    /// The facing that its places require.
    pub(super) facing: Facing,
    /// The number of joints of its skin, if it has one.
    pub(super) joints: Option<u32>,
    /// True if its morph targets matter.
    pub(super) is_morphed: bool,
}

/// The side from which the triangles of a primitive are visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Facing {
    /// The side of the file.
    Plain,
    /// The other side, since its places mirror.
    Mirrored,
    /// Both sides, since its places mirror at some times and not at others.
    Both,
}

impl Facing {
    pub(super) fn of(transform: &Affine3A, may_turn: bool) -> Self {
        match (may_turn, mirrors(transform)) {
            (true, _) => Self::Both,
            (false, true) => Self::Mirrored,
            (false, false) => Self::Plain,
        }
    }
}

impl Variant {
    /// Returns the variant without a skin.
    pub(super) fn rigid(facing: Facing) -> Self {
        Self { facing, joints: None, is_morphed: false }
    }
}

/// A primitive of a file.
pub(super) struct Primitive<'a> {
    pub(super) source: &'a Source,
    pub(super) json: &'a json::mesh::Primitive,
    /// The index of its mesh.
    pub(super) mesh: usize,
    /// The index of the primitive in the mesh.
    pub(super) number: usize,
}

impl Primitive<'_> {
    /// Returns the names of its mesh and of the primitive, for errors.
    pub(super) fn place(&self) -> String {
        let mesh = self.source.document.as_json().meshes.get(self.mesh);
        let name = mesh.and_then(|mesh| mesh.name.as_deref()).filter(|name| !name.is_empty());
        let name = name.map(|name| format!(" ({})", quoted(name))).unwrap_or_default();
        format!("mesh {}{name}, primitive {}", self.mesh, self.number)
    }

    /// Returns the accessor of an attribute.
    pub(super) fn attribute(&self, semantic: Semantic) -> Option<usize> {
        self.json.attributes.get(&Checked::Valid(semantic)).map(json::Index::value)
    }

    pub(super) fn mode(&self) -> Mode {
        match self.json.mode {
            Checked::Valid(mode) => mode,
            Checked::Invalid => Mode::Triangles,
        }
    }

    /// Returns true if it consists of lines or points without normals, which are unlit (3.9.1, as
    /// with `KHR_materials_unlit`).
    pub(super) fn is_unlit(&self) -> bool {
        self.is_thin() && self.attribute(Semantic::Normals).is_none()
    }

    /// Returns true if it consists of points or lines.
    pub(super) fn is_thin(&self) -> bool {
        matches!(self.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip)
    }

    pub(super) fn is_skinned(&self) -> bool {
        self.attribute(Semantic::Joints(0)).is_some()
            && self.attribute(Semantic::Weights(0)).is_some()
    }

    pub(super) fn targets(&self) -> &[json::mesh::MorphTarget] {
        self.json.targets.as_deref().unwrap_or_default()
    }

    pub(super) fn error(&self, cause: Cause, reason: String) -> ImportError {
        self.source.error(cause, self.place(), reason)
    }

    /// Returns the complete triangles of the primitive, with normals, tangents and backs. `None` if
    /// there is nothing to draw. Points and lines are sized for `sight`.
    pub(super) fn build(
        &self,
        variant: Variant,
        material: &MaterialUse,
        sight: &InitialView<'_>,
        to_world: &Affine3A,
        budget: &mut Budget,
        notes: &mut Notes,
    ) -> Result<Option<Geometry>, ImportError> {
        let Some((geometry, elements)) = self.read(variant, material, notes)? else {
            return Ok(None);
        };
        let own_backs = match (material.backs, variant.facing, material.is_transparent) {
            (Backs::None, Facing::Both, false) => Backs::Last,
            (Backs::None, Facing::Both, true) => Backs::First,
            (backs, ..) => backs,
        };
        let solid_backs = if variant.facing == Facing::Both { own_backs } else { Backs::None };
        let (vertices, triangles, backs) = match &elements {
            Elements::Triangles(list) => {
                let triangles = list.len() as u64;
                let is_flat = geometry.normals.is_empty();
                let shared = geometry.positions.len() as u64;
                (if is_flat { triangles * 3 } else { shared }, triangles, own_backs)
            }
            Elements::Lines(lines) => {
                let lines = lines.len() as u64;
                (lines * solids::LINE_VERTICES, lines * solids::LINE_TRIANGLES, solid_backs)
            }
            Elements::Points(points) => {
                let points = points.len() as u64;
                (points * solids::POINT_VERTICES, points * solids::POINT_TRIANGLES, solid_backs)
            }
        };
        let sides = if backs == Backs::None { 1 } else { 2 };
        // Flat normals may share more vertices than estimated; the exact numbers are counted below.
        let is_exact = !geometry.normals.is_empty() || !matches!(elements, Elements::Triangles(_));
        let least = if is_exact { vertices } else { geometry.positions.len() as u64 };
        let least = least * sides;
        let corners = triangles * 3 * sides;
        budget.check(least, corners).map_err(|over| self.over(&over))?;
        memory::ask(least * VERTEX_BYTES + corners * CORNER_BYTES)
            .map_err(|reason| reason.of(self.place()).in_file(&self.source.file))?;
        let mut geometry = solid(geometry, elements, sight, to_world);
        if geometry.skin.is_none() && geometry.targets.is_empty() {
            weld::weld(&mut geometry.positions);
        }
        let broken = normals::repair(&mut geometry);
        notes.count("a normal has no direction, and is taken from its triangles", broken, || {
            self.place()
        });
        let (mut geometry, broken) = tangents::complete(geometry, material.normal);
        notes.count("a tangent has no direction, and is replaced by any", broken, || self.place());
        budget
            .take(geometry.positions.len() as u64 * sides, triangles * 3 * sides)
            .map_err(|over| self.over(&over))?;
        with_backs(&mut geometry, backs);
        geometry.has_both_sides = variant.facing == Facing::Both;
        if variant.facing == Facing::Mirrored {
            mirror(&mut geometry);
        }
        Ok((!geometry.triangles.is_empty()).then_some(geometry))
    }

    /// Returns the index that begins a new strip with `count` vertices: the greatest of its type,
    /// unless there is such a vertex.
    fn restart(&self, count: usize) -> Option<u32> {
        let indices = self.json.indices.map(|indices| indices.value());
        let indices = indices.and_then(|at| self.source.document.as_json().accessors.get(at));
        indices.and_then(restart_index).filter(|index| *index as usize >= count)
    }

    pub(super) fn over(&self, over: &super::budget::Over) -> ImportError {
        self.error(Cause::TooLarge, over.to_string())
    }

    /// Returns all required attributes of the used vertices.
    pub(super) fn read(
        &self,
        variant: Variant,
        material: &MaterialUse,
        notes: &mut Notes,
    ) -> Result<Option<(Geometry, Elements)>, ImportError> {
        // Primitives without positions were noted before.
        let Some(positions) = self.attribute(Semantic::Positions) else { return Ok(None) };
        let count = self.source.count_of(positions, None);
        let list = match &self.json.indices {
            Some(indices) => {
                self.source.integers::<1>(indices.value()).unwrap_or_default().into_flattened()
            }
            None => (0..count as u32).collect(),
        };
        let mode = self.mode();
        let restart = self.restart(count);
        if Elements::leave_rest(mode, &list, restart) {
            let what = "its last vertices make no whole line or triangle, and are left out";
            notes.count(what, 1, || self.place());
        }
        let mut elements = Elements::of(mode, &list, restart);
        drop(list);
        let picks = elements.compact(count).map_err(|vertex| {
            self.error(Cause::Malformed, format!("an index names vertex {vertex} of {count}"))
        })?;
        let vertices = Vertices::new(self, picks.as_deref());
        Ok(Some((vertices.read(positions, variant, material, notes)?, elements)))
    }
}

/// Returns triangles with normals: the triangles of the primitive, or the solids of its lines and
/// points.
fn solid(
    geometry: Geometry,
    elements: Elements,
    sight: &InitialView<'_>,
    to_world: &Affine3A,
) -> Geometry {
    let height = |geometry: &Geometry| sight.height_at(&geometry.bounds(), to_world);
    match elements {
        Elements::Triangles(triangles) => {
            let geometry = Geometry { triangles, ..geometry };
            if geometry.normals.is_empty() { normals::flatten(&geometry) } else { geometry }
        }
        Elements::Lines(lines) => solids::lines(&geometry, &lines, height(&geometry)),
        Elements::Points(points) => solids::points(&geometry, &points, height(&geometry)),
    }
}
