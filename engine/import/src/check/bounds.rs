//! The bounds that accessors say of their elements: those that do not hold them are replaced by those that do.

use gltf::json::{Accessor, Root, Value};

use crate::elements::{self, Store};
use crate::reach::Kind;
use crate::verdict::Verdict;

/// How far elements may be out of their bounds, as a share of the bounds: exporters round them.
const TOLERANCE: f32 = 1e-5;

/// Checks the bounds of all accessors that are used, and notes and replaces those that are wrong.
pub(crate) fn check(root: &mut Root, store: &Store, verdict: &mut Verdict) {
    for index in 0..root.accessors.len() {
        let element = Kind::Accessor.at(index);
        let has_bounds =
            root.accessors.get(index).is_some_and(|it| it.min.is_some() || it.max.is_some());
        if !has_bounds || !verdict.is_used(element) || !verdict.is_kept(root, element) {
            continue;
        }
        let Some([least, most]) = extents(root, store, index) else { continue };
        let Some(accessor) = root.accessors.get_mut(index) else { continue };
        if holds(accessor, &least, &most) {
            continue;
        }
        (accessor.min, accessor.max) = (Some(list(&least)), Some(list(&most)));
        let what = "its min and max do not hold its elements: they were computed anew";
        verdict.notes.count(what, 1, || element.to_string());
    }
}

/// Returns the least and the greatest of each component, integers as they are. Numbers that are not finite have
/// none.
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
    let (mut least, mut most) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
    elements::for_each_raw::<N>(root, store, accessor, |element| {
        for (place, number) in element.into_iter().enumerate() {
            least[place] = least[place].min(number);
            most[place] = most[place].max(number);
        }
    })?;
    let is_finite = least.iter().chain(&most).all(|number| number.is_finite());
    is_finite.then(|| [least.to_vec(), most.to_vec()])
}

/// Returns whether the bounds of an accessor, as far as it has any, hold its elements.
fn holds(accessor: &Accessor, least: &[f32], most: &[f32]) -> bool {
    let margin = |bound: f32| bound.abs() * TOLERANCE + f32::MIN_POSITIVE;
    let all = |bound: &Option<Value>, extents: &[f32], holds: fn(f32, f32, f32) -> bool| {
        let Some(bound) = bound else { return true };
        let Some(numbers) = bound.as_array().filter(|it| it.len() == extents.len()) else {
            return false;
        };
        numbers.iter().zip(extents).all(|(bound, extent)| {
            let bound = bound.as_f64().map(|bound| bound as f32);
            bound.is_some_and(|bound| holds(bound, *extent, margin(bound)))
        })
    };
    all(&accessor.min, least, |bound, least, margin| bound <= least + margin)
        && all(&accessor.max, most, |bound, most, margin| bound >= most - margin)
}

fn list(numbers: &[f32]) -> Value {
    numbers.iter().copied().map(Value::from).collect()
}
