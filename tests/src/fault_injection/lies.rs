//! The commands of a driver that does not do what the commands say.

use std::ffi::CStr;
use std::mem::transmute;

use ash::vk;

use super::{Function, Lie, barriers, due, injected, real};

/// Counts the blocks of conditional rendering of a [`FaultInjection`](super::FaultInjection).
pub const CONDITIONAL_BLOCKS: &CStr = c"vkCmdBeginConditionalRenderingEXT";

const COPY: &CStr = c"vkCmdCopyQueryPoolResults";
const BEGIN: &CStr = CONDITIONAL_BLOCKS;
const END: &CStr = c"vkCmdEndConditionalRenderingEXT";
pub(super) const DRAW: &CStr = c"vkCmdDrawIndexedIndirect";
const DISPATCH: &CStr = c"vkCmdDispatch";

/// Returns the replacements of all these commands.
pub(super) fn lies() -> Vec<(&'static CStr, Function)> {
    // SAFETY: all are function pointers, and the caller knows the type by the name.
    unsafe {
        vec![
            (COPY, transmute::<vk::PFN_vkCmdCopyQueryPoolResults, Function>(copy_results)),
            (BEGIN, transmute::<vk::PFN_vkCmdBeginConditionalRenderingEXT, Function>(begin)),
            (END, transmute::<vk::PFN_vkCmdEndConditionalRenderingEXT, Function>(end)),
            (DRAW, transmute::<vk::PFN_vkCmdDrawIndexedIndirect, Function>(draw)),
            (DISPATCH, transmute::<vk::PFN_vkCmdDispatch, Function>(dispatch)),
        ]
    }
}

fn is(lie: Lie) -> bool {
    injected(|injected| injected.lie == Some(lie))
}

unsafe extern "system" fn copy_results(
    commands: vk::CommandBuffer,
    pool: vk::QueryPool,
    first: u32,
    count: u32,
    buffer: vk::Buffer,
    offset: vk::DeviceSize,
    stride: vk::DeviceSize,
    flags: vk::QueryResultFlags,
) {
    barriers::wrote_results();
    // SAFETY: here and in all functions below: the type belongs to the function, and the caller
    // passes valid arguments for it.
    unsafe {
        let real = real::<vk::PFN_vkCmdCopyQueryPoolResults>(COPY);
        if !is(Lie::FirstResultForAll) {
            return real(commands, pool, first, count, buffer, offset, stride, flags);
        }
        for place in 0..u64::from(count) {
            real(commands, pool, first, 1, buffer, offset + place * stride, stride, flags);
        }
    }
}

unsafe extern "system" fn begin(
    commands: vk::CommandBuffer,
    info: *const vk::ConditionalRenderingBeginInfoEXT<'_>,
) {
    due(BEGIN);
    barriers::read_predicate();
    if !is(Lie::NoConditions) {
        // SAFETY: as above.
        unsafe { real::<vk::PFN_vkCmdBeginConditionalRenderingEXT>(BEGIN)(commands, info) }
    }
}

unsafe extern "system" fn end(commands: vk::CommandBuffer) {
    if !is(Lie::NoConditions) {
        // SAFETY: as above.
        unsafe { real::<vk::PFN_vkCmdEndConditionalRenderingEXT>(END)(commands) }
    }
}

unsafe extern "system" fn draw(
    commands: vk::CommandBuffer,
    buffer: vk::Buffer,
    offset: vk::DeviceSize,
    count: u32,
    stride: u32,
) {
    barriers::read_draws();
    // SAFETY: as above.
    unsafe {
        let real = real::<vk::PFN_vkCmdDrawIndexedIndirect>(DRAW);
        if !is(Lie::LastDrawFirst) {
            return real(commands, buffer, offset, count, stride);
        }
        for place in (0..u64::from(count)).rev() {
            real(commands, buffer, offset + place * u64::from(stride), 1, stride);
        }
    }
}

unsafe extern "system" fn dispatch(commands: vk::CommandBuffer, x: u32, y: u32, z: u32) {
    if !is(Lie::NoDispatches) {
        // SAFETY: as above.
        unsafe { real::<vk::PFN_vkCmdDispatch>(DISPATCH)(commands, x, y, z) }
    }
}
