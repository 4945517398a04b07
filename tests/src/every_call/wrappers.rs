//! The wrappers, one for each number of arguments.

use std::ffi::c_void;
use std::mem::transmute;

use ash::vk;

use super::device;
use super::live::note_success;
use super::state::{Function, real, with_state};

/// The number of a call, as a value whose type carries it.
pub(super) struct Index<const N: usize>;

/// Defines functions that make the wrapper of a function of some type.
macro_rules! arities {
    ($($wrap:ident ($($argument:ident: $kind:ident),+);)+) => {$(
        pub(super) fn $wrap<const N: usize, $($kind: Copy),+>(
            _: Index<N>,
            _: Option<unsafe extern "system" fn($($kind),+) -> vk::Result>,
        ) -> Function {
            unsafe extern "system" fn wrapper<const N: usize, $($kind: Copy),+>(
                $($argument: $kind),+
            ) -> vk::Result {
                type Real<$($kind),+> = unsafe extern "system" fn($($kind),+) -> vk::Result;
                let arguments = [$((&raw const $argument).cast::<c_void>()),+];
                // SAFETY: the first argument of each is a pointer or a dispatchable handle.
                let first = unsafe { arguments[0].cast::<*const c_void>().read() } as u64;
                // SAFETY: the caller passes valid arguments for the function of this number.
                let real = || unsafe { real::<Real<$($kind),+>>(N)($($argument),+) };
                let code = answer(N, first, real);
                if code == vk::Result::SUCCESS {
                    // SAFETY: the last argument of a call that succeeded.
                    unsafe { note_success(N, arguments[arguments.len() - 1]) };
                }
                code
            }
            let wrapper: unsafe extern "system" fn($($kind),+) -> vk::Result =
                wrapper::<N, $($kind),+>;
            // SAFETY: both are function pointers, and the caller knows the type by the name.
            unsafe { transmute::<unsafe extern "system" fn($($kind),+) -> vk::Result, Function>(wrapper) }
        }
    )+};
}

arities! {
    wrap_1(a: A);
    wrap_2(a: A, b: B);
    wrap_3(a: A, b: B, c: C);
    wrap_4(a: A, b: B, c: C, d: D);
    wrap_5(a: A, b: B, c: C, d: D, e: E);
    wrap_6(a: A, b: B, c: C, d: D, e: E, f: F);
    wrap_7(a: A, b: B, c: C, d: D, e: E, f: F, g: G);
    wrap_8(a: A, b: B, c: C, d: D, e: E, f: F, g: G, h: H);
}

/// Counts a call whose first argument is `first`, and returns the injected code, or the code of the
/// real call.
pub(super) fn answer(number: usize, first: u64, real: impl FnOnce() -> vk::Result) -> vk::Result {
    let real = || {
        let _alone = super::name_of(number).starts_with("vkQueue").then(device::queue_alone);
        real()
    };
    let Some(code) = with_state(|state| state.due(number, first)) else {
        return real();
    };
    if code == vk::Result::ERROR_DEVICE_LOST {
        device::finish();
    }
    if !is_executed_too(number, code) {
        return code;
    }
    match real() {
        vk::Result::SUCCESS => code,
        other => other,
    }
}

/// Returns true for codes of calls that have done their work: outputs are written, and semaphores
/// of a present are waited for.
fn is_executed_too(number: usize, code: vk::Result) -> bool {
    match code {
        vk::Result::INCOMPLETE | vk::Result::SUBOPTIMAL_KHR => true,
        vk::Result::ERROR_OUT_OF_DATE_KHR
        | vk::Result::ERROR_SURFACE_LOST_KHR
        | vk::Result::ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT => {
            super::name_of(number) == "vkQueuePresentKHR"
        }
        _ => false,
    }
}
