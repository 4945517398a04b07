//! The device of each object, and the one check that no other device is given its handles.
//!
//! Handles mean something to the device (or instance) that gave them away and to no other: drivers
//! follow them as pointers. Whatever owns handles says by [`OfDevice`] where they come from;
//! [`Commands`](crate::Commands) ask before they record it, everything else by
//! [`Device::check`](crate::Device::check).

use std::sync::atomic::{AtomicU64, Ordering};

use crate::core::error::Error;

/// The identity of a [`Device`](crate::Device) or an [`Instance`](crate::Instance) among all of the
/// process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct OwnerId(u64);

impl OwnerId {
    /// Returns an id that is unique in the process.
    pub(crate) fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// The owner of a Vulkan handle, who destroys it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ownership {
    /// The engine made it.
    Ours,
    /// A host lent it.
    Host,
}

/// A thing made from a [`Device`](crate::Device), of use to no other.
pub trait OfDevice {
    /// Its kind with an article, for error messages.
    const KIND: &'static str;

    /// Returns the id of the device that it was made from.
    fn device_id(&self) -> OwnerId;
}

/// Refuses a thing that has another owner than its user.
pub(crate) fn check(
    owner: OwnerId,
    wanted: OwnerId,
    thing: &'static str,
    user: &'static str,
    kind: &'static str,
) -> Result<(), Error> {
    if owner == wanted { Ok(()) } else { Err(Error::Foreign { thing, user, owner: kind }) }
}

/// Implements [`OfDevice`] for types with a field `device` of type [`Device`](crate::Device).
macro_rules! of_device {
    ($($type:ty: $kind:literal),+ $(,)?) => {
        $(impl $crate::core::ownership::OfDevice for $type {
            const KIND: &'static str = $kind;

            fn device_id(&self) -> $crate::core::ownership::OwnerId {
                self.device.id()
            }
        })+
    };
}
pub(crate) use of_device;
