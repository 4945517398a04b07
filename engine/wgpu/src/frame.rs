//! A frame that is encoded: its draws as lists, and its tests as command buffers.

use std::sync::Arc;

use gpu::BufferSlice;
use occlusion::{BucketId, DrawList};
use wgpu::hal::{api::Vulkan, vulkan};

use crate::device::DeviceParts;
use crate::frame_log::FrameGuard;

/// The draws and the tests of one view in one frame. [`WgpuFrame::submit`] puts them in order.
///
/// A frame that is dropped instead was never drawn; later frames are right without it.
#[must_use = "a frame that is not submitted draws nothing"]
pub struct WgpuFrame {
    visible: Vec<WgpuDraws>,
    revealed: Vec<WgpuDraws>,
    tests: [wgpu::CommandBuffer; 2],
    guard: FrameGuard,
    // Dropped after the commands, which use objects of the device.
    _parts: Arc<DeviceParts>,
}

/// The indirect draws of one bucket: a list of commands that the engine writes.
pub struct WgpuDraws {
    /// The pipeline that draws them.
    pub bucket: BucketId,
    commands: Part,
    most: u32,
    count: Option<Part>,
}

/// A part of a buffer from an offset on.
struct Part {
    buffer: wgpu::Buffer,
    offset_bytes: u64,
}

impl WgpuFrame {
    pub(crate) fn new(
        parts: &Arc<DeviceParts>,
        tests: [wgpu::CommandBuffer; 2],
        lists: [&[DrawList]; 2],
        guard: FrameGuard,
    ) -> Self {
        let buffers = ListBuffers::of(&parts.device, lists, &guard);
        let [visible, revealed] = lists.map(|lists| buffers.draws(lists));
        Self { visible, revealed, tests, guard, _parts: Arc::clone(parts) }
    }

    /// Returns the draws of the first render pass, which clears the depth: what is taken as
    /// visible, in the order of the buckets.
    #[must_use]
    pub fn visible(&self) -> &[WgpuDraws] {
        &self.visible
    }

    /// Returns the draws of the second render pass, which loads colours and depth: what the tests
    /// reveal.
    #[must_use]
    pub fn revealed(&self) -> &[WgpuDraws] {
        &self.revealed
    }

    /// Submits the frame: `first`, which ends with the pass of the visible draws, then the tests,
    /// then `second`, which begins with the pass of the revealed draws.
    pub fn submit(
        self,
        queue: &wgpu::Queue,
        first: impl IntoIterator<Item = wgpu::CommandBuffer>,
        second: impl IntoIterator<Item = wgpu::CommandBuffer>,
    ) -> wgpu::SubmissionIndex {
        let submission = queue.submit(first.into_iter().chain(self.tests).chain(second));
        self.guard.submitted(&submission);
        submission
    }

    /// Returns the command buffers of the tests, for a program whose submits are made elsewhere.
    ///
    /// # Safety
    /// Both are submitted in one submit, in this order and with nothing of wgpu between them, or
    /// never. The pass of the visible draws lies before them and that of the revealed draws behind
    /// them.
    pub unsafe fn into_tests(self) -> [wgpu::CommandBuffer; 2] {
        self.tests
    }
}

impl WgpuDraws {
    /// Draws the list. The pipeline of the bucket, the vertex buffers and an index buffer are set.
    ///
    /// # Safety
    /// The commands of the draws in this bucket lie within the index buffer and the vertex buffers
    /// that are set, since wgpu does not check them. The pass is part of the `first` command
    /// buffers of [`WgpuFrame::submit`] for visible draws, and of the `second` for revealed ones,
    /// whose commands are undefined before.
    pub unsafe fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        let Self { commands, most, count, .. } = self;
        match count {
            Some(count) => pass.multi_draw_indexed_indirect_count(
                &commands.buffer,
                commands.offset_bytes,
                &count.buffer,
                count.offset_bytes,
                *most,
            ),
            None => {
                pass.multi_draw_indexed_indirect(&commands.buffer, commands.offset_bytes, *most)
            }
        }
    }
}

/// The buffers of all lists of a frame as wgpu sees them: lists lie in the same few buffers.
struct ListBuffers {
    buffers: Vec<ListBuffer>,
}

struct ListBuffer {
    raw: gpu::vk::Buffer,
    buffer: wgpu::Buffer,
}

/// The part of a buffer that lists use, from its beginning on.
struct UsedBuffer {
    raw: gpu::vk::Buffer,
    size_bytes: u64,
}

impl ListBuffers {
    fn of(device: &wgpu::Device, lists: [&[DrawList]; 2], guard: &FrameGuard) -> Self {
        let mut used: Vec<UsedBuffer> = Vec::new();
        for slice in lists.into_iter().flatten().filter(|list| list.most > 0).flat_map(slices) {
            let end = slice.offset_bytes + slice.size_bytes;
            match used.iter_mut().find(|other| other.raw == slice.raw()) {
                Some(other) => other.size_bytes = other.size_bytes.max(end),
                None => used.push(UsedBuffer { raw: slice.raw(), size_bytes: end }),
            }
        }
        let import = |UsedBuffer { raw, size_bytes }: UsedBuffer| {
            let part = guard.clone();
            let descriptor = wgpu::BufferDescriptor {
                label: Some("antumbra draws"),
                size: size_bytes,
                usage: wgpu::BufferUsages::INDIRECT,
                mapped_at_creation: false,
            };
            // SAFETY: the engine's buffer has this size and usage, and lives until the frame is
            // over: that is when wgpu has dropped this buffer, and the part of the guard with it.
            let buffer = unsafe {
                let imported =
                    vulkan::Buffer::from_raw_externally_owned(raw, Box::new(move || drop(part)));
                device.create_buffer_from_hal::<Vulkan>(imported, &descriptor)
            };
            ListBuffer { raw, buffer }
        };
        Self { buffers: used.into_iter().map(import).collect() }
    }

    fn draws(&self, lists: &[DrawList]) -> Vec<WgpuDraws> {
        let draws = |list: &DrawList| {
            Some(WgpuDraws {
                bucket: list.bucket,
                commands: self.part(list.commands)?,
                most: list.most,
                count: match list.count {
                    Some(count) => Some(self.part(count)?),
                    None => None,
                },
            })
        };
        lists.iter().filter(|list| list.most > 0).filter_map(draws).collect()
    }

    fn part(&self, slice: BufferSlice) -> Option<Part> {
        let found = self.buffers.iter().find(|buffer| buffer.raw == slice.raw())?;
        Some(Part { buffer: found.buffer.clone(), offset_bytes: slice.offset_bytes })
    }
}

/// Returns the parts of buffers that a list lies in.
fn slices(list: &DrawList) -> impl Iterator<Item = BufferSlice> {
    [Some(list.commands), list.count].into_iter().flatten()
}
