//! Checks of views within their buffers, and of accessors within their views.

use gltf::json::accessor::sparse::Sparse;
use gltf::json::buffer::{MAX_BYTE_STRIDE, MIN_BYTE_STRIDE, View};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Root};

use scene::counted;

use super::numbers::in_range;
use crate::Limits;
use crate::element::Kind;
use crate::error::{At, Fault, Reason};
use crate::layout::{self, Layout};
use crate::verdict::Verdict;

/// Checks every view and every accessor; only used ones count towards limits. The values of sparse
/// indices are checked later, in the module `values`.
pub(crate) fn views_and_accessors(
    root: &Root,
    limits: &Limits,
    verdict: &mut Verdict,
) -> Result<(), Fault> {
    for (index, view) in root.buffer_views.iter().enumerate() {
        let checked = check_view(root, view).at(|| format!("buffer view {index}"));
        verdict.judge(Kind::View.at(index), checked)?;
    }
    let mut elements: u64 = 0;
    for (index, accessor) in root.accessors.iter().enumerate() {
        let at = || format!("accessor {index}");
        let element = Kind::Accessor.at(index);
        let checked = check_accessor(root, accessor).at(at);
        if verdict.judge(element, checked)?.is_none() || !verdict.is_used(element) {
            continue;
        }
        elements = elements.saturating_add(accessor.count.0);
        if elements > limits.elements {
            return Err(Reason::too_large("elements up to it", elements, limits.elements).of(at()));
        }
    }
    Ok(())
}

fn check_view(root: &Root, view: &View) -> Result<(), Reason> {
    in_range("buffer", view.buffer.value(), root.buffers.len())?;
    if view.target == Some(Checked::Invalid) {
        return Err(Reason::malformed("its target does not exist"));
    }
    if let Some(stride) = view.byte_stride
        && !(MIN_BYTE_STRIDE..=MAX_BYTE_STRIDE).contains(&stride.0)
    {
        let text = format!("its byteStride {} is not within 4 to 252", stride.0);
        return Err(Reason::malformed(text));
    }
    let there = root.buffers.get(view.buffer.value()).map_or(0, |buffer| buffer.byte_length.0);
    let offset = view.byte_offset.unwrap_or_default().0;
    ends_within(offset, Some(view.byte_length.0), there, "its buffer")
}

/// Checks that `bytes` from `offset` on lie within `there` bytes.
fn ends_within(offset: u64, bytes: Option<u64>, there: u64, of: &str) -> Result<(), Reason> {
    let end = bytes.and_then(|bytes| offset.checked_add(bytes));
    if end.is_some_and(|end| end <= there) {
        return Ok(());
    }
    let end = end.map_or_else(|| "beyond all numbers".to_owned(), |end| format!("at byte {end}"));
    let there = counted(there, "byte", "bytes");
    Err(Reason::malformed(format!("it ends {end}, but {of} has {there}")))
}

fn check_accessor(root: &Root, accessor: &Accessor) -> Result<(), Reason> {
    let layout = Layout::of(accessor)?;
    let count = accessor.count.0;
    if count == 0 {
        return Err(Reason::malformed("it has no elements: its count is 0, and 1 is the least"));
    }
    if let Some(view) = accessor.buffer_view {
        let view = view.value();
        in_range("buffer view", view, root.buffer_views.len())?;
        let stride = layout::stride(root, view, &layout);
        if stride < layout.element_bytes {
            let text = format!(
                "its elements of {} overlap at a byteStride of {stride}",
                counted(layout.element_bytes, "byte", "bytes")
            );
            return Err(Reason::malformed(text));
        }
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let span = layout.span(count, stride as u64);
        ends_within(offset, span, view_bytes(root, view), "its buffer view")?;
    }
    match &accessor.sparse {
        Some(sparse) => check_sparse(root, sparse, count, &layout),
        None => Ok(()),
    }
}

fn view_bytes(root: &Root, view: usize) -> u64 {
    root.buffer_views.get(view).map_or(0, |view| view.byte_length.0)
}

fn check_sparse(root: &Root, sparse: &Sparse, count: u64, layout: &Layout) -> Result<(), Reason> {
    let replaced = sparse.count.0;
    if replaced == 0 || replaced > count {
        let count = counted(count, "element", "elements");
        let text = format!("it is sparse with {replaced} of {count} replaced");
        return Err(Reason::malformed(text));
    }
    let Checked::Valid(index_type) = sparse.indices.component_type else {
        return Err(Reason::malformed("the componentType of its sparse indices does not exist"));
    };
    let parts = [
        (sparse.indices.buffer_view, sparse.indices.byte_offset.0, index_type.0.size()),
        (sparse.values.buffer_view, sparse.values.byte_offset.0, layout.element_bytes),
    ];
    for ((view, offset, bytes), of) in parts
        .into_iter()
        .zip(["the buffer view of its sparse indices", "the buffer view of its sparse values"])
    {
        in_range("buffer view", view.value(), root.buffer_views.len())?;
        let span = replaced.checked_mul(bytes as u64);
        ends_within(offset, span, view_bytes(root, view.value()), of)?;
    }
    Ok(())
}
