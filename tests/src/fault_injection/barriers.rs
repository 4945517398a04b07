//! Barriers that no validation layer misses: before results become predicates, before draws that
//! fragments enabled, before the CPU reads, and before streams overwrite what earlier frames read.
//! Follows the commands of one thread in their order.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ffi::{CStr, c_char};
use std::mem::{take, transmute};

use ash::vk;

use super::{Function, injected, real};

const COPY: &CStr = c"vkCmdCopyBuffer";
const LABEL: &CStr = c"vkCmdBeginDebugUtilsLabelEXT";

/// The reads behind such barriers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GuardedReads {
    /// The number of predicates that conditional rendering read.
    pub predicates: usize,
    /// The number of times that fragments enabled draws.
    pub enabled: usize,
    /// The number of copies between buffers.
    pub copies: usize,
    /// The number of passes that stream meshes and textures.
    pub streams: usize,
    /// The reads, and the writes of streams, that had no barrier before them.
    pub unguarded: BTreeSet<&'static str>,
}

#[derive(Default)]
struct Recorder {
    reads: GuardedReads,
    has_new_results: bool,
    has_new_draws: bool,
    has_new_copies: bool,
    /// True in a pass that streams, until earlier reads are over.
    is_stream_unguarded: bool,
}

thread_local! {
    static RECORDER: RefCell<Recorder> = RefCell::default();
}

/// Returns the reads of the commands that this thread recorded since the last call. What was copied
/// last must be visible to the CPU.
pub fn guarded_reads() -> GuardedReads {
    RECORDER.with_borrow_mut(|recorder| {
        if recorder.has_new_copies {
            recorder.reads.unguarded.insert("the CPU reads a copy");
        }
        take(recorder).reads
    })
}

/// Calls `note` with the recorder if the machine records.
fn record(note: impl FnOnce(&mut Recorder)) {
    if injected(|injected| injected.records_barriers) {
        RECORDER.with_borrow_mut(note);
    }
}

/// Notes that results were written that may become predicates.
pub(super) fn wrote_results() {
    record(|recorder| recorder.has_new_results = true);
}

/// Notes that conditional rendering begins.
pub(super) fn read_predicate() {
    record(|recorder| {
        recorder.reads.predicates += 1;
        if recorder.has_new_results {
            recorder.reads.unguarded.insert("conditional rendering reads a result");
        }
    });
}

/// Notes that the commands of draws are read from a buffer.
pub(super) fn read_draws() {
    record(|recorder| {
        if recorder.has_new_draws {
            recorder.reads.unguarded.insert("a draw reads what fragments enabled");
        }
    });
}

/// Notes a barrier.
///
/// # Safety
/// The barriers are valid, as those of a call.
pub(super) unsafe fn passed(info: &vk::DependencyInfo<'_>) {
    let barriers = match info.memory_barrier_count {
        0 => &[],
        // SAFETY: the caller vouches for them.
        count => unsafe { std::slice::from_raw_parts(info.p_memory_barriers, count as usize) },
    };
    record(|recorder| {
        for barrier in barriers {
            let reads = |access| barrier.dst_access_mask.contains(access);
            let from_shaders =
                barrier.src_access_mask.contains(vk::AccessFlags2::SHADER_STORAGE_WRITE);
            let is_indirect = reads(vk::AccessFlags2::INDIRECT_COMMAND_READ);
            recorder.has_new_results &= !reads(vk::AccessFlags2::CONDITIONAL_RENDERING_READ_EXT);
            recorder.has_new_draws &= !(from_shaders && is_indirect);
            recorder.has_new_copies &= !reads(vk::AccessFlags2::HOST_READ);
            recorder.is_stream_unguarded &= !reads(vk::AccessFlags2::TRANSFER_WRITE);
        }
    });
}

pub(super) fn calls_that_write() -> Vec<(&'static CStr, Function)> {
    // SAFETY: all are function pointers, and the caller knows the type by the name.
    unsafe {
        vec![
            (COPY, transmute::<vk::PFN_vkCmdCopyBuffer, Function>(copy_buffer)),
            (LABEL, transmute::<vk::PFN_vkCmdBeginDebugUtilsLabelEXT, Function>(begin_label)),
        ]
    }
}

unsafe extern "system" fn copy_buffer(
    commands: vk::CommandBuffer,
    from: vk::Buffer,
    to: vk::Buffer,
    count: u32,
    regions: *const vk::BufferCopy,
) {
    record(|recorder| {
        recorder.reads.copies += 1;
        recorder.has_new_copies = true;
        if recorder.is_stream_unguarded {
            recorder.reads.unguarded.insert("a stream overwrites what frames in flight read");
        }
    });
    // SAFETY: here and below: the type belongs to the function, and the caller passes valid
    // arguments for it.
    unsafe { real::<vk::PFN_vkCmdCopyBuffer>(COPY)(commands, from, to, count, regions) }
}

unsafe extern "system" fn begin_label(
    commands: vk::CommandBuffer,
    info: *const vk::DebugUtilsLabelEXT<'_>,
) {
    // SAFETY: as above; a label ends with a zero.
    unsafe {
        let label: *const c_char = (*info).p_label_name;
        match CStr::from_ptr(label).to_bytes() {
            b"proxies" => wrote_results(),
            b"leaf boxes" => record(|recorder| {
                recorder.reads.enabled += 1;
                recorder.has_new_draws = true;
            }),
            b"stream meshes and textures" => record(|recorder| {
                recorder.reads.streams += 1;
                recorder.is_stream_unguarded = true;
            }),
            _ => {}
        }
        real::<vk::PFN_vkCmdBeginDebugUtilsLabelEXT>(LABEL)(commands, info);
    }
}
