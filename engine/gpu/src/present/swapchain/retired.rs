//! Replaced swapchains, until the presentation engine no longer uses them.
//!
//! Their last presents wait for semaphores that are destroyed with them. No tick proves the end of
//! such a wait. These events do:
//!
//! - *Present fences* (`VK_EXT_swapchain_maintenance1`): polled, never waited for.
//! - Without them, *an image of a newer chain that was presented and is acquired again*: presents
//!   to one window are executed in order. So the presents of older chains are over with the frame
//!   that waits for this acquire.
//! - If chains are replaced faster than their images come back, at most [`MOST`] are kept: the
//!   oldest is destroyed when a submit made after its last present is over. `vkQueueWaitIdle`,
//!   which programs use for this, proves no more, and it waits.

use std::collections::VecDeque;

use super::images::RetiredImages;
use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::order::Order;

/// The number of chains that are kept until their end is proven. A window that is resized with the
/// mouse creates one per frame.
pub(super) const MOST: usize = 8;

/// The replaced chains, oldest first.
#[derive(Default)]
pub(super) struct RetiredSwapchains {
    chains: VecDeque<RetiredImages>,
}

impl RetiredSwapchains {
    pub(super) fn push(&mut self, device: &Device, chain: RetiredImages) -> Result<(), Error> {
        self.chains.push_back(chain);
        if self.chains.len() > MOST { self.retire_behind_a_submit(device, 1) } else { Ok(()) }
    }

    /// Retires the chains whose present fences prove that they are over. A fence that cannot be
    /// read proves nothing: its chain is kept as if it still presented.
    pub(super) fn retire_presented(&mut self, device: &Device) -> Result<(), Error> {
        while let Some(oldest) = self.chains.front() {
            match oldest.is_presented(device) {
                Ok(Some(true)) => self.retire_oldest(device),
                Err(error) if error.is_device_lost() => return Err(error),
                Ok(_) | Err(_) => break,
            }
        }
        Ok(())
    }

    /// Retires all chains: the frame just submitted waits for an image that proves their presents
    /// over.
    pub(super) fn retire_proven(&mut self, device: &Device) {
        while !self.chains.is_empty() {
            self.retire_oldest(device);
        }
    }

    /// Retires the `count` oldest chains once a submit made now is over.
    pub(super) fn retire_behind_a_submit(
        &mut self,
        device: &Device,
        count: usize,
    ) -> Result<(), Error> {
        let count = count.min(self.chains.len());
        if count == 0 {
            return Ok(());
        }
        let submit = || device.submit(None, &Order::default()).map(|_| ());
        // A failure other than a loss may pass.
        let submitted =
            submit().or_else(|error| if error.is_device_lost() { Err(error) } else { submit() });
        for chain in self.chains.drain(..count) {
            let retired = Retired::Other(Box::new(chain));
            if submitted.is_ok() {
                device.retire(retired);
            } else {
                device.retire_behind_next_submit(retired);
            }
        }
        submitted
    }

    pub(super) fn len(&self) -> usize {
        self.chains.len()
    }

    fn retire_oldest(&mut self, device: &Device) {
        if let Some(chain) = self.chains.pop_front() {
            device.retire(Retired::Other(Box::new(chain)));
        }
    }
}
