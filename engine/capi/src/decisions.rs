//! Decisions alone: boxes in, plan out, answers in. No Vulkan.

pub mod camera;
pub mod culler;
pub mod hierarchy;
pub mod plan;
