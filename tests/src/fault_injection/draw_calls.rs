//! Counts the calls that draw with a count buffer.

use std::ffi::CStr;
use std::mem::transmute;

use ash::vk;

use super::lies::DRAW;
use super::{Function, Lie, barriers, due, injected, real};

/// The call that reads the number of its indirect commands from a buffer.
pub const CALL_THAT_COUNTS_DRAWS: &CStr = c"vkCmdDrawIndexedIndirectCount";

pub(super) fn calls_that_draw() -> Vec<(&'static CStr, Function)> {
    type Call = vk::PFN_vkCmdDrawIndexedIndirectCount;
    // SAFETY: a function pointer, and the caller knows the type by the name.
    vec![(CALL_THAT_COUNTS_DRAWS, unsafe { transmute::<Call, Function>(draw_counted) })]
}

unsafe extern "system" fn draw_counted(
    commands: vk::CommandBuffer,
    buffer: vk::Buffer,
    offset: vk::DeviceSize,
    count_buffer: vk::Buffer,
    count_offset: vk::DeviceSize,
    most: u32,
    stride: u32,
) {
    due(CALL_THAT_COUNTS_DRAWS);
    barriers::read_draws();
    // SAFETY: the types belong to the functions. The caller passes valid arguments for the counted
    // function, and the plain one takes the same commands.
    unsafe {
        if injected(|injected| injected.lie == Some(Lie::NoCounts)) {
            let plain = real::<vk::PFN_vkCmdDrawIndexedIndirect>(DRAW);
            return plain(commands, buffer, offset, most, stride);
        }
        real::<vk::PFN_vkCmdDrawIndexedIndirectCount>(CALL_THAT_COUNTS_DRAWS)(
            commands,
            buffer,
            offset,
            count_buffer,
            count_offset,
            most,
            stride,
        );
    }
}
