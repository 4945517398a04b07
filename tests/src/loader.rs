//! A loader of Vulkan that returns other functions than the real ones.

use std::ffi::{CStr, c_char};
use std::sync::OnceLock;

use ash::vk;
use gpu::Entry;

/// A set of functions that replace real ones.
pub(crate) trait Replaces {
    /// Returns the function of this name for a program: another one of the same type, the real one,
    /// or none.
    fn replaced(name: &CStr, real: vk::PFN_vkVoidFunction) -> vk::PFN_vkVoidFunction;
}

/// Returns an entry through the real loader, with the functions of `R` in place of the real ones.
pub(crate) fn replacing_entry<R: Replaces>() -> Entry {
    let get_instance_proc_addr = instance_proc_addr::<R>;
    // SAFETY: the function below returns functions of the same types as the real one, and exists as
    // long as the program.
    unsafe { Entry::from_static_fn(ash::StaticFn { get_instance_proc_addr }) }
}

/// Returns the real loader. It stays loaded, since its functions are stored in many places.
fn loader() -> &'static Entry {
    static LOADER: OnceLock<Entry> = OnceLock::new();
    LOADER.get_or_init(|| gpu::load_entry().unwrap_or_else(|error| panic!("{error}")))
}

unsafe extern "system" fn instance_proc_addr<R: Replaces>(
    instance: vk::Instance,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    // SAFETY: the caller passes what it would pass to the real function.
    let real = unsafe { (loader().static_fn().get_instance_proc_addr)(instance, name) };
    // SAFETY: the name ends with a zero.
    R::replaced(unsafe { CStr::from_ptr(name) }, real)
}
