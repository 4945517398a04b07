//! The frame ring: N frames in flight, each with its slot, and the waits of a frame loop.
//!
//! On a device that was adopted without a queue, the frames belong to a host: they are recorded
//! into its command buffers ([`FrameRing::begin_in`]), and the ring never waits.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::core::deletion::RecordingId;
use crate::core::device::{Device, OpenRecording, WaitFor};
use crate::core::error::Error;
use crate::core::frames_in_flight::check_frames_in_flight;
use crate::core::loss_report::{LossReport, UnfinishedFrame};
use crate::core::order::Order;
use crate::core::ownership::{OfDevice, OwnerId};
use crate::core::pending_uploads::PendingUpload;
use crate::core::tick::Tick;
use crate::core::timeline::TimelineWait;
use crate::memory::upload::Uploads;
use crate::record::access::{Access, MemoryBarrier};
use crate::record::commands::Commands;
use crate::record::frame_slot::{NO_QUEUE, Slot, SlotTiming};
use crate::record::frame_stamps::FrameStamps;
use crate::record::resubmission::Resubmission;
use crate::record::timing::{FrameTime, FrameTimer, PASSES, PassTime, PassTimer};

/// The index of a slot of the ring, which holds the resources of one frame in flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SlotIndex(pub usize);

/// The identity of a ring of frames on its device: a recording that no frame has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRingId(RecordingId);

/// N frames in flight.
pub struct FrameRing {
    id: FrameRingId,
    device: Device,
    slots: Vec<Slot>,
    next: usize,
    /// The interval of timing: the passes of one frame per interval are timed.
    timed_interval: u64,
    begun: u64,
    resubmission: Resubmission,
    /// The stamps of a host's frames.
    stamps: Option<FrameStamps>,
}

/// The numbers that a host gives to a frame. They increase from frame to frame, not necessarily by
/// one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameNumbers {
    /// The number of the frame, above 0.
    pub current: Tick,
    /// The newest frame that is known to be over on the GPU, together with all frames before it.
    /// Frames that will never be submitted count as over.
    pub safe: Tick,
}

/// A frame being recorded. If it is dropped without [`Frame::submit`] or [`Frame::end`], it is
/// abandoned.
pub struct Frame<'ring> {
    ring: &'ring mut FrameRing,
    slot: SlotIndex,
    /// The number of the frame, if it belongs to a host.
    current: Option<Tick>,
    waited: Duration,
    waits: u32,
    /// The recording, which is open during all pieces of the frame.
    _recording: OpenRecording,
}

impl FrameRing {
    /// Creates a ring of `frames_in_flight` slots (at least one), without timing.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more than [`MAX_FRAMES_IN_FLIGHT`](crate::MAX_FRAMES_IN_FLIGHT); a
    /// failed call.
    pub fn new(device: &Device, frames_in_flight: usize) -> Result<Self, Error> {
        check_frames_in_flight(frames_in_flight)?;
        let slots = (0..frames_in_flight.max(1)).map(|slot| Slot::new(device, slot));
        let slots: Vec<Slot> = slots.collect::<Result<_, _>>()?;
        let (resubmission, stamps) = if device.has_queue() {
            (Resubmission::Never, None)
        } else {
            (Resubmission::Allowed, Some(FrameStamps::new(device, slots.len())?))
        };
        Ok(Self {
            id: FrameRingId(device.open_recording().number),
            device: device.clone(),
            slots,
            next: 0,
            timed_interval: 1,
            begun: 0,
            resubmission,
            stamps,
        })
    }

    /// Allows or forbids to submit frames again, from now on. By default a host's frames may be
    /// submitted again, and frames of a device with a queue are submitted once.
    pub fn set_resubmission(&mut self, resubmission: Resubmission) {
        self.resubmission = resubmission;
    }

    /// Measures the GPU time of every pass from now on.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the queue has no timestamps; a failed call.
    pub fn time_passes(&mut self) -> Result<(), Error> {
        self.time_passes_of_one_in(1)
    }

    /// Measures the GPU time of the passes of one frame per `frames` frames from now on; 0 counts
    /// as 1.
    ///
    /// # Errors
    /// The errors of [`FrameRing::time_passes`].
    pub fn time_passes_of_one_in(&mut self, frames: u64) -> Result<(), Error> {
        self.device.require(OptionalFeature::Timestamps, "timing passes")?;
        (self.timed_interval, self.begun) = (frames.max(1), 0);
        for (index, slot) in self.slots.iter_mut().enumerate() {
            slot.is_timed = false;
            let timer = PassTimer::new(&self.device, &format!("pass times {index}"), PASSES)?;
            slot.timer = Some(Arc::new(timer));
        }
        Ok(())
    }

    /// Stops measuring passes from now on.
    pub fn stop_timing_passes(&mut self) {
        for slot in &mut self.slots {
            slot.timer = None;
            slot.is_timed = false;
            slot.pass_times.clear();
        }
    }

    /// Returns the interval in frames at which the passes of a frame are timed; `None` without
    /// timing.
    pub fn timed_interval(&self) -> Option<u64> {
        let is_timing = self.slots.iter().any(|slot| slot.timer.is_some());
        is_timing.then_some(self.timed_interval)
    }

    /// Enables the timing of whole frames from now on, with two timestamps per frame, for frames
    /// that call [`Frame::begin_timing`].
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the queue has no timestamps; a failed call.
    pub fn time_frames(&mut self) -> Result<(), Error> {
        self.device.require(OptionalFeature::Timestamps, "timing frames")?;
        for (index, slot) in self.slots.iter_mut().enumerate() {
            let timer = PassTimer::new(&self.device, &format!("frame time {index}"), 1)?;
            slot.whole = FrameTimer::new(timer);
        }
        Ok(())
    }

    /// Returns the number of slots.
    pub fn frames_in_flight(&self) -> usize {
        self.slots.len()
    }

    /// Returns what is known about the loss of the device: which of these frames it did not finish,
    /// and what the driver says. Never waits.
    pub fn loss_report(&self) -> LossReport {
        let submitted = self.device.submitted();
        // A lost device may no longer tell.
        let completed = self.device.completed().unwrap_or_else(|_| self.device.known_over());
        let in_flight = self.slots.iter().filter(|slot| slot.tick > completed);
        let mut unfinished: Vec<UnfinishedFrame> = in_flight
            .map(|slot| UnfinishedFrame { tick: slot.tick, passes: slot.commands.passes() })
            .collect();
        unfinished.sort_by_key(|frame| frame.tick);
        LossReport { submitted, completed, unfinished, fault: self.device.fault() }
    }

    pub(crate) fn next_slot(&self) -> SlotIndex {
        SlotIndex(self.next)
    }

    /// Waits for the frame that used the next slot before, for at most `bound`. Returns true if it
    /// is over, so that [`FrameRing::begin`] would not wait.
    pub(crate) fn is_ready_within(&self, bound: Duration) -> Result<bool, Error> {
        let tick = self.slots.get(self.next).map_or(Tick::ZERO, |slot| slot.tick);
        self.device.wait_within(tick, bound)
    }

    /// Begins a frame: waits until the frame that used this slot N frames ago is over, and frees
    /// the objects that were retired before it.
    ///
    /// # Errors
    /// [`Error::Timeout`], a failed call.
    pub fn begin(&mut self) -> Result<Frame<'_>, Error> {
        if !self.device.has_queue() {
            return Err(NO_QUEUE);
        }
        let began = Instant::now();
        let tick = self.slots.get(self.next).map_or(Tick::ZERO, |slot| slot.tick);
        if tick > Tick::ZERO {
            self.device.wait(tick, WaitFor::Slot)?;
        }
        self.restart(None, began.elapsed())
    }

    /// Begins a frame in a command buffer of a host. Never waits. Frees the objects that were
    /// retired before the frame `safe`.
    ///
    /// The host must submit the command buffers in the order of the frame numbers. It may submit
    /// one again only before the frame is safe, after its first run, and if
    /// [`FrameRing::set_resubmission`] allows it. Answers of frames that never ran are ignored. If
    /// a frame runs after a later one, it shows the changes in between in the state of the later
    /// frame. Then all data that frames share is uploaded again.
    ///
    /// # Errors
    /// [`Error::HasQueue`] for a device with a queue; [`Error::FrameNumbers`] for numbers that do
    /// not increase; [`Error::TooManyFrames`] if the frame that used the next slot is not safe; a
    /// failed call.
    ///
    /// # Safety
    /// `commands` is a primary command buffer of the adopted device, for a queue of the given
    /// family. It is being recorded, outside of renderings, queries and conditional rendering,
    /// until the frame is dropped. All frames up to `safe` are over or will never be submitted;
    /// command buffers of such frames are not submitted again. A command buffer whose frame was
    /// dropped without [`Frame::end`] is never submitted.
    pub unsafe fn begin_in(
        &mut self,
        commands: vk::CommandBuffer,
        numbers: FrameNumbers,
    ) -> Result<Frame<'_>, Error> {
        let FrameNumbers { current, safe } = numbers;
        let used = self.slots.get(self.next).map_or(Tick::ZERO, |slot| slot.tick);
        if used > safe.max(self.device.completed()?) {
            let slots = self.slots.len();
            return Err(Error::TooManyFrames { current: current.0, used: used.0, slots });
        }
        self.device.host_frame(current, safe)?;
        let mut frame = self.restart(Some(commands), Duration::ZERO)?;
        frame.current = Some(current);
        frame.record_pending_uploads(current);
        Ok(frame)
    }

    fn restart(
        &mut self,
        hosts: Option<vk::CommandBuffer>,
        waited: Duration,
    ) -> Result<Frame<'_>, Error> {
        let index = self.next;
        self.device.free_retired()?;
        let recording = self.device.open_recording();
        let timing = if self.begun.is_multiple_of(self.timed_interval) {
            SlotTiming::Timed
        } else {
            SlotTiming::Untimed
        };
        self.begun += 1;
        if self.device.is_lost(self.slots[index].tick) {
            self.slots[index].is_timed = false;
            self.slots[index].whole.forget();
        }
        let resubmission = self.resubmission;
        self.slots[index].restart(recording.number, timing, resubmission, hosts)?;
        let slot = SlotIndex(index);
        Ok(Frame { ring: self, slot, current: None, waited, waits: 0, _recording: recording })
    }
}

impl OfDevice for Frame<'_> {
    const KIND: &'static str = "a frame (`Frame`)";

    fn device_id(&self) -> OwnerId {
        self.ring.device.id()
    }
}

impl Frame<'_> {
    /// Returns the identity of the ring.
    pub fn ring(&self) -> FrameRingId {
        self.ring.id
    }

    /// Returns the number of frames of the ring that may be in flight at once.
    pub fn frames_in_flight(&self) -> usize {
        self.ring.frames_in_flight()
    }

    /// Returns the slot of this frame, whose resources may be reused.
    pub fn slot(&self) -> SlotIndex {
        self.slot
    }

    /// Returns the time of waits: in [`FrameRing::begin`] for the frame that used this slot before,
    /// and in [`Frame::wait`] during this frame.
    pub fn waited(&self) -> Duration {
        self.waited
    }

    /// Returns the number of times that [`Frame::wait`] had to wait.
    pub fn waits(&self) -> u32 {
        self.waits
    }

    /// Returns the commands that this frame records into.
    pub fn commands(&self) -> &Commands {
        &self.ring.slots[self.slot.0].commands
    }

    /// Returns this frame's upload memory.
    pub fn uploads(&mut self) -> &mut Uploads {
        &mut self.ring.slots[self.slot.0].uploads
    }

    /// Returns the GPU times of the last complete frame of this slot, which was N frames ago unless
    /// frames were abandoned since. Empty without timing, and for a frame that was not timed.
    pub fn pass_times(&self) -> &[PassTime] {
        &self.ring.slots[self.slot.0].pass_times
    }

    /// Measures the rest of this frame if its ring [times frames](FrameRing::time_frames) and the
    /// timing has not begun yet. Must be called outside of passes.
    pub fn begin_timing(&mut self) {
        let slot = &mut self.ring.slots[self.slot.0];
        slot.whole.begin(&slot.commands);
    }

    /// Returns the GPU time of the last frame of this slot, if it was timed and not abandoned.
    pub fn last_time(&self) -> Option<FrameTime> {
        self.ring.slots[self.slot.0].whole.newest()
    }

    /// Submits the commands recorded so far and continues the same frame in another command buffer.
    /// Must be called outside of passes. The GPU starts the submitted commands once `after`,
    /// if given, is reached.
    ///
    /// # Errors
    /// A failure while recording, or a failed call.
    pub fn flush(&mut self, after: Option<TimelineWait<'_>>) -> Result<Tick, Error> {
        let slot = &mut self.ring.slots[self.slot.0];
        let tick = slot.submit(&Order { after, ..Order::default() })?;
        slot.next_piece()?;
        Ok(tick)
    }

    /// Waits until `tick` of a flushed piece is over, within the device's bound. For methods that
    /// need a result to continue: the wait counts as [`crate::WaitCounts::other`].
    ///
    /// # Errors
    /// [`Error::Timeout`], a failed call.
    pub fn wait(&mut self, tick: Tick) -> Result<(), Error> {
        let device = &self.ring.device;
        // A tick that was never submitted would never be over.
        let tick = tick.min(self.ring.slots[self.slot.0].tick);
        if device.completed()? >= tick {
            return Ok(());
        }
        let began = Instant::now();
        self.waits += 1;
        let over = device.wait(tick, WaitFor::Answer);
        self.waited += began.elapsed();
        over
    }

    /// Submits the frame and returns its tick. The GPU starts it once `after`, if given, is
    /// reached; the CPU does not wait.
    ///
    /// # Errors
    /// A failure while recording, or a failed call.
    pub fn submit(self, after: Option<TimelineWait<'_>>) -> Result<Tick, Error> {
        self.submit_in_order(&Order { after, ..Order::default() })
    }

    pub(crate) fn submit_in_order(mut self, order: &Order<'_>) -> Result<Tick, Error> {
        let is_timed = self.end_timing();
        let tick = self.ring.slots[self.slot.0].submit(order)?;
        self.note_sent(is_timed);
        Ok(tick)
    }

    /// Ends the frame of a host, which then continues its command buffer or submits it. Returns the
    /// frame's number.
    ///
    /// # Errors
    /// [`Error::HasQueue`] for a frame of a device with a queue; a failure while recording, after
    /// which the command buffer must not be submitted.
    pub fn end(mut self) -> Result<Tick, Error> {
        let Some(current) = self.current else { return Err(Error::HasQueue) };
        let is_timed = self.end_timing();
        let slot = &mut self.ring.slots[self.slot.0];
        slot.commands.check()?;
        if let Some(stamps) = &self.ring.stamps {
            stamps.record(&self.ring.device, &slot.commands, self.slot.0, current);
        }
        slot.commands.submitted(current);
        slot.tick = current;
        self.note_sent(is_timed);
        Ok(current)
    }

    /// Records the uploads that no earlier frame is known to have executed.
    fn record_pending_uploads(&self, current: Tick) {
        let device = &self.ring.device;
        let commands = self.commands();
        let confirmed = device.executions().confirmed();
        let mut copies = 0;
        let copy = |upload: &PendingUpload| {
            if copies == 0 {
                // Earlier frames may have recorded the same copies and read the results.
                commands.barrier(MemoryBarrier::between(&[Access::Any], &[Access::CopyWrite]));
            }
            copies += 1;
            commands.copy_pending(upload);
        };
        device
            .pending_uploads()
            .record(current, confirmed, copy, |pending_upload| device.retire(pending_upload));
        if copies > 0 {
            commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::Any]));
        }
    }

    /// Ends the timing of the frame. Returns true if its passes were timed.
    fn end_timing(&mut self) -> bool {
        let slot = &mut self.ring.slots[self.slot.0];
        let mut has_stamps = slot.whole.end(slot.commands.raw());
        let timer = slot.timer.as_ref().filter(|_| slot.timing == SlotTiming::Timed);
        if let Some(timer) = timer {
            timer.read_back(slot.commands.raw());
            has_stamps = true;
        }
        if has_stamps {
            let visible = MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]);
            slot.commands.barrier(visible);
        }
        timer.is_some()
    }

    /// Notes that the frame was submitted or ended, and switches to the next slot.
    fn note_sent(&mut self, is_timed: bool) {
        let slot = &mut self.ring.slots[self.slot.0];
        slot.is_timed = is_timed;
        slot.whole.submitted();
        self.ring.next = (self.slot.0 + 1) % self.ring.slots.len();
    }
}
