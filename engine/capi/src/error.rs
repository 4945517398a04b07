//! Results and messages of calls.

use std::ffi::c_char;
use std::fmt::Display;

use cull::HierarchyError;

use crate::layout::layout;

/// The result of a call.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AntumbraResult {
    /// The call succeeded.
    Ok = 0,
    /// A required pointer is null, or a pointer is not aligned.
    BadPointer = -1,
    /// A `struct_size` does not belong to any version of the struct, or a field that this version
    /// of the library does not know is not 0.
    BadStructSize = -2,
    /// A value is outside its range, or does not fit other values.
    BadArgument = -3,
    /// A handle that is 0, was destroyed, or belongs to another context or kind of object.
    UnknownHandle = -4,
    /// Another call is using the object.
    Busy = -5,
    /// An earlier call that was changing the object ended with `ANTUMBRA_RESULT_PANIC`: destroy the
    /// object.
    Poisoned = -6,
    /// A defect of the library: please report the message.
    Panic = -7,
    /// There is not enough memory.
    NoMemory = -8,
    /// The program was compiled with another version of the interface.
    AbiVersion = -9,
    /// The device or the machine lacks something that is needed.
    Unsupported = -10,
    /// The Vulkan device is lost: destroy it and everything that was created on it.
    DeviceLost = -11,
    /// A call of Vulkan failed; the message names it.
    Vulkan = -12,
    /// A file that cannot be read or shown; the message names the file, the object in it, and the
    /// reason.
    BadFile = -13,
}

/// The message of a call that failed, in memory of the caller.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraError {
    /// Size of this struct in bytes, set by the caller. A caller may use a smaller struct to get
    /// less text.
    pub struct_size: u32,
    /// The result of the call, an `AntumbraResult`.
    pub result: i32,
    /// The reason and what to do, in UTF-8 with a 0 at the end; empty after a success.
    pub message: [c_char; 504],
}
layout!(AntumbraError: struct_size, result, message);

impl AntumbraError {
    /// The number of bytes before the text.
    const HEADER: usize = 8;

    /// Writes the outcome of a call.
    ///
    /// # Safety
    /// `error` is null, or points to a struct of [`AntumbraError::struct_size`] bytes.
    pub(crate) unsafe fn write(error: *mut Self, result: AntumbraResult, message: &str) {
        if error.is_null() || !error.is_aligned() {
            return;
        }
        // SAFETY: as above; nothing beyond the size given by the caller is written.
        unsafe {
            let size = ((*error).struct_size as usize).min(size_of::<Self>());
            let Some(room) = size.checked_sub(Self::HEADER + 1) else { return };
            (*error).result = result as i32;
            let end = (0..=room.min(message.len())).rev().find(|at| message.is_char_boundary(*at));
            let text = &message.as_bytes()[..end.unwrap_or(0)];
            let target = (&raw mut (*error).message).cast::<u8>();
            target.copy_from_nonoverlapping(text.as_ptr(), text.len());
            target.add(text.len()).write(0);
        }
    }
}

/// The names of the Rust interface in errors of other crates, and the names in C.
const NAMES_IN_C: [(&str, &str); 15] = [
    ("FrameNumbers::current", "AntumbraFrameDesc::current"),
    ("HostImage::usage", "AntumbraImage::usage"),
    ("FrameNumbers::safe", "AntumbraFrameDesc::safe"),
    ("DeviceOptions::memory_budget_bytes", "AntumbraDeviceDesc::memory_budget_bytes"),
    ("HostDevice::queue", "AntumbraDeviceDesc::queue"),
    ("Device::host_finished", "antumbra_device_finished"),
    ("Device::completed", "antumbra_renderer_render"),
    ("Device::wait_idle", "vkDeviceWaitIdle"),
    ("CulledSceneOptions::frames_in_flight", "AntumbraSceneDesc::frames_in_flight"),
    ("CulledScene::begin", "antumbra_scene_record"),
    ("RendererOptions::spare_objects", "AntumbraRendererDesc::spare_objects"),
    ("RendererOptions::spare", "AntumbraRendererDesc::spare_meshes"),
    ("Renderer::size", "AntumbraRendererDesc::width"),
    ("Target::attachments", "AntumbraAttachments"),
    ("DrawPhases::Two", "ANTUMBRA_DRAWS_BY_LISTS"),
];

/// A call that failed.
#[derive(Debug)]
pub(crate) struct Failure {
    pub result: AntumbraResult,
    pub message: String,
}

impl Failure {
    pub fn new(result: AntumbraResult, message: impl Display) -> Self {
        let mut message = message.to_string();
        for (rust, c) in NAMES_IN_C {
            if message.contains(rust) {
                message = message.replace(rust, c);
            }
        }
        Self { result, message }
    }

    pub fn null(name: impl Display) -> Self {
        Self::new(AntumbraResult::BadPointer, format_args!("{name} is null"))
    }

    pub fn argument(message: impl Display) -> Self {
        Self::new(AntumbraResult::BadArgument, message)
    }

    /// Names the place in the caller's arguments, such as an element of an array.
    pub fn within(self, place: impl Display) -> Self {
        Self { message: format!("{place}: {}", self.message), ..self }
    }
}

impl From<HierarchyError> for Failure {
    fn from(error: HierarchyError) -> Self {
        let result = match error {
            HierarchyError::NoMemory { .. } => AntumbraResult::NoMemory,
            _ => AntumbraResult::BadArgument,
        };
        Self::new(result, error)
    }
}

#[cfg(feature = "vulkan")]
impl From<occlusion::Error> for Failure {
    fn from(error: occlusion::Error) -> Self {
        match error {
            occlusion::Error::Gpu(error) => error.into(),
            occlusion::Error::Hierarchy(error) => error.into(),
            error => Self::argument(error),
        }
    }
}

#[cfg(feature = "vulkan")]
impl From<gpu::Error> for Failure {
    fn from(error: gpu::Error) -> Self {
        use gpu::Error as E;
        if let E::TooManyFrames { current, used, slots } = error {
            return Self::argument(format_args!(
                "frame {current} needs the memory of frame {used}, which is not over yet, since \
                 AntumbraSceneDesc::frames_in_flight is {slots}: set it to the number of your \
                 frames in flight, and AntumbraFrameDesc::safe to the newest frame that is over"
            ));
        }
        let result = match &error {
            _ if error.is_device_lost() => AntumbraResult::DeviceLost,
            E::DeviceLacks { .. }
            | E::Unsupported { .. }
            | E::NoLoader(_)
            | E::NoDriver(_)
            | E::NoSuitableDevice { .. }
            | E::NoValidationLayer(_) => AntumbraResult::Unsupported,
            E::FrameNumbers { .. }
            | E::TooLarge { .. }
            | E::Foreign { .. }
            | E::NoQueue { .. }
            | E::HasQueue
            | E::TargetFormat { .. }
            | E::TargetUsage { .. }
            | E::Samples { .. }
            | E::UnknownDevice { .. }
            | E::NoImage => AntumbraResult::BadArgument,
            E::Memory(_) => AntumbraResult::NoMemory,
            _ => AntumbraResult::Vulkan,
        };
        Self::new(result, error)
    }
}

#[cfg(feature = "renderer")]
impl From<render::Error> for Failure {
    fn from(error: render::Error) -> Self {
        match error {
            render::Error::Gpu(error) => error.into(),
            render::Error::Hierarchy(error) => error.into(),
            render::Error::NoMemory { .. } | render::Error::SceneMemory { .. } => {
                Self::new(AntumbraResult::NoMemory, error)
            }
            render::Error::Change { index, reason } => Self::argument(format_args!(
                "objects[{index}]: {reason}; no object was added, moved or removed"
            )),
            render::Error::Mesh { index, reason } => Self::argument(format_args!(
                "meshes[{index}]: {reason}; no mesh was added or removed"
            )),
            error => Self::argument(error),
        }
    }
}

#[cfg(all(test, feature = "vulkan"))]
mod tests {
    use super::{AntumbraResult, Failure};

    #[test]
    fn messages_name_the_interface_in_c() {
        let failure = Failure::from(gpu::Error::HasQueue);
        assert_eq!(failure.result, AntumbraResult::BadArgument);
        assert!(failure.message.contains("AntumbraDeviceDesc::queue"), "{}", failure.message);
        let in_flight = occlusion::Error::FramesInFlight { ring: 3, scene: 2 };
        let failure = Failure::from(in_flight);
        assert!(failure.message.contains("AntumbraSceneDesc::frames_in_flight"));
    }
}
