//! The validation log: the messages of the layers, kept until they are drained.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;

/// One message of a validation layer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// The name of the rule, such as `VUID-vkCmdDraw-None-02699`.
    pub id: String,
    /// The text of the message from the layer.
    pub text: String,
}

/// All messages of the validation layers, in order. Clones share one log.
#[derive(Debug, Clone, Default)]
pub struct ValidationLog {
    messages: Arc<Mutex<Vec<Message>>>,
}

/// The most messages that are kept: the first messages explain the rest.
const MESSAGES_KEPT: usize = 10_000;

impl ValidationLog {
    /// Removes and returns all messages since the last call.
    pub fn drain(&self) -> Vec<Message> {
        std::mem::take(&mut *self.lock())
    }

    /// Returns the number of messages in the log.
    pub fn len(&self) -> usize {
        self.lock().len()
    }

    /// Returns true if the log has no message.
    pub fn is_empty(&self) -> bool {
        self.lock().is_empty()
    }

    fn push(&self, message: Message) {
        let mut messages = self.lock();
        if messages.len() < MESSAGES_KEPT {
            messages.push(message);
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Message>> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the description of the messenger, with this log as the user data of the callback.
    /// The log must outlive the messenger; [`crate::Instance`] keeps it in a box for this.
    pub(crate) fn messenger_info(log: &ValidationLog) -> vk::DebugUtilsMessengerCreateInfoEXT<'_> {
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                    | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                    | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE
                    | vk::DebugUtilsMessageTypeFlagsEXT::GENERAL,
            )
            .pfn_user_callback(Some(on_message))
            .user_data(std::ptr::from_ref(log).cast_mut().cast())
    }
}

unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    if data.is_null() || user_data.is_null() {
        return vk::FALSE;
    }
    // SAFETY: the loader passes callback data that is valid during the call.
    let data = unsafe { &*data };
    // SAFETY: user_data is the boxed log of the instance, which outlives its messenger.
    let log = unsafe { &*user_data.cast::<ValidationLog>() };
    // SAFETY: both strings are null or null-terminated and live for the call.
    let (id, text) = unsafe { (text_of(data.p_message_id_name), text_of(data.p_message)) };
    if !is_about_our_calls(kind, &id) {
        tracing::debug!(target: "vulkan", "{id}: {text}");
    } else {
        tracing::warn!(target: "vulkan", "{id}: {text}");
        log.push(Message { id, text });
    }
    vk::FALSE
}

/// Returns false for messages of the loader (about a manifest that it could not read), and for
/// messages about names that were looked up at the wrong level. Loaders and drivers do so within
/// `vkCreateDevice`, as NVIDIA 580 does with
/// `vkGetPhysicalDeviceVideoEncodeQualityLevelPropertiesKHR`, a name that this program does not
/// contain. The names of this program are looked up by `ash` at their level.
fn is_about_our_calls(kind: vk::DebugUtilsMessageTypeFlagsEXT, id: &str) -> bool {
    kind != vk::DebugUtilsMessageTypeFlagsEXT::GENERAL && id != "WARNING-vkGetDeviceProcAddr-device"
}

/// Copies a string of a message.
///
/// # Safety
/// `text` is null or points to a null-terminated string.
unsafe fn text_of(text: *const std::ffi::c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: not null, and null-terminated by the caller's promise.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_about_calls_of_loaders_and_drivers_are_not_about_ours() {
        let validation = vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION;
        assert!(is_about_our_calls(validation, "SYNC-HAZARD-READ-AFTER-WRITE"));
        assert!(!is_about_our_calls(validation, "WARNING-vkGetDeviceProcAddr-device"));
        let general = vk::DebugUtilsMessageTypeFlagsEXT::GENERAL;
        assert!(!is_about_our_calls(general, "Loader Message"));
    }
}
