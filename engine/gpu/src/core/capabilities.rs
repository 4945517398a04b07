//! The one table of capabilities: those that the engine requires of a device, and optional ones.

use std::ffi::{CStr, CString};

use ash::{ext, google, khr, vk};

use crate::core::instance::InstanceShared;

/// A capability that a device must have. A device that lacks one is refused, and the refusal names
/// it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Required {
    /// Core 1.3: dynamic rendering, synchronization2.
    Vulkan13,
    /// Rendering without render-pass objects.
    DynamicRendering,
    /// Barriers and submits of `VK_KHR_synchronization2`.
    Synchronization2,
    /// One counter that proves which frames are over.
    TimelineSemaphore,
    /// One call that draws a contiguous range of objects.
    MultiDrawIndirect,
    /// Indirect draws with a first instance other than 0.
    DrawIndirectFirstInstance,
    /// A queue family with graphics and compute.
    GraphicsQueue,
    /// 32-bit float depth, drawn to and copied from.
    Depth32,
}

impl Required {
    /// All required capabilities, in the order in which they are shown to the user.
    pub const ALL: [Required; 8] = [
        Required::Vulkan13,
        Required::DynamicRendering,
        Required::Synchronization2,
        Required::TimelineSemaphore,
        Required::MultiDrawIndirect,
        Required::DrawIndirectFirstInstance,
        Required::GraphicsQueue,
        Required::Depth32,
    ];

    /// Returns the name shown to the user.
    pub fn name(self) -> &'static str {
        match self {
            Required::Vulkan13 => "Vulkan 1.3",
            Required::DynamicRendering => "dynamicRendering",
            Required::Synchronization2 => "synchronization2",
            Required::TimelineSemaphore => "timelineSemaphore",
            Required::MultiDrawIndirect => "multiDrawIndirect",
            Required::DrawIndirectFirstInstance => "drawIndirectFirstInstance",
            Required::GraphicsQueue => "a queue with graphics and compute",
            Required::Depth32 => "D32_SFLOAT as a depth attachment that can be copied",
        }
    }
}

/// A capability that a device may have; each has a fallback.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Optional {
    /// `VK_EXT_conditional_rendering`: the GPU skips draws by 32 bits in memory.
    ConditionalRendering,
    /// Indirect draws whose count the GPU reads.
    DrawIndirectCount,
    /// Exact numbers of samples from occlusion queries.
    PreciseQueries,
    /// Timestamps on the graphics queue.
    Timestamps,
    /// Fragment shaders that write to storage buffers.
    FragmentStores,
    /// Triangles drawn as their edges.
    Wireframe,
    /// Textures that stay sharp at grazing angles.
    Anisotropy,
    /// Reading the clocks of GPU and CPU at once.
    CalibratedTimestamps,
    /// Frames in windows. This one and those below are there only if the instance was made for
    /// windows ([`crate::InstanceOptions::windows`]).
    Swapchain,
    /// Fences that are signalled when a present no longer uses its semaphore and image.
    PresentFences,
    /// Waiting for a present to be on the screen.
    PresentWait,
    /// The times at which presents were on the screen, and the duration of a refresh.
    DisplayTiming,
}

impl Optional {
    /// All optional capabilities.
    pub const ALL: [Optional; 12] = [
        Optional::ConditionalRendering,
        Optional::DrawIndirectCount,
        Optional::PreciseQueries,
        Optional::Timestamps,
        Optional::FragmentStores,
        Optional::Wireframe,
        Optional::Anisotropy,
        Optional::CalibratedTimestamps,
        Optional::Swapchain,
        Optional::PresentFences,
        Optional::PresentWait,
        Optional::DisplayTiming,
    ];

    /// Returns the name shown to the user.
    pub fn name(self) -> &'static str {
        match self {
            Optional::ConditionalRendering => "VK_EXT_conditional_rendering",
            Optional::DrawIndirectCount => "drawIndirectCount",
            Optional::PreciseQueries => "occlusionQueryPrecise",
            Optional::Timestamps => "timestamps",
            Optional::FragmentStores => "fragmentStoresAndAtomics",
            Optional::Wireframe => "fillModeNonSolid",
            Optional::Anisotropy => "samplerAnisotropy",
            Optional::CalibratedTimestamps => "VK_EXT_calibrated_timestamps",
            Optional::Swapchain => "VK_KHR_swapchain",
            Optional::PresentFences => "VK_EXT_swapchain_maintenance1",
            Optional::PresentWait => "VK_KHR_present_wait",
            Optional::DisplayTiming => "VK_GOOGLE_display_timing",
        }
    }
}

/// The capabilities of one device.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Capabilities {
    /// The required ones it lacks.
    pub missing: Vec<Required>,
    /// The optional ones it has.
    pub optional: Vec<Optional>,
}

impl Capabilities {
    /// Returns true if the device has `optional`.
    pub fn has(&self, optional: Optional) -> bool {
        self.optional.contains(&optional)
    }

    /// Reads the table off a physical device; `queue_family` is its graphics family, if any.
    pub(crate) fn read(
        instance: &InstanceShared,
        physical: vk::PhysicalDevice,
        api_version: u32,
        queue_family: Option<&vk::QueueFamilyProperties>,
    ) -> Self {
        let mut missing = Vec::new();
        let mut require = |there: bool, what: Required| {
            if !there {
                missing.push(what);
            }
        };
        require(api_version >= vk::API_VERSION_1_3, Required::Vulkan13);
        require(queue_family.is_some(), Required::GraphicsQueue);
        if api_version < vk::API_VERSION_1_3 {
            // The feature chains below may not be asked of such a device.
            return Self { missing, optional: Vec::new() };
        }
        let extensions = extension_names(instance, physical);
        let has_extension = |name: &CStr| extensions.iter().any(|e| e.as_c_str() == name);

        let shows = instance.windows.is_some() && has_extension(khr::swapchain::NAME);
        let features = Features::read(instance, physical, &extensions, shows);
        let Features { core, features_12, features_13, .. } = &features;
        // SAFETY: a valid physical device and format.
        let depth = unsafe {
            instance.raw.get_physical_device_format_properties(physical, vk::Format::D32_SFLOAT)
        };

        require(yes(features_13.dynamic_rendering), Required::DynamicRendering);
        require(yes(features_13.synchronization2), Required::Synchronization2);
        require(yes(features_12.timeline_semaphore), Required::TimelineSemaphore);
        require(yes(core.multi_draw_indirect), Required::MultiDrawIndirect);
        require(yes(core.draw_indirect_first_instance), Required::DrawIndirectFirstInstance);
        require(
            depth.optimal_tiling_features.contains(
                vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT
                    | vk::FormatFeatureFlags::TRANSFER_SRC,
            ),
            Required::Depth32,
        );
        let timestamps = queue_family.is_some_and(|family| family.timestamp_valid_bits > 0);
        let optional = [
            (features.conditional_rendering, Optional::ConditionalRendering),
            (yes(features_12.draw_indirect_count), Optional::DrawIndirectCount),
            (yes(core.occlusion_query_precise), Optional::PreciseQueries),
            (timestamps, Optional::Timestamps),
            (yes(core.fragment_stores_and_atomics), Optional::FragmentStores),
            (yes(core.fill_mode_non_solid), Optional::Wireframe),
            (yes(core.sampler_anisotropy), Optional::Anisotropy),
            (
                timestamps && has_extension(ext::calibrated_timestamps::NAME),
                Optional::CalibratedTimestamps,
            ),
            (shows, Optional::Swapchain),
            (features.present_fences, Optional::PresentFences),
            (features.present_wait, Optional::PresentWait),
            (shows && has_extension(google::display_timing::NAME), Optional::DisplayTiming),
        ];
        let optional = optional.into_iter().filter(|(there, _)| *there).map(|(_, what)| what);
        Self { missing, optional: optional.collect() }
    }
}

fn yes(feature: vk::Bool32) -> bool {
    feature == vk::TRUE
}

/// The features of a device, as far as they are used.
struct Features {
    core: vk::PhysicalDeviceFeatures,
    features_12: vk::PhysicalDeviceVulkan12Features<'static>,
    features_13: vk::PhysicalDeviceVulkan13Features<'static>,
    conditional_rendering: bool,
    present_fences: bool,
    present_wait: bool,
}

impl Features {
    /// Reads the features of a device with Vulkan 1.3; those of presenting if it `shows` images in
    /// windows.
    fn read(
        instance: &InstanceShared,
        physical: vk::PhysicalDevice,
        extensions: &[CString],
        shows: bool,
    ) -> Self {
        let has_extension = |name: &CStr| extensions.iter().any(|e| e.as_c_str() == name);
        let mut conditional = vk::PhysicalDeviceConditionalRenderingFeaturesEXT::default();
        let mut features_12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut features_13 = vk::PhysicalDeviceVulkan13Features::default();
        let mut all = vk::PhysicalDeviceFeatures2::default()
            .push_next(&mut features_12)
            .push_next(&mut features_13);
        if has_extension(ext::conditional_rendering::NAME) {
            all = all.push_next(&mut conditional);
        }
        let mut present_fences = vk::PhysicalDeviceSwapchainMaintenance1FeaturesEXT::default();
        let mut present_id = vk::PhysicalDevicePresentIdFeaturesKHR::default();
        let mut present_wait = vk::PhysicalDevicePresentWaitFeaturesKHR::default();
        if shows && fences_extension(instance, extensions).is_some() {
            all = all.push_next(&mut present_fences);
        }
        if shows && has_extension(khr::present_id::NAME) && has_extension(khr::present_wait::NAME) {
            all = all.push_next(&mut present_id).push_next(&mut present_wait);
        }
        // SAFETY: the chain holds only structures this device's version and extensions know.
        unsafe { instance.raw.get_physical_device_features2(physical, &mut all) };
        let core = all.features;
        Self {
            core,
            features_12,
            features_13,
            conditional_rendering: yes(conditional.conditional_rendering),
            present_fences: yes(present_fences.swapchain_maintenance1),
            present_wait: yes(present_id.present_id) && yes(present_wait.present_wait),
        }
    }
}

/// Returns the extension that gives a device present fences.
pub(crate) fn fences_extension(
    instance: &InstanceShared,
    extensions: &[CString],
) -> Option<&'static CStr> {
    let mut names = instance.windows.iter().flat_map(|windows| &windows.present_fences);
    names.find(|name| extensions.iter().any(|there| there.as_c_str() == **name)).copied()
}

pub(crate) fn extension_names(
    instance: &InstanceShared,
    physical: vk::PhysicalDevice,
) -> Vec<CString> {
    // SAFETY: a valid physical device of this instance.
    let extensions = unsafe { instance.raw.enumerate_device_extension_properties(physical) };
    extensions
        .unwrap_or_default()
        .iter()
        .filter_map(|extension| extension.extension_name_as_c_str().ok().map(Into::into))
        .collect()
}
