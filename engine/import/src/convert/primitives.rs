//! Primitives: from a file's attributes to geometry that can be packed.

use glam::{Affine3A, Vec2, Vec3, Vec4};
use gltf::json;
use gltf::json::validation::Checked;
use gltf::mesh::{Mode, Semantic};
use scene::{MorphTarget, SkinWeights};

use super::budget::Budget;
use super::geometry::Geometry;
use super::materials::MaterialUse;
use super::numbers::mirrors;
use super::sidedness::{Backs, mirror, with_backs};
use super::sight::Sight;
use super::topology::Elements;
use super::{normals, solids, tangents};
use crate::error::quoted;
use crate::memory;
use crate::notes::Notes;
use crate::{Cause, ImportError, Source};

/// Texture coordinates beyond this are cut off: no number left between two of them is a texture's part.
const LARGEST_UV: f32 = 1e6;

/// Memory that a vertex, and a corner of a triangle, take at the most while they are made (bytes): their numbers as
/// they are read, split at edges, and packed.
const VERTEX_BYTES: u64 = 256;
const CORNER_BYTES: u64 = 32;

/// What is made of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Variant {
    /// How it is for the places that it is at.
    pub(super) facing: Facing,
    /// The number of joints of its skin, if it hangs on one.
    pub(super) joints: Option<u32>,
    /// Whether its morph targets count.
    pub(super) is_morphed: bool,
}

/// Which way the triangles of a primitive are to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Facing {
    /// As they are.
    Plain,
    /// The other way round: its places mirror.
    Mirrored,
    /// Either way: its places mirror at one time and not at another.
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
    /// Not deformed.
    pub(super) fn rigid(facing: Facing) -> Self {
        Self { facing, joints: None, is_morphed: false }
    }
}

/// A primitive of a file.
pub(super) struct Primitive<'a> {
    pub(super) source: &'a Source,
    pub(super) json: &'a json::mesh::Primitive,
    /// The number of its mesh.
    pub(super) mesh: usize,
    /// Its own number in that.
    pub(super) number: usize,
}

impl Primitive<'_> {
    /// Its mesh and its number in that, for errors.
    pub(super) fn place(&self) -> String {
        let mesh = self.source.document.as_json().meshes.get(self.mesh);
        let name = mesh.and_then(|mesh| mesh.name.as_deref()).filter(|name| !name.is_empty());
        let name = name.map(|name| format!(" ({})", quoted(name))).unwrap_or_default();
        format!("mesh {}{name}, primitive {}", self.mesh, self.number)
    }

    /// The accessor of an attribute.
    pub(super) fn attribute(&self, semantic: Semantic) -> Option<usize> {
        self.json.attributes.get(&Checked::Valid(semantic)).map(json::Index::value)
    }

    pub(super) fn mode(&self) -> Mode {
        match self.json.mode {
            Checked::Valid(mode) => mode,
            Checked::Invalid => Mode::Triangles,
        }
    }

    /// Whether lines or points are drawn that no light can fall on: they are their own colour
    /// (3.9.1, as for `KHR_materials_unlit`).
    pub(super) fn is_unlit(&self) -> bool {
        self.is_thin() && self.attribute(Semantic::Normals).is_none()
    }

    /// Whether it is points or lines.
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

    fn error(&self, cause: Cause, reason: String) -> ImportError {
        self.source.error(cause, self.place(), reason)
    }

    /// The primitive as triangles, in full: normals, tangents, backs. `None` if there is nothing to draw. Points and
    /// lines are as large as they are to be seen from `sight`.
    ///
    /// # Errors
    /// Positions that are not finite; more vertices or triangles than the limits allow.
    pub(super) fn build(
        &self,
        variant: Variant,
        material: &MaterialUse,
        (sight, to_world): (&Sight<'_>, &Affine3A),
        budget: &mut Budget,
        notes: &mut Notes,
    ) -> Result<Option<Geometry>, ImportError> {
        let Some((geometry, elements)) = self.read(variant, material, notes)? else {
            return Ok(None);
        };
        let own_backs = match (material.backs, variant.facing, material.is_blended) {
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
        // Flat normals may share more than this says; the exact numbers are taken below.
        let is_exact = !geometry.normals.is_empty() || !matches!(elements, Elements::Triangles(_));
        let least = if is_exact { vertices } else { geometry.positions.len() as u64 };
        let (least, corners) = (least * sides, triangles * 3 * sides);
        budget.check(least, corners).map_err(|over| self.over(&over))?;
        memory::ask(least * VERTEX_BYTES + corners * CORNER_BYTES)
            .map_err(|reason| reason.of(self.place()).in_file(&self.source.file))?;
        let geometry = match elements {
            Elements::Triangles(triangles) => {
                let geometry = Geometry { triangles, ..geometry };
                if geometry.normals.is_empty() { normals::flatten(&geometry) } else { geometry }
            }
            Elements::Lines(lines) => {
                let height = sight.height_at(&geometry.bounds(), to_world);
                solids::lines(&geometry, &lines, height)
            }
            Elements::Points(points) => {
                let height = sight.height_at(&geometry.bounds(), to_world);
                solids::points(&geometry, &points, height)
            }
        };
        let mut geometry = geometry;
        let broken = normals::repair(&mut geometry);
        notes.count("normals without a direction, taken from their triangles", broken, || {
            self.place()
        });
        let (mut geometry, broken) = tangents::complete(geometry, material.normal);
        notes.count("tangents without a direction, replaced by any", broken, || self.place());
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

    pub(super) fn over(&self, over: &super::budget::Over) -> ImportError {
        self.error(Cause::TooLarge, over.to_string())
    }

    /// All attributes that count, of the vertices that something is drawn with.
    pub(super) fn read(
        &self,
        variant: Variant,
        material: &MaterialUse,
        notes: &mut Notes,
    ) -> Result<Option<(Geometry, Elements)>, ImportError> {
        let Some(positions) = self.attribute(Semantic::Positions) else {
            notes.count("primitives without positions, which draw nothing", 1, || self.place());
            return Ok(None);
        };
        let positions = self.vectors(positions);
        let list = match &self.json.indices {
            Some(indices) => {
                self.source.integers::<1>(indices.value()).unwrap_or_default().into_flattened()
            }
            None => (0..positions.len() as u32).collect(),
        };
        if Elements::leaves_rest(self.mode(), list.len()) {
            let what = "vertices at the end that make no whole line or triangle, left out";
            notes.count(what, 1, || self.place());
        }
        let mut elements = Elements::of(self.mode(), &list);
        drop(list);
        let picks = self.used(&positions, &mut elements)?;
        let mut geometry = Geometry { positions, ..Geometry::default() };
        let of = |semantic| self.attribute(semantic);
        geometry.normals = of(Semantic::Normals).map(|it| self.vectors(it)).unwrap_or_default();
        if let Some(tangents) = of(Semantic::Tangents)
            && !geometry.normals.is_empty()
        {
            let tangents = self.source.floats::<4>(tangents).unwrap_or_default();
            geometry.tangents = tangents.into_iter().map(Vec4::from_array).collect();
        }
        for (uvs, set) in geometry.uvs.iter_mut().zip(material.sets) {
            match set.map(|set| of(Semantic::TexCoords(set))) {
                Some(Some(accessor)) => *uvs = self.uvs(accessor, notes),
                Some(None) => {
                    let what = "textures by coordinates that it does not have, shown by one texel";
                    notes.count(what, 1, || self.place());
                }
                None => {}
            }
        }
        if let Some(colours) = of(Semantic::Colors(0)) {
            geometry.colours = self.colours(colours, notes);
        }
        if let Some(joint_count) = variant.joints {
            geometry.skin = Some(self.skin(joint_count, geometry.positions.len(), notes));
        }
        if variant.is_morphed {
            geometry.targets = self.morph_targets()?;
        }
        if let Some(picks) = picks {
            geometry = geometry.gather(&picks);
        }
        Ok(Some((geometry, elements)))
    }

    /// Names only vertices that are used, by their order. Returns which those are, `None` if all.
    fn used(
        &self,
        positions: &[Vec3],
        elements: &mut Elements,
    ) -> Result<Option<Vec<u32>>, ImportError> {
        let mut is_used = vec![false; positions.len()];
        for &vertex in elements.vertices() {
            let (Some(is_used), Some(position)) =
                (is_used.get_mut(vertex as usize), positions.get(vertex as usize))
            else {
                let reason = format!("an index names vertex {vertex} of {}", positions.len());
                return Err(self.error(Cause::Malformed, reason));
            };
            if !position.is_finite() {
                let reason = format!("the position of vertex {vertex} is not a finite number");
                return Err(self.error(Cause::Malformed, reason));
            }
            *is_used = true;
        }
        if is_used.iter().all(|is_used| *is_used) {
            return Ok(None);
        }
        let mut names = vec![0; positions.len()];
        let mut picks = Vec::new();
        for ((vertex, is_used), name) in (0..).zip(&is_used).zip(&mut names) {
            if *is_used {
                *name = picks.len() as u32;
                picks.push(vertex);
            }
        }
        elements.rename(|vertex| names.get(vertex as usize).copied().unwrap_or_default());
        Ok(Some(picks))
    }

    fn vectors(&self, accessor: usize) -> Vec<Vec3> {
        let vectors = self.source.floats::<3>(accessor).unwrap_or_default();
        vectors.into_iter().map(Vec3::from_array).collect()
    }

    fn uvs(&self, accessor: usize, notes: &mut Notes) -> Vec<Vec2> {
        let mut broken = 0;
        let uvs = self.source.floats::<2>(accessor).unwrap_or_default().into_iter().map(|uv| {
            let uv = Vec2::from_array(uv);
            if uv.abs().max_element() <= LARGEST_UV && uv.is_finite() {
                return uv;
            }
            broken += 1;
            if uv.is_finite() {
                uv.clamp(Vec2::splat(-LARGEST_UV), Vec2::splat(LARGEST_UV))
            } else {
                Vec2::ZERO
            }
        });
        let uvs = uvs.collect();
        notes.count("texture coordinates that are huge or no numbers", broken, || self.place());
        uvs
    }

    fn colours(&self, accessor: usize, notes: &mut Notes) -> Vec<[f32; 4]> {
        let opaque = |[red, green, blue]: [f32; 3]| [red, green, blue, 1.0];
        let mut colours = self.source.floats::<4>(accessor).unwrap_or_else(|| {
            let colours = self.source.floats::<3>(accessor).unwrap_or_default();
            colours.into_iter().map(opaque).collect()
        });
        let (mut broken, mut cut) = (0, 0);
        for colour in &mut colours {
            if colour.iter().any(|part| !part.is_finite()) {
                *colour = [1.0; 4];
                broken += 1;
            }
            cut += usize::from(colour.iter().any(|part| !(0.0..=1.0).contains(part)));
        }
        notes.count("colours of vertices below 0 or above 1, cut off there", cut, || self.place());
        notes.count("colours of vertices that are no numbers, white instead", broken, || {
            self.place()
        });
        colours
    }

    /// All sets of joints and weights, which are 1 together for each vertex.
    fn skin(&self, joint_count: u32, vertices: usize, notes: &mut Notes) -> SkinWeights {
        let of_set = |set| {
            let joints = self.source.integers::<4>(self.attribute(Semantic::Joints(set))?)?;
            let weights = self.source.floats::<4>(self.attribute(Semantic::Weights(set))?)?;
            Some((joints, weights))
        };
        let sets: Vec<_> = (0..).map_while(of_set).collect();
        let mut skin = SkinWeights {
            joint_count,
            joints: Vec::with_capacity(vertices * sets.len()),
            weights: Vec::with_capacity(vertices * sets.len()),
            sets: sets.len() as u32,
        };
        let mut broken = 0;
        for vertex in 0..vertices {
            let start = skin.weights.len();
            for (joints, weights) in &sets {
                let joints = joints.get(vertex).copied().unwrap_or_default();
                let weights = weights.get(vertex).copied().unwrap_or_default();
                let weights =
                    weights.map(|weight| if weight.is_finite() { weight.max(0.0) } else { 0.0 });
                skin.joints.push(std::array::from_fn(|place| {
                    // What weighs nothing may name a joint that is not there.
                    let is_there = weights[place] > 0.0 && joints[place] < joint_count;
                    if is_there { joints[place] as u16 } else { 0 }
                }));
                skin.weights.push(weights);
            }
            let own = skin.weights.get_mut(start..).unwrap_or_default().as_flattened_mut();
            let sum: f64 = own.iter().map(|weight| f64::from(*weight)).sum();
            if sum > 0.0 {
                own.iter_mut().for_each(|weight| *weight = (f64::from(*weight) / sum) as f32);
            } else if let Some(first) = own.first_mut() {
                *first = 1.0;
                broken += 1;
            }
        }
        notes.count(
            "vertices without any weight, hung on their skin's first joint",
            broken,
            || self.place(),
        );
        skin
    }

    fn morph_targets(&self) -> Result<Vec<MorphTarget>, ImportError> {
        let deltas = |accessor: &Option<json::Index<json::Accessor>>| {
            let deltas = accessor.as_ref().and_then(|it| self.source.floats::<3>(it.value()));
            deltas.unwrap_or_default()
        };
        let finite = |delta: [f32; 3]| {
            if delta.iter().all(|part| part.is_finite()) { delta } else { [0.0; 3] }
        };
        let mut targets = Vec::with_capacity(self.targets().len());
        for (number, target) in self.targets().iter().enumerate() {
            let positions = deltas(&target.positions);
            let is_broken = |delta: &[f32; 3]| delta.iter().any(|part| !part.is_finite());
            if let Some(vertex) = positions.iter().position(is_broken) {
                let reason = format!(
                    "morph target {number} moves vertex {vertex} by what is not a finite number"
                );
                return Err(self.error(Cause::Malformed, reason));
            }
            let normals = deltas(&target.normals).into_iter().map(finite).collect();
            let tangents = deltas(&target.tangents).into_iter().map(finite).collect();
            targets.push(MorphTarget { positions, normals, tangents });
        }
        Ok(targets)
    }
}
