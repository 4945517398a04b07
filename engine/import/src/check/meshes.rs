//! Checks of meshes: their primitives' accessors, targets and weights.

use gltf::Semantic;
use gltf::json::accessor::Type;
use gltf::json::mesh::{MorphTarget, Primitive};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Mesh, Root};

use super::attributes::{self, INDICES};
use super::extensions::QUANTISATION;
use super::numbers::{finite, in_range};
use crate::element::Kind;
use crate::error::{At, Fault, Reason};
use crate::extensions::uses;
use crate::verdict::Verdict;

pub(super) fn check(root: &Root, verdict: &mut Verdict) -> Result<(), Fault> {
    let is_quantised = uses(root, QUANTISATION);
    for (index, mesh) in root.meshes.iter().enumerate() {
        let checked = check_mesh(root, index, mesh, is_quantised);
        verdict.judge(Kind::Mesh.at(index), checked)?;
        if verdict.is_required(Kind::Mesh.at(index)) {
            note_targets_alone(index, mesh, verdict);
        }
    }
    Ok(())
}

/// Notes morph targets of normals or tangents that the primitive lacks.
fn note_targets_alone(number: usize, mesh: &Mesh, verdict: &mut Verdict) {
    for (index, primitive) in mesh.primitives.iter().enumerate() {
        let lacks = |semantic| !primitive.attributes.contains_key(&Checked::Valid(semantic));
        let (no_normals, no_tangents) = (lacks(Semantic::Normals), lacks(Semantic::Tangents));
        let is_alone = |target: &&MorphTarget| {
            target.normals.is_some() && no_normals || target.tangents.is_some() && no_tangents
        };
        let alone = primitive.targets.iter().flatten().filter(is_alone).count();
        let what = "morph targets with normals or tangents that the primitive does not have: computed instead";
        verdict.notes.count(what, alone, || format!("mesh {number}, primitive {index}"));
    }
}

fn check_mesh(root: &Root, number: usize, mesh: &Mesh, is_quantised: bool) -> Result<(), Fault> {
    for (index, primitive) in mesh.primitives.iter().enumerate() {
        let checker = Checker { root, primitive, is_quantised };
        checker.check(&|| format!("mesh {number}, primitive {index}"))?;
    }
    check_targets(mesh).at(|| format!("mesh {number}"))
}

/// Returns the number of morph targets of a mesh.
pub(super) fn target_count(mesh: &Mesh) -> usize {
    mesh.primitives.first().and_then(|first| first.targets.as_ref()).map_or(0, Vec::len)
}

fn check_targets(mesh: &Mesh) -> Result<(), Reason> {
    let count = target_count(mesh);
    if mesh.primitives.iter().any(|other| other.targets.as_ref().map_or(0, Vec::len) != count) {
        return Err(Reason::malformed("its primitives have not the same number of morph targets"));
    }
    check_weights(mesh.weights.as_deref(), count)
}

/// Checks the weights of a mesh, or of a node with one.
pub(super) fn check_weights(weights: Option<&[f32]>, targets: usize) -> Result<(), Reason> {
    let weights = weights.unwrap_or_default();
    finite("weight", weights)?;
    if !weights.is_empty() && weights.len() != targets {
        let text = format!("it has {} weights for {targets} morph targets", weights.len());
        return Err(Reason::malformed(text));
    }
    Ok(())
}

struct Checker<'a> {
    root: &'a Root,
    primitive: &'a Primitive,
    is_quantised: bool,
}

impl Checker<'_> {
    fn check(&self, name: &dyn Fn() -> String) -> Result<(), Fault> {
        let primitive = self.primitive;
        if primitive.mode == Checked::Invalid {
            return Err(Reason::malformed("its mode does not exist").of(name()));
        }
        if let Some(material) = primitive.material {
            in_range("material", material.value(), self.root.materials.len()).at(name)?;
        }
        if let Some(indices) = primitive.indices {
            let checked = self
                .accessor(indices)
                .and_then(|accessor| attributes::check_form(accessor, Type::Scalar, INDICES));
            checked.at(|| format!("{}, indices", name()))?;
        }
        self.check_attributes(name)?;
        for (index, target) in primitive.targets.iter().flatten().enumerate() {
            self.check_target(target).at(|| format!("{}, target {index}", name()))?;
        }
        Ok(())
    }

    fn accessor(&self, index: Index<Accessor>) -> Result<&Accessor, Reason> {
        let count = self.root.accessors.len();
        self.root.get(index).ok_or_else(|| Reason::out_of_range("accessor", index.value(), count))
    }

    fn check_attributes(&self, name: &dyn Fn() -> String) -> Result<(), Fault> {
        for (semantic, &index) in &self.primitive.attributes {
            let Checked::Valid(semantic) = semantic else { continue };
            let checked = self.accessor(index).and_then(|accessor| {
                attributes::check(semantic, accessor, self.is_quantised)?;
                self.check_count(accessor)?;
                self.check_partner(semantic)
            });
            checked.at(|| format!("{}, attribute {}", name(), shown(semantic)))?;
        }
        Ok(())
    }

    /// Checks that all attributes have as many elements as the first.
    fn check_count(&self, accessor: &Accessor) -> Result<(), Reason> {
        let first =
            self.primitive.attributes.values().next().and_then(|&first| self.root.get(first));
        let expected = first.map_or(accessor.count, |first| first.count);
        if accessor.count == expected {
            return Ok(());
        }
        let text = format!(
            "it has {} elements, another attribute of the primitive has {}",
            accessor.count.0, expected.0
        );
        Err(Reason::malformed(text))
    }

    /// Checks that joints come with weights.
    fn check_partner(&self, semantic: &Semantic) -> Result<(), Reason> {
        let partner = match *semantic {
            Semantic::Joints(set) => Semantic::Weights(set),
            Semantic::Weights(set) => Semantic::Joints(set),
            _ => return Ok(()),
        };
        let name = shown(&partner);
        if self.primitive.attributes.contains_key(&Checked::Valid(partner)) {
            return Ok(());
        }
        Err(Reason::malformed(format!("it means nothing without {name}")))
    }

    fn check_target(&self, target: &MorphTarget) -> Result<(), Reason> {
        if let Some(positions) = target.positions {
            let accessor = self.accessor(positions)?;
            attributes::check_position_delta(accessor, self.is_quantised)?;
            self.check_count(accessor)?;
        }
        for directions in [target.normals, target.tangents].into_iter().flatten() {
            let accessor = self.accessor(directions)?;
            attributes::check_direction_delta(accessor, self.is_quantised)?;
            self.check_count(accessor)?;
        }
        Ok(())
    }
}

fn shown(semantic: &Semantic) -> String {
    match semantic {
        Semantic::Extras(name) => crate::error::quoted(&format!("_{name}")),
        known => known.to_string(),
    }
}
