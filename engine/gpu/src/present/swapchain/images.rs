//! A Vulkan swapchain with its images, and the semaphores and fences of their presents.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ash::{khr, vk};

use super::outcome::PresentId;
use super::plan;
use crate::core::capabilities::OptionalFeature;
use crate::core::deletion::RetiredObject;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::present::present_mode::PresentMode;
use crate::present::surface::Surface;

/// The number of a chain, unique among the chains of its window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ChainNumber(pub(super) u64);

/// The index of an image in its chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ImageIndex(u32);

/// An image of the window. Its semaphore is signalled when it is drawn, and the present waits for
/// it. There is one semaphore per image, not per frame: only when the image is acquired again is it
/// certain that the present before has waited for the semaphore.
pub(super) struct ChainImage {
    pub(super) raw: vk::Image,
    pub(super) drawn: vk::Semaphore,
    /// The fence that is signalled when a present no longer uses semaphore and image.
    fence: Option<vk::Fence>,
    is_fence_pending: bool,
    pub(super) was_presented: bool,
}

pub(super) struct SwapchainImages {
    pub(super) raw: vk::SwapchainKHR,
    // Keeps the window alive as long as its chains.
    _surface: Surface,
    functions: khr::swapchain::Device,
    pub(super) size: [u32; 2],
    pub(super) mode: PresentMode,
    pub(super) format: vk::Format,
    pub(super) images: Vec<ChainImage>,
    /// True once a present of the window did not end in time: no chain waits for another one.
    is_stuck: Arc<AtomicBool>,
}

/// A chain that shows no frames any more. It is destroyed when neither the GPU nor the presentation
/// engine uses it.
pub(super) struct RetiredImages {
    chain: SwapchainImages,
}

/// The parameters of a new chain.
pub(super) struct Wanted<'a> {
    pub(super) number: ChainNumber,
    pub(super) state: &'a vk::SurfaceCapabilitiesKHR,
    pub(super) size: [u32; 2],
    pub(super) mode: PresentMode,
    /// The previous chain, which shows no further frames.
    pub(super) before: vk::SwapchainKHR,
    /// Shared by all chains of the window.
    pub(super) is_stuck: &'a Arc<AtomicBool>,
}

impl SwapchainImages {
    pub(super) fn new(
        device: &Device,
        functions: &khr::swapchain::Device,
        surface: &Surface,
        wanted: &Wanted<'_>,
    ) -> Result<Self, Error> {
        let format = plan::format(&surface.formats(device)?)?;
        check_copies(device, wanted.state, format)?;
        let [width, height] = wanted.size;
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw())
            .min_image_count(plan::image_count(wanted.state))
            .image_format(format)
            .image_color_space(plan::COLOUR_SPACE)
            .image_extent(vk::Extent2D { width, height })
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::TRANSFER_DST)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(plan::transform(wanted.state))
            .composite_alpha(plan::alpha(wanted.state))
            .present_mode(wanted.mode.raw())
            .clipped(true)
            .old_swapchain(wanted.before);
        // SAFETY: all parameters are offered by the surface; the previous chain is of this window,
        // and all calls with it are made through its one owner.
        let raw = unsafe { functions.create_swapchain(&info, None) };
        let raw = raw.called("vkCreateSwapchainKHR")?;
        device.name(raw, &format!("swapchain {}", wanted.number.0));
        // From here on the chain owns the objects, and drops them if the rest fails.
        let surface = surface.clone();
        let functions = functions.clone();
        let size = wanted.size;
        let mode = wanted.mode;
        let is_stuck = Arc::clone(wanted.is_stuck);
        let images = Vec::new();
        let mut chain =
            Self { raw, _surface: surface, functions, size, mode, format, images, is_stuck };
        match chain.bring_images(device, wanted.number) {
            Ok(()) => Ok(chain),
            Err(error) => {
                Box::new(RetiredImages { chain }).destroy(device.raw());
                Err(error)
            }
        }
    }

    fn bring_images(&mut self, device: &Device, number: ChainNumber) -> Result<(), Error> {
        // SAFETY: a live chain.
        let images = unsafe { self.functions.get_swapchain_images(self.raw) };
        for (place, raw) in images.called("vkGetSwapchainImagesKHR")?.into_iter().enumerate() {
            let name = format!("swapchain {}, image {place}", number.0);
            device.name(raw, &name);
            // SAFETY: a plain semaphore.
            let drawn =
                unsafe { device.raw().create_semaphore(&vk::SemaphoreCreateInfo::default(), None) };
            let drawn = drawn.called("vkCreateSemaphore")?;
            device.name(drawn, &format!("{name}, drawn"));
            self.images.push(ChainImage {
                raw,
                drawn,
                fence: None,
                is_fence_pending: false,
                was_presented: false,
            });
            if device.capabilities().has(OptionalFeature::PresentFences) {
                // SAFETY: a plain fence.
                let fence =
                    unsafe { device.raw().create_fence(&vk::FenceCreateInfo::default(), None) };
                let fence = fence.called("vkCreateFence")?;
                device.name(fence, &format!("{name}, presented"));
                self.images.last_mut().map(|image| image.fence.insert(fence));
            }
        }
        Ok(())
    }

    pub(super) fn image(&mut self, index: ImageIndex) -> Result<&mut ChainImage, Error> {
        let none = Error::WrongCommands("the image acquired is none of the swapchain's");
        self.images.get_mut(index.0 as usize).ok_or(none)
    }

    /// Acquires an image, waiting for at most `bound`. `semaphore` is signalled when the image may
    /// be written. Also returns true if the chain is suboptimal for the window.
    pub(super) fn acquire(
        &self,
        semaphore: vk::Semaphore,
        bound: Duration,
    ) -> Result<(ImageIndex, bool), vk::Result> {
        let bound_ns = u64::try_from(bound.as_nanos()).unwrap_or(MOST_NS).min(MOST_NS);
        // SAFETY: the semaphore is unsignalled and nothing waits for it, because the frame that
        // used it before is over.
        unsafe {
            self.functions.acquire_next_image(self.raw, bound_ns, semaphore, vk::Fence::null())
        }
        .map(|(index, is_suboptimal)| (ImageIndex(index), is_suboptimal))
    }

    /// Returns true if the last present of the image signals its fence within `bound`. The image is
    /// then ready for the next present.
    pub(super) fn is_ready_within(
        &mut self,
        device: &Device,
        index: ImageIndex,
        bound: Duration,
    ) -> Result<bool, Error> {
        let image = self.image(index)?;
        let (Some(fence), true) = (image.fence, image.is_fence_pending) else { return Ok(true) };
        if !wait_for(device.raw(), fence, bound)? {
            return Ok(false);
        }
        // SAFETY: the fence is signalled, and no pending work signals it again.
        unsafe { device.raw().reset_fences(&[fence]) }.called("vkResetFences")?;
        image.is_fence_pending = false;
        // Presents end again.
        self.is_stuck.store(false, Ordering::Relaxed);
        Ok(true)
    }

    /// Returns the call that passes a drawn image to the presentation engine. From now on the
    /// present counts as made.
    pub(super) fn present(
        &mut self,
        index: ImageIndex,
        id: PresentId,
    ) -> Result<PresentCall, Error> {
        let chain = self.raw;
        let functions = self.functions.clone();
        let image = self.image(index)?;
        (image.is_fence_pending, image.was_presented) = (image.fence.is_some(), true);
        Ok(PresentCall { functions, chain, index, drawn: image.drawn, fence: image.fence, id })
    }

    /// Handles the result of a [`PresentCall`]. After some errors nothing was done; after others
    /// the present still uses its semaphore and fence (Vulkan specification, vkQueuePresentKHR).
    pub(super) fn presented(&mut self, index: ImageIndex, result: &Result<bool, Error>) {
        const IS_DONE_ALL_THE_SAME: [vk::Result; 3] = [
            vk::Result::ERROR_OUT_OF_DATE_KHR,
            vk::Result::ERROR_SURFACE_LOST_KHR,
            vk::Result::ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT,
        ];
        let is_made = match result {
            Ok(_) => true,
            Err(Error::Vulkan { code, .. }) => IS_DONE_ALL_THE_SAME.contains(code),
            Err(_) => false,
        };
        if let (false, Ok(image)) = (is_made, self.image(index)) {
            image.is_fence_pending = false;
        }
    }

    pub(super) fn retired(self) -> RetiredImages {
        RetiredImages { chain: self }
    }
}

const MOST_NS: u64 = 60_000_000_000;

/// A present, to be made on the thread of the frame loop or on another thread.
pub(super) struct PresentCall {
    functions: khr::swapchain::Device,
    chain: vk::SwapchainKHR,
    index: ImageIndex,
    drawn: vk::Semaphore,
    fence: Option<vk::Fence>,
    id: PresentId,
}

impl PresentCall {
    /// Makes the call. Returns true if the chain is suboptimal for the window.
    pub(super) fn make(&self, device: &Device) -> Result<bool, Error> {
        let chains = [self.chain];
        let indices = [self.index.0];
        let drawn = [self.drawn];
        let fences = [self.fence.unwrap_or_default()];
        let ids = [self.id.0];
        let mut fence_info = vk::SwapchainPresentFenceInfoEXT::default().fences(&fences);
        let mut id_info = vk::PresentIdKHR::default().present_ids(&ids);
        let times =
            [vk::PresentTimeGOOGLE { present_id: self.id.0 as u32, desired_present_time: 0 }];
        let mut time_info = vk::PresentTimesInfoGOOGLE::default().times(&times);
        let mut info = vk::PresentInfoKHR::default()
            .wait_semaphores(&drawn)
            .swapchains(&chains)
            .image_indices(&indices);
        if self.fence.is_some() {
            info = info.push_next(&mut fence_info);
        }
        if device.extensions().present_wait.is_some() {
            info = info.push_next(&mut id_info);
        }
        if device.extensions().display_timing.is_some() {
            info = info.push_next(&mut time_info);
        }
        // SAFETY: the image was acquired, its semaphore is signalled by a submit made before, its
        // fence is unsignalled; the chain is not used concurrently, and the queue is locked.
        let present = |queue| unsafe { self.functions.queue_present(queue, &info) };
        device.with_queue("presenting", present)?.called("vkQueuePresentKHR")
    }
}

impl RetiredImages {
    /// Returns true if the presentation engine no longer uses the chain; `None` without present
    /// fences.
    pub(super) fn is_presented(&self, device: &Device) -> Result<Option<bool>, Error> {
        if !device.capabilities().has(OptionalFeature::PresentFences) {
            return Ok(None);
        }
        for image in self.chain.images.iter().filter(|image| image.is_fence_pending) {
            if let Some(fence) = image.fence
                && !wait_for(device.raw(), fence, Duration::ZERO)?
            {
                return Ok(Some(false));
            }
        }
        Ok(Some(true))
    }
}

impl RetiredObject for RetiredImages {
    /// Destroys the chain once the GPU no longer uses it. Waits, within a bound, for presents that
    /// still use it: if a swapchain is dropped in the middle of a frame, or a present never ends.
    /// In the latter case the chain is destroyed, too, as it is where there are no present fences:
    /// it must not outlive its window and its device.
    fn destroy(self: Box<Self>, device: &ash::Device) {
        let chain = self.chain;
        let began = Instant::now();
        let pending = chain.images.iter().filter(|image| image.is_fence_pending);
        let waited = pending.filter_map(|image| image.fence).try_for_each(|fence| {
            let is_stuck = chain.is_stuck.load(Ordering::Relaxed);
            let bound = if is_stuck { Duration::ZERO } else { PRESENT_BOUND };
            wait_until(device, fence, bound.saturating_sub(began.elapsed()))
        });
        if let Err(error) = waited {
            chain.is_stuck.store(true, Ordering::Relaxed);
            tracing::error!(
                "a present did not end within {} s; its swapchain is destroyed all the same: \
                 {error}",
                PRESENT_BOUND.as_secs()
            );
        }
        // SAFETY: the tick of the last submit that used the images is over, and this is the only
        // owner of the chain. Presents are done with the semaphores as far as they ever tell.
        unsafe {
            for image in &chain.images {
                device.destroy_semaphore(image.drawn, None);
                if let Some(fence) = image.fence {
                    device.destroy_fence(fence, None);
                }
            }
            chain.functions.destroy_swapchain(chain.raw, None);
        }
    }
}

/// The time in which the last presents of a window must end.
const PRESENT_BOUND: Duration = Duration::from_secs(1);

/// Waits until `fence` is signalled, or its device is lost. A wait that fails is repeated until
/// `bound` is over: nothing else proves that a present is over.
fn wait_until(device: &ash::Device, fence: vk::Fence, bound: Duration) -> Result<(), Error> {
    let began = Instant::now();
    loop {
        let left = bound.saturating_sub(began.elapsed());
        let failure = match wait_for(device, fence, left) {
            Ok(true) => return Ok(()),
            Err(error) if error.is_device_lost() => return Ok(()),
            Ok(false) => Error::Vulkan { call: "vkWaitForFences", code: vk::Result::TIMEOUT },
            Err(error) => error,
        };
        if left.is_zero() {
            return Err(failure);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Returns true if `fence` is signalled within `bound`. When the wait ends without it, the fence is
/// read, so that a wait that fails or ends too early does not count as a present that never ends.
fn wait_for(device: &ash::Device, fence: vk::Fence, bound: Duration) -> Result<bool, Error> {
    let bound_ns = u64::try_from(bound.as_nanos()).unwrap_or(MOST_NS).min(MOST_NS);
    // SAFETY: a live fence of this device.
    match unsafe { device.wait_for_fences(&[fence], true, bound_ns) } {
        Err(code) if code != vk::Result::ERROR_DEVICE_LOST => {
            // SAFETY: as above.
            let status = unsafe { device.get_fence_status(fence) };
            let is_signalled = status.called("vkGetFenceStatus")?;
            if is_signalled || code == vk::Result::TIMEOUT {
                Ok(is_signalled)
            } else {
                Err(code).called("vkWaitForFences")
            }
        }
        other => other.called("vkWaitForFences").map(|()| true),
    }
}

/// Returns an error for a surface whose images cannot be copied to.
fn check_copies(
    device: &Device,
    state: &vk::SurfaceCapabilitiesKHR,
    format: vk::Format,
) -> Result<(), Error> {
    use crate::record::attachments::COLOUR_BYTES;
    let can = |format, feature| device.has_format_feature(format, feature);
    let is_destination = state.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_DST)
        && can(format, vk::FormatFeatureFlags::BLIT_DST);
    let from =
        vk::FormatFeatureFlags::BLIT_SRC | vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
    if is_destination && can(COLOUR_BYTES, from) {
        Ok(())
    } else {
        Err(Error::CannotPresent(format!("frames cannot be copied to its {format:?} images")))
    }
}
