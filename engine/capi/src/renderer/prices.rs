//! The measurement of the prices of a device.

use render::RendererOptions;

use crate::error::Failure;
use crate::executor::device::AntumbraDevice;
use crate::executor::trust::assumptions;
use crate::layout::{Versioned, layout};
use crate::renderer::description::sample_count;

/// The image that prices are measured on.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraPricesDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// A set of `ANTUMBRA_ASSUMPTION_..` that a self-test found broken: ways to skip draws that
    /// rest on them are not measured. Default: 0.
    pub distrusted: u32,
    /// The device, which was adopted with a queue.
    pub device: AntumbraDevice,
    /// Width of the image (pixels).
    pub width: u32,
    /// Height of the image (pixels).
    pub height: u32,
    /// Samples per pixel, 1 or 4; 0 for 1. Default: 0.
    pub samples: u32,
    /// Must be 0.
    pub reserved: u32,
}
layout!(AntumbraPricesDesc: struct_size, distrusted, device, width, height, samples, reserved);

// SAFETY: the first field is the size.
unsafe impl Versioned for AntumbraPricesDesc {
    const REQUIRED_FIELDS: usize = 7;
    const DEFAULT: Self = Self {
        struct_size: size_of::<Self>() as u32,
        distrusted: 0,
        device: AntumbraDevice { id: 0 },
        width: 0,
        height: 0,
        samples: 0,
        reserved: 0,
    };
}

impl AntumbraPricesDesc {
    /// Returns the options of a renderer of such images.
    pub(crate) fn options(&self) -> Result<RendererOptions, Failure> {
        if self.reserved != 0 {
            return Err(Failure::argument("desc.reserved must be 0"));
        }
        Ok(RendererOptions {
            size: [self.width, self.height],
            samples: sample_count(self.samples)?,
            distrusted: assumptions(self.distrusted)?,
            ..RendererOptions::default()
        })
    }
}
