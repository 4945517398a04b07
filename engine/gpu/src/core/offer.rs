//! The offer of an adapter or of a host, from which the capability table is filled.

use std::ffi::{CStr, CString};

use ash::{ext, khr, vk};

use crate::core::error::{Called, Error};
use crate::core::features::{FeatureStructures, Features, KHR_SWAPCHAIN_MAINTENANCE1};
use crate::core::window_system::WindowFunctions;

/// The version, queue, extensions and features that a device may use.
#[derive(Debug, Clone, Default)]
pub(crate) struct Offer {
    pub(crate) api_version: u32,
    /// The index of a queue family with graphics and compute.
    pub(crate) queue_family: Option<u32>,
    /// The number of timestamp bits of this family.
    pub(crate) timestamp_bits: u32,
    pub(crate) extensions: Vec<CString>,
    pub(crate) features: Features,
    pub(crate) has_depth_32: bool,
    /// The most storage buffers that a shader stage may bind.
    pub(crate) stage_storage_buffers: u32,
    /// The most textures of a [`TextureTable`](crate::TextureTable), by the device's limits.
    pub(crate) indexed_textures: u32,
    /// The limits of a capture of tessellated triangles.
    pub(crate) capture: CaptureLimits,
    /// The driver, if it is known.
    pub(crate) driver: vk::DriverId,
}

/// The limits of tessellation and transform feedback; 0 if there is none.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct CaptureLimits {
    /// The most control points in a patch.
    pub(crate) patch_points: u32,
    /// The highest tessellation level of an edge.
    pub(crate) level: u32,
    /// The most bytes captured in one buffer.
    pub(crate) buffer_bytes: u64,
}

impl CaptureLimits {
    /// Returns true if every limit is at least the limit in `least`.
    pub(crate) fn holds(self, least: Self) -> bool {
        self.patch_points >= least.patch_points
            && self.level >= least.level
            && self.buffer_bytes >= least.buffer_bytes
    }
}

/// The flags that a queue family needs for the engine.
pub(crate) const QUEUE_FLAGS: vk::QueueFlags =
    vk::QueueFlags::from_raw(vk::QueueFlags::GRAPHICS.as_raw() | vk::QueueFlags::COMPUTE.as_raw());

/// Vulkan 1.4, for which `ash` has no constant yet.
const VULKAN_1_4: u32 = vk::make_api_version(0, 1, 4, 0);

/// The descriptors that a pipeline has besides a table of textures, with some reserve: they count
/// towards the same limits.
const OTHER_DESCRIPTORS: u32 = 64;

impl Offer {
    /// Reads everything that an adapter offers, including frames in windows if the instance is for
    /// `windows`.
    ///
    /// # Safety
    /// `physical` is of `instance`.
    ///
    /// # Errors
    /// A failed call.
    pub(crate) unsafe fn read(
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        windows: Option<&WindowFunctions>,
    ) -> Result<Self, Error> {
        // SAFETY: the caller's promise, here and below.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        let family = families.iter().position(|family| family.queue_flags.contains(QUEUE_FLAGS));
        let family = family.map_or(u32::MAX, |index| index as u32);
        // SAFETY: as above.
        let mut offer = unsafe { Self::of_family(instance, physical, family) }?;
        if offer.api_version < vk::API_VERSION_1_3 {
            // The feature structures must not be queried on such a device.
            return Ok(offer);
        }
        // SAFETY: as above.
        let there = unsafe { extensions_of(instance, physical) }?;
        let names = there.iter().filter_map(|there| there.extension_name_as_c_str().ok());
        let names: Vec<_> = names.filter(|name| is_usable(name, windows)).collect();
        let mut structures = FeatureStructures::default();
        let mut chain = structures.link(&names);
        // SAFETY: the chain contains only structures that this device's version and extensions
        // support.
        unsafe { instance.get_physical_device_features2(physical, &mut chain) };
        structures.core = chain.features;
        offer.features = Features::from(&structures);
        offer.extensions = names.into_iter().map(CString::from).collect();
        Ok(offer)
    }

    /// Reads the offer of a physical device with no extension and no feature enabled.
    ///
    /// # Safety
    /// `physical` is of `instance`.
    ///
    /// # Errors
    /// A failed call.
    pub(crate) unsafe fn of_family(
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        family: u32,
    ) -> Result<Self, Error> {
        // SAFETY: the caller's promise, here and below.
        let properties = unsafe { instance.get_physical_device_properties(physical) };
        // SAFETY: as above.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        let format = vk::Format::D32_SFLOAT;
        // SAFETY: as above; a format of the core.
        let depth = unsafe { instance.get_physical_device_format_properties(physical, format) };
        let needed =
            vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT | vk::FormatFeatureFlags::TRANSFER_SRC;
        let of_family = families.get(family as usize);
        let of_family = of_family.filter(|family| family.queue_flags.contains(QUEUE_FLAGS));
        Ok(Self {
            api_version: properties.api_version,
            queue_family: of_family.map(|_| family),
            timestamp_bits: of_family.map_or(0, |family| family.timestamp_valid_bits),
            stage_storage_buffers: properties.limits.max_per_stage_descriptor_storage_buffers,
            has_depth_32: depth.optimal_tiling_features.contains(needed),
            // SAFETY: as above.
            indexed_textures: unsafe { indexed_textures(instance, physical, &properties) },
            // SAFETY: as above.
            capture: unsafe { capture_limits(instance, physical, &properties) }?,
            // SAFETY: as above.
            driver: unsafe { driver_of(instance, physical, &properties) },
            ..Self::default()
        })
    }

    /// Adds the extensions and features that a host enabled. The host itself shows frames in
    /// windows.
    pub(crate) fn turn_on(&mut self, extensions: Vec<CString>, features: Features) {
        self.extensions = extensions;
        self.extensions.retain(|name| is_usable(name, None));
        self.features = features;
    }

    /// Returns true if the driver offers multiview but draws wrong images with it, as Mesa's
    /// llvmpipe 22.3 does, which draws most of the contents of later views to the first layer.
    /// Version 25.0 draws them right. It is the first that was tested after 22.3, and it has Vulkan
    /// 1.4; the version of the driver is 1 in both.
    pub(crate) fn draws_views_wrong(&self) -> bool {
        self.driver == vk::DriverId::MESA_LLVMPIPE && self.api_version < VULKAN_1_4
    }

    /// Returns true if the driver takes the depth of a sample at a different position than its
    /// coverage, as Google's SwiftShader does. For a triangle that is seen edge-on, such a depth
    /// does not lie on the triangle.
    pub(crate) fn misplaces_sample_depths(&self) -> bool {
        self.driver == vk::DriverId::GOOGLE_SWIFTSHADER
    }

    /// Returns true if the driver uses the count of a counted indirect draw for the next plain
    /// indirect draw in the command buffer, as Mesa's llvmpipe 22.3 and 25.0 do. No other version
    /// was tested.
    pub(crate) fn keeps_draw_counts(&self) -> bool {
        self.driver == vk::DriverId::MESA_LLVMPIPE
    }

    /// Returns true if the extension may be used.
    pub(crate) fn has(&self, extension: &CStr) -> bool {
        self.extensions.iter().any(|there| there.as_c_str() == extension)
    }
}

/// Returns the driver of an adapter; a default if the Vulkan version is too old to report it.
///
/// # Safety
/// `physical` is of `instance`, with these properties.
unsafe fn driver_of(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    properties: &vk::PhysicalDeviceProperties,
) -> vk::DriverId {
    if properties.api_version < vk::API_VERSION_1_2 {
        return vk::DriverId::default();
    }
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: driver properties are core since 1.2, checked above.
    unsafe { instance.get_physical_device_properties2(physical, &mut chain) };
    driver.driver_id
}

/// Returns the most textures that shaders can index; 0 if the Vulkan version is too old to report
/// it.
///
/// # Safety
/// `physical` is of `instance`, with these properties.
unsafe fn indexed_textures(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    properties: &vk::PhysicalDeviceProperties,
) -> u32 {
    if properties.api_version < vk::API_VERSION_1_2 {
        return 0;
    }
    let mut limits = vk::PhysicalDeviceVulkan12Properties::default();
    let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
    // SAFETY: properties of Vulkan 1.2, checked above.
    unsafe { instance.get_physical_device_properties2(physical, &mut chain) };
    let all = [
        limits.max_per_stage_descriptor_update_after_bind_samplers,
        limits.max_per_stage_descriptor_update_after_bind_sampled_images,
        limits.max_per_stage_update_after_bind_resources,
        limits.max_descriptor_set_update_after_bind_samplers,
        limits.max_descriptor_set_update_after_bind_sampled_images,
        limits.max_update_after_bind_descriptors_in_all_pools,
    ];
    all.into_iter().min().unwrap_or(0).saturating_sub(OTHER_DESCRIPTORS)
}

/// Returns the limits of captures; 0 if there is no transform feedback.
///
/// # Safety
/// `physical` is of `instance`, with these properties.
unsafe fn capture_limits(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    properties: &vk::PhysicalDeviceProperties,
) -> Result<CaptureLimits, Error> {
    // SAFETY: the caller's promise.
    let there = unsafe { extensions_of(instance, physical) }?;
    let wanted = Ok(ext::transform_feedback::NAME);
    let has_extension = there.iter().any(|there| there.extension_name_as_c_str() == wanted);
    if properties.api_version < vk::API_VERSION_1_2 || !has_extension {
        return Ok(CaptureLimits::default());
    }
    let mut feedback = vk::PhysicalDeviceTransformFeedbackPropertiesEXT::default();
    let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut feedback);
    // SAFETY: the device supports the structure, because it has the extension.
    unsafe { instance.get_physical_device_properties2(physical, &mut chain) };
    Ok(CaptureLimits {
        patch_points: properties.limits.max_tessellation_patch_size,
        level: properties.limits.max_tessellation_generation_level,
        buffer_bytes: feedback.max_transform_feedback_buffer_size,
    })
}

/// Returns the extensions of a device. A failure is an error, and not a device without extensions:
/// what one read of an offer has, the next one must have, too.
///
/// # Safety
/// `physical` is of `instance`.
unsafe fn extensions_of(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
) -> Result<Vec<vk::ExtensionProperties>, Error> {
    // SAFETY: the caller's promise.
    unsafe { instance.enumerate_device_extension_properties(physical) }
        .called("vkEnumerateDeviceExtensionProperties")
}

/// Returns true if the instance has the instance extension that a device extension depends on.
fn is_usable(extension: &CStr, windows: Option<&WindowFunctions>) -> bool {
    let maintenance = [KHR_SWAPCHAIN_MAINTENANCE1, ext::swapchain_maintenance1::NAME];
    match windows {
        Some(windows) if maintenance.contains(&extension) => {
            windows.present_fences.contains(&extension)
        }
        None => extension != khr::swapchain::NAME && !maintenance.contains(&extension),
        Some(_) => true,
    }
}
