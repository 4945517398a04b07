//! The objects that are alive, and those without a debug name: what calls made, without what other
//! calls destroyed or named.

use std::collections::BTreeMap;
use std::ffi::c_void;
use std::mem::{take, transmute};

use ash::vk;
use ash::vk::Handle;

use super::device::Replacement;
use super::state::{CallNumber, Function, State, real_other, with_state};

pub(super) const NAMING: &str = "vkSetDebugUtilsObjectNameEXT";

/// The number of objects of each type.
pub type LiveObjects = BTreeMap<&'static str, i64>;

/// Returns the number of objects that are alive, by their type.
pub fn live_objects() -> LiveObjects {
    with_state(|state| state.live.clone())
}

/// Returns the number of objects that never got a debug name since the last call, by their type:
/// those that are alive, and those that were destroyed without one.
pub fn take_unnamed() -> LiveObjects {
    with_state(|state| {
        let mut unnamed = take(&mut state.never_named);
        for (_, kind) in state.unnamed.drain() {
            *unnamed.entry(kind).or_default() += 1;
        }
        unnamed
    })
}

/// Returns the type of the object that a call makes.
fn made_by(name: &'static str) -> Option<&'static str> {
    match name {
        "vkAllocateMemory" => Some("Memory"),
        // The engine creates them one by one.
        "vkCreateGraphicsPipelines" | "vkCreateComputePipelines" => Some("Pipeline"),
        name if name.ends_with(SURFACE) => Some(SURFACE),
        name => name.strip_prefix("vkCreate").filter(|kind| is_counted(kind)),
    }
}

const SURFACE: &str = "SurfaceKHR";

/// The types whose objects are not those of a device, and need no debug name.
const OF_INSTANCES: [&str; 3] = ["Instance", "DebugUtilsMessengerEXT", SURFACE];

fn is_counted(kind: &str) -> bool {
    ["Device", "Instance"].contains(&kind)
        || DESTROYERS.iter().any(|name| name.strip_prefix("vkDestroy") == Some(kind))
}

/// Notes the object that a call made or named.
///
/// # Safety
/// `last` points to the last argument of the call, which succeeded.
pub(super) unsafe fn note_success(call: CallNumber, last: *const c_void) {
    let name = super::name_of(call);
    if name == NAMING {
        let info = last.cast::<*const vk::DebugUtilsObjectNameInfoEXT<'_>>();
        // SAFETY: this function has such an argument.
        let handle = unsafe { (**info).object_handle };
        with_state(|state| state.unnamed.remove(&handle));
    } else if let Some(kind) = made_by(name) {
        // SAFETY: the last argument of functions that make an object is a pointer to its handle,
        // which has 64 bits.
        let handle = unsafe { **last.cast::<*const u64>() };
        with_state(|state| state.note_made(kind, handle));
    }
}

impl State {
    /// Notes that a call made an object.
    pub(super) fn note_made(&mut self, kind: &'static str, handle: u64) {
        *self.live.entry(kind).or_default() += 1;
        if !OF_INSTANCES.contains(&kind) {
            self.unnamed.insert(handle, kind);
        }
    }

    /// Notes that an object is destroyed.
    pub(super) fn note_destroyed(&mut self, kind: &'static str, handle: u64) {
        *self.live.entry(kind).or_default() -= 1;
        if self.unnamed.remove(&handle).is_some() {
            *self.never_named.entry(kind).or_default() += 1;
        }
    }
}

/// Defines the names and replacements of functions that destroy an object of a device or instance.
macro_rules! destroyers {
    ($($pfn:ident)+) => {
        #[allow(non_camel_case_types)]
        #[repr(usize)]
        enum Number {
            $($pfn),+
        }

        const DESTROYERS: &[&str] = &[$(stringify!($pfn).split_at("PFN_".len()).1),+];

        /// Returns the replacement of a function that destroys an object.
        pub(super) fn replacement(name: &str) -> Option<Replacement> {
            let place = DESTROYERS.iter().position(|known| *known == name)?;
            let all = [$(destroyer(Index::<{ Number::$pfn as usize }>, None::<vk::$pfn>)),+];
            Some(Replacement { name: DESTROYERS[place], function: all[place] })
        }
    };
}

destroyers! {
    PFN_vkDestroyBuffer PFN_vkDestroyBufferView PFN_vkDestroyCommandPool
    PFN_vkDestroyDescriptorPool PFN_vkDestroyDescriptorSetLayout PFN_vkDestroyEvent
    PFN_vkDestroyFence PFN_vkDestroyImage PFN_vkDestroyImageView PFN_vkDestroyPipeline
    PFN_vkDestroyPipelineCache PFN_vkDestroyPipelineLayout PFN_vkDestroyQueryPool
    PFN_vkDestroySampler PFN_vkDestroySemaphore PFN_vkDestroyShaderModule
    PFN_vkDestroySwapchainKHR PFN_vkFreeMemory PFN_vkDestroySurfaceKHR
    PFN_vkDestroyDebugUtilsMessengerEXT
}

/// The place of a function in the list, as a value whose type carries it.
struct Index<const N: usize>;

/// Returns the replacement of a function of this type.
fn destroyer<const N: usize, A, B: Handle + Copy, C>(
    _: Index<N>,
    _: Option<unsafe extern "system" fn(A, B, C)>,
) -> Function {
    unsafe extern "system" fn wrapper<const N: usize, A, B: Handle + Copy, C>(
        device: A,
        object: B,
        callbacks: C,
    ) {
        let name = DESTROYERS[N];
        if !object.is_null() {
            let kind = name.strip_prefix("vkDestroy").unwrap_or("Memory");
            with_state(|state| state.note_destroyed(kind, object.as_raw()));
        }
        type Real<A, B, C> = unsafe extern "system" fn(A, B, C);
        // SAFETY: the caller passes what it would pass to the real function.
        unsafe { real_other::<Real<A, B, C>>(name)(device, object, callbacks) }
    }
    let wrapper: unsafe extern "system" fn(A, B, C) = wrapper::<N, A, B, C>;
    // SAFETY: both are function pointers, and the caller knows the type by the name.
    unsafe { transmute::<unsafe extern "system" fn(A, B, C), Function>(wrapper) }
}
