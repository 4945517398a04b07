//! The Vulkan instance: loader, layers, and the messenger that fills the validation log.

use std::ffi::{CStr, CString, c_char};
use std::sync::Arc;

use ash::{ext, khr, vk};

use crate::core::address_space::{check_room, explained};
use crate::core::error::{Called, Error};
use crate::core::ownership::{OwnerId, Ownership};
use crate::core::validation::ValidationLog;
use crate::core::window_system::{WindowFunctions, WindowSystem};

/// The checks of the Khronos validation layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Validation {
    /// The layer is not loaded.
    #[default]
    Off,
    /// The core checks: valid usage of every call.
    Core,
    /// The core checks and synchronization hazards.
    Synchronization,
}

/// The options of an [`Instance`].
#[derive(Debug, Clone, Default)]
pub struct InstanceOptions {
    /// The application's name, for the driver.
    pub application: String,
    /// The checks of the validation layer.
    pub validation: Validation,
    /// The window system whose windows will show frames; `None` for an instance without windows.
    pub windows: Option<WindowSystem>,
}

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// An instance with its messenger and its validation log.
#[derive(Clone)]
pub struct Instance {
    pub(crate) shared: Arc<InstanceShared>,
}

type Messenger = (ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT);

pub(crate) struct InstanceShared {
    pub(crate) id: OwnerId,
    // Kept alive for its function table: the loader library is unloaded with the last entry.
    pub(crate) entry: ash::Entry,
    pub(crate) raw: ash::Instance,
    messenger: Option<Messenger>,
    pub(crate) has_debug_utils: bool,
    /// The functions that create and query surfaces, if the instance is for windows.
    pub(crate) windows: Option<WindowFunctions>,
    // Boxed: the messenger holds its address.
    log: Box<ValidationLog>,
    validation: Validation,
    ownership: Ownership,
}

impl InstanceShared {
    /// Wraps the instance of a host, which also destroys it.
    pub(crate) fn of_host(entry: ash::Entry, raw: ash::Instance, extensions: &[CString]) -> Self {
        let has_debug_utils =
            extensions.iter().any(|name| name.as_c_str() == ext::debug_utils::NAME);
        Self {
            id: OwnerId::new(),
            entry,
            raw,
            messenger: None,
            has_debug_utils,
            windows: None,
            log: Box::default(),
            validation: Validation::Off,
            ownership: Ownership::Host,
        }
    }
}

/// Finds and opens the Vulkan loader of this machine.
///
/// # Errors
/// [`Error::NoLoader`] if there is none; [`Error::AddressSpace`] if there is no room for it.
#[cfg(feature = "loaded")]
pub fn load_entry() -> Result<ash::Entry, Error> {
    // SAFETY: we load the system's Vulkan loader, whose initialisation has no further contract.
    unsafe { ash::Entry::load() }.map_err(|error| explained(Error::NoLoader(error.to_string())))
}

impl Instance {
    /// Creates an instance through `entry`: the loader's, or an entry whose calls a test wraps.
    ///
    /// # Errors
    /// An old loader, a missing validation layer, no driver or no room for one, or a failed call.
    pub fn new(entry: ash::Entry, options: &InstanceOptions) -> Result<Self, Error> {
        check_room()?;
        require_1_3(&entry)?;
        let layers = wanted_layers(&entry, options.validation)?;
        let there = extension_names(&entry)?;
        // The layer offers debug_utils even if the loader does not.
        let has_debug_utils = options.validation != Validation::Off
            || there.iter().any(|name| name.as_c_str() == ext::debug_utils::NAME);
        let (mut extensions, present_fences) = match options.windows {
            Some(windows) => windows.extensions(&there)?,
            None => Default::default(),
        };
        if has_debug_utils {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        if options.validation == Validation::Synchronization {
            extensions.push(ext::validation_features::NAME.as_ptr());
        }
        // Without the flag, the loader hides drivers on top of another interface, such as MoltenVK.
        let mut flags = vk::InstanceCreateFlags::empty();
        if there.iter().any(|name| name.as_c_str() == khr::portability_enumeration::NAME) {
            extensions.push(khr::portability_enumeration::NAME.as_ptr());
            flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        }
        let log = Box::new(ValidationLog::default());

        let name = CString::new(options.application.replace('\0', " ")).unwrap_or_default();
        let application = vk::ApplicationInfo::default()
            .application_name(&name)
            .engine_name(c"Antumbra")
            .api_version(vk::API_VERSION_1_3);
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut messenger_info = ValidationLog::messenger_info(&log);
        let mut info = vk::InstanceCreateInfo::default()
            .flags(flags)
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        if options.validation == Validation::Synchronization {
            info = info.push_next(&mut features);
        }
        if has_debug_utils {
            info = info.push_next(&mut messenger_info);
        }
        // SAFETY: every pointer in `info` lives until the call returns.
        let made = unsafe { entry.create_instance(&info, None) };
        let raw = made.map_err(|code| refusal("vkCreateInstance", code))?;
        let messenger = has_debug_utils.then(|| create_messenger(&entry, &raw, &log)).transpose();
        let messenger = messenger
            // SAFETY: nothing was made from the instance yet.
            .inspect_err(|_| unsafe { raw.destroy_instance(None) })?;
        let validation = options.validation;
        let id = OwnerId::new();
        let windows = options.windows.map(|system| WindowFunctions {
            system,
            surface: khr::surface::Instance::new(&entry, &raw),
            present_fences,
        });
        let ownership = Ownership::Ours;
        let shared = InstanceShared {
            id,
            entry,
            raw,
            messenger,
            has_debug_utils,
            windows,
            log,
            validation,
            ownership,
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Returns the log of the validation layers. It stays empty if validation is off.
    pub fn validation_log(&self) -> &ValidationLog {
        &self.shared.log
    }

    /// Returns the enabled checks.
    pub fn validation(&self) -> Validation {
        self.shared.validation
    }
}

impl Drop for InstanceShared {
    fn drop(&mut self) {
        if let Some((debug, messenger)) = self.messenger.take() {
            // SAFETY: made from this instance and used only here.
            unsafe { debug.destroy_debug_utils_messenger(messenger, None) };
        }
        if self.ownership == Ownership::Ours {
            // SAFETY: every device holds this Arc, so no device is left.
            unsafe { self.raw.destroy_instance(None) };
        }
    }
}

/// Creates the messenger that fills `log`; the box of the log outlives the messenger.
fn create_messenger(
    entry: &ash::Entry,
    raw: &ash::Instance,
    log: &ValidationLog,
) -> Result<Messenger, Error> {
    let debug = ext::debug_utils::Instance::new(entry, raw);
    let info = ValidationLog::messenger_info(log);
    // SAFETY: the log is boxed and dropped after the messenger.
    let made = unsafe { debug.create_debug_utils_messenger(&info, None) };
    let messenger = made.called("vkCreateDebugUtilsMessengerEXT")?;
    Ok((debug, messenger))
}

fn require_1_3(entry: &ash::Entry) -> Result<(), Error> {
    // SAFETY: no contract beyond a loaded entry.
    let version = unsafe { entry.try_enumerate_instance_version() }
        .called("vkEnumerateInstanceVersion")?
        .unwrap_or(vk::API_VERSION_1_0);
    if version < vk::API_VERSION_1_3 {
        return Err(Error::OldLoader { found: version_text(version) });
    }
    Ok(())
}

/// Returns a packed version as text, such as `1.3.230`.
pub(crate) fn version_text(version: u32) -> String {
    format!(
        "{}.{}.{}",
        vk::api_version_major(version),
        vk::api_version_minor(version),
        vk::api_version_patch(version)
    )
}

fn wanted_layers(entry: &ash::Entry, validation: Validation) -> Result<Vec<*const c_char>, Error> {
    if validation == Validation::Off {
        return Ok(Vec::new());
    }
    // SAFETY: no contract beyond a loaded entry.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }
        .map_err(|code| refusal("vkEnumerateInstanceLayerProperties", code))?;
    let there = layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER));
    if there {
        Ok(vec![VALIDATION_LAYER.as_ptr()])
    } else {
        Err(Error::NoValidationLayer(VALIDATION_LAYER.to_string_lossy().into_owned()))
    }
}

fn extension_names(entry: &ash::Entry) -> Result<Vec<CString>, Error> {
    // SAFETY: no contract beyond a loaded entry.
    let there = unsafe { entry.enumerate_instance_extension_properties(None) };
    let there = there.map_err(|code| refusal("vkEnumerateInstanceExtensionProperties", code))?;
    let names = there.iter().filter_map(|extension| extension.extension_name_as_c_str().ok());
    Ok(names.map(Into::into).collect())
}

/// Returns the error that explains a failure of the loader. With a damaged manifest of a driver or
/// a layer, a loader reports missing memory.
pub(crate) fn refusal(call: &'static str, code: vk::Result) -> Error {
    let error = match code {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER | vk::Result::ERROR_INITIALIZATION_FAILED => {
            Error::NoDriver(format!("{call} failed with {code:?}"))
        }
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => Error::BadManifest { call, code },
        code => return Error::Vulkan { call, code },
    };
    explained(error)
}
