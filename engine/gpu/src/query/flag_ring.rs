//! The flag ring: results that shaders write over N frames in flight, read back like query results.
//!
//! A flag is the equivalent of a query that a shader writes: it is zero until something is visible.
//! A slot belongs to one frame until its tick is over. Predicates read the results in the same
//! frame, and at the end of the frame they are copied to mapped memory.

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::ownership::{OfDevice, OwnerId};
use crate::core::tick::Tick;
use crate::memory::buffer::BufferSlice;
use crate::query::predicates::ResultSource;
use crate::query::result_buffer::ResultBuffer;
use crate::query::ring::Ring;
use crate::record::commands::Commands;
use crate::record::frames::Frame;

/// A ring of flags over the frames in flight. Each flag carries a tag `T` of the caller and returns
/// it with its result.
pub struct FlagRing<T> {
    device: Device,
    ring: Ring<T, Option<ResultBuffer>>,
    source: ResultSource,
    name: String,
}

impl<T> OfDevice for FlagRing<T> {
    const KIND: &'static str = "a flag ring (`FlagRing`)";

    fn device_id(&self) -> OwnerId {
        self.device.id()
    }
}

impl<T: Copy> FlagRing<T> {
    /// Creates a ring for `frames_in_flight` frames whose results `source` writes.
    pub fn new(device: &Device, frames_in_flight: usize, source: ResultSource, name: &str) -> Self {
        let device = device.clone();
        let ring = Ring::new(frames_in_flight);
        Self { device, ring, source, name: name.to_owned() }
    }

    /// Passes the tags and results of every frame that is over to `answer`, oldest first.
    /// `completed` is [`Device::completed`]. Never waits.
    pub fn collect(&mut self, completed: Tick, mut answer: impl FnMut(&[T], &[u32])) {
        let device = &self.device;
        self.ring.collect(
            device.proven(completed),
            |tick| device.is_lost(tick),
            |slot| {
                if let Some(results) = &slot.memory {
                    answer(&slot.tags, results.read(slot.tags.len()));
                }
            },
        );
    }

    /// Begins the flags of `frame`, one per tag and with its index, all zero. A barrier from
    /// [`Access::CopyWrite`](crate::Access::CopyWrite) to the stores must follow. Results of this
    /// slot that were not collected are dropped.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a frame of another device, which then fails; no memory.
    pub fn begin(
        &mut self,
        frame: &Frame<'_>,
        tags: impl ExactSizeIterator<Item = T>,
    ) -> Result<(), Error> {
        frame.commands().check_owner(self)?;
        let (slot, _) = self.ring.turn_to(frame.slot(), |tick| self.device.is_lost(tick));
        slot.begin(frame.commands().recording(), tags);
        let wanted = slot.tags.len();
        if wanted == 0 {
            return Ok(());
        }
        if slot.memory.as_ref().is_none_or(|results| !results.holds(wanted)) {
            let name = format!("{} {}", self.name, slot.number);
            slot.memory = None; // retired: the slot's own tick is over
            slot.memory =
                Some(ResultBuffer::new(&self.device, &name, ResultBuffer::roomy(wanted))?);
        }
        if let Some(results) = &slot.memory {
            frame.commands().fill(results.first(wanted), 0);
        }
        Ok(())
    }

    /// Returns the results that shaders write, one per tag of the frame being recorded; `None`
    /// without tags.
    pub fn results(&self) -> Option<BufferSlice> {
        let slot = self.ring.current();
        let results = slot.memory.as_ref().filter(|_| !slot.tags.is_empty())?;
        Some(results.first(slot.tags.len()))
    }

    /// Copies all results to mapped memory for [`FlagRing::collect`]. Must be the last use in a
    /// frame.
    pub fn read_back(&self, commands: &Commands) {
        let slot = self.ring.current();
        if let (Ok(()), Some(results)) = (commands.check_owner(self), &slot.memory) {
            results.read_back(commands, slot.tags.len(), self.source.access());
        }
    }

    /// Notes that the frame of the present recording was submitted as `tick`.
    pub fn submitted(&mut self, tick: Tick) {
        self.ring.submitted(self.device.not_before(tick));
    }
}
