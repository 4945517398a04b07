//! The path of a frame to the window: the copy, the submit, the present, and its outcome.

use std::time::{Duration, Instant};

use super::super::images::SwapchainImages;
use super::super::outcome::{PresentId, PresentResult, PresentSkipped, Presented};
use super::super::presenter::Presenter;
use super::super::state::{Fit, SwapchainState, is_outdated};
use crate::core::error::Error;
use crate::core::order::Order;
use crate::present::window_copy::copy_to_window;
use crate::record::frames::Frame;
use crate::record::target::Target;

impl SwapchainState {
    /// Copies the frame to the acquired image and presents it.
    pub(in super::super) fn show(
        &mut self,
        frame: Frame<'_>,
        target: &Target,
        slot_wait: Duration,
        acquire_wait: Duration,
    ) -> Result<PresentResult, Error> {
        let (Some(held), Some(chain)) = (self.held, &mut self.chain) else {
            return Err(Error::WrongCommands("an image is shown that was not acquired"));
        };
        self.device.check(target, "a window (`Swapchain`)")?;
        if !target.has_frame() {
            return Err(Error::WrongCommands(
                "what is shown was drawn in no frame that was submitted",
            ));
        }
        let size = chain.size;
        let image = chain.image(held.index)?;
        frame.commands().pass("copy to window", |commands| {
            copy_to_window(target, commands, image.raw, size);
        });
        let order =
            Order { acquired: Some(held.acquired), presents: Some(image.drawn), after: None };
        let tick = frame.submit_in_order(&order)?;
        self.held = None;
        if held.proves {
            self.old.retire_proven(&self.device);
        }
        let id = PresentId(self.newest.0 + 1);
        let began = Instant::now();
        let call = chain.present(held.index, id)?;
        (self.newest, self.calling) = (id, Some(held.index));
        let is_guarded = self.surface.may_hold_presents() && chain.mode.is_queued();
        let result = match &self.presenter {
            Some(presenter) if is_guarded => {
                presenter.start(call);
                presenter.result_within(self.options.acquire_bound)
            }
            _ => Some(call.make(&self.device)),
        };
        let present_wait = began.elapsed();
        let Some(result) = result else { return Ok(PresentResult::Not(PresentSkipped::Hidden)) };
        match self.came_back(result)? {
            None => {
                let presented = Presented { id, tick, size, slot_wait, acquire_wait, present_wait };
                Ok(PresentResult::Presented(presented))
            }
            Some(not_shown) => Ok(PresentResult::Not(not_shown)),
        }
    }

    /// Returns true if the call of the last present returned within the bound.
    pub(in super::super) fn is_ready(&mut self) -> Result<bool, Error> {
        let (Some(presenter), Some(_)) = (&self.presenter, self.calling) else { return Ok(true) };
        let Some(result) = presenter.result_within(self.options.acquire_bound) else {
            return Ok(false);
        };
        self.came_back(result).map(|_| true)
    }

    /// Returns the chain, unless another thread is using it in a call.
    pub(in super::super) fn idle_chain(&self) -> Option<&SwapchainImages> {
        let is_busy = self.presenter.as_ref().is_some_and(Presenter::is_busy);
        self.chain.as_ref().filter(|_| !is_busy)
    }

    /// Handles the result of a present. Returns the reason why the frame is not shown, if it is
    /// not.
    fn came_back(&mut self, result: Result<bool, Error>) -> Result<Option<PresentSkipped>, Error> {
        if let (Some(index), Some(chain)) = (self.calling.take(), &mut self.chain) {
            chain.presented(index, &result);
        }
        match result {
            Ok(is_suboptimal) => {
                self.is_renewed = false;
                if is_suboptimal {
                    self.fit = Fit::Doubtful;
                }
                Ok(None)
            }
            Err(error) => {
                // The image is no longer acquired, or its semaphore was left signalled.
                self.fit = Fit::Unusable;
                match error {
                    Error::Vulkan { code, .. } if is_outdated(code) => {
                        Ok(Some(PresentSkipped::OutOfDate))
                    }
                    error => Err(error),
                }
            }
        }
    }
}
