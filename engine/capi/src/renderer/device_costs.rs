//! The measurement of the costs of a device.

use render::RendererOptions;

use crate::error::Failure;
use crate::executor::device::AntumbraDevice;
use crate::executor::quirks::assumptions;
use crate::layout::{layout, versioned};
use crate::renderer::description::sample_count;

/// The device and the image for which costs are measured.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraDeviceCostsDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// A set of `ANTUMBRA_ASSUMPTION_..` that a self-test found broken: ways to skip draws that
    /// rest on them are not measured. Default: 0, none.
    pub disabled: u32,
    /// Required: the device, which was adopted with a queue.
    pub device: AntumbraDevice,
    /// Required: width of the image (pixels).
    pub width: u32,
    /// Required: height of the image (pixels).
    pub height: u32,
    /// Samples per pixel, 1 or 4. Default: 1.
    pub samples: u32,
    /// Must be 0.
    pub reserved: u32,
}
layout!(AntumbraDeviceCostsDesc: struct_size, disabled, device, width, height, samples, reserved);

versioned!(AntumbraDeviceCostsDesc: 7, required: [width, height], defaults: { samples: 1 });

impl AntumbraDeviceCostsDesc {
    /// Returns the options of a renderer with such an image.
    pub(crate) fn options(&self) -> Result<RendererOptions, Failure> {
        Ok(RendererOptions {
            size: [self.width, self.height],
            samples: sample_count(self.samples)?,
            disabled: assumptions(self.disabled)?,
            ..RendererOptions::default()
        })
    }
}
