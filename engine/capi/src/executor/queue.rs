//! The queue that a host shares with a renderer.

use std::ffi::c_void;
use std::sync::Arc;
use std::time::Duration;

use gpu::{HostQueue, HostQueueLock, vk};

use crate::error::Failure;
use crate::layout::{layout, pointers, versioned};
use crate::pointers::read;

/// Takes or releases the host's lock of a queue. The callback runs on the thread that renders, and
/// must not call the library.
pub type AntumbraQueueLockCallback = Option<unsafe extern "C" fn(user: *mut c_void)>;

pointers!(AntumbraQueueLockCallback);

/// A queue that host and renderer share.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraQueueDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Must be 0.
    pub reserved: u32,
    /// Required: the queue.
    pub queue: vk::Queue,
    /// Called before each submit; returns when no other thread uses the queue. Default: null, if
    /// the host uses the queue only on the thread that renders.
    pub lock: AntumbraQueueLockCallback,
    /// Called after each submit; lets other threads use the queue again. Default: null, as `lock`.
    pub unlock: AntumbraQueueLockCallback,
    /// The first argument of both. Default: null.
    pub user: *mut c_void,
}
layout!(AntumbraQueueDesc: struct_size, reserved, queue, lock, unlock, user);

versioned!(AntumbraQueueDesc: 3, required: [queue], defaults: {});

type Callback = unsafe extern "C" fn(*mut c_void);

/// The lock of a host, taken through its callbacks.
struct CallbackLock {
    callbacks: Option<[Callback; 2]>,
    user: *mut c_void,
}

// SAFETY: the caller promises that the functions may be called on every thread that calls us.
unsafe impl Send for CallbackLock {}
// SAFETY: as above.
unsafe impl Sync for CallbackLock {}

impl HostQueueLock for CallbackLock {
    fn locked(&self, _bound: Duration, submit: &mut dyn FnMut()) {
        let Some([lock, unlock]) = self.callbacks else { return submit() };
        // SAFETY: the promise of the caller who gave the functions, here and below.
        unsafe { lock(self.user) };
        submit();
        // SAFETY: as above.
        unsafe { unlock(self.user) };
    }
}

/// Returns the queue of a host, if it gave one.
///
/// # Safety
/// As the rules of the interface.
pub(crate) unsafe fn host_queue(
    desc: *const AntumbraQueueDesc,
) -> Result<Option<HostQueue>, Failure> {
    if desc.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    let AntumbraQueueDesc { queue, lock, unlock, user, .. } = unsafe { read("desc.queue", desc) }?;
    let callbacks = match (lock, unlock) {
        (Some(lock), Some(unlock)) => Some([lock, unlock]),
        (None, None) => None,
        _ => {
            let message = "desc.queue has one of lock and unlock: give both or none";
            return Err(Failure::argument(message));
        }
    };
    Ok(Some(HostQueue { raw: queue, lock: Arc::new(CallbackLock { callbacks, user }) }))
}
