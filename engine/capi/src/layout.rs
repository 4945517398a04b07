//! The layout of the structs of the interface, as values: what reads structs of older callers and
//! what tests compare with a C compiler.

/// A field of a struct in C.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldLayout {
    /// The name.
    pub name: &'static str,
    /// Bytes from the beginning of the struct.
    pub offset: usize,
    /// Bytes of the field.
    pub size: usize,
}

/// A struct in C.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// The name.
    pub name: &'static str,
    /// Bytes of it.
    pub size: usize,
    /// The fields in their order.
    pub fields: &'static [FieldLayout],
}

impl StructLayout {
    /// Returns the layout of a struct.
    #[must_use]
    pub const fn of<T: CLayout>() -> Self {
        Self { name: T::NAME, size: size_of::<T>(), fields: T::FIELDS }
    }
}

/// A struct without padding of numbers, pointers and other such structs.
///
/// # Safety
/// `FIELDS` are all its fields, and any bytes are a valid value.
pub unsafe trait CLayout: Copy {
    /// The name in C.
    const NAME: &'static str;
    /// The fields in their order.
    const FIELDS: &'static [FieldLayout];
}

/// A struct that begins with `struct_size`, a `u32`, and may grow at its end.
///
/// # Safety
/// The first field is `struct_size`.
pub unsafe trait Versioned: CLayout {
    /// The number of fields of its first version.
    const REQUIRED_FIELDS: usize;
    /// The values of fields that a caller does not have.
    const DEFAULT: Self;
}

/// Returns the size of the field that a function returns.
#[doc(hidden)]
#[must_use]
pub const fn field_size<T, F>(_field: fn(&T) -> &F) -> usize {
    size_of::<F>()
}

/// Implements [`CLayout`] for a `repr(C)` struct, and does not compile if a field is missing or
/// there is padding.
macro_rules! layout {
    ($type:ident: $($field:ident),+) => {
        // SAFETY: the checks below; no struct has a field that restricts its bytes.
        unsafe impl $crate::layout::CLayout for $type {
            const NAME: &'static str = stringify!($type);
            const FIELDS: &'static [$crate::layout::FieldLayout] = &[$(
                $crate::layout::FieldLayout {
                    name: stringify!($field),
                    offset: std::mem::offset_of!($type, $field),
                    size: $crate::layout::field_size(|it: &$type| &it.$field),
                },
            )+];
        }
        const _: () = {
            let _exhaustive = |it: $type| { let $type { $($field: _),+ } = it; };
            let sum = 0 $(+ $crate::layout::field_size(|it: &$type| &it.$field))+;
            assert!(sum == size_of::<$type>(), "padding must be a field");
        };
    };
}
pub(crate) use layout;
