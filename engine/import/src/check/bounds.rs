//! The bounds that accessors state for their elements: wrong ones are replaced by the true bounds.

use gltf::Semantic;
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Root, Value};

use crate::element::Kind;
use crate::elements::{self, Store};
use crate::verdict::Verdict;

/// The distance by which elements may exceed their bounds, as a share of the bounds: exporters
/// round bounds.
const TOLERANCE: f32 = 1e-5;

/// Checks the bounds of all used accessors. Wrong bounds, and missing bounds that are required, are
/// noted and replaced.
pub(crate) fn check(root: &mut Root, store: &Store, verdict: &mut Verdict) {
    for (index, is_needed) in needed(root, verdict).into_iter().enumerate() {
        let element = Kind::Accessor.at(index);
        let Some(accessor) = root.accessors.get(index) else { continue };
        let there = [&accessor.min, &accessor.max].map(Option::is_some);
        let is_missing = is_needed && there.contains(&false);
        if !(is_missing || there.contains(&true))
            || !verdict.is_used(element)
            || !verdict.is_kept(root, element)
        {
            continue;
        }
        let Some([least, most]) = extents(root, store, index) else { continue };
        let Some(accessor) = root.accessors.get_mut(index) else { continue };
        let what = match (holds(accessor, &least, &most), is_missing) {
            (true, false) => continue,
            (true, true) => "it has no min or no max, as positions and times must: computed again",
            (false, _) => "its min and max do not hold its elements: they were computed again",
        };
        (accessor.min, accessor.max) = (Some(list(&least)), Some(list(&most)));
        verdict.notes.count(what, 1, || element.to_string());
    }
}

/// Returns true for each accessor that must have bounds: it holds positions or times of shown
/// parts.
fn needed(root: &Root, verdict: &Verdict) -> Vec<bool> {
    let mut needed = vec![false; root.accessors.len()];
    let meshes = root.meshes.iter().enumerate();
    let shown = meshes.filter(|(index, _)| verdict.is_used(Kind::Mesh.at(*index)));
    let positions = shown.flat_map(|(_, mesh)| &mesh.primitives).flat_map(|primitive| {
        let own = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).copied();
        let targets = primitive.targets.iter().flatten();
        own.into_iter().chain(targets.filter_map(|target| target.positions))
    });
    let times = root.animations.iter().flat_map(|animation| {
        let samplers = animation
            .channels
            .iter()
            .filter_map(|channel| animation.samplers.get(channel.sampler.value()));
        samplers.map(|sampler| sampler.input)
    });
    for accessor in positions.chain(times) {
        if let Some(is_needed) = needed.get_mut(accessor.value()) {
            *is_needed = true;
        }
    }
    needed
}

/// Returns the least and the greatest value of each component, integers without normalisation;
/// `None` if a number is not finite.
fn extents(root: &Root, store: &Store, accessor: usize) -> Option<[Vec<f32>; 2]> {
    extents_of::<1>(root, store, accessor)
        .or_else(|| extents_of::<2>(root, store, accessor))
        .or_else(|| extents_of::<3>(root, store, accessor))
        .or_else(|| extents_of::<4>(root, store, accessor))
        .or_else(|| extents_of::<9>(root, store, accessor))
        .or_else(|| extents_of::<16>(root, store, accessor))
}

fn extents_of<const N: usize>(
    root: &Root,
    store: &Store,
    accessor: usize,
) -> Option<[Vec<f32>; 2]> {
    let mut least = [f32::INFINITY; N];
    let mut most = [f32::NEG_INFINITY; N];
    elements::for_each_raw::<N>(root, store, accessor, |element| {
        for (place, number) in element.into_iter().enumerate() {
            least[place] = least[place].min(number);
            most[place] = most[place].max(number);
        }
    })?;
    let is_finite = least.iter().chain(&most).all(|number| number.is_finite());
    is_finite.then(|| [least.to_vec(), most.to_vec()])
}

/// Returns true if the bounds of an accessor hold its elements, or if it has none.
fn holds(accessor: &Accessor, least: &[f32], most: &[f32]) -> bool {
    let margin = |bound: f32| bound.abs() * TOLERANCE + f32::MIN_POSITIVE;
    let all = |bound: &Option<Value>, extents: &[f32], holds: fn(f32, f32, f32) -> bool| {
        let Some(bound) = bound else { return true };
        let Some(numbers) = bound.as_array().filter(|array| array.len() == extents.len()) else {
            return false;
        };
        numbers.iter().zip(extents).all(|(bound, extent)| {
            let bound = bound.as_f64().map(|bound| bound as f32);
            bound.is_some_and(|bound| bound.is_finite() && holds(bound, *extent, margin(bound)))
        })
    };
    all(&accessor.min, least, |bound, least, margin| bound <= least + margin)
        && all(&accessor.max, most, |bound, most, margin| bound >= most - margin)
}

fn list(numbers: &[f32]) -> Value {
    numbers.iter().copied().map(Value::from).collect()
}
