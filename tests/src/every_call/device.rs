//! The functions that create and destroy devices, that return queues, and destroy instances. What a
//! lost device executes is over, so its work is waited for when the first call reports the loss.

use std::ffi::{CStr, c_char};
use std::mem::transmute;
use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;
use ash::vk::Handle;

use super::EveryCall;
use super::state::{Function, real, real_other, with_state};
use super::wrappers::answer;
use crate::loader::Replaces;

/// A function that replaces a real one in a way of its own.
pub(super) struct Replacement {
    pub(super) name: &'static str,
    pub(super) function: Function,
}

const PROC_ADDR: &str = "vkGetDeviceProcAddr";
const CREATE: &str = "vkCreateDevice";
const DESTROY: &str = "vkDestroyDevice";
const QUEUE: &str = "vkGetDeviceQueue";
const DESTROY_INSTANCE: &str = "vkDestroyInstance";
const WAIT_IDLE: &str = "vkDeviceWaitIdle";

/// Returns the replacement of a function that is not only counted.
pub(super) fn replacement(name: &str) -> Option<Replacement> {
    // SAFETY: all are function pointers, and the caller knows the type by the name.
    let all = unsafe {
        [
            (PROC_ADDR, transmute::<vk::PFN_vkGetDeviceProcAddr, Function>(proc_addr)),
            (CREATE, transmute::<vk::PFN_vkCreateDevice, Function>(create_device)),
            (DESTROY, transmute::<vk::PFN_vkDestroyDevice, Function>(destroy_device)),
            (QUEUE, transmute::<vk::PFN_vkGetDeviceQueue, Function>(device_queue)),
            (DESTROY_INSTANCE, transmute::<vk::PFN_vkDestroyInstance, Function>(destroy_instance)),
        ]
    };
    let found = all.into_iter().find(|(replaced, _)| *replaced == name);
    found.map(|(name, function)| Replacement { name, function })
}

unsafe extern "system" fn proc_addr(
    device: vk::Device,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    // SAFETY: here and below: the type is that of the function, and the caller passes what it would
    // pass to the real one.
    let found = unsafe { real_other::<vk::PFN_vkGetDeviceProcAddr>(PROC_ADDR)(device, name) };
    // SAFETY: the name ends with a zero.
    EveryCall::replaced(unsafe { CStr::from_ptr(name) }, found)
}

unsafe extern "system" fn create_device(
    physical: vk::PhysicalDevice,
    info: *const vk::DeviceCreateInfo<'_>,
    callbacks: *const vk::AllocationCallbacks<'_>,
    made: *mut vk::Device,
) -> vk::Result {
    let number = super::number_of(CREATE).expect("the registry has it");
    // SAFETY: as above.
    let create =
        || unsafe { real_other::<vk::PFN_vkCreateDevice>(CREATE)(physical, info, callbacks, made) };
    let code = answer(number, physical.as_raw(), create);
    if code == vk::Result::SUCCESS {
        // SAFETY: the call has written it.
        let device = unsafe { *made };
        with_state(|state| {
            state.devices.push(device);
            state.note_made("Device", device.as_raw());
        });
    }
    code
}

unsafe extern "system" fn destroy_device(
    device: vk::Device,
    callbacks: *const vk::AllocationCallbacks<'_>,
) {
    with_state(|state| {
        state.note_device_destroyed(device);
        state.note_destroyed("Device", device.as_raw());
    });
    // SAFETY: as above.
    unsafe { real_other::<vk::PFN_vkDestroyDevice>(DESTROY)(device, callbacks) }
}

unsafe extern "system" fn device_queue(
    device: vk::Device,
    family: u32,
    index: u32,
    queue: *mut vk::Queue,
) {
    // SAFETY: as above.
    unsafe { real_other::<vk::PFN_vkGetDeviceQueue>(QUEUE)(device, family, index, queue) };
    // SAFETY: the call has written it.
    let queue = unsafe { *queue };
    with_state(|state| state.queues.insert(queue.as_raw(), device));
}

unsafe extern "system" fn destroy_instance(
    instance: vk::Instance,
    callbacks: *const vk::AllocationCallbacks<'_>,
) {
    with_state(|state| state.note_destroyed("Instance", instance.as_raw()));
    // SAFETY: as above.
    unsafe { real_other::<vk::PFN_vkDestroyInstance>(DESTROY_INSTANCE)(instance, callbacks) }
}

/// Waits until no other thread is in a call that uses a queue. A thread of a swapchain may present
/// while another one meets the loss of the device.
pub(super) fn queue_alone() -> MutexGuard<'static, ()> {
    static QUEUES: Mutex<()> = Mutex::new(());
    QUEUES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits until the real devices are idle.
pub(super) fn finish() {
    let _alone = queue_alone();
    let number = super::number_of(WAIT_IDLE).expect("the registry has it");
    for device in with_state(|state| state.devices.clone()) {
        // SAFETY: a live device; one that another thread uses is only waited for.
        let _it_is_lost_all_the_same = unsafe { real::<vk::PFN_vkDeviceWaitIdle>(number)(device) };
    }
}
