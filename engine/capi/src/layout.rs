//! The layouts of the structs of the interface, as values. Structs of older callers are read by
//! them, and tests compare them with a C compiler.

/// A field of a struct in C.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldLayout {
    /// The name.
    pub name: &'static str,
    /// The offset from the beginning of the struct in bytes.
    pub offset: usize,
    /// The size in bytes.
    pub size: usize,
    /// True for a pointer or a Vulkan handle, for which 0 means none.
    pub is_pointer: bool,
    /// The fields of a field that is a struct.
    pub fields: &'static [FieldLayout],
}

impl FieldLayout {
    /// Returns true if the field is reserved and must be 0.
    pub(crate) fn is_reserved(&self) -> bool {
        self.name.starts_with("reserved")
    }

    /// Returns true if the field is reserved, or is a struct with a reserved field.
    pub(crate) fn has_reserved(&self) -> bool {
        self.is_reserved() || self.fields.iter().any(Self::has_reserved)
    }
}

/// A struct in C.
#[derive(Clone, Copy, Debug)]
pub struct StructLayout {
    /// The name.
    pub name: &'static str,
    /// The size in bytes.
    pub size: usize,
    /// The fields in their order.
    pub fields: &'static [FieldLayout],
    /// Reads the bytes of a struct as the functions of the interface do. Returns the bytes with all
    /// defaults, or the reason why the struct is refused.
    pub read: fn(&[u8]) -> Result<Vec<u8>, String>,
}

impl StructLayout {
    /// Returns the layout of a struct without a `struct_size`.
    #[must_use]
    pub const fn of<T: CLayout>() -> Self {
        let read = crate::pointers::plain_bytes::<T>;
        Self { name: T::NAME, size: size_of::<T>(), fields: T::FIELDS, read }
    }

    /// Returns the layout of a struct with a `struct_size`.
    #[must_use]
    pub const fn of_versioned<T: Versioned>() -> Self {
        Self { read: crate::pointers::versioned_bytes::<T>, ..Self::of::<T>() }
    }
}

/// The type of a field, of an element of an array, or a whole struct.
///
/// # Safety
/// Any bytes are a valid value. `FIELDS` are all its fields, if it is a struct.
pub unsafe trait CValue: Copy {
    /// The fields in their order.
    const FIELDS: &'static [FieldLayout] = &[];
    /// True if 0 stands for none.
    const IS_POINTER: bool = false;
}

/// A struct of numbers, pointers and other such structs, without padding.
pub trait CLayout: CValue {
    /// The name in C.
    const NAME: &'static str;
}

/// A struct that begins with `struct_size`, a `u32`, and may grow at its end.
///
/// # Safety
/// The first field is `struct_size`.
pub unsafe trait Versioned: CLayout {
    /// The number of fields of its first version.
    const FIRST_VERSION_FIELDS: usize;
    /// The fields that have no default: 0 is refused.
    const REQUIRED: &'static [&'static str];
    /// A value with its `struct_size`, and with 0 in all other fields: `ANTUMBRA_INIT` in C.
    const INIT: Self;

    /// Sets fields that are 0 to their default, if the default is not 0.
    fn set_defaults(&mut self);
}

/// Implements [`CValue`] for numbers, among which 0 has no special meaning.
macro_rules! numbers {
    ($($type:ty),+) => {$(
        // SAFETY: a number.
        unsafe impl $crate::layout::CValue for $type {}
    )+};
}
numbers!(u8, u32, i32, u64, usize, f32, f64, std::ffi::c_char);

/// Implements [`CValue`] for pointers to functions and for handles of Vulkan.
macro_rules! pointers {
    ($($type:ty),+) => {$(
        // SAFETY: the rules of the interface, as for pointers.
        unsafe impl $crate::layout::CValue for $type {
            const IS_POINTER: bool = true;
        }
    )+};
}
#[cfg(feature = "vulkan")]
pub(crate) use numbers;
pub(crate) use pointers;

// SAFETY: a pointer, which is not followed.
unsafe impl<T> CValue for *const T {
    const IS_POINTER: bool = true;
}
// SAFETY: as above.
unsafe impl<T> CValue for *mut T {
    const IS_POINTER: bool = true;
}
// SAFETY: any bytes are valid elements.
unsafe impl<T: CValue, const N: usize> CValue for [T; N] {
    const FIELDS: &'static [FieldLayout] = {
        assert!(T::FIELDS.is_empty(), "reserved fields of elements would not be checked");
        &[]
    };
}

/// Returns the layout of the field that `_field` returns.
pub(crate) const fn field_layout<T, F: CValue>(
    name: &'static str,
    offset: usize,
    _field: fn(&T) -> &F,
) -> FieldLayout {
    FieldLayout { name, offset, size: size_of::<F>(), is_pointer: F::IS_POINTER, fields: F::FIELDS }
}

/// Implements [`CLayout`] for a `repr(C)` struct, and does not compile if a field is missing or
/// there is padding.
macro_rules! layout {
    ($type:ident: $($field:ident),+) => {
        // SAFETY: the checks below; no struct has a field that restricts its bytes.
        unsafe impl $crate::layout::CValue for $type {
            const FIELDS: &'static [$crate::layout::FieldLayout] = &[$(
                $crate::layout::field_layout(
                    stringify!($field),
                    std::mem::offset_of!($type, $field),
                    |value: &$type| &value.$field,
                ),
            )+];
        }
        impl $crate::layout::CLayout for $type {
            const NAME: &'static str = stringify!($type);
        }
        const _: () = {
            let _exhaustive = |value: $type| { let $type { $($field: _),+ } = value; };
            let fields = <$type as $crate::layout::CValue>::FIELDS;
            let mut sum = 0;
            let mut place = 0;
            while place < fields.len() {
                sum += fields[place].size;
                place += 1;
            }
            assert!(sum == size_of::<$type>(), "padding must be a field");
        };
    };
}

/// Implements [`Versioned`]: the number of fields of the first version, those that are required,
/// and the defaults that are not 0.
macro_rules! versioned {
    (
        $type:ident: $first_version:literal,
        required: [$($required:ident),*],
        defaults: {$($field:ident: $default:expr),*}
    ) => {
        // SAFETY: the first field is the size, or this does not compile.
        unsafe impl $crate::layout::Versioned for $type {
            const FIRST_VERSION_FIELDS: usize = $first_version;
            const REQUIRED: &'static [&'static str] = &[$(stringify!($required)),*];
            const INIT: Self = {
                assert!(std::mem::offset_of!($type, struct_size) == 0);
                $(let _ = std::mem::offset_of!($type, $required);)*
                // SAFETY: all fields are numbers and pointers, of which 0 is a value.
                Self { struct_size: size_of::<Self>() as u32, ..unsafe { std::mem::zeroed() } }
            };

            fn set_defaults(&mut self) {
                $(if self.$field == Self::INIT.$field {
                    self.$field = $default;
                })*
            }
        }
    };
}
pub(crate) use {layout, versioned};
