//! Checks of meshes: their primitives' accessors, targets and weights.

use gltf::Semantic;
use gltf::json::accessor::Type;
use gltf::json::mesh::{MorphTarget, Primitive};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Mesh, Root};

use scene::counted;

use super::attributes::{self, Allowed, DIRECTION_DELTA, INDICES, POSITION_DELTA};
use super::extensions::QUANTISATION;
use super::numbers::{finite, in_range};
use crate::element::Kind;
use crate::error::{At, Fault, Reason};
use crate::extensions::uses;
use crate::leave_out::empty_primitive;
use crate::verdict::Verdict;

/// Checks all meshes. Broken primitives of shown meshes are emptied.
pub(super) fn check(root: &mut Root, verdict: &mut Verdict) -> Result<(), Fault> {
    for index in 0..root.meshes.len() {
        if verdict.is_used(Kind::Mesh.at(index)) {
            mend_mesh(root, index, verdict)?;
        } else if let Some(mesh) = root.meshes.get(index) {
            let checked = check_mesh(root, index, mesh);
            verdict.judge(Kind::Mesh.at(index), checked)?;
        }
    }
    Ok(())
}

/// Notes the primitives of shown meshes that have no positions.
pub(super) fn note_without_positions(root: &Root, verdict: &mut Verdict) {
    for (index, mesh) in root.meshes.iter().enumerate() {
        let element = Kind::Mesh.at(index);
        let primitives = if verdict.is_used(element) { mesh.primitives.as_slice() } else { &[] };
        for (number, primitive) in primitives.iter().enumerate() {
            let has_none = !primitive.attributes.contains_key(&Checked::Valid(Semantic::Positions));
            let what = "it has no positions, and draws nothing";
            let name = || format!("mesh {index}, primitive {number}");
            verdict.notes.count(what, usize::from(has_none), name);
        }
    }
}

/// Empties the broken primitives of a mesh, and removes weights that do not fit.
fn mend_mesh(root: &mut Root, index: usize, verdict: &mut Verdict) -> Result<(), Fault> {
    let mut targets = None;
    let count = root.meshes.get(index).map_or(0, |mesh| mesh.primitives.len());
    let given = root.meshes.get(index).map_or(0, target_count);
    for number in 0..count {
        let name = || format!("mesh {index}, primitive {number}");
        let Some(primitive) = root.meshes.get(index).and_then(|mesh| mesh.primitives.get(number))
        else {
            continue;
        };
        let mut checker = Checker::new(root, primitive);
        let checked = checker.check(&name);
        let own = primitive.targets.as_ref().map_or(0, Vec::len);
        let checked = checked.and_then(|()| same_targets(own, targets.unwrap_or(own)).at(name));
        let Err(fault) = checked else {
            targets = Some(own);
            let undeclared = checker.undeclared.take();
            note_targets_alone(primitive, &name, verdict);
            if let Some(fault) = undeclared {
                verdict.repair(fault, "read as if it were named")?;
            }
            continue;
        };
        if let Some(primitive) =
            root.meshes.get_mut(index).and_then(|mesh| mesh.primitives.get_mut(number))
        {
            empty_primitive(primitive);
        }
        verdict.leave_out(fault, "this primitive is left out")?;
    }
    let Some(mesh) = root.meshes.get_mut(index) else { return Ok(()) };
    let targets = targets.unwrap_or(given);
    // Emptied primitives keep the number of targets of the others.
    for primitive in &mut mesh.primitives {
        if primitive.attributes.is_empty() {
            primitive.targets = Some(vec![NO_TARGET; targets]);
        }
    }
    let Err(reason) = check_weights(mesh.weights.as_deref(), targets) else { return Ok(()) };
    mesh.weights = None;
    verdict.repair(reason.of(format!("mesh {index}")), "they are ignored")
}

/// Notes morph targets for normals or tangents that the primitive does not have.
fn note_targets_alone(primitive: &Primitive, name: &dyn Fn() -> String, verdict: &mut Verdict) {
    let lacks = |semantic| !primitive.attributes.contains_key(&Checked::Valid(semantic));
    let no_normals = lacks(Semantic::Normals);
    let no_tangents = lacks(Semantic::Tangents);
    let is_alone = |target: &&MorphTarget| {
        target.normals.is_some() && no_normals || target.tangents.is_some() && no_tangents
    };
    let alone = primitive.targets.iter().flatten().filter(is_alone).count();
    let what = "a morph target has normals or tangents that the primitive lacks: they are computed";
    verdict.notes.count(what, alone, name);
}

fn check_mesh(root: &Root, number: usize, mesh: &Mesh) -> Result<(), Fault> {
    let targets = target_count(mesh);
    for (index, primitive) in mesh.primitives.iter().enumerate() {
        let name = || format!("mesh {number}, primitive {index}");
        Checker::new(root, primitive).check(&name)?;
        let own = primitive.targets.as_ref().map_or(0, Vec::len);
        same_targets(own, targets).at(name)?;
    }
    check_weights(mesh.weights.as_deref(), targets).at(|| format!("mesh {number}"))
}

/// Returns the number of morph targets of a mesh.
pub(super) fn target_count(mesh: &Mesh) -> usize {
    mesh.primitives.first().and_then(|first| first.targets.as_ref()).map_or(0, Vec::len)
}

fn same_targets(own: usize, others: usize) -> Result<(), Reason> {
    if own == others {
        return Ok(());
    }
    let own = counted(own, "morph target", "morph targets");
    let text = format!("it has {own}, and the primitives of its mesh before it have {others}");
    Err(Reason::malformed(text))
}

/// Checks the weights of a mesh, or of a node with a mesh.
pub(super) fn check_weights(weights: Option<&[f32]>, targets: usize) -> Result<(), Reason> {
    let weights = weights.unwrap_or_default();
    finite("weight", weights)?;
    if !weights.is_empty() && weights.len() != targets {
        let own = counted(weights.len(), "weight", "weights");
        let targets = counted(targets, "morph target", "morph targets");
        let text = format!("it has {own} for {targets}");
        return Err(Reason::malformed(text));
    }
    Ok(())
}

/// A target that moves nothing.
const NO_TARGET: MorphTarget = MorphTarget { positions: None, normals: None, tangents: None };

struct Checker<'a> {
    root: &'a Root,
    primitive: &'a Primitive,
    /// True if the file declares the extension for integer attributes.
    is_quantised: bool,
    /// The first attribute that needs the extension although it is not declared.
    undeclared: Option<Fault>,
}

impl<'a> Checker<'a> {
    fn new(root: &'a Root, primitive: &'a Primitive) -> Self {
        Self { root, primitive, is_quantised: uses(root, QUANTISATION), undeclared: None }
    }

    fn check(&mut self, name: &dyn Fn() -> String) -> Result<(), Fault> {
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
            let name = || format!("{}, target {index}", name());
            self.check_target(target, &name).at(name)?;
        }
        Ok(())
    }

    fn accessor(&self, index: Index<Accessor>) -> Result<&'a Accessor, Reason> {
        let count = self.root.accessors.len();
        self.root.get(index).ok_or_else(|| Reason::out_of_range("accessor", index.value(), count))
    }

    fn check_attributes(&mut self, name: &dyn Fn() -> String) -> Result<(), Fault> {
        for (semantic, &index) in &self.primitive.attributes {
            let Checked::Valid(semantic) = semantic else { continue };
            let name = || format!("{}, attribute {}", name(), shown(semantic));
            let checked = self.accessor(index).and_then(|accessor| {
                if let Some(allowed) = attributes::allowed(semantic) {
                    self.check_form(accessor, &allowed, &name)?;
                }
                self.check_count(accessor)?;
                self.check_partner(semantic)
            });
            checked.at(name)?;
        }
        Ok(())
    }

    /// Checks the type of an attribute. Integers that need the extension are accepted without it,
    /// too.
    fn check_form(
        &mut self,
        accessor: &Accessor,
        allowed: &Allowed,
        name: &dyn Fn() -> String,
    ) -> Result<(), Reason> {
        let Err(reason) = allowed.check(accessor, self.is_quantised) else { return Ok(()) };
        if allowed.check(accessor, true).is_err() {
            return Err(reason);
        }
        self.undeclared.get_or_insert_with(|| reason.of(name()));
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
        let own = counted(accessor.count.0, "element", "elements");
        let text = format!("it has {own}, another attribute of the primitive has {}", expected.0);
        Err(Reason::malformed(text))
    }

    /// Checks that joints and weights come together.
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

    fn check_target(
        &mut self,
        target: &MorphTarget,
        name: &dyn Fn() -> String,
    ) -> Result<(), Reason> {
        if let Some(positions) = target.positions {
            let accessor = self.accessor(positions)?;
            self.check_form(accessor, &POSITION_DELTA, name)?;
            self.check_count(accessor)?;
        }
        for directions in [target.normals, target.tangents].into_iter().flatten() {
            let accessor = self.accessor(directions)?;
            self.check_form(accessor, &DIRECTION_DELTA, name)?;
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
