//! The Vulkan features that the engine uses, and the structures that contain them.

use std::ffi::CStr;

use ash::{ext, khr, nv, vk};

/// Declares [`Features`] and its conversion to and from the structures of Vulkan: each structure
/// with its features.
macro_rules! features {
    ($($structure:ident { $($field:ident $name:literal)+ })+) => {
        /// Features of a device that the engine uses, each by its Vulkan name; true for enabled.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        pub struct Features {
            $($(#[doc = concat!("`", $name, "`.")] pub $field: bool,)+)+
        }

        impl Features {
            /// Returns the Vulkan names of the enabled features.
            pub fn names(self) -> impl Iterator<Item = &'static str> {
                let all = [$($((self.$field, $name),)+)+];
                all.into_iter().filter_map(|(is_on, name)| is_on.then_some(name))
            }

            /// Returns the features that are enabled in either set.
            pub fn union(self, other: Self) -> Self {
                Self { $($($field: self.$field || other.$field,)+)+ }
            }

            /// Returns the features that are enabled here but not in `other`.
            pub fn without(self, other: Self) -> Self {
                Self { $($($field: self.$field && !other.$field,)+)+ }
            }

            /// Returns the Vulkan structures with these features enabled and all others disabled.
            pub fn structures(self) -> FeatureStructures {
                let mut structures = FeatureStructures::default();
                $($(structures.$structure.$field = self.$field.into();)+)+
                structures
            }
        }

        impl From<&FeatureStructures> for Features {
            fn from(structures: &FeatureStructures) -> Self {
                Self { $($($field: structures.$structure.$field == vk::TRUE,)+)+ }
            }
        }
    };
}

features! {
    core {
        multi_draw_indirect "multiDrawIndirect"
        draw_indirect_first_instance "drawIndirectFirstInstance"
        occlusion_query_precise "occlusionQueryPrecise"
        fragment_stores_and_atomics "fragmentStoresAndAtomics"
        fill_mode_non_solid "fillModeNonSolid"
        sampler_anisotropy "samplerAnisotropy"
        texture_compression_bc "textureCompressionBC"
        texture_compression_astc_ldr "textureCompressionASTC_LDR"
        geometry_shader "geometryShader"
        depth_clamp "depthClamp"
        tessellation_shader "tessellationShader"
    }
    vulkan_11 {
        multiview "multiview"
    }
    vulkan_12 {
        timeline_semaphore "timelineSemaphore"
        draw_indirect_count "drawIndirectCount"
        host_query_reset "hostQueryReset"
        runtime_descriptor_array "runtimeDescriptorArray"
        shader_sampled_image_array_non_uniform_indexing "shaderSampledImageArrayNonUniformIndexing"
        descriptor_binding_partially_bound "descriptorBindingPartiallyBound"
        descriptor_binding_sampled_image_update_after_bind "descriptorBindingSampledImageUpdateAfterBind"
        descriptor_binding_update_unused_while_pending "descriptorBindingUpdateUnusedWhilePending"
    }
    vulkan_13 {
        dynamic_rendering "dynamicRendering"
        synchronization2 "synchronization2"
    }
    conditional {
        conditional_rendering "conditionalRendering"
    }
    capture {
        transform_feedback "transformFeedback"
    }
    representative {
        representative_fragment_test "representativeFragmentTest"
    }
    fault {
        device_fault "deviceFault"
    }
    present_fences {
        swapchain_maintenance1 "swapchainMaintenance1"
    }
    ids {
        present_id "presentId"
    }
    waits {
        present_wait "presentWait"
    }
    portability {
        mutable_comparison_samplers "mutableComparisonSamplers"
    }
}

impl Features {
    /// Returns true if no feature is enabled.
    pub fn is_empty(self) -> bool {
        self == Self::default()
    }
}

/// The Vulkan structures that contain [`Features`], for the creation of a device.
#[derive(Debug, Clone, Copy, Default)]
pub struct FeatureStructures {
    /// The features of Vulkan 1.0.
    pub core: vk::PhysicalDeviceFeatures,
    /// The features of Vulkan 1.1.
    pub vulkan_11: vk::PhysicalDeviceVulkan11Features<'static>,
    /// The features of Vulkan 1.2.
    pub vulkan_12: vk::PhysicalDeviceVulkan12Features<'static>,
    /// The features of Vulkan 1.3.
    pub vulkan_13: vk::PhysicalDeviceVulkan13Features<'static>,
    /// The feature of `VK_EXT_conditional_rendering`.
    pub conditional: vk::PhysicalDeviceConditionalRenderingFeaturesEXT<'static>,
    capture: vk::PhysicalDeviceTransformFeedbackFeaturesEXT<'static>,
    representative: vk::PhysicalDeviceRepresentativeFragmentTestFeaturesNV<'static>,
    fault: vk::PhysicalDeviceFaultFeaturesEXT<'static>,
    present_fences: vk::PhysicalDeviceSwapchainMaintenance1FeaturesEXT<'static>,
    ids: vk::PhysicalDevicePresentIdFeaturesKHR<'static>,
    waits: vk::PhysicalDevicePresentWaitFeaturesKHR<'static>,
    portability: vk::PhysicalDevicePortabilitySubsetFeaturesKHR<'static>,
}

/// The newer name of `VK_EXT_swapchain_maintenance1`, with the same structures.
pub(crate) const KHR_SWAPCHAIN_MAINTENANCE1: &CStr = c"VK_KHR_swapchain_maintenance1";

impl FeatureStructures {
    /// Links the structures into one chain. Leaves out structures of extensions that are not in
    /// `extensions`, because Vulkan rejects unknown structures.
    pub fn link(&mut self, extensions: &[&CStr]) -> vk::PhysicalDeviceFeatures2<'_> {
        let has = |name: &CStr| extensions.contains(&name);
        let mut chain = vk::PhysicalDeviceFeatures2::default()
            .features(self.core)
            .push_next(&mut self.vulkan_11)
            .push_next(&mut self.vulkan_12)
            .push_next(&mut self.vulkan_13);
        if has(ext::conditional_rendering::NAME) {
            chain = chain.push_next(&mut self.conditional);
        }
        if has(ext::transform_feedback::NAME) {
            chain = chain.push_next(&mut self.capture);
        }
        if has(nv::representative_fragment_test::NAME) {
            chain = chain.push_next(&mut self.representative);
        }
        if has(ext::device_fault::NAME) {
            chain = chain.push_next(&mut self.fault);
        }
        if has(KHR_SWAPCHAIN_MAINTENANCE1) || has(ext::swapchain_maintenance1::NAME) {
            chain = chain.push_next(&mut self.present_fences);
        }
        if has(khr::present_id::NAME) {
            chain = chain.push_next(&mut self.ids);
        }
        if has(khr::present_wait::NAME) {
            chain = chain.push_next(&mut self.waits);
        }
        if has(khr::portability_subset::NAME) {
            chain = chain.push_next(&mut self.portability);
        }
        chain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn features_go_through_the_structures_and_back() {
        let some = Features {
            multi_draw_indirect: true,
            draw_indirect_count: true,
            conditional_rendering: true,
            ..Features::default()
        };
        let mut structures = some.structures();
        assert_eq!(Features::from(&structures), some);
        let names: Vec<_> = some.names().collect();
        assert_eq!(names, ["multiDrawIndirect", "drawIndirectCount", "conditionalRendering"]);
        assert_eq!(structures.link(&[]).features.multi_draw_indirect, vk::TRUE);
        assert_eq!(structures.vulkan_12.draw_indirect_count, vk::TRUE);
        let other = Features { draw_indirect_count: true, ..Features::default() };
        assert_eq!(some.without(other).union(other), some);
        assert!(!some.is_empty() && some.without(some).is_empty());
    }

    #[test]
    fn structures_of_unknown_extensions_are_not_linked() {
        let mut structures = FeatureStructures::default();
        // Vulkan 1.3's structure was pushed last, so the chain begins with it.
        let chain = structures.link(&[khr::swapchain::NAME]);
        let first = chain.p_next.cast::<vk::BaseOutStructure<'_>>();
        // SAFETY: the chain points to the structures above, which are alive.
        let kind = unsafe { (*first).s_type };
        assert_eq!(kind, vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
        let mut structures = FeatureStructures::default();
        let chain = structures.link(&[ext::conditional_rendering::NAME]);
        let first = chain.p_next.cast::<vk::BaseOutStructure<'_>>();
        // SAFETY: as above.
        let kind = unsafe { (*first).s_type };
        assert_eq!(kind, vk::StructureType::PHYSICAL_DEVICE_CONDITIONAL_RENDERING_FEATURES_EXT);
    }
}
