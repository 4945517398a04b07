//! The layout of an accessor's elements in its view (glTF 2.0, section 3.6.2).

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Root};

use crate::error::Reason;

/// The layout of the components of each element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) component: ComponentType,
    /// The number of components per element.
    pub(crate) components: usize,
    /// The number of consecutive components without padding: a column of a matrix, or all
    /// components.
    run: usize,
    /// The distance in bytes from one run to the next.
    run_bytes: usize,
    /// The size of an element, including the padding of a matrix's columns.
    pub(crate) element_bytes: usize,
}

impl Layout {
    pub(crate) fn of(accessor: &Accessor) -> Result<Self, Reason> {
        let component = match accessor.component_type {
            Checked::Valid(component) => component.0,
            Checked::Invalid => return Err(Reason::malformed("its componentType does not exist")),
        };
        let kind = match accessor.type_ {
            Checked::Valid(kind) => kind,
            Checked::Invalid => return Err(Reason::malformed("its type does not exist")),
        };
        Ok(Self::new(component, kind))
    }

    fn new(component: ComponentType, kind: Type) -> Self {
        let components = kind.multiplicity();
        let run = match kind {
            Type::Mat2 => 2,
            Type::Mat3 => 3,
            Type::Mat4 => 4,
            Type::Scalar | Type::Vec2 | Type::Vec3 | Type::Vec4 => components,
        };
        let packed = run * component.size();
        // Columns of matrices begin at multiples of four bytes.
        let run_bytes = if run == components { packed } else { packed.next_multiple_of(4) };
        Self {
            component,
            components,
            run,
            run_bytes,
            element_bytes: run_bytes * (components / run),
        }
    }

    /// Returns the offset of a component in its element.
    pub(crate) fn offset(&self, component: usize) -> usize {
        component / self.run * self.run_bytes + component % self.run * self.component.size()
    }

    /// Returns the number of bytes of `count` elements with this stride.
    pub(crate) fn span(&self, count: u64, stride: u64) -> Option<u64> {
        let last = count.checked_sub(1)?.checked_mul(stride)?;
        last.checked_add(self.element_bytes as u64)
    }
}

/// Returns the stride of an accessor's elements in a view.
pub(crate) fn stride(root: &Root, view: usize, layout: &Layout) -> usize {
    root.buffer_views
        .get(view)
        .and_then(|view| view.byte_stride)
        .map_or(layout.element_bytes, |stride| stride.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_small_matrices_are_padded() {
        let bytes = |component, kind| Layout::new(component, kind).element_bytes;
        assert_eq!(bytes(ComponentType::U8, Type::Mat2), 8);
        assert_eq!(bytes(ComponentType::U8, Type::Mat3), 12);
        assert_eq!(bytes(ComponentType::U16, Type::Mat3), 24);
        assert_eq!(bytes(ComponentType::F32, Type::Mat3), 36);
        assert_eq!(bytes(ComponentType::U8, Type::Vec3), 3);
        let layout = Layout::new(ComponentType::U8, Type::Mat3);
        let offsets: Vec<_> = (0..9).map(|component| layout.offset(component)).collect();
        assert_eq!(offsets, [0, 1, 2, 4, 5, 6, 8, 9, 10]);
    }
}
