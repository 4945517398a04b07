//! Checks of animations: their targets must exist, and the numbers of keys and values must match.

use gltf::json::accessor::Type;
use gltf::json::animation::{Channel, Interpolation, Property, Sampler};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Animation, Index, Root};

use scene::counted;

use super::attributes::{self, FLOATS, FRACTIONS};
use super::meshes;
use super::numbers::in_range;
use crate::element::Kind;
use crate::error::{At, Fault, Reason};
use crate::verdict::Verdict;

pub(super) fn check(root: &Root, verdict: &mut Verdict) -> Result<(), Fault> {
    for (index, animation) in root.animations.iter().enumerate() {
        let checked = check_animation(root, index, animation);
        verdict.judge(Kind::Animation.at(index), checked)?;
    }
    Ok(())
}

/// Checks the channels of an animation, and the samplers to which they refer.
fn check_animation(root: &Root, number: usize, animation: &Animation) -> Result<(), Fault> {
    for (index, channel) in animation.channels.iter().enumerate() {
        let sampler = channel.sampler.value();
        if let Some(sampler) = animation.samplers.get(sampler) {
            check_sampler(root, sampler)
                .at(|| format!("animation {number}, sampler {}", channel.sampler.value()))?;
        }
        check_channel(root, animation, channel)
            .at(|| format!("animation {number}, channel {index}"))?;
    }
    Ok(())
}

fn accessor(root: &Root, index: Index<Accessor>) -> Result<&Accessor, Reason> {
    root.get(index)
        .ok_or_else(|| Reason::out_of_range("accessor", index.value(), root.accessors.len()))
}

fn check_sampler(root: &Root, sampler: &Sampler) -> Result<(), Reason> {
    accessor(root, sampler.output)?;
    if sampler.interpolation == Checked::Invalid {
        return Err(Reason::malformed("its interpolation does not exist"));
    }
    attributes::check_form(accessor(root, sampler.input)?, Type::Scalar, FLOATS)
}

fn check_channel(root: &Root, animation: &Animation, channel: &Channel) -> Result<(), Reason> {
    let index = channel.sampler.value();
    let count = animation.samplers.len();
    let sampler = animation
        .samplers
        .get(index)
        .ok_or_else(|| Reason::out_of_range("sampler", index, count))?;
    let node = channel.target.node.value();
    in_range("node", node, root.nodes.len())?;

    let output = accessor(root, sampler.output)?;
    let values_per_key = match channel.target.path {
        Checked::Invalid => return Err(Reason::malformed("its path does not exist")),
        Checked::Valid(Property::Translation | Property::Scale) => {
            attributes::check_form(output, Type::Vec3, FLOATS)?;
            1
        }
        Checked::Valid(Property::Rotation) => {
            attributes::check_form(output, Type::Vec4, FRACTIONS)?;
            1
        }
        Checked::Valid(Property::MorphTargetWeights) => {
            attributes::check_form(output, Type::Scalar, FRACTIONS)?;
            targets_of(root, node)?
        }
    };
    let values_per_key = match sampler.interpolation {
        // The tangent in, the value, the tangent out.
        Checked::Valid(Interpolation::CubicSpline) => 3 * values_per_key,
        _ => values_per_key,
    };
    let keys = accessor(root, sampler.input)?.count.0;
    if keys.checked_mul(values_per_key) == Some(output.count.0) {
        return Ok(());
    }
    let text = format!(
        "{} of {} each, but its output has {}",
        counted(keys, "key", "keys"),
        counted(values_per_key, "value", "values"),
        output.count.0
    );
    Err(Reason::malformed(text))
}

fn targets_of(root: &Root, node: usize) -> Result<u64, Reason> {
    let mesh = root.nodes.get(node).and_then(|node| node.mesh).and_then(|mesh| root.get(mesh));
    match mesh.map_or(0, meshes::target_count) {
        0 => Err(Reason::malformed(format!(
            "it moves the weights of node {node}, which has no morph targets"
        ))),
        count => Ok(count as u64),
    }
}
