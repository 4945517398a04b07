//! The list of all structs.

use crate::context::AntumbraContextDesc;
use crate::decisions::camera::AntumbraCamera;
use crate::decisions::culler::{AntumbraCuller, AntumbraCullerDesc, AntumbraPlanDesc};
use crate::decisions::hierarchy::{
    AntumbraAabb, AntumbraHierarchy, AntumbraHierarchyDesc, AntumbraLeaves,
};
use crate::decisions::plan::{
    AntumbraAnswer, AntumbraDraw, AntumbraFramePlan, AntumbraQueryTag, AntumbraRound, AntumbraTest,
};
use crate::error::AntumbraError;
#[cfg(feature = "vulkan")]
use crate::executor::{device, device_costs, device_open, frame, lists, queue, scene, target};
use crate::layout::StructLayout;
#[cfg(feature = "renderer")]
use crate::renderer::{
    description, device_costs as measured, frame as rendered, scene_file, self_test, shadows, view,
};

/// All structs of the interface, for comparison with a C compiler.
pub const STRUCTS: &[StructLayout] = &[
    StructLayout::of_versioned::<AntumbraContextDesc>(),
    StructLayout::of::<AntumbraCuller>(),
    StructLayout::of_versioned::<AntumbraCullerDesc>(),
    StructLayout::of_versioned::<AntumbraPlanDesc>(),
    StructLayout::of::<AntumbraError>(),
    StructLayout::of::<AntumbraAabb>(),
    StructLayout::of::<AntumbraHierarchy>(),
    StructLayout::of_versioned::<AntumbraHierarchyDesc>(),
    StructLayout::of_versioned::<AntumbraLeaves>(),
    StructLayout::of::<AntumbraAnswer>(),
    StructLayout::of::<AntumbraDraw>(),
    StructLayout::of_versioned::<AntumbraFramePlan>(),
    StructLayout::of::<AntumbraQueryTag>(),
    StructLayout::of::<AntumbraRound>(),
    StructLayout::of::<AntumbraTest>(),
    StructLayout::of_versioned::<AntumbraCamera>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<device::AntumbraAdapterDesc>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<device::AntumbraDevice>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<device::AntumbraDeviceDesc>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<device::AntumbraFeatures>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<device::AntumbraRequirements>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<device_open::AntumbraDeviceOpenDesc>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<queue::AntumbraQueueDesc>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<frame::AntumbraBinding>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<frame::AntumbraFrameDesc>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<frame::AntumbraRendering>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<frame::AntumbraViewFrame>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<scene::AntumbraObject>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<scene::AntumbraObjectDraw>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<scene::AntumbraScene>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<scene::AntumbraSceneDesc>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<scene::AntumbraView>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<scene::AntumbraViewStats>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<lists::AntumbraDrawList>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<lists::AntumbraDrawLists>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<device_costs::AntumbraDeviceCosts>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<target::AntumbraAttachments>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<target::AntumbraImage>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of::<target::AntumbraImageState>(),
    #[cfg(feature = "vulkan")]
    StructLayout::of_versioned::<target::AntumbraTargetDesc>(),
    #[cfg(feature = "renderer")]
    StructLayout::of::<description::AntumbraVertex>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<description::AntumbraMeshDesc>(),
    #[cfg(feature = "renderer")]
    StructLayout::of::<description::AntumbraTransform>(),
    #[cfg(feature = "renderer")]
    StructLayout::of::<description::AntumbraMeshObject>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<description::AntumbraSunlight>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<description::AntumbraRendererDesc>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<shadows::AntumbraShadowDesc>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<shadows::AntumbraShadowStats>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<shadows::AntumbraLightShadowDesc>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<measured::AntumbraDeviceCostsDesc>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<self_test::AntumbraSelfTest>(),
    #[cfg(feature = "renderer")]
    StructLayout::of::<rendered::AntumbraRenderer>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<rendered::AntumbraRenderDesc>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<rendered::AntumbraFinishedImage>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<view::AntumbraRendererStats>(),
    #[cfg(feature = "renderer")]
    StructLayout::of::<view::AntumbraRendererView>(),
    #[cfg(feature = "renderer")]
    StructLayout::of::<scene_file::AntumbraSceneFile>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<scene_file::AntumbraSceneFileDesc>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<scene_file::AntumbraSceneFileInfo>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<scene_file::AntumbraSceneFileCamera>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<scene_file::AntumbraSceneFileClip>(),
    #[cfg(feature = "renderer")]
    StructLayout::of_versioned::<scene_file::AntumbraSceneFileNote>(),
];
