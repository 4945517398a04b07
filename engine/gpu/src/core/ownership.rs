//! The owning device of each object, and the check that handles are only used with their own
//! device.
//!
//! A handle is only valid for the device (or instance) that created it: drivers follow it as a
//! pointer. Every owner of handles reports its device by [`OfDevice`].
//! [`Commands`](crate::Commands) check it before they record; all other code uses
//! [`Device::check`](crate::Device::check).

use std::sync::atomic::{AtomicU64, Ordering};

use crate::core::error::Error;

/// The identity of a [`Device`](crate::Device) or an [`Instance`](crate::Instance), unique in the
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

/// The owner of a Vulkan handle, which destroys it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ownership {
    /// The engine created it.
    Ours,
    /// A host lent it.
    Host,
}

/// An object made from a [`Device`](crate::Device), which cannot be used with another device.
pub trait OfDevice {
    /// The kind of the object with an article, for error messages.
    const KIND: &'static str;

    /// Returns the id of the device that the object was made from.
    fn device_id(&self) -> OwnerId;
}

/// Returns an error if an object has another owner than its user.
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
