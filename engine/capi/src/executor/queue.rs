//! The queue that a host shares with a renderer.

use std::ffi::c_void;
use std::sync::Arc;
use std::time::Duration;

use gpu::{HostQueue, HostQueueLock, vk};

use crate::error::Failure;
use crate::layout::{Versioned, layout};
use crate::pointers::read;

/// Takes or gives back the host's lock around a queue. It is called on the thread that renders, and
/// must not call the library.
pub type AntumbraQueueLockCallback = Option<unsafe extern "C" fn(user: *mut c_void)>;

/// A queue that host and renderer share.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraQueueDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Must be 0.
    pub reserved: u32,
    /// The queue.
    pub queue: vk::Queue,
    /// Returns when nobody else uses the queue; called before each submit. Null where the host uses
    /// it on the thread that renders alone. Default: null.
    pub lock: AntumbraQueueLockCallback,
    /// Lets others use the queue again; called after each submit. Default: null.
    pub unlock: AntumbraQueueLockCallback,
    /// The first argument of both. Default: null.
    pub user: *mut c_void,
}
layout!(AntumbraQueueDesc: struct_size, reserved, queue, lock, unlock, user);

// SAFETY: the first field is the size.
unsafe impl Versioned for AntumbraQueueDesc {
    const REQUIRED_FIELDS: usize = 3;
    const DEFAULT: Self = Self {
        struct_size: size_of::<Self>() as u32,
        reserved: 0,
        queue: vk::Queue::null(),
        lock: None,
        unlock: None,
        user: std::ptr::null_mut(),
    };
}

type Callback = unsafe extern "C" fn(*mut c_void);

/// The lock of a host, by its callbacks.
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

/// Returns the queue of a host, if it names one.
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
    if queue == vk::Queue::null() {
        return Err(Failure::null("desc.queue.queue"));
    }
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
