//! The functions of a device's extensions.

use ash::{ext, google, khr};

use crate::core::capabilities::{Capabilities, OptionalFeature};
use crate::core::instance::InstanceShared;

/// The functions of the enabled extensions.
pub(crate) struct Extensions {
    pub(crate) debug: Option<ext::debug_utils::Device>,
    pub(crate) conditional: Option<ext::conditional_rendering::Device>,
    pub(crate) capture: Option<ext::transform_feedback::Device>,
    pub(crate) calibrated: Option<ext::calibrated_timestamps::Device>,
    pub(crate) fault: Option<ext::device_fault::Device>,
    pub(crate) swapchain: Option<khr::swapchain::Device>,
    pub(crate) present_wait: Option<khr::present_wait::Device>,
    pub(crate) display_timing: Option<google::display_timing::Device>,
}

impl Extensions {
    pub(crate) fn load(
        instance: &InstanceShared,
        device: &ash::Device,
        capabilities: &Capabilities,
    ) -> Self {
        let from = &instance.raw;
        let has = |optional| capabilities.has(optional);
        Self {
            debug: instance.has_debug_utils.then(|| ext::debug_utils::Device::new(from, device)),
            conditional: has(OptionalFeature::ConditionalRendering)
                .then(|| ext::conditional_rendering::Device::new(from, device)),
            capture: has(OptionalFeature::TessellationCapture)
                .then(|| ext::transform_feedback::Device::new(from, device)),
            calibrated: has(OptionalFeature::CalibratedTimestamps)
                .then(|| ext::calibrated_timestamps::Device::new(from, device)),
            fault: has(OptionalFeature::DeviceFault)
                .then(|| ext::device_fault::Device::new(from, device)),
            swapchain: has(OptionalFeature::Swapchain)
                .then(|| khr::swapchain::Device::new(from, device)),
            present_wait: has(OptionalFeature::PresentWait)
                .then(|| khr::present_wait::Device::new(from, device)),
            display_timing: has(OptionalFeature::DisplayTiming)
                .then(|| google::display_timing::Device::new(from, device)),
        }
    }
}
