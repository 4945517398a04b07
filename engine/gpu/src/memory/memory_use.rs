//! The use of device memory.

use std::fmt;

/// The memory that a device takes from the driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MemoryUse {
    /// The blocks that were taken from the driver. The budget bounds these.
    pub block_bytes: u64,
    /// The parts of blocks that buffers and images use.
    pub used_bytes: u64,
    /// The budget ([`DeviceOptions::memory_budget_bytes`](crate::DeviceOptions)).
    pub budget_bytes: Option<u64>,
    /// The largest heap of device memory.
    pub heap_bytes: u64,
}

impl MemoryUse {
    /// Returns the bytes that the budget and the heap leave. This is an estimate: what is free in
    /// blocks may lie in small pieces, and other programs use the heap, too.
    pub fn left_bytes(&self) -> u64 {
        self.budget_bytes.unwrap_or(u64::MAX).min(self.heap_bytes).saturating_sub(self.used_bytes)
    }
}

impl fmt::Display for MemoryUse {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        let Self { block_bytes, used_bytes, budget_bytes, heap_bytes } = *self;
        write!(to, "{} MiB are in use, in blocks of {} MiB", mib(used_bytes), mib(block_bytes))?;
        if let Some(budget) = budget_bytes {
            write!(to, ", of a budget of {} MiB", mib(budget))?;
        }
        write!(to, ", and the heap has {} MiB", mib(heap_bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_budget_and_the_heap_bound_what_is_left() {
        let left = |budget_bytes| {
            MemoryUse { block_bytes: 64, used_bytes: 10, budget_bytes, heap_bytes: 100 }
                .left_bytes()
        };
        assert_eq!((left(None), left(Some(50)), left(Some(5))), (90, 40, 0));
    }
}
