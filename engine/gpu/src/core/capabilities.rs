//! The table of capabilities: required and optional ones, each with the features and extensions
//! that it needs.

use std::ffi::CStr;

use ash::{ext, google, khr, nv, vk};

use crate::core::features::{Features, KHR_SWAPCHAIN_MAINTENANCE1};
use crate::core::offer::{CaptureLimits, Offer};

/// A capability that a device must have. A device without it is rejected, and the error names the
/// capability.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RequiredFeature {
    /// Core 1.3: dynamic rendering, synchronization2.
    Vulkan13,
    /// Rendering without render-pass objects.
    DynamicRendering,
    /// Barriers and submits of `VK_KHR_synchronization2`.
    Synchronization2,
    /// A counter that proves which frames are over.
    TimelineSemaphore,
    /// One call that draws a contiguous range of objects.
    MultiDrawIndirect,
    /// Indirect draws with a first instance other than 0.
    DrawIndirectFirstInstance,
    /// A queue family with graphics and compute.
    GraphicsQueue,
    /// 32-bit float depth, drawn to and copied from.
    Depth32,
    /// The number of storage buffers per shader stage that the engine's shaders need.
    StorageBuffers,
    /// Samplers that compare depths, chosen when a descriptor is written. Only devices with
    /// `VK_KHR_portability_subset` may lack them.
    ComparisonSamplers,
}

/// The most storage buffers that a stage of the engine's shaders binds (`list_sizes.comp`). Vulkan
/// guarantees four.
pub(crate) const STAGE_STORAGE_BUFFERS: u32 = 7;

/// The most storage buffers that a stage binds if section planes cut
/// (`surface_shadowed_section.frag`) or if it stores fragments
/// (`surface_shadowed_sorted_section.frag`).
pub(crate) const SECTION_STORAGE_BUFFERS: u32 = 9;

/// The limits that a capture of tessellated triangles needs: patches of 16 control points, levels
/// up to 64, and a buffer of the size that every storage buffer may have. Vulkan guarantees these
/// limits on devices with tessellation and transform feedback.
pub(crate) const LEAST_CAPTURE: CaptureLimits =
    CaptureLimits { patch_points: 16, level: 64, buffer_bytes: 1 << 27 };

/// The least number of textures that is worth a table. Devices with descriptor indexing have half a
/// million (specification, "Required Limits").
pub(crate) const LEAST_INDEXED_TEXTURES: u32 = 1024;

impl RequiredFeature {
    /// All required capabilities, in the order of display.
    pub const ALL: [RequiredFeature; 10] = [
        RequiredFeature::Vulkan13,
        RequiredFeature::DynamicRendering,
        RequiredFeature::Synchronization2,
        RequiredFeature::TimelineSemaphore,
        RequiredFeature::MultiDrawIndirect,
        RequiredFeature::DrawIndirectFirstInstance,
        RequiredFeature::GraphicsQueue,
        RequiredFeature::Depth32,
        RequiredFeature::StorageBuffers,
        RequiredFeature::ComparisonSamplers,
    ];

    /// Returns the name shown to the user.
    pub fn name(self) -> &'static str {
        match self {
            RequiredFeature::Vulkan13 => "Vulkan 1.3",
            RequiredFeature::DynamicRendering => "dynamicRendering",
            RequiredFeature::Synchronization2 => "synchronization2",
            RequiredFeature::TimelineSemaphore => "timelineSemaphore",
            RequiredFeature::MultiDrawIndirect => "multiDrawIndirect",
            RequiredFeature::DrawIndirectFirstInstance => "drawIndirectFirstInstance",
            RequiredFeature::GraphicsQueue => "a queue with graphics and compute",
            RequiredFeature::Depth32 => "D32_SFLOAT as a depth attachment that can be copied",
            RequiredFeature::StorageBuffers => "maxPerStageDescriptorStorageBuffers of at least 7",
            RequiredFeature::ComparisonSamplers => "mutableComparisonSamplers",
        }
    }

    /// Returns true if `purpose` requires the capability.
    pub fn is_for(self, purpose: Purpose) -> bool {
        match self {
            // An executor neither submits work nor creates images, and draws no shadows.
            RequiredFeature::TimelineSemaphore
            | RequiredFeature::Depth32
            | RequiredFeature::ComparisonSamplers => purpose == Purpose::Renderer,
            _ => true,
        }
    }

    /// Returns the features that the capability needs.
    pub fn features(self) -> Features {
        let none = Features::default();
        match self {
            RequiredFeature::DynamicRendering => Features { dynamic_rendering: true, ..none },
            RequiredFeature::Synchronization2 => Features { synchronization2: true, ..none },
            RequiredFeature::TimelineSemaphore => Features { timeline_semaphore: true, ..none },
            RequiredFeature::MultiDrawIndirect => Features { multi_draw_indirect: true, ..none },
            RequiredFeature::DrawIndirectFirstInstance => {
                Features { draw_indirect_first_instance: true, ..none }
            }
            RequiredFeature::Vulkan13
            | RequiredFeature::GraphicsQueue
            | RequiredFeature::Depth32
            | RequiredFeature::StorageBuffers
            // Most devices do not report it: see [`OptionalFeature::PortabilitySubset`].
            | RequiredFeature::ComparisonSamplers => none,
        }
    }

    fn is_in(self, offer: &Offer) -> bool {
        match self {
            RequiredFeature::Vulkan13 => offer.api_version >= vk::API_VERSION_1_3,
            RequiredFeature::GraphicsQueue => offer.queue_family.is_some(),
            RequiredFeature::Depth32 => offer.has_depth_32,
            RequiredFeature::StorageBuffers => offer.stage_storage_buffers >= STAGE_STORAGE_BUFFERS,
            RequiredFeature::ComparisonSamplers => {
                !offer.has(khr::portability_subset::NAME)
                    || offer.features.mutable_comparison_samplers
            }
            feature => feature.features().without(offer.features).is_empty(),
        }
    }
}

/// The part of the engine that a device is used for. Each part has its own requirements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The executor of plans, which records into the command buffers of a host.
    Executor,
    /// The renderer, which creates images, submits work and uses everything else.
    Renderer,
}

/// A capability that a device may have; each has a fallback.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OptionalFeature {
    /// `VK_EXT_conditional_rendering`: the GPU skips draws by 32 bits in memory.
    ConditionalRendering,
    /// Indirect draws whose count is read by the GPU.
    DrawIndirectCount,
    /// Exact numbers of samples from occlusion queries.
    PreciseQueries,
    /// Queries that are reset by the CPU: some drivers wait for each query that a command resets.
    HostQueryReset,
    /// Timestamps on the graphics queue.
    Timestamps,
    /// Fragment shaders that write to storage buffers.
    FragmentStores,
    /// `VK_NV_representative_fragment_test`: if several fragments of a primitive pass the depth
    /// test, a single one is enough to set a flag.
    RepresentativeFragments,
    /// Renderings of several views at once, each to a layer of the image.
    Multiview,
    /// Triangles drawn as their edges.
    Wireframe,
    /// Textures that stay sharp at grazing angles.
    Anisotropy,
    /// Thousands of textures that shaders access by index, with more added while frames are in
    /// flight ([`TextureTable`](crate::TextureTable)).
    DescriptorIndexing,
    /// Block-compressed textures, BC1 to BC7, as on desktop GPUs.
    BcTextures,
    /// Block-compressed textures, ASTC, as on mobile GPUs.
    AstcTextures,
    /// Depth per sample, taken at the position of the sample's coverage, as Vulkan requires.
    /// Without it no test of a proxy is exact with several samples per pixel.
    SampleDepths,
    /// Shaders that create triangles from triangles.
    GeometryShaders,
    /// Tessellation shaders whose triangles `VK_EXT_transform_feedback` captures in a buffer.
    TessellationCapture,
    /// Depths beyond the near and far plane that are clamped instead of cut off.
    DepthClamp,
    /// The storage buffers of passes that section planes cut, or that store fragments to be sorted.
    SectionBuffers,
    /// Reading the clocks of GPU and CPU at once.
    CalibratedTimestamps,
    /// A description of the fault that lost the device ([`crate::LossReport`]).
    DeviceFault,
    /// `VK_KHR_portability_subset`, of a Vulkan on top of another interface such as Metal. A device
    /// that has the extension must be created with it (VUID-VkDeviceCreateInfo-pProperties-04451).
    PortabilitySubset,
    /// Frames in windows. This capability and the ones below exist only if the instance was created
    /// for windows ([`crate::InstanceOptions::windows`]).
    Swapchain,
    /// Fences that are signalled when a present no longer uses its semaphore and image.
    PresentFences,
    /// Waiting until a present is on the screen.
    PresentWait,
    /// The times at which presents appeared on the screen, and the duration of a refresh.
    DisplayTiming,
}

impl OptionalFeature {
    /// All optional capabilities.
    pub const ALL: [OptionalFeature; 25] = [
        OptionalFeature::ConditionalRendering,
        OptionalFeature::DrawIndirectCount,
        OptionalFeature::PreciseQueries,
        OptionalFeature::HostQueryReset,
        OptionalFeature::Timestamps,
        OptionalFeature::FragmentStores,
        OptionalFeature::RepresentativeFragments,
        OptionalFeature::Multiview,
        OptionalFeature::Wireframe,
        OptionalFeature::Anisotropy,
        OptionalFeature::DescriptorIndexing,
        OptionalFeature::BcTextures,
        OptionalFeature::AstcTextures,
        OptionalFeature::SampleDepths,
        OptionalFeature::GeometryShaders,
        OptionalFeature::TessellationCapture,
        OptionalFeature::DepthClamp,
        OptionalFeature::SectionBuffers,
        OptionalFeature::CalibratedTimestamps,
        OptionalFeature::DeviceFault,
        OptionalFeature::PortabilitySubset,
        OptionalFeature::Swapchain,
        OptionalFeature::PresentFences,
        OptionalFeature::PresentWait,
        OptionalFeature::DisplayTiming,
    ];

    /// Returns the name shown to the user.
    pub fn name(self) -> &'static str {
        match self {
            OptionalFeature::ConditionalRendering => "VK_EXT_conditional_rendering",
            OptionalFeature::DrawIndirectCount => "drawIndirectCount",
            OptionalFeature::PreciseQueries => "occlusionQueryPrecise",
            OptionalFeature::HostQueryReset => "hostQueryReset",
            OptionalFeature::Timestamps => "timestamps",
            OptionalFeature::FragmentStores => "fragmentStoresAndAtomics",
            OptionalFeature::RepresentativeFragments => "VK_NV_representative_fragment_test",
            OptionalFeature::Multiview => "multiview",
            OptionalFeature::Wireframe => "fillModeNonSolid",
            OptionalFeature::Anisotropy => "samplerAnisotropy",
            OptionalFeature::DescriptorIndexing => "descriptor indexing of sampled images",
            OptionalFeature::BcTextures => "textureCompressionBC",
            OptionalFeature::AstcTextures => "textureCompressionASTC_LDR",
            OptionalFeature::SampleDepths => "depths of samples at their own places",
            OptionalFeature::GeometryShaders => "geometryShader",
            OptionalFeature::TessellationCapture => {
                "tessellationShader and VK_EXT_transform_feedback"
            }
            OptionalFeature::DepthClamp => "depthClamp",
            OptionalFeature::SectionBuffers => "maxPerStageDescriptorStorageBuffers of at least 9",
            OptionalFeature::CalibratedTimestamps => "VK_EXT_calibrated_timestamps",
            OptionalFeature::DeviceFault => "VK_EXT_device_fault",
            OptionalFeature::PortabilitySubset => "VK_KHR_portability_subset",
            OptionalFeature::Swapchain => "VK_KHR_swapchain",
            OptionalFeature::PresentFences => "VK_EXT_swapchain_maintenance1",
            OptionalFeature::PresentWait => "VK_KHR_present_wait",
            OptionalFeature::DisplayTiming => "VK_GOOGLE_display_timing",
        }
    }

    /// Returns true if `purpose` can use the capability.
    pub fn is_for(self, purpose: Purpose) -> bool {
        match self {
            OptionalFeature::ConditionalRendering
            | OptionalFeature::DrawIndirectCount
            | OptionalFeature::PreciseQueries
            | OptionalFeature::HostQueryReset
            | OptionalFeature::Timestamps
            | OptionalFeature::FragmentStores
            | OptionalFeature::RepresentativeFragments
            | OptionalFeature::SampleDepths
            | OptionalFeature::SectionBuffers
            | OptionalFeature::PortabilitySubset
            | OptionalFeature::Multiview => true,
            _ => purpose == Purpose::Renderer,
        }
    }

    /// Returns the features that the capability needs.
    pub fn features(self) -> Features {
        let none = Features::default();
        match self {
            OptionalFeature::ConditionalRendering => {
                Features { conditional_rendering: true, ..none }
            }
            OptionalFeature::DrawIndirectCount => Features { draw_indirect_count: true, ..none },
            OptionalFeature::PreciseQueries => Features { occlusion_query_precise: true, ..none },
            OptionalFeature::HostQueryReset => Features { host_query_reset: true, ..none },
            OptionalFeature::FragmentStores => {
                Features { fragment_stores_and_atomics: true, ..none }
            }
            OptionalFeature::RepresentativeFragments => {
                Features { representative_fragment_test: true, ..none }
            }
            OptionalFeature::Multiview => Features { multiview: true, ..none },
            OptionalFeature::Wireframe => Features { fill_mode_non_solid: true, ..none },
            OptionalFeature::Anisotropy => Features { sampler_anisotropy: true, ..none },
            OptionalFeature::DescriptorIndexing => Features {
                runtime_descriptor_array: true,
                shader_sampled_image_array_non_uniform_indexing: true,
                descriptor_binding_partially_bound: true,
                descriptor_binding_sampled_image_update_after_bind: true,
                descriptor_binding_update_unused_while_pending: true,
                ..none
            },
            OptionalFeature::BcTextures => Features { texture_compression_bc: true, ..none },
            OptionalFeature::AstcTextures => {
                Features { texture_compression_astc_ldr: true, ..none }
            }
            OptionalFeature::GeometryShaders => Features { geometry_shader: true, ..none },
            OptionalFeature::TessellationCapture => {
                Features { tessellation_shader: true, transform_feedback: true, ..none }
            }
            OptionalFeature::DepthClamp => Features { depth_clamp: true, ..none },
            OptionalFeature::DeviceFault => Features { device_fault: true, ..none },
            OptionalFeature::PortabilitySubset => {
                Features { mutable_comparison_samplers: true, ..none }
            }
            OptionalFeature::PresentFences => Features { swapchain_maintenance1: true, ..none },
            OptionalFeature::PresentWait => {
                Features { present_id: true, present_wait: true, ..none }
            }
            OptionalFeature::Timestamps
            | OptionalFeature::SampleDepths
            | OptionalFeature::SectionBuffers
            | OptionalFeature::CalibratedTimestamps
            | OptionalFeature::Swapchain
            | OptionalFeature::DisplayTiming => none,
        }
    }

    /// Returns the extensions that the capability needs, each with all of its names. Any one of the
    /// names is enough; the first is preferred.
    pub fn extensions(self) -> &'static [&'static [&'static CStr]] {
        const SWAPCHAIN: &[&CStr] = &[khr::swapchain::NAME];
        const MAINTENANCE: &[&CStr] =
            &[KHR_SWAPCHAIN_MAINTENANCE1, ext::swapchain_maintenance1::NAME];
        match self {
            OptionalFeature::ConditionalRendering => &[&[ext::conditional_rendering::NAME]],
            OptionalFeature::RepresentativeFragments => {
                &[&[nv::representative_fragment_test::NAME]]
            }
            OptionalFeature::TessellationCapture => &[&[ext::transform_feedback::NAME]],
            OptionalFeature::CalibratedTimestamps => &[&[ext::calibrated_timestamps::NAME]],
            OptionalFeature::DeviceFault => &[&[ext::device_fault::NAME]],
            OptionalFeature::PortabilitySubset => &[&[khr::portability_subset::NAME]],
            OptionalFeature::Swapchain => &[SWAPCHAIN],
            OptionalFeature::PresentFences => &[SWAPCHAIN, MAINTENANCE],
            OptionalFeature::PresentWait => {
                &[SWAPCHAIN, &[khr::present_id::NAME], &[khr::present_wait::NAME]]
            }
            OptionalFeature::DisplayTiming => &[SWAPCHAIN, &[google::display_timing::NAME]],
            _ => &[],
        }
    }

    fn is_in(self, offer: &Offer) -> bool {
        let is_flawed = match self {
            OptionalFeature::Timestamps | OptionalFeature::CalibratedTimestamps => {
                offer.timestamp_bits == 0
            }
            OptionalFeature::Multiview => offer.draws_views_wrong(),
            OptionalFeature::SampleDepths => offer.misplaces_sample_depths(),
            OptionalFeature::DescriptorIndexing => offer.indexed_textures < LEAST_INDEXED_TEXTURES,
            OptionalFeature::TessellationCapture => !offer.capture.holds(LEAST_CAPTURE),
            OptionalFeature::SectionBuffers => {
                offer.stage_storage_buffers < SECTION_STORAGE_BUFFERS
            }
            _ => false,
        };
        let has_any = |names: &&[&'static CStr]| names.iter().any(|name| offer.has(name));
        !is_flawed
            && self.features().without(offer.features).is_empty()
            && self.extensions().iter().all(has_any)
    }
}

/// The capabilities of one device.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Capabilities {
    /// The required capabilities that the device lacks.
    pub missing: Vec<RequiredFeature>,
    /// The optional capabilities that the device has.
    pub optional: Vec<OptionalFeature>,
    /// True if a plain indirect draw takes the count of the counted draw before it.
    pub(crate) keeps_draw_counts: bool,
}

impl Capabilities {
    /// Returns true if the device has `optional`.
    pub fn has(&self, optional: OptionalFeature) -> bool {
        self.optional.contains(&optional)
    }

    /// Returns true if unconditional draws also need a count, because plain indirect draws take the
    /// count of the counted draw before them. On other drivers they must have none: NVIDIA's driver
    /// (580, on an H100) hangs in draws whose count is `maxDrawIndirectCount`, which is 2^32 - 1
    /// there.
    pub(crate) fn keeps_draw_counts(&self) -> bool {
        self.keeps_draw_counts
    }

    /// Derives the capabilities from an offer.
    pub(crate) fn of(offer: &Offer) -> Self {
        let missing = RequiredFeature::ALL.into_iter().filter(|what| !what.is_in(offer));
        let missing = if offer.api_version < vk::API_VERSION_1_3 {
            // The features of such a device must not be queried.
            missing.filter(|what| what.features().is_empty()).collect()
        } else {
            missing.collect()
        };
        let optional: Vec<OptionalFeature> =
            OptionalFeature::ALL.into_iter().filter(|what| what.is_in(offer)).collect();
        let keeps_draw_counts =
            offer.keeps_draw_counts() && optional.contains(&OptionalFeature::DrawIndirectCount);
        Self { missing, optional, keeps_draw_counts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_old_lavapipe_draws_several_views_wrong() {
        let offer = |driver, minor| Offer {
            api_version: vk::make_api_version(0, 1, minor, 230),
            features: Features { multiview: true, ..Features::default() },
            driver,
            ..Offer::default()
        };
        let has = |offer: &Offer| Capabilities::of(offer).has(OptionalFeature::Multiview);
        assert!(!has(&offer(vk::DriverId::MESA_LLVMPIPE, 3)));
        assert!(has(&offer(vk::DriverId::MESA_LLVMPIPE, 4)));
        assert!(has(&offer(vk::DriverId::GOOGLE_SWIFTSHADER, 3)));
    }

    #[test]
    fn only_drivers_that_keep_a_draw_count_take_one_for_every_draw() {
        let offer = |driver| Offer {
            api_version: vk::API_VERSION_1_3,
            features: Features { draw_indirect_count: true, ..Features::default() },
            driver,
            ..Offer::default()
        };
        let keeps = |offer: &Offer| Capabilities::of(offer).keeps_draw_counts();
        assert!(keeps(&offer(vk::DriverId::MESA_LLVMPIPE)));
        assert!(!keeps(&offer(vk::DriverId::NVIDIA_PROPRIETARY)));
        let without = Features::default();
        assert!(!keeps(&Offer { features: without, ..offer(vk::DriverId::MESA_LLVMPIPE) }));
    }
}
