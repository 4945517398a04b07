//! The attempts to get memory, in their order, as pure values.

use ash::vk;
use gpu_allocator::MemoryLocation;

/// The kinds of blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scheme {
    /// A part of a block; a new block if none has room.
    SharedBlock,
    /// A block of exactly the requested size.
    OwnBlock,
}

/// An attempt to get memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Attempt {
    pub(crate) scheme: Scheme,
    /// A bit for each memory type that is possible; the first suitable one is taken.
    pub(crate) type_bits: u32,
    pub(crate) location: MemoryLocation,
    /// True for host memory in place of device memory.
    pub(crate) is_slower: bool,
}

impl Attempt {
    /// Returns the attempt that succeeds unless memory is short.
    pub(crate) fn plain(type_bits: u32, location: MemoryLocation) -> Self {
        Self { scheme: Scheme::SharedBlock, type_bits, location, is_slower: false }
    }
}

/// The memory types and heaps of a device.
pub(crate) struct MemoryTypes(pub(crate) vk::PhysicalDeviceMemoryProperties);

impl MemoryTypes {
    /// Returns a bit for each type with flags for which `wanted` is true.
    fn bits(&self, wanted: impl Fn(vk::MemoryPropertyFlags) -> bool) -> u32 {
        let types = (0..).zip(self.0.memory_types_as_slice());
        let types = types.filter(|(_, kind): &(u32, _)| wanted(kind.property_flags));
        types.fold(0, |bits, (number, _)| bits | 1 << number)
    }

    /// Returns a bit for each type that is allocated lazily.
    pub(crate) fn lazy(&self) -> u32 {
        self.bits(|flags| flags.contains(vk::MemoryPropertyFlags::LAZILY_ALLOCATED))
    }

    /// Returns a bit for each type of plain host memory. Types with other flags need features or
    /// belong to protected objects.
    fn host(&self) -> u32 {
        let plain = vk::MemoryPropertyFlags::HOST_VISIBLE
            | vk::MemoryPropertyFlags::HOST_COHERENT
            | vk::MemoryPropertyFlags::HOST_CACHED;
        self.bits(|flags| plain.contains(flags))
    }

    /// Returns the size of the largest heap of device memory.
    pub(crate) fn device_heap_bytes(&self) -> u64 {
        let is_local =
            |heap: &&vk::MemoryHeap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
        let local = self.0.memory_heaps_as_slice().iter().filter(is_local);
        local.map(|heap| heap.size).max().unwrap_or(u64::MAX)
    }
}

/// Returns the attempts to get memory of the types `type_bits`, in their order: a part of a block,
/// a block of exactly the size, and the same in host memory, if a type of it is possible.
pub(crate) fn attempts(
    type_bits: u32,
    location: MemoryLocation,
    types: &MemoryTypes,
) -> impl Iterator<Item = Attempt> + use<> {
    let is_slower = location == MemoryLocation::GpuOnly;
    let plain = Attempt::plain(type_bits, location);
    let host = Attempt {
        type_bits: type_bits & types.host(),
        // All other locations are mapped.
        location: if is_slower { MemoryLocation::Unknown } else { location },
        is_slower,
        ..plain
    };
    let own = |attempt| Attempt { scheme: Scheme::OwnBlock, ..attempt };
    let count = if host.type_bits == 0 { 2 } else { 4 };
    [plain, own(plain), host, own(host)].into_iter().take(count)
}

const MIB: u64 = 1 << 20;

/// Returns the sizes of the blocks of device memory and of host memory. With a budget, a block is
/// at most a sixteenth of it, since a part of each block stays empty.
pub(crate) fn block_bytes(budget_bytes: Option<u64>) -> [u64; 2] {
    // The allocator takes multiples of 4 MiB only.
    let most = budget_bytes.map_or(u64::MAX, |budget| budget / 16 / (4 * MIB) * (4 * MIB));
    [256 * MIB, 64 * MIB].map(|bytes| bytes.min(most).max(4 * MIB))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOCAL: vk::MemoryPropertyFlags = vk::MemoryPropertyFlags::DEVICE_LOCAL;
    const VISIBLE: vk::MemoryPropertyFlags = vk::MemoryPropertyFlags::HOST_VISIBLE;
    const LAZY: vk::MemoryPropertyFlags = vk::MemoryPropertyFlags::LAZILY_ALLOCATED;
    const AMD: vk::MemoryPropertyFlags = vk::MemoryPropertyFlags::DEVICE_COHERENT_AMD;

    fn types(flags: &[vk::MemoryPropertyFlags]) -> MemoryTypes {
        let mut memory = vk::PhysicalDeviceMemoryProperties::default();
        for (kind, property_flags) in memory.memory_types.iter_mut().zip(flags) {
            kind.property_flags = *property_flags;
        }
        memory.memory_type_count = flags.len() as u32;
        MemoryTypes(memory)
    }

    #[test]
    fn a_block_of_its_own_comes_before_host_memory() {
        let gpu = types(&[LOCAL, VISIBLE, LOCAL | VISIBLE, VISIBLE | AMD]);
        let all = 0b1111;
        let found: Vec<_> = attempts(all, MemoryLocation::GpuOnly, &gpu).collect();
        let plain = Attempt::plain(all, MemoryLocation::GpuOnly);
        let host = Attempt {
            type_bits: 0b10,
            location: MemoryLocation::Unknown,
            is_slower: true,
            ..plain
        };
        let own = |attempt| Attempt { scheme: Scheme::OwnBlock, ..attempt };
        assert_eq!(found, [plain, own(plain), host, own(host)]);
    }

    #[test]
    fn host_memory_is_tried_only_where_it_is_possible() {
        let gpu = types(&[LOCAL, VISIBLE]);
        let count = |bits, location| attempts(bits, location, &gpu).count();
        assert_eq!(count(0b01, MemoryLocation::GpuOnly), 2, "an image that cannot lie there");
        assert_eq!(count(0b11, MemoryLocation::GpuOnly), 4);
        let one_kind = types(&[LOCAL | VISIBLE]);
        assert_eq!(attempts(1, MemoryLocation::GpuOnly, &one_kind).count(), 2);
    }

    #[test]
    fn mapped_memory_stays_mapped_and_is_not_slower() {
        let gpu = types(&[VISIBLE | LOCAL, VISIBLE]);
        for location in [MemoryLocation::CpuToGpu, MemoryLocation::GpuToCpu] {
            let mut found = attempts(0b11, location, &gpu);
            assert!(found.all(|attempt| attempt.location == location && !attempt.is_slower));
        }
    }

    #[test]
    fn lazy_memory_is_found_among_all_types() {
        assert_eq!(types(&[LOCAL, LOCAL | LAZY, LOCAL]).lazy(), 0b10);
        assert_eq!(types(&[LOCAL, LOCAL | LAZY, LOCAL, LOCAL | LAZY]).lazy(), 0b1010);
    }

    #[test]
    fn the_largest_heap_of_device_memory_counts() {
        let mut memory =
            vk::PhysicalDeviceMemoryProperties { memory_heap_count: 3, ..Default::default() };
        for (heap, size) in memory.memory_heaps.iter_mut().zip([256 * MIB, 8192 * MIB, 16384 * MIB])
        {
            heap.size = size;
            heap.flags = vk::MemoryHeapFlags::DEVICE_LOCAL;
        }
        memory.memory_heaps[2].flags = vk::MemoryHeapFlags::empty();
        assert_eq!(MemoryTypes(memory).device_heap_bytes(), 8192 * MIB);
    }

    #[test]
    fn blocks_are_a_small_part_of_a_budget() {
        assert_eq!(block_bytes(None), [256 * MIB, 64 * MIB]);
        assert_eq!(block_bytes(Some(u64::MAX)), [256 * MIB, 64 * MIB]);
        assert_eq!(block_bytes(Some(1024 * MIB)), [64 * MIB; 2]);
        assert_eq!(block_bytes(Some(200 * MIB)), [12 * MIB; 2]);
        assert_eq!(block_bytes(Some(0)), [4 * MIB; 2]);
    }
}
