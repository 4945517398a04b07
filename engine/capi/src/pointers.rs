//! The checks of pointers that come from C: null, alignment, sizes, lengths.

use std::fmt::Display;
use std::mem::MaybeUninit;

use crate::error::{AntumbraResult, Failure};
use crate::layout::{CLayout, CValue, FieldLayout, Versioned};

/// The largest `struct_size` that is accepted: a larger value is probably uninitialised memory.
const MAX_STRUCT_SIZE: usize = 4096;

/// Checks that a pointer is not null, and is aligned.
fn check<T>(name: impl Display, pointer: *const T) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::null(name));
    }
    if !pointer.is_aligned() {
        let message = format!("{name} is not aligned to {} bytes", align_of::<T>());
        return Err(Failure::new(AntumbraResult::BadPointer, message));
    }
    Ok(())
}

/// Returns an array of the caller.
///
/// # Safety
/// `pointer` points to `count` readable values, which are not written as long as the slice is used.
pub(crate) unsafe fn slice<'a, T: CValue>(
    name: impl Display,
    pointer: *const T,
    count: usize,
) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    check(&name, pointer)?;
    check_length::<T>(&name, count)?;
    // SAFETY: the caller's promise, and the checks above.
    let values = unsafe { std::slice::from_raw_parts(pointer, count) };
    if T::FIELDS.iter().any(FieldLayout::has_reserved) {
        for (number, value) in values.iter().enumerate() {
            check_reserved(format_args!("{name}[{number}]"), value)?;
        }
    }
    Ok(values)
}

/// Returns a byte of a value.
fn byte_of<T: CValue>(value: &T, at: usize) -> u8 {
    assert!(at < size_of::<T>());
    // SAFETY: the byte is in the value, and no struct of the interface has padding.
    unsafe { (&raw const *value).cast::<u8>().add(at).read() }
}

/// Returns an array to be written.
///
/// # Safety
/// `pointer` points to `count` writable values, which have no other user as long as the slice is
/// used.
pub(crate) unsafe fn output_slice<'a, T: CValue>(
    name: &str,
    pointer: *mut T,
    count: usize,
) -> Result<&'a mut [MaybeUninit<T>], Failure> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(name, pointer)?;
    check_length::<T>(name, count)?;
    // SAFETY: the caller's promise, and the checks above.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer.cast(), count) })
}

fn check_length<T>(name: impl Display, count: usize) -> Result<(), Failure> {
    match count.checked_mul(size_of::<T>()) {
        Some(bytes) if isize::try_from(bytes).is_ok() => Ok(()),
        _ => Err(Failure::argument(format_args!("{count} values of {name} are more than memory"))),
    }
}

/// Refuses a struct with a reserved field that is not 0.
fn check_reserved<T: CValue>(name: impl Display, value: &T) -> Result<(), Failure> {
    match set_reserved(T::FIELDS, &|at| byte_of(value, at)) {
        Some(field) => Err(Failure::argument(format_args!("{name}.{field} must be 0"))),
        None => Ok(()),
    }
}

/// Returns the first reserved field that is not 0.
fn set_reserved(fields: &[FieldLayout], bytes: &dyn Fn(usize) -> u8) -> Option<String> {
    fields.iter().find_map(|field| {
        if !field.fields.is_empty() {
            let inner = set_reserved(field.fields, &|at| bytes(field.offset + at))?;
            return Some(format!("{}.{inner}", field.name));
        }
        (field.is_reserved() && !is_zero(field, bytes)).then(|| field.name.to_owned())
    })
}

/// Returns true if all bytes of a field are 0.
fn is_zero(field: &FieldLayout, bytes: &dyn Fn(usize) -> u8) -> bool {
    (field.offset..field.offset + field.size).all(|at| bytes(at) == 0)
}

/// Reads a struct that may come from an older or a newer caller. Fields that the caller does not
/// have or leaves at 0 get their defaults.
///
/// # Safety
/// `pointer` is null, or points to a struct with `struct_size` readable bytes.
pub(crate) unsafe fn read<T: Versioned>(
    name: impl Display,
    pointer: *const T,
) -> Result<T, Failure> {
    // SAFETY: the caller's promise.
    let size = unsafe { struct_size(&name, pointer) }?;
    let mut value = T::INIT;
    // SAFETY: any bytes are a value, and a field is copied whole or not at all.
    unsafe {
        let known = size.min(size_of::<T>());
        let target = (&raw mut value).cast::<u8>();
        target.copy_from_nonoverlapping(pointer.cast::<u8>(), known);
        // The struct of a newer caller has the size that this version knows from here on.
        target.cast::<u32>().write(size_of::<T>() as u32);
        for at in size_of::<T>()..size {
            if pointer.cast::<u8>().add(at).read() != 0 {
                let message = format!(
                    "{name} ({}) has a field at byte {at} that this version of the library does \
                     not know: set it to 0, or use a newer library",
                    T::NAME
                );
                return Err(Failure::new(AntumbraResult::BadStructSize, message));
            }
        }
    }
    check_reserved(&name, &value)?;
    for field in T::FIELDS.iter().filter(|field| T::REQUIRED.contains(&field.name)) {
        if is_zero(field, &|at| byte_of(&value, at)) {
            return Err(if field.is_pointer {
                Failure::null(format_args!("{name}.{}", field.name))
            } else {
                Failure::argument(format_args!(
                    "{name}.{} is 0, and has no default: it must be set",
                    field.name
                ))
            });
        }
    }
    value.set_defaults();
    Ok(value)
}

/// Reads the bytes of a struct without a `struct_size` as an array of one.
pub(crate) fn plain_bytes<T: CLayout>(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let value = value_of::<T>(bytes)?;
    // SAFETY: a value on this stack.
    let read = unsafe { slice("it", &raw const value, 1) };
    read.map(|values| bytes_of(&values[0])).map_err(|failure| failure.message)
}

/// Reads the bytes of a struct with a `struct_size`.
pub(crate) fn versioned_bytes<T: Versioned>(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let value = value_of::<T>(bytes)?;
    // SAFETY: the whole struct is on this stack.
    let read = unsafe { read("it", &raw const value) };
    read.map(|value| bytes_of(&value)).map_err(|failure| failure.message)
}

fn value_of<T: CLayout>(bytes: &[u8]) -> Result<T, String> {
    if bytes.len() != size_of::<T>() {
        return Err(format!("{} has {} bytes", T::NAME, size_of::<T>()));
    }
    // SAFETY: the length is the size of the type, and any bytes are a valid value.
    Ok(unsafe { bytes.as_ptr().cast::<T>().read_unaligned() })
}

fn bytes_of<T: CLayout>(value: &T) -> Vec<u8> {
    (0..size_of::<T>()).map(|at| byte_of(value, at)).collect()
}

/// Checks the `struct_size` of a struct and returns it.
///
/// # Safety
/// As [`read`].
unsafe fn struct_size<T: Versioned>(
    name: impl Display,
    pointer: *const T,
) -> Result<usize, Failure> {
    check(&name, pointer)?;
    // SAFETY: the caller's promise; the first field is the size.
    let size = unsafe { pointer.cast::<u32>().read() } as usize;
    let ends =
        T::FIELDS[T::FIRST_VERSION_FIELDS - 1..].iter().map(|field| field.offset + field.size);
    let is_newer = (size_of::<T>()..=MAX_STRUCT_SIZE).contains(&size);
    if is_newer || ends.into_iter().any(|end| end == size) {
        return Ok(size);
    }
    let ours = size_of::<T>();
    let struct_name = T::NAME;
    let message = format!(
        "{name} has a struct_size of {size}, which no version of {struct_name} has: set it to \
         sizeof({struct_name}), which is {ours} in this version of the library"
    );
    Err(Failure::new(AntumbraResult::BadStructSize, message))
}

/// A checked struct of the caller, to be written.
pub(crate) struct Output<T> {
    pointer: *mut T,
    size: usize,
}

impl<T: Versioned> Output<T> {
    /// Checks a struct for output.
    ///
    /// # Safety
    /// `pointer` is null, or points to a struct with `struct_size` writable bytes, as long as the
    /// result is used.
    pub unsafe fn new(name: &str, pointer: *mut T) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        let size = unsafe { struct_size(name, pointer.cast_const()) }?;
        Ok(Self { pointer, size })
    }

    /// Writes all fields that the caller's struct has, except `struct_size`. Fields that only the
    /// caller knows become 0.
    pub fn write(self, value: &T) {
        let Self { pointer, size } = self;
        const SKIPPED: usize = size_of::<u32>();
        let known = size.min(size_of::<T>());
        // SAFETY: the promise of `new`; the first four bytes remain as they are.
        unsafe {
            let from = (&raw const *value).cast::<u8>();
            let to = pointer.cast::<u8>();
            to.add(SKIPPED).copy_from_nonoverlapping(from.add(SKIPPED), known - SKIPPED);
            to.add(known).write_bytes(0, size - known);
        }
    }
}

/// Checks a pointer to a single value that will be written.
pub(crate) fn check_output<T>(name: &str, pointer: *mut T) -> Result<(), Failure> {
    check(name, pointer.cast_const())
}
