//! The reset of a frame slot's queries before they are used again.

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::core::device::Device;
use crate::record::commands::Commands;
use crate::record::resubmission::Resubmission;

/// Resets the first `count` queries of the pool of a frame slot whose tick is over. The CPU resets
/// them if the device supports it and `commands` run only once, because some drivers (NVK) wait for
/// each query that a command resets. Otherwise `commands` reset them, outside of rendering and
/// before they are used.
pub(crate) fn reset_queries(device: &Device, commands: &Commands, pool: vk::QueryPool, count: u32) {
    if count == 0 {
        return;
    }
    let raw = device.raw();
    let is_once = commands.resubmission() == Resubmission::Never;
    if is_once && device.capabilities().has(OptionalFeature::HostQueryReset) {
        // SAFETY: the feature is enabled; the slot's tick is over, so no submitted command uses the
        // queries (VUID-vkResetQueryPool-firstQuery-02741).
        unsafe { raw.reset_query_pool(pool, 0, count) };
    } else {
        // SAFETY: the slot's tick is over, so none of its queries is in use.
        unsafe { raw.cmd_reset_query_pool(commands.raw(), pool, 0, count) };
    }
}
