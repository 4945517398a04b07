//! An instance of a host, under the validation layer, with checks of synchronization, where
//! it is installed.

use std::error::Error;
use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicU64, Ordering};

use ash::{ext, vk};

/// The messages of the validation layer so far.
static MESSAGES: AtomicU64 = AtomicU64::new(0);

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// An instance, and the listener to the validation layer.
pub struct HostInstance {
    /// The loader's entry.
    pub entry: ash::Entry,
    /// The instance.
    pub raw: ash::Instance,
    debug: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
}

impl HostInstance {
    /// Creates an instance of Vulkan 1.3 with these extensions.
    ///
    /// # Errors
    /// No loader, a failed call.
    pub fn new(extensions: &[&CStr]) -> Result<Self, Box<dyn Error>> {
        // SAFETY: the loader of this system.
        let entry = unsafe { ash::Entry::load() }?;
        // SAFETY: the entry is loaded.
        let layers = unsafe { entry.enumerate_instance_layer_properties() }?;
        let is_validated = layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(LAYER));
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut checks = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let layers = [LAYER.as_ptr()];
        let of_layer = [ext::debug_utils::NAME, ext::validation_features::NAME];
        let of_layer = of_layer.into_iter().filter(|_| is_validated);
        let names: Vec<_> = extensions.iter().copied().chain(of_layer).map(CStr::as_ptr).collect();
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_extension_names(&names);
        if is_validated {
            info = info.enabled_layer_names(&layers).push_next(&mut checks);
        }
        // SAFETY: every pointer in `info` lives until the call returns.
        let raw = unsafe { entry.create_instance(&info, None) }?;
        let debug = if is_validated {
            Some(listen(&entry, &raw)?)
        } else {
            println!("the validation layer is not installed");
            None
        };
        Ok(Self { entry, raw, debug })
    }

    /// Returns the extensions of the instance that a device must be told about.
    #[must_use]
    pub fn extensions(&self) -> Option<&'static CStr> {
        self.debug.is_some().then_some(ext::debug_utils::NAME)
    }

    /// Returns the first device whose name contains `wanted`, in any case.
    ///
    /// # Errors
    /// No such device, a failed call.
    pub fn find(&self, wanted: &str) -> Result<vk::PhysicalDevice, Box<dyn Error>> {
        let is_wanted = |physical: &vk::PhysicalDevice| {
            // SAFETY: a physical device of this instance.
            let properties = unsafe { self.raw.get_physical_device_properties(*physical) };
            let name = properties.device_name_as_c_str().unwrap_or_default().to_string_lossy();
            name.to_lowercase().contains(&wanted.to_lowercase())
        };
        // SAFETY: a valid instance.
        let mut all = unsafe { self.raw.enumerate_physical_devices() }?.into_iter();
        all.find(is_wanted).ok_or_else(|| format!("no device is called {wanted:?}").into())
    }

    /// Destroys the instance, and returns the number of messages.
    #[must_use]
    pub fn destroy(self) -> u64 {
        // SAFETY: everything made from it is gone.
        unsafe {
            if let Some((debug, messenger)) = self.debug {
                debug.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
        MESSAGES.load(Ordering::Relaxed)
    }
}

fn listen(
    entry: &ash::Entry,
    instance: &ash::Instance,
) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT), vk::Result> {
    use vk::{
        DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type,
    };
    let debug = ext::debug_utils::Instance::new(entry, instance);
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Type::VALIDATION)
        .pfn_user_callback(Some(on_message));
    // SAFETY: the callback lives as long as the program.
    let messenger = unsafe { debug.create_debug_utils_messenger(&info, None) }?;
    Ok((debug, messenger))
}

unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    _user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data with a text that ends.
    let text = unsafe { (*data).message_as_c_str() }.unwrap_or_default();
    eprintln!("validation: {}", text.to_string_lossy());
    MESSAGES.fetch_add(1, Ordering::Relaxed);
    vk::FALSE
}
