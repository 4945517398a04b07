//! A thread for windows whose presents may block while the windows are hidden.
//!
//! On Wayland, drivers wait inside `vkQueuePresentKHR` until the compositor requests another frame.
//! It requests none for a hidden window, and the call has no bound. So this thread makes the call,
//! and the frame loop waits for its end with a bound. Meanwhile the queue is locked: until the call
//! returns nothing can be submitted, and [`super::Swapchain::is_ready`] returns false.

use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use super::images::PresentCall;
use super::teardown::Teardown;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::queue_lock::lock;

/// The thread and its state.
pub(super) struct Presenter {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    call: Option<PresentCall>,
    result: Option<Result<bool, Error>>,
    is_busy: bool,
    is_over: bool,
    /// The teardown of a window that was closed during a call.
    remains: Option<Teardown>,
}

impl Presenter {
    pub(super) fn new(device: &Device) -> Result<Self, Error> {
        let shared = Arc::new(Shared::default());
        let device = device.clone();
        let theirs = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("present".to_owned());
        let thread = thread.spawn(move || present_all(&device, &theirs));
        let thread = thread.map_err(|error| Error::NoThread(error.to_string()))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Starts a call. The last call must have returned, and its result must have been taken.
    pub(super) fn start(&self, call: PresentCall) {
        let mut state = lock(&self.shared.state);
        (state.call, state.result, state.is_busy) = (Some(call), None, true);
        self.shared.changed.notify_all();
    }

    /// Returns the result of the call once, if the call returns within `bound`.
    pub(super) fn result_within(&self, bound: Duration) -> Option<Result<bool, Error>> {
        let waited =
            self.shared
                .changed
                .wait_timeout_while(lock(&self.shared.state), bound, |state| state.is_busy);
        waited.unwrap_or_else(|error| error.into_inner()).0.result.take()
    }

    pub(super) fn is_busy(&self) -> bool {
        lock(&self.shared.state).is_busy
    }

    /// Ends the thread and drops the objects of the window: at once, or when the present call
    /// returns.
    pub(super) fn end(mut self, remains: Teardown) {
        let mut state = lock(&self.shared.state);
        state.is_over = true;
        let is_busy = state.is_busy;
        let ours = if is_busy {
            state.remains = Some(remains);
            None
        } else {
            Some(remains)
        };
        drop(state);
        self.shared.changed.notify_all();
        if let (false, Some(thread)) = (is_busy, self.thread.take()) {
            let _panics_are_logged = thread.join();
        }
        drop(ours);
    }
}

fn present_all(device: &Device, shared: &Shared) {
    loop {
        let waited = shared
            .changed
            .wait_while(lock(&shared.state), |state| state.call.is_none() && !state.is_over);
        let mut state = waited.unwrap_or_else(|error| error.into_inner());
        let Some(call) = state.call.take() else {
            let remains = state.remains.take();
            drop(state);
            drop(remains);
            return;
        };
        drop(state);
        let result = call.make(device);
        let mut state = lock(&shared.state);
        (state.result, state.is_busy) = (Some(result), false);
        shared.changed.notify_all();
    }
}
