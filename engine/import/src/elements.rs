//! The elements of accessors as numbers: any type, sparse, without a view, matrices with padding.

use std::ops::Range;

use gltf::json::accessor::ComponentType;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Root};

use crate::layout::{self, Layout};

/// Where the bytes of a buffer are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum BufferBytes {
    /// Within the file: the binary chunk of a GLB is not held twice.
    InFile(Range<usize>),
    /// By themselves.
    Apart(Vec<u8>),
}

/// The bytes of a file and of what it refers to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Store {
    pub(crate) file: Vec<u8>,
    pub(crate) buffers: Vec<BufferBytes>,
}

impl Store {
    /// The bytes of a buffer; empty if there is no such buffer.
    pub(crate) fn buffer(&self, index: usize) -> &[u8] {
        match self.buffers.get(index) {
            Some(BufferBytes::InFile(range)) => self.file.get(range.clone()).unwrap_or_default(),
            Some(BufferBytes::Apart(bytes)) => bytes,
            None => &[],
        }
    }

    /// The bytes of a view; empty if there is no such view.
    pub(crate) fn view(&self, root: &Root, index: usize) -> &[u8] {
        let Some(view) = root.buffer_views.get(index) else {
            return &[];
        };
        let bytes = self.buffer(view.buffer.value());
        let start = view.byte_offset.unwrap_or_default().0 as usize;
        let end = start.saturating_add(view.byte_length.0 as usize);
        bytes.get(start..end).unwrap_or_default()
    }

    /// The bytes of a view from an offset on.
    fn from(&self, root: &Root, view: usize, offset: u64) -> &[u8] {
        self.view(root, view).get(offset as usize..).unwrap_or_default()
    }
}

/// The indices of the elements that a sparse accessor replaces.
pub(crate) fn sparse_indices<'a>(
    root: &'a Root,
    store: &'a Store,
    sparse: &'a Sparse,
) -> impl Iterator<Item = u32> + 'a {
    let indices = &sparse.indices;
    let component = match indices.component_type {
        Checked::Valid(component) => component.0,
        Checked::Invalid => ComponentType::U8,
    };
    let bytes = store.from(root, indices.buffer_view.value(), indices.byte_offset.0);
    let read = integer_reader(component).unwrap_or(|_| 0);
    bytes.chunks(component.size()).map(read).take(sparse.count.0 as usize)
}

/// Calls `visit` with each element of an accessor of unsigned integers; `None` and no call if it is not
/// one, or has not `N` components.
pub(crate) fn for_each_integers<const N: usize>(
    root: &Root,
    store: &Store,
    accessor: usize,
    visit: impl FnMut([u32; N]),
) -> Option<()> {
    let accessor = root.accessors.get(accessor)?;
    let layout = Layout::of(accessor).ok().filter(|layout| layout.components == N)?;
    let elements = Elements { root, store, accessor, layout };
    match layout.component {
        ComponentType::U8 => elements.for_each(unsigned8, visit),
        ComponentType::U16 => elements.for_each(unsigned16, visit),
        ComponentType::U32 => elements.for_each(unsigned32, visit),
        ComponentType::I8 | ComponentType::I16 | ComponentType::F32 => return None,
    }
    Some(())
}

/// Calls `visit` with each element of an accessor as floats; `None` and no call if it has not `N` components.
pub(crate) fn for_each_floats<const N: usize>(
    root: &Root,
    store: &Store,
    accessor: usize,
    visit: impl FnMut([f32; N]),
) -> Option<()> {
    let is_normalised = root.accessors.get(accessor)?.normalized;
    for_each_number((root, store), accessor, is_normalised, visit)
}

/// Calls `visit` with each element of an accessor as the numbers that are stored, also where they are normalised;
/// `None` and no call if it has not `N` components.
pub(crate) fn for_each_raw<const N: usize>(
    root: &Root,
    store: &Store,
    accessor: usize,
    visit: impl FnMut([f32; N]),
) -> Option<()> {
    for_each_number((root, store), accessor, false, visit)
}

fn for_each_number<const N: usize>(
    (root, store): (&Root, &Store),
    accessor: usize,
    is_normalised: bool,
    visit: impl FnMut([f32; N]),
) -> Option<()> {
    let accessor = root.accessors.get(accessor)?;
    let layout = Layout::of(accessor).ok().filter(|layout| layout.components == N)?;
    let elements = Elements { root, store, accessor, layout };
    match (layout.component, is_normalised) {
        (ComponentType::F32, _) => elements.for_each(float, visit),
        (ComponentType::U8, false) => elements.for_each(|b| unsigned8(b) as f32, visit),
        (ComponentType::U16, false) => elements.for_each(|b| unsigned16(b) as f32, visit),
        (ComponentType::U32, _) => elements.for_each(|b| unsigned32(b) as f32, visit),
        (ComponentType::I8, false) => elements.for_each(signed8, visit),
        (ComponentType::I16, false) => elements.for_each(signed16, visit),
        (ComponentType::U8, true) => elements.for_each(|b| unsigned8(b) as f32 / 255.0, visit),
        (ComponentType::U16, true) => elements.for_each(|b| unsigned16(b) as f32 / 65535.0, visit),
        (ComponentType::I8, true) => elements.for_each(|b| (signed8(b) / 127.0).max(-1.0), visit),
        (ComponentType::I16, true) => {
            elements.for_each(|b| (signed16(b) / 32767.0).max(-1.0), visit)
        }
    }
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

// Accessors were checked to lie in their views, so that what is missing here is never missed.

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

/// An accessor and where its bytes are.
struct Elements<'a> {
    root: &'a Root,
    store: &'a Store,
    accessor: &'a Accessor,
    layout: Layout,
}

impl Elements<'_> {
    fn for_each<T: Copy + Default, const N: usize>(
        &self,
        read: impl Fn(&[u8]) -> T,
        mut visit: impl FnMut([T; N]),
    ) {
        let offsets: [usize; N] = std::array::from_fn(|component| self.layout.offset(component));
        let element =
            |bytes: &[u8]| offsets.map(|at| bytes.get(at..).map_or_else(T::default, &read));
        let count = self.accessor.count.0 as usize;
        let mut base = self.base();
        let Some(sparse) = &self.accessor.sparse else {
            match base {
                Some(base) => base.take(count).for_each(|bytes| visit(element(bytes))),
                None => (0..count).for_each(|_| visit([T::default(); N])),
            }
            return;
        };
        let values = self.store.from(
            self.root,
            sparse.values.buffer_view.value(),
            sparse.values.byte_offset.0,
        );
        let values = values.chunks(self.layout.element_bytes);
        let mut replaced = sparse_indices(self.root, self.store, sparse).zip(values).peekable();
        for index in 0..count {
            let below = base.as_mut().and_then(Iterator::next);
            let above = replaced.next_if(|&(at, _)| at as usize == index);
            match (above, below) {
                (Some((_, bytes)), _) | (None, Some(bytes)) => visit(element(bytes)),
                (None, None) => visit([T::default(); N]),
            }
        }
    }

    /// The bytes of each element in its view, if it has one.
    fn base(&self) -> Option<std::slice::Chunks<'_, u8>> {
        let view = self.accessor.buffer_view?.value();
        let stride = layout::stride(self.root, view, &self.layout);
        let offset = self.accessor.byte_offset.unwrap_or_default().0;
        Some(self.store.from(self.root, view, offset).chunks(stride))
    }
}
