//! Checks of sizes that a renderer or a device does not support, before memory is allocated for
//! them.

use gpu::Device;

use crate::error::Error;
use crate::resources::instance::Instance;

/// Refuses a number beyond its limit.
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

/// Refuses more elements than a storage buffer of the device holds.
pub(crate) fn check_storage(
    device: &Device,
    what: &'static str,
    count: u64,
    bytes: u64,
    instead: &'static str,
) -> Result<(), Error> {
    let limit = u64::from(device.adapter().limits.max_storage_buffer_range);
    check(what, count, limit / bytes.max(1), instead)
}

/// Refuses a size for which there is not enough memory. Allocates the whole size and frees it,
/// since a failure in the middle of many allocations would end the program.
pub(crate) fn check_memory(
    what: &'static str,
    count: usize,
    bytes_each: usize,
) -> Result<(), Error> {
    let size_bytes = count.saturating_mul(bytes_each);
    let asked = Vec::<u8>::new().try_reserve_exact(size_bytes);
    asked.map_err(|_| Error::NoMemory { what, size_bytes })
}

/// Refuses an image of compressed blocks if there is not enough memory for its texels.
pub(crate) fn check_unpacking(size: [u32; 2]) -> Result<(), Error> {
    let [width, height] = size;
    let texels = (width as usize).saturating_mul(height as usize);
    check_memory("a compressed image that is unpacked", texels, 4)
}

/// Returns an empty list with room for `count` elements.
pub(crate) fn room<T>(what: &'static str, count: usize) -> Result<Vec<T>, Error> {
    let mut list = Vec::new();
    let size_bytes = count.saturating_mul(size_of::<T>());
    let reserved = list.try_reserve_exact(count);
    reserved.map(|()| list).map_err(|_| Error::NoMemory { what, size_bytes })
}

/// Refuses more leaves than a hierarchy or the device can hold, before any of their data is
/// created.
pub(crate) fn check_leaves(device: &Device, leaf_count: usize) -> Result<(), Error> {
    if leaf_count > cull::MAX_OBJECTS {
        return Err(cull::HierarchyError::TooMany { count: leaf_count }.into());
    }
    check_storage(
        device,
        "objects, with room for those that come",
        leaf_count as u64,
        size_of::<Instance>() as u64,
        "split the scene, or join objects that stand still",
    )
}

#[cfg(test)]
mod tests {
    use scene::limits::INSTANCE_BYTES;

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
    fn an_object_takes_what_the_limits_say() {
        assert_eq!(INSTANCE_BYTES, size_of::<crate::resources::instance::Instance>() as u64);
    }
}
