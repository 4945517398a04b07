//! The objects that are alive: what calls made, without what other calls destroyed.

use std::collections::BTreeMap;
use std::mem::transmute;

use ash::vk;
use ash::vk::Handle;

use super::device::Replacement;
use super::state::{CallNumber, Function, State, real_other, with_state};

/// The number of objects of each type.
pub type LiveObjects = BTreeMap<&'static str, i64>;

/// Returns the number of objects that are alive, by their type.
pub fn live_objects() -> LiveObjects {
    with_state(|state| state.live.clone())
}

/// Returns the type of the object that a call makes.
fn made_by(name: &'static str) -> Option<&'static str> {
    match name {
        "vkAllocateMemory" => Some("Memory"),
        // The engine creates them one by one.
        "vkCreateGraphicsPipelines" | "vkCreateComputePipelines" => Some("Pipeline"),
        name => name.strip_prefix("vkCreate").filter(|kind| is_counted(kind)),
    }
}

fn is_counted(kind: &str) -> bool {
    kind == "Device" || DESTROYERS.iter().any(|name| name.strip_prefix("vkDestroy") == Some(kind))
}

impl State {
    /// Notes that a call made its object.
    pub(super) fn note_made(&mut self, call: CallNumber) {
        if let Some(kind) = made_by(super::name_of(call)) {
            *self.live.entry(kind).or_default() += 1;
        }
    }

    /// Notes that an object is destroyed.
    pub(super) fn note_destroyed(&mut self, kind: &'static str) {
        *self.live.entry(kind).or_default() -= 1;
    }
}

/// Defines the names and replacements of functions that destroy an object of a device.
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
    PFN_vkDestroySwapchainKHR PFN_vkFreeMemory
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
            with_state(|state| state.note_destroyed(kind));
        }
        type Real<A, B, C> = unsafe extern "system" fn(A, B, C);
        // SAFETY: the caller passes what it would pass to the real function.
        unsafe { real_other::<Real<A, B, C>>(name)(device, object, callbacks) }
    }
    let wrapper: unsafe extern "system" fn(A, B, C) = wrapper::<N, A, B, C>;
    // SAFETY: both are function pointers, and the caller knows the type by the name.
    unsafe { transmute::<unsafe extern "system" fn(A, B, C), Function>(wrapper) }
}
