//! The window's part of a swapchain: its chain, the fit of the chain, and the acquired image.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ash::{khr, vk};

use super::images::{ChainNumber, ImageIndex, SwapchainImages, Wanted};
use super::options::SwapchainOptions;
use super::outcome::{PresentId, PresentSkipped};
use super::plan;
use super::presenter::Presenter;
use super::retired::RetiredSwapchains;
use super::teardown::{AcquiredImage, Teardown};
use crate::core::capabilities::OptionalFeature;
use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::order::Order;
use crate::present::present_mode::{Fallback, PresentMode};
use crate::present::surface::Surface;
use crate::record::frames::SlotIndex;

pub(super) struct SwapchainState {
    pub(super) device: Device,
    pub(super) functions: khr::swapchain::Device,
    pub(super) surface: Surface,
    pub(super) options: SwapchainOptions,
    pub(super) chain: Option<SwapchainImages>,
    /// The number of the newest chain.
    pub(super) number: ChainNumber,
    pub(super) old: RetiredSwapchains,
    /// True after a present that did not end in time, until one ends.
    is_stuck: Arc<AtomicBool>,
    pub(super) fallback: Option<Fallback>,
    pub(super) fit: Fit,
    /// The requested mode when the chain was created or last compared.
    pub(super) mode: PresentMode,
    /// The size of the window when the chain was created or last compared.
    pub(super) window_size: [u32; 2],
    /// The acquire semaphores, one per slot.
    pub(super) acquire: Vec<vk::Semaphore>,
    pub(super) held: Option<AcquiredImage>,
    /// The thread that presents, if a present may block forever.
    pub(super) presenter: Option<Presenter>,
    /// The image of the present whose call has not returned.
    pub(super) calling: Option<ImageIndex>,
    pub(super) is_gone: bool,
    /// True if the surface is a renewed one that has not shown a frame yet.
    pub(super) is_renewed: bool,
    pub(super) newest: PresentId,
    /// The newest present before the chain was created.
    pub(super) before_chain: PresentId,
    /// The newest frame known to have been on the screen.
    pub(super) shown_until: PresentId,
}

/// The fit of the chain to the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fit {
    Fits,
    /// A suboptimal fit: sizes must be compared.
    Doubtful,
    /// The chain cannot show frames any more.
    Unusable,
}

impl SwapchainState {
    pub(super) fn new(
        device: &Device,
        surface: &Surface,
        options: &SwapchainOptions,
    ) -> Result<Self, Error> {
        surface.check(device)?;
        let lacking = || {
            let name = &device.adapter().name;
            Error::CannotPresent(format!(
                "{name} was opened without {}",
                OptionalFeature::Swapchain.name()
            ))
        };
        let functions = device.extensions().swapchain.clone().ok_or_else(lacking)?;
        let mut screen = Self {
            device: device.clone(),
            functions,
            surface: surface.clone(),
            options: options.clone(),
            chain: None,
            number: ChainNumber(0),
            old: RetiredSwapchains::default(),
            is_stuck: Arc::default(),
            fallback: None,
            fit: Fit::Fits,
            mode: options.mode,
            window_size: [0, 0],
            acquire: Vec::new(),
            held: None,
            presenter: None,
            calling: None,
            is_gone: false,
            is_renewed: false,
            newest: PresentId::default(),
            before_chain: PresentId::default(),
            shown_until: PresentId::default(),
        };
        screen.set_slots(options.frames_in_flight.max(1))?;
        Ok(screen)
    }

    /// Acquires an image unless one is already acquired. Returns the reason if there is none.
    pub(super) fn acquire(
        &mut self,
        slot: SlotIndex,
        window_size: [u32; 2],
    ) -> Result<Option<PresentSkipped>, Error> {
        // A chain that is out of date is replaced and tried once more; after that the next frame
        // must try.
        const ATTEMPTS: usize = 2;
        if self.is_gone {
            return Ok(Some(PresentSkipped::WindowGone));
        }
        self.old.retire_presented(&self.device)?;
        for _ in 0..ATTEMPTS {
            if !self.keep_up(window_size)? {
                return Ok(Some(PresentSkipped::NoArea));
            }
            let bound = self.options.acquire_bound;
            let (Some(chain), Some(semaphore)) = (&mut self.chain, self.acquire.get(slot.0)) else {
                return Err(Error::WrongCommands("a window has fewer slots than frames"));
            };
            if self.held.is_none() {
                match chain.acquire(*semaphore, bound) {
                    Ok((index, is_suboptimal)) => {
                        let proves = chain.image(index)?.was_presented;
                        self.held = Some(AcquiredImage { index, acquired: *semaphore, proves });
                        if is_suboptimal {
                            self.fit = Fit::Doubtful;
                        }
                    }
                    Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => {
                        return Ok(Some(PresentSkipped::Hidden));
                    }
                    Err(code) if is_outdated(code) => {
                        self.fit = Fit::Unusable;
                        continue;
                    }
                    Err(code) => return Err(code).called("vkAcquireNextImageKHR"),
                }
            }
            if let Some(held) = self.held {
                let is_ready = chain.is_ready_within(&self.device, held.index, bound)?;
                return Ok((!is_ready).then_some(PresentSkipped::Hidden));
            }
        }
        Ok(Some(PresentSkipped::OutOfDate))
    }

    /// Makes the chain fit the window. Returns false if the window has no pixel.
    fn keep_up(&mut self, window_size: [u32; 2]) -> Result<bool, Error> {
        let is_known = self.fit == Fit::Fits
            && self.window_size == window_size
            && self.mode == self.options.mode;
        if is_known && self.chain.is_some() {
            return Ok(true);
        }
        let state = self.surface.state(&self.device);
        let state = state.called("vkGetPhysicalDeviceSurfaceCapabilitiesKHR")?;
        let Some(size) = plan::extent(&state, window_size) else { return Ok(false) };
        let mut is_same = self.chain.as_ref().is_some_and(|chain| chain.size == size);
        if self.mode != self.options.mode {
            let mode = self.choose_mode()?;
            is_same &= self.chain.as_ref().is_some_and(|chain| chain.mode == mode);
        }
        if !is_same || self.fit == Fit::Unusable {
            self.replace(&state, size)?;
        }
        (self.fit, self.mode, self.window_size) = (Fit::Fits, self.options.mode, window_size);
        Ok(true)
    }

    fn replace(&mut self, state: &vk::SurfaceCapabilitiesKHR, size: [u32; 2]) -> Result<(), Error> {
        let mode = self.choose_mode()?;
        if self.presenter.is_none() && mode.is_queued() && self.surface.may_hold_presents() {
            self.presenter = Some(Presenter::new(&self.device)?);
        }
        self.let_go()?;
        let before = self.chain.take();
        let number = ChainNumber(self.number.0 + 1);
        let wanted = Wanted {
            number,
            state,
            size,
            mode,
            before: before.as_ref().map_or(vk::SwapchainKHR::null(), |chain| chain.raw),
            is_stuck: &self.is_stuck,
        };
        let made = SwapchainImages::new(&self.device, &self.functions, &self.surface, &wanted);
        // The call retires the old chain even if it fails.
        let pushed = match before {
            Some(before) => self.old.push(&self.device, before.retired()),
            None => Ok(()),
        };
        let chain = match made {
            Ok(chain) => chain,
            Err(error) => {
                // No newer chain will prove that the old ones are over, and one of them may hold
                // the window.
                self.old.retire_behind_a_submit(&self.device, self.old.len())?;
                return Err(error);
            }
        };
        tracing::debug!(
            "swapchain {}: {}x{}, {:?} in {:?}, {mode}, {} images",
            number.0,
            size[0],
            size[1],
            chain.format,
            plan::COLOUR_SPACE,
            chain.images.len()
        );
        self.chain = Some(chain);
        self.number = number;
        self.before_chain = self.newest;
        // The new chain is there, even if the submit behind an old one failed.
        pushed
    }

    fn choose_mode(&mut self) -> Result<PresentMode, Error> {
        let wanted = self.options.mode;
        let taken = wanted.nearest(&self.surface.present_modes(&self.device)?);
        let fallback = (taken != wanted).then_some(Fallback { wanted, taken });
        if let (Some(Fallback { wanted, taken }), true) = (fallback, fallback != self.fallback) {
            tracing::warn!("this window has no present mode {wanted}: {taken} is used");
        }
        self.fallback = fallback;
        Ok(taken)
    }

    pub(super) fn set_mode(&mut self, mode: PresentMode) {
        self.options.mode = mode;
    }

    /// Replaces the acquire semaphores by `count` new ones, one per slot.
    pub(super) fn set_slots(&mut self, count: usize) -> Result<(), Error> {
        self.let_go()?;
        let mut semaphores = Vec::with_capacity(count);
        for slot in 0..count {
            match self.new_semaphore(slot) {
                Ok(semaphore) => semaphores.push(semaphore),
                Err(error) => {
                    semaphores.into_iter().for_each(|semaphore| self.retire(semaphore));
                    return Err(error);
                }
            }
        }
        std::mem::swap(&mut self.acquire, &mut semaphores);
        semaphores.into_iter().for_each(|semaphore| self.retire(semaphore));
        Ok(())
    }

    fn new_semaphore(&self, slot: usize) -> Result<vk::Semaphore, Error> {
        let info = vk::SemaphoreCreateInfo::default();
        // SAFETY: a plain semaphore.
        let semaphore =
            unsafe { self.device.raw().create_semaphore(&info, self.device.callbacks()) };
        let semaphore = semaphore.called("vkCreateSemaphore")?;
        self.device.name(semaphore, &format!("window image acquired {slot}"));
        Ok(semaphore)
    }

    pub(super) fn retire(&self, semaphore: vk::Semaphore) {
        self.device.retire(Retired::Semaphore(semaphore));
    }

    /// Releases an image that will not be presented; the chain never gets it back. A submit waits
    /// for its semaphore, which will be signalled. Until this submit is over the semaphore must not
    /// be used by another acquire (VUID-vkAcquireNextImageKHR-semaphore-01779), so its slot gets a
    /// new one.
    pub(super) fn let_go(&mut self) -> Result<(), Error> {
        let Some(held) = self.held else { return Ok(()) };
        let slot = self.acquire.iter().position(|semaphore| *semaphore == held.acquired);
        let slot = slot.ok_or(Error::WrongCommands("an image was acquired for no slot"))?;
        let fresh = self.new_semaphore(slot)?;
        let order = Order { acquired: Some(held.acquired), ..Order::default() };
        if let Err(error) = self.device.submit(None, &order) {
            self.retire(fresh);
            return Err(error);
        }
        let used = std::mem::replace(&mut self.acquire[slot], fresh);
        self.retire(used);
        (self.held, self.fit) = (None, Fit::Unusable);
        Ok(())
    }

    /// Retires all chains of the window.
    pub(super) fn give_up_chain(&mut self) -> Result<(), Error> {
        self.let_go()?;
        self.fit = Fit::Unusable;
        drop(self.remains(Vec::new()));
        Ok(())
    }

    fn remains(&mut self, acquire: Vec<vk::Semaphore>) -> Teardown {
        Teardown {
            device: self.device.clone(),
            chain: self.chain.take(),
            old: std::mem::take(&mut self.old),
            held: self.held.take(),
            acquire,
        }
    }

    /// Converts an error to a [`PresentSkipped`] if there is one for it, and repairs the state as
    /// far as possible.
    pub(super) fn settle(&mut self, error: Error) -> Result<PresentSkipped, Error> {
        let settled = match error {
            Error::Vulkan { code: vk::Result::ERROR_SURFACE_LOST_KHR, .. } => {
                self.give_up_chain().and_then(|()| self.renew_surface())
            }
            Error::Vulkan { code, .. } if is_outdated(code) => {
                self.fit = Fit::Unusable;
                Ok(PresentSkipped::OutOfDate)
            }
            error => Err(error),
        };
        // The repair may meet the loss, too.
        settled.or_else(|error| match error {
            Error::Vulkan { call, code: code @ vk::Result::ERROR_DEVICE_LOST } => {
                self.device.note_loss(&error);
                tracing::error!("{call} failed with {code:?} while a frame was presented");
                Ok(PresentSkipped::DeviceLost)
            }
            error => Err(error),
        })
    }

    /// Replaces the surface by a new one for the same window, or returns that the window is closed.
    fn renew_surface(&mut self) -> Result<PresentSkipped, Error> {
        // Checked first: if the connection is closed, some drivers crash when they create a
        // surface, and others create one that is lost at its first use.
        if !self.is_renewed && self.surface.is_there(&self.device)? {
            match self.surface.renewed() {
                Ok(surface) => match surface.state(&self.device) {
                    Ok(_) => {
                        (self.surface, self.is_renewed) = (surface, true);
                        return Ok(PresentSkipped::SurfaceLost);
                    }
                    Err(vk::Result::ERROR_SURFACE_LOST_KHR) => {}
                    Err(code) => {
                        return Err(code).called("vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
                    }
                },
                Err(Error::NoDisplay(_)) => {}
                // Mesa 25.0 reports a destroyed window of X11 so, to any device beside it.
                Err(Error::Vulkan { call, code: code @ vk::Result::ERROR_OUT_OF_HOST_MEMORY }) => {
                    tracing::warn!("{call} failed with {code:?} after the surface was lost");
                }
                Err(error) => return Err(error),
            }
        }
        self.is_gone = true;
        Ok(PresentSkipped::WindowGone)
    }
}

impl Drop for SwapchainState {
    fn drop(&mut self) {
        let acquire = std::mem::take(&mut self.acquire);
        let remains = self.remains(acquire);
        match self.presenter.take() {
            Some(presenter) => presenter.end(remains),
            None => drop(remains),
        }
    }
}

/// Returns true if the window changed, or if another swapchain keeps the window until it is
/// destroyed.
pub(super) fn is_outdated(code: vk::Result) -> bool {
    [
        vk::Result::ERROR_OUT_OF_DATE_KHR,
        vk::Result::ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT,
        vk::Result::ERROR_NATIVE_WINDOW_IN_USE_KHR,
    ]
    .contains(&code)
}
