//! A device that the library opens, for a program without Vulkan of its own.

use std::ffi::c_char;

use crate::layout::{layout, versioned};

/// The validation layer is not loaded.
pub const ANTUMBRA_VALIDATION_OFF: u32 = 0;
/// The validation layer checks the use of every call. Its messages are warnings in the log of the
/// context.
pub const ANTUMBRA_VALIDATION_CORE: u32 = 1;
/// As `ANTUMBRA_VALIDATION_CORE`, and the layer finds hazards between commands.
pub const ANTUMBRA_VALIDATION_SYNCHRONIZATION: u32 = 2;

/// The options of a device that the library opens.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraDeviceOpenDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// An `ANTUMBRA_VALIDATION_..`. Default: `ANTUMBRA_VALIDATION_OFF`.
    pub validation: u32,
    /// A part of the name of the device or of its driver, in any case, or the index of the device,
    /// in UTF-8 with a 0 at the end. Default: null, for the best device.
    pub name: *const c_char,
    /// As `AntumbraDeviceDesc::memory_budget_bytes`. Default: 0, for no bound but that of the
    /// device.
    pub memory_budget_bytes: u64,
}
layout!(AntumbraDeviceOpenDesc: struct_size, validation, name, memory_budget_bytes);

versioned!(AntumbraDeviceOpenDesc: 4, required: [], defaults: {});
