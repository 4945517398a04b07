//! The flag ring: words that shaders set, over N frames in flight, brought home like query answers.
//!
//! What a query is to the rasteriser's counter, a flag is to a shader's store: zero until something
//! shows. A slot belongs to one frame until its tick is over; the words are read by predicates in
//! the same frame and copied to mapped memory at its end.

use crate::access::{Access, MemoryBarrier};
use crate::buffer::{Buffer, BufferSlice, Place};
use crate::commands::Commands;
use crate::device::Device;
use crate::error::Error;
use crate::frames::Frame;
use crate::ownership::{OfDevice, OwnerId};
use crate::predicates::WordSource;
use crate::timeline::Tick;
use ash::vk;

/// Flags over the frames in flight. Each carries a tag `T` and brings it back with its word; the
/// ring does not look into it.
pub struct FlagRing<T> {
    device: Device,
    slots: Vec<FlagSlot<T>>,
    recording: usize,
    source: WordSource,
    name: String,
}

struct FlagSlot<T> {
    flags: Option<Flags>,
    tags: Vec<T>,
    // The frame whose answers this slot holds; None while recording or after collecting.
    in_flight: Option<Tick>,
}

struct Flags {
    words: Buffer,
    readback: Buffer,
}

const FIRST_CAPACITY: usize = 256;
const WORD_BYTES: u64 = 4;

impl<T> OfDevice for FlagRing<T> {
    const KIND: &'static str = "a flag ring (`FlagRing`)";

    fn device_id(&self) -> OwnerId {
        self.device.id()
    }
}

impl<T: Copy> FlagRing<T> {
    /// A ring for `frames_in_flight` frames whose words `source` writes.
    pub fn new(device: &Device, frames_in_flight: usize, source: WordSource, name: &str) -> Self {
        let slot = || FlagSlot { flags: None, tags: Vec::new(), in_flight: None };
        Self {
            device: device.clone(),
            slots: (0..frames_in_flight.max(1)).map(|_| slot()).collect(),
            recording: 0,
            source,
            name: name.to_owned(),
        }
    }

    /// Gives `answer` the tags and words of every frame that is home, oldest first. `completed` is
    /// [`Device::completed`]. Never waits.
    pub fn collect(&mut self, completed: Tick, mut answer: impl FnMut(&[T], &[u32])) {
        let completed = self.device.proven(completed);
        loop {
            let home = |slot: &FlagSlot<T>| slot.in_flight.filter(|tick| *tick <= completed);
            let oldest = self.slots.iter_mut().filter(|slot| home(slot).is_some());
            let Some(slot) = oldest.min_by_key(|slot| slot.in_flight) else {
                return;
            };
            slot.in_flight = None;
            let Some(flags) = &slot.flags else {
                continue;
            };
            answer(&slot.tags, flags.readback.read(0..slot.tags.len()));
        }
    }

    /// Starts the flags of `frame`, one per tag, all zero; the place of a flag is that of its tag.
    /// A barrier from [`Access::CopyWrite`] to the stores must follow. Answers of this slot that
    /// nobody collected are forgotten.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a frame of another device, which fails; no memory.
    pub fn begin(
        &mut self,
        frame: &Frame<'_>,
        tags: impl ExactSizeIterator<Item = T>,
    ) -> Result<(), Error> {
        frame.commands().admit(self)?;
        let slot_index = frame.slot().0 % self.slots.len();
        self.recording = slot_index;
        let Some(slot) = self.slots.get_mut(slot_index) else {
            return Ok(());
        };
        slot.in_flight = None;
        slot.tags.clear();
        slot.tags.extend(tags);
        if slot.tags.is_empty() {
            return Ok(());
        }
        let wanted = slot.tags.len() as u64 * WORD_BYTES;
        if slot.flags.as_ref().is_none_or(|flags| flags.words.size_bytes() < wanted) {
            let capacity = slot.tags.len().max(FIRST_CAPACITY).next_power_of_two();
            let name = format!("{} {slot_index}", self.name);
            slot.flags = None; // retired: the slot's own tick is over
            slot.flags = Some(Flags::new(&self.device, capacity as u64 * WORD_BYTES, &name)?);
        }
        if let Some(flags) = &slot.flags {
            frame.commands().fill(flags.words.whole().part(0, wanted), 0);
        }
        Ok(())
    }

    /// The words that shaders set, one per tag of the frame being recorded; none without tags.
    pub fn words(&self) -> Option<BufferSlice> {
        let slot = self.slots.get(self.recording)?;
        let used_bytes = slot.tags.len() as u64 * WORD_BYTES;
        let flags = slot.flags.as_ref().filter(|_| used_bytes > 0)?;
        Some(flags.words.whole().part(0, used_bytes))
    }

    /// Copies all words to mapped memory for [`FlagRing::collect`]. The last use in a frame.
    pub fn read_back(&self, commands: &Commands) {
        if commands.admit(self).is_err() {
            return;
        }
        let slot = self.slots.get(self.recording);
        let (Some(words), Some(flags)) = (self.words(), slot.and_then(|slot| slot.flags.as_ref()))
        else {
            return;
        };
        commands.barrier(MemoryBarrier::between(&[self.source.access()], &[Access::CopyRead]));
        commands.copy_buffer(words, flags.readback.whole());
        commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
    }

    /// Tells the ring that the frame it recorded for is on its way.
    pub fn submitted(&mut self, tick: Tick) {
        let tick = self.device.not_before(tick);
        if let Some(slot) = self.slots.get_mut(self.recording) {
            slot.in_flight = Some(tick);
        }
    }
}

impl Flags {
    fn new(device: &Device, size_bytes: u64, name: &str) -> Result<Self, Error> {
        let mut usage = vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::STORAGE_BUFFER;
        if device.conditional().is_some() {
            usage |= vk::BufferUsageFlags::CONDITIONAL_RENDERING_EXT;
        }
        let home = vk::BufferUsageFlags::TRANSFER_DST;
        Ok(Self {
            words: Buffer::new(device, name, size_bytes, usage, Place::Device)?,
            readback: Buffer::new(
                device,
                &format!("{name} read back"),
                size_bytes,
                home,
                Place::ReadBack,
            )?,
        })
    }
}
