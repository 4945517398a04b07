//! How much a scene may have: what no renderer takes more of, and what each takes on any device. What is beyond
//! is refused by [`Error::SceneTooLarge`], before memory is taken for it.

use gpu::Device;

use crate::error::Error;
use crate::surfaces::MAX_PAGES;

/// Bytes that a storage buffer has on every device; many have more.
pub const STORAGE_BYTES_ANYWHERE: u64 = 1 << 27;

/// Objects, with room for those that come, that every device takes; blended ones count by themselves.
pub const OBJECTS_ANYWHERE: u64 = STORAGE_BYTES_ANYWHERE / INSTANCE_BYTES;

/// Objects together with blended ones that every device takes in a scene with points' or spots' lights.
pub const LIT_OBJECTS_ANYWHERE: u64 = STORAGE_BYTES_ANYWHERE / 32;

/// Materials that every device takes.
pub const MATERIALS_ANYWHERE: u64 = STORAGE_BYTES_ANYWHERE / 64 - 1;

/// Vertices of meshes that change their form that every device takes, all of them together.
pub const DEFORMED_VERTICES_ANYWHERE: u64 = STORAGE_BYTES_ANYWHERE / 40;

/// Images that every device takes, each counted twice that is both looked at as colours and as numbers.
pub const IMAGES_ANYWHERE: u64 = MAX_PAGES as u64 * 256;

pub(crate) const INSTANCE_BYTES: u64 = 64;

/// Refuses more of something than there may be.
pub(crate) fn check(
    what: &'static str,
    wanted: u64,
    limit: u64,
    instead: &'static str,
) -> Result<(), Error> {
    if wanted > limit {
        return Err(Error::SceneTooLarge { what, wanted, limit, instead });
    }
    Ok(())
}

/// Refuses more things of so many bytes than a storage buffer of the device holds.
pub(crate) fn check_storage(
    device: &Device,
    what: &'static str,
    (count, bytes): (u64, u64),
    instead: &'static str,
) -> Result<(), Error> {
    let limit = u64::from(device.adapter().limits.max_storage_buffer_range);
    check(what, count, limit / bytes.max(1), instead)
}

/// Refuses what there is no memory for, before it is allocated piece by piece: that would end the
/// program. Asks for all of it and gives it back.
pub(crate) fn check_memory(
    what: &'static str,
    count: usize,
    bytes_each: usize,
) -> Result<(), Error> {
    let size_bytes = count.saturating_mul(bytes_each);
    let asked = Vec::<u8>::new().try_reserve_exact(size_bytes);
    asked.map_err(|_| Error::NoMemory { what, size_bytes })
}

/// Returns an empty list with room for so many.
pub(crate) fn room<T>(what: &'static str, count: usize) -> Result<Vec<T>, Error> {
    let mut list = Vec::new();
    let size_bytes = count.saturating_mul(size_of::<T>());
    let reserved = list.try_reserve_exact(count);
    reserved.map(|()| list).map_err(|_| Error::NoMemory { what, size_bytes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_much_is_named_with_the_limit_and_a_way_out() {
        assert!(check("lights", 10, 10, "").is_ok());
        let error = check("lights", 11, 10, "leave some out").unwrap_err().to_string();
        assert_eq!(
            error,
            "the scene has 11 lights, and a renderer takes at most 10 here: leave some out"
        );
    }

    #[test]
    fn the_limits_are_those_of_what_lies_in_the_buffers() {
        assert_eq!(INSTANCE_BYTES, size_of::<crate::geometry::Instance>() as u64);
        assert_eq!(OBJECTS_ANYWHERE, 2_097_152);
        assert_eq!(LIT_OBJECTS_ANYWHERE, 4_194_304);
        assert_eq!(MATERIALS_ANYWHERE, 2_097_151);
        assert_eq!(DEFORMED_VERTICES_ANYWHERE, 3_355_443);
        assert_eq!(IMAGES_ANYWHERE, 3072);
    }
}
