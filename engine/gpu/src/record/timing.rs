//! GPU time per pass: timestamps around each pass, read frames later from mapped memory.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use ash::vk;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::queue_lock::lock;
use crate::core::tick::Tick;
use crate::memory::buffer::{Buffer, MemoryKind};
use crate::query::query_reset::reset_queries;
use crate::record::commands::Commands;

/// The time of a pass on the GPU.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassTime {
    /// The label of the pass, which debuggers also show.
    pub label: &'static str,
    /// The duration in milliseconds.
    pub gpu_ms: f64,
    /// The begin of the pass, in nanoseconds of the GPU's clock ([`crate::Clocks`]).
    pub began_ns: u64,
}

/// The time of a frame on the GPU, from [`Frame::begin_timing`](crate::Frame::begin_timing) to its
/// end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameTime {
    /// The tick of the frame.
    pub tick: Tick,
    /// The duration in milliseconds.
    pub gpu_ms: f64,
}

/// Timestamps of one frame slot.
pub(crate) struct PassTimer {
    device: Device,
    pool: vk::QueryPool,
    results: Buffer,
    // Shared by a slot and its commands, which move between threads together.
    labels: Mutex<Vec<&'static str>>,
    is_inside: AtomicBool,
    ns_per_step: f64,
    mask: u64,
    needs_full_barriers: bool,
    /// The most passes that are timed; further ones are not.
    passes: u32,
}

/// The most passes of a frame that are timed; further ones are not.
pub(crate) const PASSES: u32 = 512;

impl PassTimer {
    /// Creates a timer with room for `passes` passes.
    pub(crate) fn new(device: &Device, name: &str, passes: u32) -> Result<Self, Error> {
        let size_bytes = u64::from(2 * passes) * 8;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let results = Buffer::new(device, name, size_bytes, usage, MemoryKind::ReadBack)?;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(2 * passes);
        // SAFETY: a plain query pool.
        let pool = unsafe { device.raw().create_query_pool(&info, device.callbacks()) }
            .called("vkCreateQueryPool")?;
        device.name(pool, name);
        let adapter = device.adapter();
        Ok(Self {
            device: device.clone(),
            pool,
            results,
            labels: Mutex::new(Vec::new()),
            is_inside: AtomicBool::new(false),
            ns_per_step: f64::from(adapter.limits.timestamp_period),
            mask: u64::MAX >> (64 - adapter.timestamp_bits.clamp(1, 64)),
            needs_full_barriers: adapter.is_software(),
            passes,
        })
    }

    /// Reads the times of the slot's last frame, which was submitted and is over.
    pub(crate) fn read(&self, times: &mut Vec<PassTime>) {
        times.clear();
        let stamps = self.results.read::<u64>(0..2 * self.passes as usize);
        for (label, pair) in lock(&self.labels).iter().zip(stamps.as_chunks::<2>().0) {
            let began_ns = ((pair[0] & self.mask) as f64 * self.ns_per_step) as u64;
            times.push(PassTime { label, gpu_ms: self.between_ms(pair), began_ns });
        }
    }

    /// Returns the time between the stamps of the first pass of a frame that is over.
    pub(crate) fn span_ms(&self) -> Option<f64> {
        let stamps = self.results.read::<u64>(0..2);
        let pair = stamps.first_chunk::<2>().filter(|_| !lock(&self.labels).is_empty())?;
        Some(self.between_ms(pair))
    }

    fn between_ms(&self, pair: &[u64; 2]) -> f64 {
        let [begin, end] = pair.map(|stamp| stamp & self.mask);
        let steps = end.wrapping_sub(begin) & self.mask;
        steps as f64 * self.ns_per_step * 1e-6
    }

    /// Resets the timestamps. The tick of the slot's last frame must be over.
    pub(crate) fn reset(&self, commands: &Commands) {
        lock(&self.labels).clear();
        self.is_inside.store(false, Ordering::Relaxed);
        reset_queries(&self.device, commands, self.pool, 2 * self.passes);
    }

    /// Begins a pass, unless it lies within another pass.
    pub(crate) fn begin(&self, commands: vk::CommandBuffer, label: &'static str) -> bool {
        if self.is_inside.swap(true, Ordering::Relaxed) {
            return false;
        }
        let mut labels = lock(&self.labels);
        labels.push(label);
        if labels.len() <= self.passes as usize {
            self.stamp(commands, 2 * (labels.len() as u32 - 1));
        }
        true
    }

    /// Ends the pass that was begun last.
    pub(crate) fn end(&self, commands: vk::CommandBuffer) {
        self.is_inside.store(false, Ordering::Relaxed);
        let passes = lock(&self.labels).len() as u32;
        if passes <= self.passes {
            self.stamp(commands, 2 * passes - 1);
        }
    }

    /// Copies the stamps to mapped memory. Must be the last command of a frame.
    pub(crate) fn read_back(&self, commands: vk::CommandBuffer) {
        let stamps = 2 * (lock(&self.labels).len() as u32).min(self.passes);
        if stamps == 0 {
            return;
        }
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        let to = self.results.whole();
        // SAFETY: these queries were written in this frame; the buffer is large enough.
        unsafe {
            self.device.raw().cmd_copy_query_pool_results(
                commands,
                self.pool,
                0,
                stamps,
                to.raw,
                to.offset_bytes,
                8,
                flags,
            );
        }
    }

    fn stamp(&self, commands: vk::CommandBuffer, query: u32) {
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        if self.needs_full_barriers {
            self.full_barrier(commands);
        }
        // SAFETY: the query was reset at the start of this frame.
        unsafe {
            self.device.raw().cmd_write_timestamp2(commands, all, self.pool, query);
        }
        if self.needs_full_barriers {
            self.full_barrier(commands);
        }
    }

    /// Records a full barrier, because lavapipe shifts a timestamp by one pass unless everything is
    /// flushed before and after it.
    fn full_barrier(&self, commands: vk::CommandBuffer) {
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let barriers = [vk::MemoryBarrier2::default().src_stage_mask(all).dst_stage_mask(all)];
        let info = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: recorded outside of rendering, like passes.
        unsafe { self.device.raw().cmd_pipeline_barrier2(commands, &info) };
    }
}

/// A timer of whole frames of one slot, if requested.
#[derive(Default)]
pub(crate) struct FrameTimer {
    timer: Option<PassTimer>,
    stage: Stage,
    newest: Option<FrameTime>,
}

/// The state of a timer of whole frames.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum Stage {
    #[default]
    Idle,
    /// A timed frame being recorded.
    Begun,
    /// A timed frame that was submitted.
    Submitted,
}

impl FrameTimer {
    /// Creates a frame timer that measures with `timer`, which needs room for one pass.
    pub(crate) fn new(timer: PassTimer) -> Self {
        Self { timer: Some(timer), ..Self::default() }
    }

    /// Returns the time of the slot's last frame, if it was timed.
    pub(crate) fn newest(&self) -> Option<FrameTime> {
        self.newest
    }

    /// Reads the time of the slot's frame with this tick, which must be over.
    pub(crate) fn read(&mut self, tick: Tick) {
        let stage = std::mem::take(&mut self.stage);
        self.newest = match &self.timer {
            Some(timer) if stage == Stage::Submitted => {
                timer.span_ms().map(|gpu_ms| FrameTime { tick, gpu_ms })
            }
            _ => None,
        };
    }

    /// Discards the slot's frame, which never ran.
    pub(crate) fn forget(&mut self) {
        self.stage = Stage::Idle;
    }

    pub(crate) fn begin(&mut self, commands: &Commands) {
        if let (Some(timer), Stage::Idle) = (&self.timer, self.stage) {
            timer.reset(commands);
            timer.begin(commands.raw(), "frame");
            self.stage = Stage::Begun;
        }
    }

    /// Ends the timing, if it was begun. Returns true if stamps are copied for the host.
    pub(crate) fn end(&mut self, commands: vk::CommandBuffer) -> bool {
        let Some(timer) = self.timer.as_ref().filter(|_| self.stage == Stage::Begun) else {
            return false;
        };
        timer.end(commands);
        timer.read_back(commands);
        true
    }

    /// Notes that the frame being timed was submitted.
    pub(crate) fn submitted(&mut self) {
        if self.stage == Stage::Begun {
            self.stage = Stage::Submitted;
        }
    }
}

impl Drop for PassTimer {
    fn drop(&mut self) {
        self.device.retire(Retired::QueryPool(self.pool));
    }
}
