//! The draws of a frame as lists, for hosts that record them themselves.

use gpu::vk;
use occlusion::{DrawList, OcclusionState};

use crate::layout::{Versioned, layout, versioned};

/// The executor draws: it calls the host to bind what the draws of a bucket need.
pub const ANTUMBRA_DRAWS_BY_CALLBACK: u32 = 0;
/// The host draws from lists, before and after the tests that the executor records.
pub const ANTUMBRA_DRAWS_BY_LISTS: u32 = 1;

/// The indexed indirect draws of one bucket: for `vkCmdDrawIndexedIndirectCount`, or
/// `vkCmdDrawIndexedIndirect` without a count.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraDrawList {
    /// The bucket.
    pub bucket: u32,
    /// The largest number of commands, above 0: `VkDrawIndexedIndirectCommand`s without gaps.
    pub most: u32,
    /// The buffer of the commands.
    pub commands: vk::Buffer,
    /// The offset of the first command in bytes.
    pub commands_offset: u64,
    /// The buffer of the number of commands, 32 bits. Null if the device does not support draw
    /// counts: then all `most` commands are drawn, and some of them are empty.
    pub count: vk::Buffer,
    /// The offset of the number in bytes.
    pub count_offset: u64,
}
layout!(AntumbraDrawList: bucket, most, commands, commands_offset, count, count_offset);

impl From<&DrawList> for AntumbraDrawList {
    fn from(list: &DrawList) -> Self {
        Self {
            bucket: list.bucket.0,
            most: list.most,
            commands: list.commands.raw(),
            commands_offset: list.commands.offset_bytes,
            count: list.count.map_or(vk::Buffer::null(), |count| count.raw()),
            count_offset: list.count.map_or(0, |count| count.offset_bytes),
        }
    }
}

/// The draws of a view in the newest frame, a list per bucket, in the order of their buckets.
///
/// The order on the queue is: the visible draws, in renderings of the host that clear; the command
/// buffer of the frame; the revealed draws, in renderings that keep the contents. The buffers live
/// until the frame is over.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraDrawLists {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Is 0.
    pub reserved: u32,
    /// The draws that are assumed to be visible. Valid until the view is recorded again.
    pub visible: *const AntumbraDrawList,
    /// The number of their lists.
    pub visible_count: usize,
    /// The draws that the tests of the frame reveal. Valid until the view is recorded again.
    pub revealed: *const AntumbraDrawList,
    /// The number of their lists.
    pub revealed_count: usize,
}
layout!(AntumbraDrawLists: struct_size, reserved, visible, visible_count, revealed, revealed_count);

versioned!(AntumbraDrawLists: 6, required: [], defaults: {});

/// The lists of a view as C reads them.
#[derive(Default)]
pub(crate) struct KeptLists {
    visible: Vec<AntumbraDrawList>,
    revealed: Vec<AntumbraDrawList>,
}

impl KeptLists {
    /// Removes the lists of an earlier frame.
    pub fn clear(&mut self) {
        self.visible.clear();
        self.revealed.clear();
    }

    /// Copies the lists of the newest frame.
    pub fn update(&mut self, state: &OcclusionState) {
        let lists = [state.visible_lists(), state.revealed_lists()];
        for (kept, lists) in [&mut self.visible, &mut self.revealed].into_iter().zip(lists) {
            kept.clear();
            kept.extend(lists.iter().map(AntumbraDrawList::from));
        }
    }

    /// Returns the lists, as pointers into `self`.
    pub fn described(&self) -> AntumbraDrawLists {
        let Self { visible, revealed } = self;
        AntumbraDrawLists {
            visible: visible.as_ptr(),
            visible_count: visible.len(),
            revealed: revealed.as_ptr(),
            revealed_count: revealed.len(),
            ..AntumbraDrawLists::INIT
        }
    }
}
