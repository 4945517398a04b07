//! The errors of the GPU layer, each with the failed call, the code and the remedy.

use ash::vk;
use gpu_allocator::AllocationError;

use crate::memory::memory_error::MemoryError;

/// An error of the GPU layer. Its text is one sentence for the user of the machine.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The Vulkan loader library is not installed.
    #[error(
        "no Vulkan loader was found ({0}); install it (on Debian: apt install libvulkan1 mesa-vulkan-drivers)"
    )]
    NoLoader(String),
    /// The loader is installed but found no driver.
    #[error(
        "the Vulkan loader found no driver ({0}); install one (on Debian: apt install mesa-vulkan-drivers, which needs no GPU)"
    )]
    NoDriver(String),
    /// The process has too little address space for a driver, found before or after a failure of
    /// the loader.
    #[error(
        "this process may take {} MiB of address space and has {} MiB of it, which is too little for a Vulkan driver: raise the limit, as by `ulimit -v unlimited` ({failure})",
        limit_bytes >> 20, used_bytes >> 20
    )]
    AddressSpace {
        /// The limit in bytes.
        limit_bytes: u64,
        /// The part in use.
        used_bytes: u64,
        /// The failure that has another error without the limit, or the address space that a driver
        /// needs.
        failure: String,
    },
    /// The loader could not read the manifest of a driver or a layer.
    #[error(
        "{call} failed with {code:?}: the Vulkan loader cannot read the manifest of a driver or a layer, or has no memory at all; install the driver again (on Debian: apt install --reinstall mesa-vulkan-drivers), or run with VK_LOADER_DEBUG=error to see which file it is"
    )]
    BadManifest {
        /// The Vulkan call.
        call: &'static str,
        /// The result that it returned.
        code: vk::Result,
    },
    /// The loader itself is older than Vulkan 1.3.
    #[error("the Vulkan loader speaks {found}, the engine needs 1.3; update libvulkan1")]
    OldLoader {
        /// The loader's version, `major.minor`.
        found: String,
    },
    /// Validation was requested, but the layer is not installed.
    #[error(
        "the layer {0} is not installed, validation is impossible; install it (on Debian: apt install vulkan-validationlayers) or switch validation off"
    )]
    NoValidationLayer(String),
    /// No device has all that the engine needs.
    #[error("no Vulkan device can run the engine: {refused}")]
    NoSuitableDevice {
        /// Each device with the capabilities that it lacks.
        refused: String,
    },
    /// The requested device does not exist.
    #[error("there is no device '{wanted}'; the devices are: {available}")]
    UnknownDevice {
        /// The requested index or name.
        wanted: String,
        /// The list of devices.
        available: String,
    },
    /// The requested device lacks a required capability.
    #[error(
        "the device {device} lacks {missing}; update its driver or choose another device ({available})"
    )]
    DeviceLacks {
        /// The device's name.
        device: String,
        /// The names of the required capabilities that are missing.
        missing: String,
        /// The list of devices.
        available: String,
    },
    /// The device lacks a requested optional capability.
    #[error("the device {device} lacks {missing}, which {wanted} needs")]
    Unsupported {
        /// The device's name.
        device: String,
        /// The missing capability.
        missing: &'static str,
        /// The option or method that needs it.
        wanted: &'static str,
    },
    /// A threshold was requested of an executor that can only compare with zero.
    #[error(
        "conditional rendering cannot compare samples with a threshold of {threshold_samples}: skip draws by counts or by instances, or set the threshold to 0"
    )]
    CannotCompare {
        /// The requested threshold.
        threshold_samples: u32,
    },
    /// A size or count is beyond the device's limit.
    #[error("{what} would be {wanted}, and this device takes at most {limit}")]
    TooLarge {
        /// The size or count that is too large.
        what: String,
        /// The requested value.
        wanted: u64,
        /// The device's limit.
        limit: u64,
    },
    /// An image of a host has a format that cannot be drawn to.
    #[error("the {what} of a host's target has the format {format:?}; {needed}")]
    TargetFormat {
        /// The image: depth, or a colour by its index.
        what: String,
        /// The format of the image.
        format: ash::vk::Format,
        /// The formats that are possible.
        needed: &'static str,
    },
    /// An image of a host lacks a usage that drawing to it needs.
    #[error(
        "the {what} of a host's target has the usage {:#x}, without {needed}: create the image with this bit, and name its whole usage in `HostImage::usage`",
        usage.as_raw()
    )]
    TargetUsage {
        /// The image: depth, or a colour by its index.
        what: String,
        /// The usage of the image.
        usage: ash::vk::ImageUsageFlags,
        /// The bit that is missing, by its name in C.
        needed: &'static str,
    },
    /// Attachments have a number of samples per pixel that the device cannot draw to.
    #[error("attachments of {samples:?} samples per pixel; this device draws to {supported:?}")]
    Samples {
        /// The samples of the attachments.
        samples: ash::vk::SampleCountFlags,
        /// The numbers of samples that the device can draw to.
        supported: ash::vk::SampleCountFlags,
    },
    /// A number of samples per pixel that the engine's own targets do not support.
    #[error("{wanted} samples per pixel are not possible: take 1 or 4")]
    SampleCount {
        /// The requested number.
        wanted: u32,
    },
    /// There is no display to open a window on, or the connection to it is lost.
    #[error(
        "there is no display to show a window on ({0}); start one, name it in DISPLAY or WAYLAND_DISPLAY, or draw without a window"
    )]
    NoDisplay(String),
    /// The instance cannot show frames in windows.
    #[error(
        "this Vulkan instance shows no windows, {0} is missing: install a driver that has it (on Debian: apt install mesa-vulkan-drivers), or draw without a window"
    )]
    NoWindows(String),
    /// No device, or not the requested one, can show frames in the window.
    #[error(
        "no frame can be shown in this window: {0}; choose another device, or draw without a window"
    )]
    CannotPresent(String),
    /// A thread could not be started.
    #[error("the thread that presents cannot start: {0}; end other programs, or show no window")]
    NoThread(String),
    /// Two objects were used together that come from different devices, instances or renderers.
    #[error(
        "{thing} is used by {user}, but both are of different `{owner}`s: make both from the same one"
    )]
    Foreign {
        /// The object that was used.
        thing: &'static str,
        /// The object or method that used it.
        user: &'static str,
        /// The type of the common owner that both need.
        owner: &'static str,
    },
    /// Work was to be submitted or waited for on a device without a queue.
    #[error(
        "{what} needs a queue, and this device was adopted without one: record it into a frame of the host, or adopt the device with `HostDevice::queue`"
    )]
    NoQueue {
        /// The work that needs a queue.
        what: &'static str,
    },
    /// A frame of a host was begun on a device that submits its own work.
    #[error(
        "this device counts its own submits, not the frames of a host: adopt it without `HostDevice::queue`"
    )]
    HasQueue,
    /// The numbers of a host's frame do not follow the numbers of the frames before.
    #[error("{}", broken_rule(*.current, *.safe, *.newest, *.over))]
    FrameNumbers {
        /// The number of the frame.
        current: u64,
        /// The newest frame that is over according to the caller.
        safe: u64,
        /// The newest frame begun before.
        newest: u64,
        /// The newest frame that was over according to the call before.
        over: u64,
    },
    /// More frames of a host are in flight than its ring has slots.
    #[error(
        "frame {current} needs the memory of frame {used}, which is not over yet: the ring has {slots} slots; make one with a slot more than the host has frames in flight, and say in `FrameNumbers::safe` which frames are over"
    )]
    TooManyFrames {
        /// The number of the frame.
        current: u64,
        /// The frame that uses the next slot.
        used: u64,
        /// The number of slots.
        slots: usize,
    },
    /// An image was read before it exists: its frame is not over, was never submitted, or there was
    /// no frame yet.
    #[error(
        "the image is not there yet: render a frame that copies it, and read it when that frame is over, see `Device::completed` and `Device::wait_idle`"
    )]
    NoImage,
    /// Commands were recorded that no device could run. This is a mistake in the recording program.
    #[error("the commands recorded cannot be run: {0}; correct the program that records them")]
    WrongCommands(&'static str),
    /// A Vulkan call failed.
    #[error("{call} failed with {code:?}{}", advice(*.code))]
    Vulkan {
        /// The Vulkan call.
        call: &'static str,
        /// The result that it returned.
        code: vk::Result,
    },
    /// The allocation of memory failed, and so did everything that is tried then.
    #[error(transparent)]
    Memory(Box<MemoryError>),
    /// The work was cancelled by its [`CancellationToken`](crate::CancellationToken). This is not a
    /// failure.
    #[error("the work was given up, as was asked for")]
    Cancelled,
    /// The memory allocator could not be set up.
    #[error("the GPU memory allocator could not start: {0}")]
    Allocator(AllocationError),
    /// The GPU did not finish in time.
    #[error(
        "the GPU did not finish {what} within {seconds:.3} s ({call}: TIMEOUT); it may hang, or the frame is too heavy for this device"
    )]
    Timeout {
        /// The work that was waited for.
        what: &'static str,
        /// The call that waited.
        call: &'static str,
        /// The time waited.
        seconds: f64,
    },
    /// A shader does not compile. The text starts with the file and line.
    #[error("the shader {name} does not compile:\n{log}")]
    ShaderCompile {
        /// The shader's file name.
        name: String,
        /// The compiler's messages, `file:line: error: …`.
        log: String,
    },
    /// The bytes of a shader are not SPIR-V.
    #[error("{name} is not SPIR-V; compile the shaders again")]
    NotSpirv {
        /// The shader's name.
        name: String,
    },
}

impl Error {
    /// Returns true if the device is lost: no object made from it works any more. Create all
    /// objects again, or end the program.
    pub fn is_device_lost(&self) -> bool {
        matches!(self, Error::Vulkan { code: vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// Returns true if no memory of the device was left, or none within the budget: something
    /// smaller may fit.
    pub fn is_out_of_memory(&self) -> bool {
        matches!(self, Error::Memory(error) if error.failure.is_out_of_memory())
    }
}

/// Adds the name of the call to a failed result.
pub(crate) trait Called<T> {
    fn called(self, call: &'static str) -> Result<T, Error>;
}

impl<T> Called<T> for Result<T, vk::Result> {
    fn called(self, call: &'static str) -> Result<T, Error> {
        self.map_err(|code| Error::Vulkan { call, code })
    }
}

/// Returns the rule about numbers of frames that a frame breaks.
fn broken_rule(current: u64, safe: u64, newest: u64, over: u64) -> String {
    if current <= newest {
        format!(
            "frame {current} cannot begin after frame {newest}: `FrameNumbers::current` must rise \
             with each frame that begins on the device, and is {} or more now",
            newest.saturating_add(1)
        )
    } else if safe >= current {
        format!(
            "frame {current} cannot begin while `FrameNumbers::safe` is {safe}: no frame is over \
             before it begins, so `safe` must be below {current}"
        )
    } else {
        format!(
            "frame {current} cannot begin while `FrameNumbers::safe` is {safe}: all frames up to \
             {over} were over before, and `safe` must not fall, so it must be {over} or more"
        )
    }
}

fn advice(code: vk::Result) -> &'static str {
    match code {
        vk::Result::ERROR_DEVICE_LOST => {
            ": the driver gave up on the GPU; restart the program, update the driver if it comes back"
        }
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => {
            ": the GPU is out of memory; use fewer or smaller objects and images"
        }
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
            ": the machine is out of memory, or this process may take no more (`ulimit -v`, the limit of a container); use fewer or smaller objects and images, or raise the limit"
        }
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => {
            ": the driver has no Vulkan 1.3; update it, or install mesa-vulkan-drivers"
        }
        vk::Result::ERROR_SURFACE_LOST_KHR => ": the window is gone; open another one",
        vk::Result::ERROR_NATIVE_WINDOW_IN_USE_KHR => {
            ": something else shows frames in this window already; give each swapchain its own"
        }
        vk::Result::ERROR_INITIALIZATION_FAILED => {
            ": the driver could not start; check that the device may be used by this user"
        }
        _ => "",
    }
}
