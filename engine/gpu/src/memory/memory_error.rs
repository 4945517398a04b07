//! The reasons why memory could not be allocated.

use ash::vk;
use gpu_allocator::AllocationError;

use crate::memory::memory_use::MemoryUse;

/// A failed allocation of memory.
#[derive(Debug, thiserror::Error)]
#[error(
    "no GPU memory for {what} ({size_bytes} bytes): {}; {in_use}; use fewer or smaller objects and images{}",
    failure.text(*.in_use), failure.advice()
)]
pub struct MemoryError {
    /// The purpose of the memory.
    pub what: String,
    /// The requested size in bytes.
    pub size_bytes: u64,
    /// The reason, of the last attempt.
    pub failure: MemoryFailure,
    /// The memory in use after the failure.
    pub in_use: MemoryUse,
}

/// The reason why memory could not be allocated.
#[derive(Debug)]
pub enum MemoryFailure {
    /// The blocks would take more than the budget.
    OverBudget,
    /// The heap is smaller than the size that is needed.
    SmallHeap,
    /// No memory type of the device is suitable.
    NoType,
    /// A Vulkan call failed.
    Call {
        /// The Vulkan call.
        call: &'static str,
        /// The result that it returned.
        code: vk::Result,
    },
    /// The allocator failed for another reason.
    Allocator(AllocationError),
}

impl MemoryFailure {
    /// Returns true if a smaller block or other memory may help.
    pub fn is_out_of_memory(&self) -> bool {
        match self {
            Self::OverBudget | Self::SmallHeap => true,
            Self::NoType | Self::Allocator(_) => false,
            Self::Call { code, .. } => matches!(
                *code,
                vk::Result::ERROR_OUT_OF_DEVICE_MEMORY
                    | vk::Result::ERROR_OUT_OF_HOST_MEMORY
                    | vk::Result::ERROR_MEMORY_MAP_FAILED
                    | vk::Result::ERROR_TOO_MANY_OBJECTS
            ),
        }
    }

    /// Returns the failure as a part of a sentence.
    pub(crate) fn text(&self, in_use: MemoryUse) -> String {
        match self {
            Self::OverBudget => {
                let left = in_use.budget_bytes.unwrap_or(0).saturating_sub(in_use.block_bytes);
                format!("the budget leaves {left} bytes for blocks")
            }
            Self::SmallHeap => "the heap is smaller".to_owned(),
            Self::NoType => "the device has no suitable memory type".to_owned(),
            Self::Call { call, code } => format!("{call} failed with {code:?}"),
            Self::Allocator(error) => error.to_string(),
        }
    }

    /// Returns what the user can do.
    pub(crate) fn advice(&self) -> &'static str {
        match self {
            Self::OverBudget => ", or raise `DeviceOptions::memory_budget_bytes`",
            Self::Call { code: vk::Result::ERROR_OUT_OF_HOST_MEMORY, .. } => {
                ", or raise the limit of this process (`ulimit -v`, the limit of a container)"
            }
            Self::Call { code: vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, .. } => {
                ", or end other programs that use the GPU"
            }
            _ => "",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(failure: MemoryFailure, budget_mib: Option<u64>) -> String {
        let in_use = MemoryUse {
            block_bytes: 60 << 20,
            used_bytes: (40 << 20) + 1,
            budget_bytes: budget_mib.map(|mib| mib << 20),
            heap_bytes: 8 << 30,
        };
        MemoryError { what: "vertices".to_owned(), size_bytes: 5000, failure, in_use }.to_string()
    }

    #[test]
    fn errors_say_what_was_needed_and_what_there_is() {
        let over = error(MemoryFailure::OverBudget, Some(60));
        assert_eq!(
            over,
            "no GPU memory for vertices (5000 bytes): the budget leaves 0 bytes for blocks; 41 MiB \
             are in use, in blocks of 60 MiB, of a budget of 60 MiB, and the heap has 8192 MiB; use \
             fewer or smaller objects and images, or raise `DeviceOptions::memory_budget_bytes`"
        );
        let code = vk::Result::ERROR_OUT_OF_HOST_MEMORY;
        let failed = error(MemoryFailure::Call { call: "vkAllocateMemory", code }, None);
        assert!(failed.contains("vkAllocateMemory failed with ERROR_OUT_OF_HOST_MEMORY; 41 MiB"));
        assert!(failed.contains("ulimit -v") && !failed.contains("budget"), "{failed}");
    }

    #[test]
    fn only_a_lack_of_memory_is_worth_another_attempt() {
        let of = |code| MemoryFailure::Call { call: "vkAllocateMemory", code }.is_out_of_memory();
        assert!(of(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY));
        assert!(of(vk::Result::ERROR_OUT_OF_HOST_MEMORY));
        assert!(!of(vk::Result::ERROR_UNKNOWN) && !of(vk::Result::ERROR_DEVICE_LOST));
        assert!(of(vk::Result::ERROR_MEMORY_MAP_FAILED));
        assert!(MemoryFailure::OverBudget.is_out_of_memory());
        assert!(!MemoryFailure::NoType.is_out_of_memory());
    }
}
