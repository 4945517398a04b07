//! The fragments of transparent objects, in a list per pixel (`fragments.glsl`).
//!
//! ```text
//! clear    the lists of the view: none has a fragment
//! store    the objects in any order, against the finished depth: what passes is added to the list
//!          of its pixel
//! sort     each list by depth, over the image
//! ```
//!
//! Fragments that opaque objects hide are not stored. So culling affects only the order of the
//! lists, which does not matter.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{
    Access, Buffer, BufferSlice, Commands, Device, FlagRing, Frame, MemoryBarrier, MemoryKind,
    ResultSource, Tick, vk,
};

use crate::error::Error;
use crate::passes::FragmentIo;
use crate::shading::transparency::{
    FragmentCounts, TransparencyMethod, TransparencyOptions, fallback_of,
};

/// The number of counts of a frame, the fields of [`FragmentCounts`].
const COUNTS: usize = 3;

const FRAGMENT_BYTES: u64 = 16;

/// The head of the buffer; mirrors `fragments.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct FragmentsHead {
    stored: u32,
    origin: [u32; 2],
    width: u32,
    first_fragment: u32,
    room: u32,
    blended_most: u32,
    unused: u32,
}

const HEAD_BYTES: u64 = size_of::<FragmentsHead>() as u64;
const _: () = assert!(HEAD_BYTES == 32);

/// The layout of the buffer for images of a given number of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PoolLayout {
    /// The size of the head and of the lists.
    lists_end_bytes: u64,
    /// The number of fragments that there is room for.
    room: u64,
}

impl PoolLayout {
    /// Returns the layout; `None` if even the lists do not fit into a buffer.
    fn of(pixels: u64, fragments_per_pixel: u32, limit_bytes: u64) -> Option<Self> {
        // The offset of a fragment is a multiple of its size.
        let lists_end_bytes = (HEAD_BYTES + pixels * 4).next_multiple_of(FRAGMENT_BYTES);
        let left_bytes = limit_bytes.checked_sub(lists_end_bytes)?;
        let room = pixels.saturating_mul(fragments_per_pixel.into());
        Some(Self { lists_end_bytes, room: room.min(left_bytes / FRAGMENT_BYTES) })
    }

    fn bytes(&self) -> u64 {
        self.lists_end_bytes + self.room * FRAGMENT_BYTES
    }
}

/// The view being recorded.
#[derive(Clone, Copy)]
struct ViewFragments {
    head: BufferSlice,
    /// The lists without fragments.
    lists: BufferSlice,
}

/// The fragments of the transparent objects of a renderer, and the counts of its frames.
pub(crate) struct Fragments {
    device: Device,
    options: TransparencyOptions,
    frames_in_flight: usize,
    pool: Option<Buffer>,
    view: Option<ViewFragments>,
    ring: Option<FlagRing<()>>,
    is_counting: bool,
    newest: FragmentCounts,
}

impl Fragments {
    /// Returns `None` unless fragments are to be sorted and the device supports it with this number
    /// of samples per pixel.
    pub(crate) fn new(
        device: &Device,
        options: TransparencyOptions,
        samples: vk::SampleCountFlags,
        frames_in_flight: usize,
    ) -> Option<Self> {
        let is_wanted = options.method == TransparencyMethod::SortedFragments;
        if !is_wanted || fallback_of(device, samples).is_some() {
            return None;
        }
        Some(Self {
            device: device.clone(),
            options,
            frames_in_flight,
            pool: None,
            view: None,
            ring: None,
            is_counting: false,
            newest: FragmentCounts::default(),
        })
    }

    /// Returns true if the lists of images of this size fit into a buffer.
    pub(crate) fn has_room_for(&self, size: [u32; 2]) -> bool {
        self.layout(size).is_some()
    }

    fn layout(&self, size: [u32; 2]) -> Option<PoolLayout> {
        let limit_bytes = self.device.adapter().limits.max_storage_buffer_range.into();
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        PoolLayout::of(pixels, self.options.fragments_per_pixel, limit_bytes)
    }

    /// Reads the counts of frames that are over. Never waits.
    pub(crate) fn collect(&mut self, completed: Tick) {
        let Self { ring: Some(ring), newest, .. } = self else { return };
        ring.collect(completed, |_, counts| {
            if let [visible, without_room, left_out] = *counts {
                *newest = FragmentCounts { visible, without_room, left_out };
            }
        });
    }

    /// Begins the counts of a frame.
    pub(crate) fn begin_frame(&mut self, frame: &Frame<'_>) -> Result<(), Error> {
        self.view = None;
        self.is_counting = false;
        self.collect(self.device.completed()?);
        let ring = self.ring.get_or_insert_with(|| {
            let source = ResultSource::Fragments;
            FlagRing::new(&self.device, self.frames_in_flight, source, "fragment counts")
        });
        ring.begin(frame, std::iter::repeat_n((), COUNTS))?;
        self.is_counting = true;
        let cleared = MemoryBarrier::between(&[Access::CopyWrite], &[Access::FragmentWrite]);
        frame.commands().barrier(cleared);
        Ok(())
    }

    /// Begins a view of the frame. The view has no lists if they do not fit into a buffer.
    pub(crate) fn begin_view(
        &mut self,
        frame: &mut Frame<'_>,
        view: &CullView,
    ) -> Result<(), Error> {
        self.view = None;
        let Some(layout) = self.layout(view.size) else { return Ok(()) };
        let kept = self.pool.take().filter(|pool| pool.size_bytes() >= layout.bytes());
        let pool = match kept {
            Some(pool) => pool,
            None => {
                let usage =
                    vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
                let bytes = layout.bytes();
                Buffer::new(&self.device, "fragments", bytes, usage, MemoryKind::Device)?
            }
        };
        let pool = self.pool.insert(pool);
        let head = FragmentsHead {
            stored: 0,
            origin: view.origin,
            width: view.size[0],
            first_fragment: (layout.lists_end_bytes / 4) as u32,
            room: layout.room as u32,
            blended_most: self.options.blended_most.max(1),
            unused: 0,
        };
        let head = frame.uploads().push(&[head])?;
        let lists = pool.whole().part(HEAD_BYTES, layout.lists_end_bytes - HEAD_BYTES);
        self.view = Some(ViewFragments { head, lists });
        Ok(())
    }

    /// Returns the buffers for the passes of the current view; `None` if objects are sorted.
    pub(crate) fn io(&self) -> Option<FragmentIo> {
        self.view?;
        let fragments = self.pool.as_ref()?.whole();
        Some(FragmentIo { fragments, counts: self.ring.as_ref()?.results()? })
    }

    /// Clears the lists of the current view. Outside of rendering.
    pub(crate) fn clear(&self, commands: &Commands) {
        let (Some(view), Some(pool)) = (&self.view, &self.pool) else { return };
        let between = MemoryBarrier::between;
        // The previous view or frame may still be sorting.
        commands.barrier(between(&[Access::FragmentWrite], &[Access::CopyWrite]));
        commands.copy_buffer(view.head, pool.whole().part(0, HEAD_BYTES));
        commands.fill(view.lists, 0);
        // The counts of the previous view are added to.
        let before = [Access::CopyWrite, Access::FragmentWrite];
        commands.barrier(between(&before, &[Access::FragmentWrite]));
    }

    /// Records the last commands of a frame.
    pub(crate) fn read_back(&self, commands: &Commands) {
        if let Some(ring) = self.ring.as_ref().filter(|_| self.is_counting) {
            ring.read_back(commands);
        }
    }

    /// Notes that the frame was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        if let Some(ring) = self.ring.as_mut().filter(|_| self.is_counting) {
            ring.submitted(tick);
        }
        self.is_counting = false;
    }

    /// Changes the number of frames in flight.
    pub(crate) fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        self.frames_in_flight = frames_in_flight;
        self.ring = None;
    }

    /// Returns the counts of the newest frame whose results were read.
    pub(crate) fn newest(&self) -> FragmentCounts {
        self.newest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_what_is_asked_for_within_the_limit_of_the_device() {
        let of = |pixels, limit_bytes| PoolLayout::of(pixels, 4, limit_bytes);
        let padded = PoolLayout { lists_end_bytes: 80, room: 40 };
        assert_eq!(of(10, 1 << 20), Some(padded));
        assert_eq!(padded.bytes(), 80 + 640);
        assert_eq!(of(10, 80 + 50), Some(PoolLayout { room: 3, ..padded }));
        assert_eq!(of(10, 80), Some(PoolLayout { room: 0, ..padded }));
        assert_eq!(of(10, 79), None);
        assert!(of(u64::from(u32::MAX), u64::from(u32::MAX)).is_none());
    }
}
