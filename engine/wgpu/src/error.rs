//! The errors of the library.

/// An error of culling on a device of wgpu.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The adapter is not one of wgpu's Vulkan backend.
    #[error(
        "the adapter does not use Vulkan; create the instance with `wgpu::Backends::VULKAN` and \
         request the adapter again"
    )]
    NotVulkan,
    /// The adapter lacks features that the descriptor or the engine requires.
    #[error("the adapter lacks the features {0:?}; leave them out, or choose another adapter")]
    Features(wgpu::Features),
    /// The descriptor requires experimental features without its consent to them.
    #[error("the features {0:?} are experimental; set `DeviceDescriptor::experimental_features`")]
    Experimental(wgpu::Features),
    /// The adapter does not have a limit that the descriptor requires.
    #[error("the adapter allows at most {allowed} for the limit {name}, not {wanted}")]
    Limit {
        /// The name of the limit in [`wgpu::Limits`].
        name: &'static str,
        /// The value in the descriptor.
        wanted: u64,
        /// The value of the adapter.
        allowed: u64,
    },
    /// Vulkan did not create the device (`vkCreateDevice`).
    #[error("wgpu could not open the Vulkan device: {0}")]
    Open(#[from] wgpu::hal::DeviceError),
    /// wgpu refused the device that was opened.
    #[error(transparent)]
    Request(#[from] wgpu::RequestDeviceError),
    /// The texture is not a 2D depth texture that can be drawn to.
    #[error(
        "the depth texture must be 2D, with one level and one layer, a format with depth and the \
         usage RENDER_ATTACHMENT; it is {dimension:?}, {format:?}, {usage:?}"
    )]
    NotDepth {
        /// The dimension of the texture.
        dimension: wgpu::TextureDimension,
        /// The format of the texture.
        format: wgpu::TextureFormat,
        /// The usage of the texture.
        usage: wgpu::TextureUsages,
    },
    /// The depth texture was destroyed, or is of another device.
    #[error("the depth texture was destroyed or is of another device; make a new `WgpuTarget`")]
    NoDepth,
    /// The encoder of the tests has no command buffer: the device is lost.
    #[error("wgpu has no command buffer for the tests; is the device lost?")]
    NoCommands,
    /// Frames did not end within [`WAIT_BOUND`](crate::WAIT_BOUND).
    #[error("waiting for frames that were submitted: {0}")]
    Wait(#[from] wgpu::PollError),
    /// Frames are encoded but neither submitted nor dropped.
    #[error("{0} frames are neither submitted nor dropped; submit or drop them first")]
    FramesHeld(usize),
    /// The engine's layer over Vulkan failed.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    /// The executor failed.
    #[error(transparent)]
    Occlusion(#[from] occlusion::Error),
    /// The matrix of a camera is not one that can be culled with.
    #[error(transparent)]
    View(#[from] cull::ViewError),
}
