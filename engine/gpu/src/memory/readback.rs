//! Images that are read back to the CPU: mapped memory that is read only while the GPU does not
//! write to it.
//!
//! Commands that copy an image store a [`Ticket`], which gets their tick when they are submitted.
//! The image cannot be read until this tick is over. While it is being read, no recording can
//! overwrite it, so no thread ever reads an incomplete image. Of several open frames, only one may
//! copy an image to the same memory.

use std::ops::Deref;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use ash::vk;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::ownership::of_device;
use crate::memory::buffer::{Buffer, BufferSlice, MemoryKind};
use crate::record::commands::{Commands, Failure};
use crate::record::ticket::Ticket;

/// An image that is read back to the CPU. It can be used for one frame after another.
pub struct Readback {
    device: Device,
    buffer: Buffer,
    size: [u32; 2],
    /// The ticket of the newest commands that copy an image here; `None` before the first.
    newest: RwLock<Option<Arc<Ticket>>>,
}

/// The pixels of an image, which do not change until this value is dropped.
pub struct Pixels<'a> {
    bytes: &'a [u8],
    _reading: RwLockReadGuard<'a, Option<Arc<Ticket>>>,
}

impl Deref for Pixels<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.bytes
    }
}

of_device!(Readback: "an image (`Readback`)");

impl Readback {
    /// Creates memory for one image of `size` pixels.
    ///
    /// # Errors
    /// No memory.
    pub fn new(device: &Device, size: [u32; 2]) -> Result<Self, Error> {
        let size_bytes = u64::from(size[0]) * u64::from(size[1]) * 4;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = Buffer::new(device, "readback", size_bytes, usage, MemoryKind::ReadBack)?;
        Ok(Self { device: device.clone(), buffer, size, newest: RwLock::new(None) })
    }

    /// Returns the size in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the image of the newest frame that was recorded to copy one here: rows from the top,
    /// four bytes per pixel, sRGB. Never waits. A frame that copies another image here while the
    /// pixels are held fails.
    ///
    /// # Errors
    /// [`Error::NoImage`] before the first frame, while the newest frame is not over, and forever
    /// if it is never submitted; a lost device. [`Device::completed`] returns the newest tick that
    /// is over, and [`Device::wait_idle`] waits for all.
    pub fn rgba8(&self) -> Result<Pixels<'_>, Error> {
        let newest = self.newest.read().unwrap_or_else(PoisonError::into_inner);
        let tick = newest.as_ref().and_then(|ticket| ticket.tick()).ok_or(Error::NoImage)?;
        if self.device.completed()? < tick {
            return Err(Error::NoImage);
        }
        let bytes = self.buffer.read(0..self.size[0] as usize * self.size[1] as usize * 4);
        Ok(Pixels { bytes, _reading: newest })
    }

    /// Returns the slice that `commands` copy an image to. Returns `None` and makes them fail if
    /// they must not copy here.
    pub(crate) fn begin_copy(&self, commands: &Commands) -> Option<BufferSlice> {
        commands.check_owner(self).ok()?;
        let Ok(mut newest) = self.newest.try_write() else {
            commands.fail(Failure::Wrong("an image is copied over another one that is being read"));
            return None;
        };
        let ticket = commands.ticket();
        // Frames may be submitted in another order than recorded: of two frames that copy here, the
        // older one could overwrite pixels that are read after the newer one.
        let is_pending = |older: &Arc<Ticket>| !Arc::ptr_eq(older, &ticket) && older.is_pending();
        if newest.as_ref().is_some_and(is_pending) {
            commands.fail(Failure::Wrong("an image is copied by two frames that are both open"));
            return None;
        }
        *newest = Some(ticket);
        Some(self.buffer.whole())
    }
}
