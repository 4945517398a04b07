//! Reads the elements of accessors as numbers: all types, sparse accessors, accessors without a
//! view, and matrices with padding.

use std::ops::Range;

use gltf::json::accessor::ComponentType;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Root};

use crate::layout::{self, Layout};

/// The location of the bytes of a buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum BufferBytes {
    /// A range of the file, so that the binary chunk of a GLB is not stored twice.
    InFile(Range<usize>),
    /// Bytes outside of the file.
    Apart(Vec<u8>),
}

/// The bytes of a file and of its buffers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Store {
    pub(crate) file: Vec<u8>,
    pub(crate) buffers: Vec<BufferBytes>,
}

impl Store {
    /// Returns the bytes of a buffer; empty if there is no such buffer.
    pub(crate) fn buffer(&self, index: usize) -> &[u8] {
        match self.buffers.get(index) {
            Some(BufferBytes::InFile(range)) => self.file.get(range.clone()).unwrap_or_default(),
            Some(BufferBytes::Apart(bytes)) => bytes,
            None => &[],
        }
    }

    /// Returns the bytes of a view; empty if there is no such view.
    pub(crate) fn view(&self, root: &Root, index: usize) -> &[u8] {
        let Some(view) = root.buffer_views.get(index) else {
            return &[];
        };
        let bytes = self.buffer(view.buffer.value());
        let start = view.byte_offset.unwrap_or_default().0 as usize;
        let end = start.saturating_add(view.byte_length.0 as usize);
        bytes.get(start..end).unwrap_or_default()
    }

    /// Returns the bytes of a view from an offset on.
    fn from(&self, root: &Root, view: usize, offset: u64) -> &[u8] {
        self.view(root, view).get(offset as usize..).unwrap_or_default()
    }
}

/// Returns the greatest value of the type of indices; `None` for other types. Graphics APIs begin a
/// new strip at it, and glTF 2.0, 3.7.2.1, does not allow it.
pub(crate) fn restart_index(indices: &Accessor) -> Option<u32> {
    let Checked::Valid(component) = indices.component_type else { return None };
    match component.0 {
        ComponentType::U8 => Some(u32::from(u8::MAX)),
        ComponentType::U16 => Some(u32::from(u16::MAX)),
        ComponentType::U32 => Some(u32::MAX),
        ComponentType::I8 | ComponentType::I16 | ComponentType::F32 => None,
    }
}

/// Returns the indices of the elements that a sparse accessor replaces.
pub(crate) fn sparse_indices<'a>(
    root: &'a Root,
    store: &'a Store,
    sparse: &'a Sparse,
) -> impl Iterator<Item = u32> + 'a {
    let (bytes, component) = index_bytes(root, store, sparse);
    let read = integer_reader(component).unwrap_or(|_| 0);
    bytes.chunks(component.size()).map(read).take(sparse.count.0 as usize)
}

/// Returns the bytes of the indices from the first one on, and their component type.
fn index_bytes<'a>(root: &Root, store: &'a Store, sparse: &Sparse) -> (&'a [u8], ComponentType) {
    let indices = &sparse.indices;
    let component = match indices.component_type {
        Checked::Valid(component) => component.0,
        Checked::Invalid => ComponentType::U8,
    };
    (store.from(root, indices.buffer_view.value(), indices.byte_offset.0), component)
}

/// Calls `visit` with the picked elements of an accessor of unsigned integers, or with all elements
/// without `picks`, which must increase. Returns `None` without a call for other component types,
/// or if elements do not have `N` components.
pub(crate) fn for_each_integers<const N: usize>(
    root: &Root,
    store: &Store,
    accessor: usize,
    picks: Option<&[u32]>,
    visit: impl FnMut([u32; N]),
) -> Option<()> {
    let elements = Elements::of::<N>(root, store, accessor)?;
    match elements.layout.component {
        ComponentType::U8 => elements.for_each(picks, unsigned8, visit),
        ComponentType::U16 => elements.for_each(picks, unsigned16, visit),
        ComponentType::U32 => elements.for_each(picks, unsigned32, visit),
        ComponentType::I8 | ComponentType::I16 | ComponentType::F32 => return None,
    }
    Some(())
}

/// Calls `visit` with the picked elements of an accessor as floats, or with all elements without
/// `picks`, which must increase. Returns `None` without a call if elements do not have `N`
/// components.
pub(crate) fn for_each_floats<const N: usize>(
    root: &Root,
    store: &Store,
    accessor: usize,
    picks: Option<&[u32]>,
    visit: impl FnMut([f32; N]),
) -> Option<()> {
    let elements = Elements::of::<N>(root, store, accessor)?;
    elements.for_each_number(elements.accessor.normalized, picks, visit);
    Some(())
}

/// Calls `visit` with each element of an accessor as the stored numbers, even if they are
/// normalised. Returns `None` without a call if elements do not have `N` components.
pub(crate) fn for_each_raw<const N: usize>(
    root: &Root,
    store: &Store,
    accessor: usize,
    visit: impl FnMut([f32; N]),
) -> Option<()> {
    Elements::of::<N>(root, store, accessor)?.for_each_number(false, None, visit);
    Some(())
}

fn integer_reader(component: ComponentType) -> Option<fn(&[u8]) -> u32> {
    match component {
        ComponentType::U8 => Some(unsigned8),
        ComponentType::U16 => Some(unsigned16),
        ComponentType::U32 => Some(unsigned32),
        ComponentType::I8 | ComponentType::I16 | ComponentType::F32 => None,
    }
}

// Accessors were checked to lie in their views, so no bytes are missing here.

fn unsigned8(bytes: &[u8]) -> u32 {
    bytes.first().copied().map_or(0, u32::from)
}

fn unsigned16(bytes: &[u8]) -> u32 {
    bytes.first_chunk().map_or(0, |&bytes| u32::from(u16::from_le_bytes(bytes)))
}

fn unsigned32(bytes: &[u8]) -> u32 {
    bytes.first_chunk().map_or(0, |&bytes| u32::from_le_bytes(bytes))
}

fn signed8(bytes: &[u8]) -> f32 {
    bytes.first_chunk().map_or(0.0, |&bytes| f32::from(i8::from_le_bytes(bytes)))
}

fn signed16(bytes: &[u8]) -> f32 {
    bytes.first_chunk().map_or(0.0, |&bytes| f32::from(i16::from_le_bytes(bytes)))
}

fn float(bytes: &[u8]) -> f32 {
    bytes.first_chunk().map_or(0.0, |&bytes| f32::from_le_bytes(bytes))
}

/// An accessor with its bytes.
struct Elements<'a> {
    root: &'a Root,
    store: &'a Store,
    accessor: &'a Accessor,
    layout: Layout,
}

impl<'a> Elements<'a> {
    /// Finds the elements of an accessor, if it has `N` components.
    fn of<const N: usize>(root: &'a Root, store: &'a Store, accessor: usize) -> Option<Self> {
        let accessor = root.accessors.get(accessor)?;
        let layout = Layout::of(accessor).ok().filter(|layout| layout.components == N)?;
        Some(Self { root, store, accessor, layout })
    }

    fn for_each_number<const N: usize>(
        &self,
        is_normalised: bool,
        picks: Option<&[u32]>,
        visit: impl FnMut([f32; N]),
    ) {
        match (self.layout.component, is_normalised) {
            (ComponentType::F32, _) => self.for_each(picks, float, visit),
            (ComponentType::U8, false) => self.for_each(picks, |b| unsigned8(b) as f32, visit),
            (ComponentType::U16, false) => self.for_each(picks, |b| unsigned16(b) as f32, visit),
            (ComponentType::U32, _) => self.for_each(picks, |b| unsigned32(b) as f32, visit),
            (ComponentType::I8, false) => self.for_each(picks, signed8, visit),
            (ComponentType::I16, false) => self.for_each(picks, signed16, visit),
            (ComponentType::U8, true) => {
                self.for_each(picks, |b| unsigned8(b) as f32 / 255.0, visit)
            }
            (ComponentType::U16, true) => {
                self.for_each(picks, |b| unsigned16(b) as f32 / 65535.0, visit)
            }
            (ComponentType::I8, true) => {
                self.for_each(picks, |b| (signed8(b) / 127.0).max(-1.0), visit)
            }
            (ComponentType::I16, true) => {
                self.for_each(picks, |b| (signed16(b) / 32767.0).max(-1.0), visit)
            }
        }
    }

    fn for_each<T: Copy + Default, const N: usize>(
        &self,
        picks: Option<&[u32]>,
        read: impl Fn(&[u8]) -> T,
        mut visit: impl FnMut([T; N]),
    ) {
        let offsets: [usize; N] = std::array::from_fn(|component| self.layout.offset(component));
        let base = self.base();
        let mut replaced = self.accessor.sparse.as_ref().map(|sparse| Replaced::of(self, sparse));
        let mut element = |index: usize| {
            #[cfg(test)]
            tests::READ.with(|read| read.set(read.get() + 1));
            let above = replaced.as_mut().and_then(|replaced| replaced.at(index));
            let bytes = above.or_else(|| {
                let (bytes, stride) = base?;
                bytes.get(index.checked_mul(stride)?..)
            });
            let bytes = bytes.unwrap_or_default();
            visit(offsets.map(|at| bytes.get(at..).map_or_else(T::default, &read)));
        };
        match picks {
            Some(picks) => picks.iter().for_each(|&pick| element(pick as usize)),
            None => (0..self.accessor.count.0 as usize).for_each(element),
        }
    }

    /// Returns the bytes of the view from the first element on, if there is a view, and the stride.
    fn base(&self) -> Option<(&'a [u8], usize)> {
        let view = self.accessor.buffer_view?.value();
        let stride = layout::stride(self.root, view, &self.layout);
        let offset = self.accessor.byte_offset.unwrap_or_default().0;
        Some((self.store.from(self.root, view, offset), stride))
    }
}

/// The elements that a sparse accessor replaces, to be queried in increasing order.
struct Replaced<'a> {
    indices: &'a [u8],
    index_bytes: usize,
    read: fn(&[u8]) -> u32,
    values: &'a [u8],
    value_bytes: usize,
    count: usize,
    /// The least element that may still be queried.
    next: usize,
}

impl<'a> Replaced<'a> {
    fn of(elements: &Elements<'a>, sparse: &'a Sparse) -> Self {
        let Elements { root, store, layout, .. } = elements;
        let (indices, component) = index_bytes(root, store, sparse);
        let values = &sparse.values;
        Self {
            indices,
            index_bytes: component.size(),
            read: integer_reader(component).unwrap_or(|_| 0),
            values: store.from(root, values.buffer_view.value(), values.byte_offset.0),
            value_bytes: layout.element_bytes,
            count: sparse.count.0 as usize,
            next: 0,
        }
    }

    fn index(&self, place: usize) -> usize {
        let bytes = place.checked_mul(self.index_bytes).and_then(|at| self.indices.get(at..));
        (self.read)(bytes.unwrap_or_default()) as usize
    }

    /// Returns the bytes of an element if the accessor replaces it.
    fn at(&mut self, index: usize) -> Option<&'a [u8]> {
        // If all elements are queried in order, it is the next one or none.
        if self.next < self.count && self.index(self.next) < index {
            let mut low = self.next;
            let mut high = self.count;
            while low < high {
                let middle = low.midpoint(high);
                if self.index(middle) < index { low = middle + 1 } else { high = middle }
            }
            self.next = low;
        }
        if self.next >= self.count || self.index(self.next) != index {
            return None;
        }
        let at = self.next.checked_mul(self.value_bytes)?;
        self.next += 1;
        self.values.get(at..)
    }
}

#[cfg(test)]
mod tests;
