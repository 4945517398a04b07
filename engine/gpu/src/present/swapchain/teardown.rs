//! The objects that are left when a window is closed, in any state.

use ash::vk;

use super::images::{ImageIndex, SwapchainImages};
use super::retired::RetiredSwapchains;
use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::order::Order;

/// An acquired image that is not presented yet, and the semaphore of its acquire.
#[derive(Clone, Copy)]
pub(super) struct AcquiredImage {
    pub(super) index: ImageIndex,
    pub(super) acquired: vk::Semaphore,
    /// True if it was presented before, which proves that its present and all presents of older
    /// chains are over.
    pub(super) proves: bool,
}

/// The objects that are left when a window is closed. They are retired when this value is dropped.
pub(super) struct Teardown {
    pub(super) device: Device,
    pub(super) chain: Option<SwapchainImages>,
    pub(super) old: RetiredSwapchains,
    pub(super) held: Option<AcquiredImage>,
    pub(super) acquire: Vec<vk::Semaphore>,
}

impl Teardown {
    fn retire(&mut self) -> Result<(), Error> {
        let mut let_go = Ok(());
        if let Some(held) = self.held.take() {
            let order = Order { acquired: Some(held.acquired), ..Order::default() };
            let_go = self.device.submit(None, &order).map(|_| ());
        }
        let mut pushed = Ok(());
        if let Some(chain) = self.chain.take() {
            pushed = self.old.push(&self.device, chain.retired());
        }
        let retired = self.old.retire_behind_a_submit(&self.device, self.old.len());
        for semaphore in self.acquire.drain(..) {
            self.device.retire(Retired::Semaphore(semaphore));
        }
        let_go.and(pushed).and(retired)
    }
}

impl Drop for Teardown {
    fn drop(&mut self) {
        if let Err(error) = self.retire()
            && !error.is_device_lost()
        {
            tracing::error!("a window was not closed in order: {error}");
        }
        // The window is in use (VK_ERROR_NATIVE_WINDOW_IN_USE_KHR) for another device until then.
        self.device.free_retired_of_lost();
    }
}
