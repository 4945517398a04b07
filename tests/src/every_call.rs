//! A Vulkan loader in which every call that returns a `VkResult` can fail.
//!
//! Each such function of the registry has a wrapper, which counts the call, and returns an injected
//! code or forwards to the real function. The state is that of the process, since a swapchain
//! presents on a thread of its own: a process injects faults into one program at a time.

mod calls;
mod codes;
mod device;
mod live;
mod numbered;
mod state;
mod wrappers;

use std::collections::BTreeSet;
use std::ffi::CStr;
use std::sync::OnceLock;

use ash::vk;
use gpu::Entry;

use crate::loader::{Replaces, replacing_entry};

pub use calls::NAMES;
pub use codes::{INVENTED, codes_of, name_of, number_of, parse_code, table_version};
pub use live::{LiveObjects, live_objects, take_unnamed};
pub use state::{CallNumber, Fault, FaultPlan, Lasts, NextFault, call_matters};
use state::{Function, with_state};

/// Installs a plan of faults, and restarts all counts.
pub fn install(plan: FaultPlan) {
    with_state(|state| state.install(plan));
}

/// Removes the plan. The counts stay.
pub fn stop() {
    with_state(|state| state.stop());
}

/// Returns the calls since the plan was installed, in their order.
pub fn trace() -> Vec<CallNumber> {
    with_state(|state| state.trace.clone())
}

/// Returns the calls that failed since the plan was installed, each with its code.
pub fn fired() -> Vec<(CallNumber, vk::Result)> {
    with_state(|state| state.fired.clone())
}

/// Returns the number of calls that followed the first fault and can be the second one; 0 if it was
/// not injected.
pub fn calls_after_first() -> usize {
    with_state(|state| state.calls_after)
}

/// Returns true if the second fault of the plan was injected, too.
pub fn second_fired() -> bool {
    with_state(|state| state.second_fired)
}

/// Returns the names of all functions that were asked for and found since the process began.
pub fn asked() -> BTreeSet<String> {
    with_state(|state| state.asked.clone())
}

/// Notes a device of a host, whose work is over when a call reports its loss.
pub fn watch(device: vk::Device) {
    with_state(|state| state.devices.push(device));
}

/// Forgets all devices of hosts: they are destroyed.
pub fn forget_devices() {
    with_state(|state| {
        state.devices.clear();
        state.queues.clear();
    });
}

/// Returns an entry through the loader in which calls fail.
pub fn entry() -> Entry {
    replacing_entry::<EveryCall>()
}

/// The functions of the registry that return a `VkResult`.
struct EveryCall;

impl Replaces for EveryCall {
    /// Returns the wrapper of a function, or the function itself if it returns no `VkResult`.
    fn replaced(name: &CStr, real: vk::PFN_vkVoidFunction) -> vk::PFN_vkVoidFunction {
        let real = real?;
        let name = name.to_str().unwrap_or_default();
        with_state(|state| {
            state.asked.insert(name.to_owned());
            if let Some(ours) = device::replacement(name).or_else(|| live::replacement(name)) {
                state.others.insert(ours.name, real);
                return Some(ours.function);
            }
            let Some(number) = number_of(name) else { return Some(real) };
            state.real[number] = Some(real);
            Some(wrapper(number))
        })
    }
}

fn wrapper(number: CallNumber) -> Function {
    static WRAPPERS: OnceLock<Vec<Function>> = OnceLock::new();
    WRAPPERS.get_or_init(calls::wrappers)[number]
}
