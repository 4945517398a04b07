//! The calls of the registry that return a `VkResult`, by their number of arguments. Written by
//! `ANTUMBRA_WRITE=1 cargo test --test fault_registry`.

use super::numbered::numbered;

numbered! {
    wrap_1:
        PFN_vkDeviceWaitIdle PFN_vkEndCommandBuffer PFN_vkEnumerateInstanceVersion
        PFN_vkQueueWaitIdle;
    wrap_2:
        PFN_vkAcquireFullScreenExclusiveModeEXT PFN_vkAcquireProfilingLockKHR
        PFN_vkAcquireWinrtDisplayNV PFN_vkBeginCommandBuffer PFN_vkCmdSetPerformanceMarkerINTEL
        PFN_vkCmdSetPerformanceOverrideINTEL PFN_vkCmdSetPerformanceStreamMarkerINTEL
        PFN_vkDebugMarkerSetObjectNameEXT PFN_vkDebugMarkerSetObjectTagEXT
        PFN_vkDeferredOperationJoinKHR PFN_vkEnumerateInstanceLayerProperties
        PFN_vkGetDeferredOperationResultKHR PFN_vkGetDeviceGroupPresentCapabilitiesKHR
        PFN_vkGetEventStatus PFN_vkGetFenceStatus PFN_vkGetSwapchainStatusKHR
        PFN_vkImportFenceFdKHR PFN_vkImportFenceWin32HandleKHR PFN_vkImportSemaphoreFdKHR
        PFN_vkImportSemaphoreWin32HandleKHR PFN_vkImportSemaphoreZirconHandleFUCHSIA
        PFN_vkInitializePerformanceApiINTEL PFN_vkQueuePresentKHR
        PFN_vkQueueSetPerformanceConfigurationINTEL PFN_vkReleaseDisplayEXT
        PFN_vkReleaseFullScreenExclusiveModeEXT PFN_vkReleasePerformanceConfigurationINTEL
        PFN_vkReleaseSwapchainImagesEXT PFN_vkResetCommandBuffer PFN_vkResetEvent
        PFN_vkSetDebugUtilsObjectNameEXT PFN_vkSetDebugUtilsObjectTagEXT PFN_vkSetEvent
        PFN_vkSignalSemaphore;
    wrap_3:
        PFN_vkAcquireDrmDisplayEXT PFN_vkAcquireNextImage2KHR
        PFN_vkAcquirePerformanceConfigurationINTEL PFN_vkAcquireXlibDisplayEXT
        PFN_vkAllocateCommandBuffers PFN_vkAllocateDescriptorSets
        PFN_vkBindAccelerationStructureMemoryNV PFN_vkBindBufferMemory2 PFN_vkBindImageMemory2
        PFN_vkCompileDeferredNV PFN_vkCopyAccelerationStructureKHR
        PFN_vkCopyAccelerationStructureToMemoryKHR PFN_vkCopyMemoryToAccelerationStructureKHR
        PFN_vkCopyMemoryToMicromapEXT PFN_vkCopyMicromapEXT PFN_vkCopyMicromapToMemoryEXT
        PFN_vkCreateDeferredOperationKHR PFN_vkCreateInstance PFN_vkDisplayPowerControlEXT
        PFN_vkEnumerateDeviceLayerProperties PFN_vkEnumerateInstanceExtensionProperties
        PFN_vkEnumeratePhysicalDeviceGroups PFN_vkEnumeratePhysicalDevices
        PFN_vkFlushMappedMemoryRanges PFN_vkGetAccelerationStructureOpaqueCaptureDescriptorDataEXT
        PFN_vkGetAndroidHardwareBufferPropertiesANDROID PFN_vkGetBufferCollectionPropertiesFUCHSIA
        PFN_vkGetBufferOpaqueCaptureDescriptorDataEXT PFN_vkGetDeviceFaultInfoEXT
        PFN_vkGetDeviceGroupSurfacePresentModes2EXT PFN_vkGetDeviceGroupSurfacePresentModesKHR
        PFN_vkGetDeviceSubpassShadingMaxWorkgroupSizeHUAWEI PFN_vkGetDisplayPlaneCapabilities2KHR
        PFN_vkGetDynamicRenderingTilePropertiesQCOM PFN_vkGetFenceFdKHR
        PFN_vkGetFenceWin32HandleKHR PFN_vkGetImageDrmFormatModifierPropertiesEXT
        PFN_vkGetImageOpaqueCaptureDescriptorDataEXT PFN_vkGetImageViewAddressNVX
        PFN_vkGetImageViewOpaqueCaptureDescriptorDataEXT
        PFN_vkGetMemoryAndroidHardwareBufferANDROID PFN_vkGetMemoryFdKHR
        PFN_vkGetMemoryRemoteAddressNV PFN_vkGetMemoryWin32HandleKHR
        PFN_vkGetMemoryZirconHandleFUCHSIA PFN_vkGetPerformanceParameterINTEL
        PFN_vkGetPhysicalDeviceCalibrateableTimeDomainsKHR
        PFN_vkGetPhysicalDeviceCooperativeMatrixPropertiesNV
        PFN_vkGetPhysicalDeviceDisplayPlaneProperties2KHR
        PFN_vkGetPhysicalDeviceDisplayPlanePropertiesKHR
        PFN_vkGetPhysicalDeviceDisplayProperties2KHR PFN_vkGetPhysicalDeviceDisplayPropertiesKHR
        PFN_vkGetPhysicalDeviceFragmentShadingRatesKHR
        PFN_vkGetPhysicalDeviceImageFormatProperties2
        PFN_vkGetPhysicalDeviceSupportedFramebufferMixedSamplesCombinationsNV
        PFN_vkGetPhysicalDeviceSurfaceCapabilities2EXT
        PFN_vkGetPhysicalDeviceSurfaceCapabilities2KHR
        PFN_vkGetPhysicalDeviceSurfaceCapabilitiesKHR PFN_vkGetPhysicalDeviceToolProperties
        PFN_vkGetPhysicalDeviceVideoCapabilitiesKHR PFN_vkGetPipelinePropertiesEXT
        PFN_vkGetRefreshCycleDurationGOOGLE PFN_vkGetSamplerOpaqueCaptureDescriptorDataEXT
        PFN_vkGetSemaphoreCounterValue PFN_vkGetSemaphoreFdKHR PFN_vkGetSemaphoreWin32HandleKHR
        PFN_vkGetSemaphoreZirconHandleFUCHSIA PFN_vkGetWinrtDisplayNV
        PFN_vkInvalidateMappedMemoryRanges PFN_vkResetCommandPool PFN_vkResetDescriptorPool
        PFN_vkResetFences PFN_vkSetBufferCollectionBufferConstraintsFUCHSIA
        PFN_vkSetBufferCollectionImageConstraintsFUCHSIA PFN_vkUpdateVideoSessionParametersKHR
        PFN_vkWaitSemaphores;
    wrap_4:
        PFN_vkAllocateMemory PFN_vkBindBufferMemory PFN_vkBindImageMemory
        PFN_vkBindVideoSessionMemoryKHR PFN_vkBuildMicromapsEXT
        PFN_vkCreateAccelerationStructureKHR PFN_vkCreateAccelerationStructureNV
        PFN_vkCreateAndroidSurfaceKHR PFN_vkCreateBuffer PFN_vkCreateBufferCollectionFUCHSIA
        PFN_vkCreateBufferView PFN_vkCreateCommandPool PFN_vkCreateCuFunctionNVX
        PFN_vkCreateCuModuleNVX PFN_vkCreateDebugReportCallbackEXT
        PFN_vkCreateDebugUtilsMessengerEXT PFN_vkCreateDescriptorPool
        PFN_vkCreateDescriptorSetLayout PFN_vkCreateDescriptorUpdateTemplate PFN_vkCreateDevice
        PFN_vkCreateDirectFBSurfaceEXT PFN_vkCreateDisplayPlaneSurfaceKHR PFN_vkCreateEvent
        PFN_vkCreateFence PFN_vkCreateFramebuffer PFN_vkCreateHeadlessSurfaceEXT
        PFN_vkCreateIOSSurfaceMVK PFN_vkCreateImage PFN_vkCreateImagePipeSurfaceFUCHSIA
        PFN_vkCreateImageView PFN_vkCreateIndirectCommandsLayoutNV PFN_vkCreateMacOSSurfaceMVK
        PFN_vkCreateMetalSurfaceEXT PFN_vkCreateMicromapEXT PFN_vkCreateOpticalFlowSessionNV
        PFN_vkCreatePipelineCache PFN_vkCreatePipelineLayout PFN_vkCreatePrivateDataSlot
        PFN_vkCreateQueryPool PFN_vkCreateRenderPass PFN_vkCreateRenderPass2 PFN_vkCreateSampler
        PFN_vkCreateSamplerYcbcrConversion PFN_vkCreateScreenSurfaceQNX PFN_vkCreateSemaphore
        PFN_vkCreateShaderModule PFN_vkCreateStreamDescriptorSurfaceGGP PFN_vkCreateSwapchainKHR
        PFN_vkCreateValidationCacheEXT PFN_vkCreateViSurfaceNN PFN_vkCreateVideoSessionKHR
        PFN_vkCreateVideoSessionParametersKHR PFN_vkCreateWaylandSurfaceKHR
        PFN_vkCreateWin32SurfaceKHR PFN_vkCreateXcbSurfaceKHR PFN_vkCreateXlibSurfaceKHR
        PFN_vkEnumerateDeviceExtensionProperties PFN_vkFreeDescriptorSets
        PFN_vkGetAccelerationStructureHandleNV PFN_vkGetDisplayModeProperties2KHR
        PFN_vkGetDisplayModePropertiesKHR PFN_vkGetDisplayPlaneCapabilitiesKHR
        PFN_vkGetDisplayPlaneSupportedDisplaysKHR PFN_vkGetDrmDisplayEXT
        PFN_vkGetFramebufferTilePropertiesQCOM PFN_vkGetMemoryFdPropertiesKHR
        PFN_vkGetMemoryHostPointerPropertiesEXT PFN_vkGetMemoryWin32HandleNV
        PFN_vkGetMemoryWin32HandlePropertiesKHR PFN_vkGetMemoryZirconHandlePropertiesFUCHSIA
        PFN_vkGetPastPresentationTimingGOOGLE PFN_vkGetPhysicalDeviceOpticalFlowImageFormatsNV
        PFN_vkGetPhysicalDevicePresentRectanglesKHR PFN_vkGetPhysicalDeviceSurfaceFormats2KHR
        PFN_vkGetPhysicalDeviceSurfaceFormatsKHR PFN_vkGetPhysicalDeviceSurfacePresentModes2EXT
        PFN_vkGetPhysicalDeviceSurfacePresentModesKHR PFN_vkGetPhysicalDeviceSurfaceSupportKHR
        PFN_vkGetPhysicalDeviceVideoFormatPropertiesKHR PFN_vkGetPipelineCacheData
        PFN_vkGetPipelineExecutableInternalRepresentationsKHR
        PFN_vkGetPipelineExecutablePropertiesKHR PFN_vkGetPipelineExecutableStatisticsKHR
        PFN_vkGetRandROutputDisplayEXT PFN_vkGetSwapchainCounterEXT
        PFN_vkGetSwapchainGrallocUsageANDROID PFN_vkGetSwapchainImagesKHR
        PFN_vkGetValidationCacheDataEXT PFN_vkGetVideoSessionMemoryRequirementsKHR
        PFN_vkMergePipelineCaches PFN_vkMergeValidationCachesEXT PFN_vkQueueBindSparse
        PFN_vkQueueSubmit PFN_vkQueueSubmit2 PFN_vkRegisterDeviceEventEXT PFN_vkWaitForPresentKHR;
    wrap_5:
        PFN_vkAcquireImageANDROID PFN_vkBindOpticalFlowSessionImageNV
        PFN_vkBuildAccelerationStructuresKHR PFN_vkCreateDisplayModeKHR
        PFN_vkCreateSharedSwapchainsKHR
        PFN_vkEnumeratePhysicalDeviceQueueFamilyPerformanceQueryCountersKHR
        PFN_vkGetCalibratedTimestampsKHR PFN_vkQueueSignalReleaseImageANDROID
        PFN_vkRegisterDisplayEventEXT PFN_vkSetPrivateData PFN_vkWaitForFences;
    wrap_6:
        PFN_vkAcquireNextImageKHR PFN_vkCreateComputePipelines PFN_vkCreateGraphicsPipelines
        PFN_vkCreateRayTracingPipelinesNV PFN_vkGetRayTracingCaptureReplayShaderGroupHandlesKHR
        PFN_vkGetRayTracingShaderGroupHandlesKHR PFN_vkGetShaderInfoAMD
        PFN_vkGetSwapchainGrallocUsage2ANDROID PFN_vkMapMemory;
    wrap_7:
        PFN_vkCreateRayTracingPipelinesKHR PFN_vkGetPhysicalDeviceImageFormatProperties
        PFN_vkWriteAccelerationStructuresPropertiesKHR PFN_vkWriteMicromapsPropertiesEXT;
    wrap_8:
        PFN_vkGetPhysicalDeviceExternalImageFormatPropertiesNV PFN_vkGetQueryPoolResults;
}
