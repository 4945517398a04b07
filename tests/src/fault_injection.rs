//! A Vulkan loader that lies: the real one, except for the features that a test hides.
//!
//! The calls are replaced above the validation layer, which therefore never sees the hidden parts.

mod attachments;
mod barriers;
mod counted_calls;
mod device_faults;
mod draw_calls;
mod lies;
mod memory;
mod portability;
mod replacements;
mod representative;

use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::{CStr, c_char};
use std::ops::Range;

use ash::vk;
use gpu::{CancellationToken, Entry, RequiredFeature};

use crate::loader::{Replaces, replacing_entry};

pub use attachments::{AttachmentKind, AttachmentTraffic, attachment_traffic};
pub use barriers::{GuardedReads, guarded_reads};
pub use counted_calls::{
    CALLS_THAT_MAKE, CALLS_THAT_OPEN_WINDOWS, CALLS_THAT_RUN, CALLS_THAT_SAVE, CALLS_THAT_SHOW,
    CALLS_THAT_START, CALLS_THAT_WAIT_FOR_PRESENTS,
};
pub use device_faults::{FAULT_ADDRESS, FAULT_DESCRIPTION};
pub use draw_calls::CALL_THAT_COUNTS_DRAWS;
pub use lies::CONDITIONAL_BLOCKS;
pub use memory::{HOST_ALLOCATIONS, LAZY_ALLOCATIONS, most_allocated};
pub use portability::is_portability_subset_enabled;
use replacements::replacements;
pub use replacements::{CALL_THAT_ASKS_A_WINDOW, CALLS_THAT_RESET};
pub use representative::{CALL_THAT_LISTS, OTHER_PIPELINES, REPRESENTATIVE_PIPELINES};

type Function = unsafe extern "system" fn();

/// A call that fails.
#[derive(Clone, Debug)]
pub struct Fault {
    /// The Vulkan call.
    pub call: &'static CStr,
    /// The calls that fail, counted from 0.
    pub fails: Range<usize>,
    /// The result of the calls that fail.
    pub code: vk::Result,
}

/// A user who cancels the loading during a call.
#[derive(Clone, Debug)]
pub struct Impatience {
    /// The Vulkan call.
    pub call: &'static CStr,
    /// The number of the call, from 0.
    pub number: usize,
    /// The request.
    pub cancellation: CancellationToken,
}

/// A fault of a driver that it does not report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lie {
    /// A copy of query results writes the result of its first query for every query.
    FirstResultForAll,
    /// Conditional rendering draws whatever the predicate says.
    NoConditions,
    /// Draws with a count ignore the count and draw the maximum.
    NoCounts,
    /// Compute shaders do nothing.
    NoDispatches,
    /// The draws of a call are drawn from the last to the first.
    LastDrawFirst,
}

/// The faults of a machine. Each thread of a test has its own machine.
#[derive(Clone, Debug, Default)]
pub struct FaultInjection {
    /// The version that the loader reports; 0 for a loader of Vulkan 1.0, which cannot report it.
    pub loader_version: Option<u32>,
    /// True if there are no devices.
    pub has_no_devices: bool,
    /// The feature that every device lacks.
    pub lacks: Option<RequiredFeature>,
    /// True if no device has conditional rendering.
    pub is_unconditional: bool,
    /// True if no device reads the count of indirect draws from memory.
    pub has_no_draw_counts: bool,
    /// True if no device counts samples.
    pub is_imprecise: bool,
    /// True if every device claims to support representative fragments.
    pub is_representative: bool,
    /// True if every device claims to describe the fault that lost it.
    pub describes_faults: bool,
    /// True if every device claims to be one on top of another interface, such as Metal.
    pub is_portability_subset: bool,
    /// True if loads and stores of attachments are recorded ([`attachment_traffic`]).
    pub records_attachments: bool,
    /// True if barriers and the reads behind them are recorded ([`guarded_reads`]).
    pub records_barriers: bool,
    /// True if every device claims to have lazily allocated memory for transient attachments.
    pub is_lazy: bool,
    /// True if every device claims to have host memory for buffers beside its device memory.
    pub has_host_memory: bool,
    /// The bytes of device memory, for all devices together.
    pub device_bytes: Option<u64>,
    /// True if no device resets queries on the CPU.
    pub resets_by_commands: bool,
    /// True if no device indexes arrays of textures.
    pub has_no_indexing: bool,
    /// The change of the features of Vulkan 1.0 that every device reports.
    pub hides: Option<fn(&mut vk::PhysicalDeviceFeatures)>,
    /// The most draws that a device draws or counts at once.
    pub most_draws: Option<u32>,
    /// The storage buffers per shader stage that every device has.
    pub stage_storage_buffers: Option<u32>,
    /// True if no device draws several samples per pixel.
    pub has_one_sample: bool,
    /// True if windows have no pixels, as if they were minimised.
    pub is_minimised: bool,
    /// True if no device shows frames in windows.
    pub is_blind: bool,
    /// True if no device has present fences.
    pub is_fenceless: bool,
    /// The calls that fail.
    pub faults: Vec<Fault>,
    /// The fault that the driver does not report.
    pub lie: Option<Lie>,
    /// The user, if the user cancels the loading.
    pub impatience: Option<Impatience>,
}

#[derive(Default)]
struct State {
    injected: FaultInjection,
    calls: HashMap<&'static CStr, usize>,
    real: HashMap<&'static CStr, Function>,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

impl FaultInjection {
    /// Installs these faults for this thread, and restarts the counts of calls at 0.
    pub fn install(self) {
        STATE.with_borrow_mut(|state| {
            state.injected = self;
            state.calls.clear();
        });
    }

    /// Installs the faults, and returns an entry through the lying loader.
    pub fn entry(self) -> Entry {
        self.install();
        replacing_entry::<Self>()
    }
}

/// Returns the number of calls of `call` by this thread since the faults were installed.
pub fn calls(call: &'static CStr) -> usize {
    STATE.with_borrow(|state| state.calls.get(call).copied().unwrap_or(0))
}

/// Counts a call, and returns the error if the call must fail.
fn due(call: &'static CStr) -> Option<vk::Result> {
    STATE.with_borrow_mut(|state| {
        let count = state.calls.entry(call).or_default();
        let number = *count;
        *count += 1;
        let impatience = state.injected.impatience.as_ref();
        if let Some(user) =
            impatience.filter(|impatience| impatience.call == call && impatience.number == number)
        {
            user.cancellation.cancel();
        }
        let mut faults = state.injected.faults.iter();
        faults.find(|fault| fault.call == call && fault.fails.contains(&number)).map(|f| f.code)
    })
}

fn injected<R>(ask: impl FnOnce(&FaultInjection) -> R) -> R {
    STATE.with_borrow(|state| ask(&state.injected))
}

/// Returns the real function of `call`.
///
/// # Safety
/// `F` is the type of the Vulkan function with this name.
unsafe fn real<F: Copy>(call: &'static CStr) -> F {
    let function = STATE.with_borrow(|state| state.real.get(call).copied());
    let function = function.unwrap_or_else(|| panic!("{call:?} was never asked for"));
    assert_eq!(size_of::<F>(), size_of::<Function>());
    // SAFETY: both are function pointers, and the caller vouches for the type.
    unsafe { std::mem::transmute_copy(&function) }
}

unsafe extern "system" fn device_proc_addr(
    device: vk::Device,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    // SAFETY: the type is the function's; the caller passes what it would pass to it.
    let real = unsafe { real::<vk::PFN_vkGetDeviceProcAddr>(c"vkGetDeviceProcAddr")(device, name) };
    // SAFETY: the name ends with a zero.
    FaultInjection::replaced(unsafe { CStr::from_ptr(name) }, real)
}

impl Replaces for FaultInjection {
    fn replaced(name: &CStr, real: vk::PFN_vkVoidFunction) -> vk::PFN_vkVoidFunction {
        if name == c"vkEnumerateInstanceVersion" && injected(|m| m.loader_version) == Some(0) {
            return None;
        }
        if let Some(pretended) = device_faults::pretended(name) {
            return Some(pretended);
        }
        let real = real?;
        let ours = replacements().into_iter().find(|(call, _)| *call == name);
        let Some((call, ours)) = ours else { return Some(real) };
        STATE.with_borrow_mut(|state| state.real.insert(call, real));
        Some(ours)
    }
}
