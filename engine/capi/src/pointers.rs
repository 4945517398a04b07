//! The checks of pointers that come from C: null, alignment, sizes, lengths.

use std::mem::MaybeUninit;

use crate::error::{AntumbraResult, Failure};
use crate::layout::{CLayout, Versioned};

/// The largest size of a struct that is believed: a larger one was never set.
const MAX_STRUCT_SIZE: usize = 4096;

/// Checks that a pointer can be one.
fn check<T>(name: &str, pointer: *const T) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::null(name));
    }
    if !pointer.is_aligned() {
        let message = format!("{name} is not aligned to {} bytes", align_of::<T>());
        return Err(Failure::new(AntumbraResult::BadPointer, message));
    }
    Ok(())
}

/// Returns an array.
///
/// # Safety
/// `pointer` is the beginning of `count` readable values, and nobody writes to them as long as the
/// slice is used.
pub(crate) unsafe fn slice<'a, T: CElement>(
    name: &str,
    pointer: *const T,
    count: usize,
) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    check(name, pointer)?;
    check_length::<T>(name, count)?;
    // SAFETY: the caller's promise, and the checks above.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Returns an array to be written.
///
/// # Safety
/// `pointer` is the beginning of `count` writable values that nobody else uses as long as the slice
/// is used.
pub(crate) unsafe fn output_slice<'a, T: CElement>(
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

fn check_length<T>(name: &str, count: usize) -> Result<(), Failure> {
    match count.checked_mul(size_of::<T>()) {
        Some(bytes) if isize::try_from(bytes).is_ok() => Ok(()),
        _ => Err(Failure::argument(format_args!("{count} values of {name} are more than memory"))),
    }
}

/// A value that any bytes are valid for: an element of arrays.
///
/// # Safety
/// Any bytes are a valid value.
pub(crate) unsafe trait CElement: Copy {}

// SAFETY: a number.
unsafe impl CElement for u32 {}
// SAFETY: a pointer, which is not followed.
unsafe impl<T> CElement for *const T {}
// SAFETY: see `CLayout`.
unsafe impl<T: CLayout> CElement for T {}

/// Reads a struct that may come from an older or a newer caller.
///
/// # Safety
/// `pointer` is null or points to as many readable bytes as its `struct_size` says.
pub(crate) unsafe fn read<T: Versioned>(name: &str, pointer: *const T) -> Result<T, Failure> {
    // SAFETY: the caller's promise.
    let size = unsafe { struct_size(name, pointer) }?;
    let mut value = T::DEFAULT;
    // SAFETY: any bytes are a value, and a field is copied whole or not at all.
    unsafe {
        let known = size.min(size_of::<T>());
        let target = (&raw mut value).cast::<u8>();
        target.copy_from_nonoverlapping(pointer.cast::<u8>(), known);
        // What was read of a newer caller has this size here.
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
    Ok(value)
}

/// Checks the `struct_size` of a struct and returns it.
///
/// # Safety
/// As [`read`].
unsafe fn struct_size<T: Versioned>(name: &str, pointer: *const T) -> Result<usize, Failure> {
    check(name, pointer)?;
    // SAFETY: the caller's promise; the first field is the size.
    let size = unsafe { pointer.cast::<u32>().read() } as usize;
    let ends = T::FIELDS[T::REQUIRED_FIELDS - 1..].iter().map(|field| field.offset + field.size);
    let is_newer = (size_of::<T>()..=MAX_STRUCT_SIZE).contains(&size);
    if is_newer || ends.into_iter().any(|end| end == size) {
        return Ok(size);
    }
    let (ours, struct_name) = (size_of::<T>(), T::NAME);
    let message = format!(
        "{name} has a struct_size of {size}, which no version of {struct_name} has: set it to \
         sizeof({struct_name}), which is {ours} in this version of the library"
    );
    Err(Failure::new(AntumbraResult::BadStructSize, message))
}

/// A struct of the caller to be written, checked.
pub(crate) struct Output<T> {
    pointer: *mut T,
    size: usize,
}

impl<T: Versioned> Output<T> {
    /// Checks a struct for output.
    ///
    /// # Safety
    /// `pointer` is null or points to as many writable bytes as its `struct_size` says, as long as
    /// the value is used.
    pub unsafe fn new(name: &str, pointer: *mut T) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        let size = unsafe { struct_size(name, pointer.cast_const()) }?;
        Ok(Self { pointer, size })
    }

    /// Writes the fields that the caller has but `struct_size`, and zeros where he has more.
    pub fn write(self, value: &T) {
        let Self { pointer, size } = self;
        const SKIPPED: usize = size_of::<u32>();
        let known = size.min(size_of::<T>());
        // SAFETY: the promise of `new`; the first four bytes remain as they are.
        unsafe {
            let (from, to) = ((&raw const *value).cast::<u8>(), pointer.cast::<u8>());
            to.add(SKIPPED).copy_from_nonoverlapping(from.add(SKIPPED), known - SKIPPED);
            to.add(known).write_bytes(0, size - known);
        }
    }
}

/// Checks the place of a single value to be written.
pub(crate) fn check_output<T>(name: &str, pointer: *mut T) -> Result<(), Failure> {
    check(name, pointer.cast_const())
}
