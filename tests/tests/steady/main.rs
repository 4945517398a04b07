//! Loops that create no Vulkan object and allocate no memory at rest. The allocator counts.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

#[cfg(feature = "shader-compiler")]
mod host;
mod renderer;
mod streaming;
mod swapchain;

#[global_allocator]
static ALLOCATOR: tests::counting::CountingAllocator = tests::counting::CountingAllocator;
