//! Messages of the engine for the caller's log.

use std::ffi::{CString, c_char, c_void};
use std::fmt::{Debug, Write};

use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

use crate::layout::pointers;

/// The default: warnings and errors.
pub const ANTUMBRA_LOG_DEFAULT: u32 = 0;
/// An error: something could not be done.
pub const ANTUMBRA_LOG_ERROR: u32 = 1;
/// A warning: something works, but not as well as it could.
pub const ANTUMBRA_LOG_WARN: u32 = 2;
/// A decision worth knowing, such as the way a device is used.
pub const ANTUMBRA_LOG_INFO: u32 = 3;
/// Details for debugging.
pub const ANTUMBRA_LOG_DEBUG: u32 = 4;

/// Takes a message of a level (`ANTUMBRA_LOG_..`). `message` is UTF-8 with a 0 at the end, valid
/// during the call. The callback runs on the thread that called the library, during that call, and
/// must not call the library.
pub type AntumbraLogCallback =
    Option<unsafe extern "C" fn(user: *mut c_void, level: u32, message: *const c_char)>;

pointers!(AntumbraLogCallback);

/// A subscriber that passes events to a function of the caller.
pub(crate) struct CallbackLog {
    pub callback: unsafe extern "C" fn(*mut c_void, u32, *const c_char),
    pub user: *mut c_void,
    pub max_level: u32,
}

// SAFETY: the caller promises that the function may be called on every thread that calls us.
unsafe impl Send for CallbackLog {}
// SAFETY: as above.
unsafe impl Sync for CallbackLog {}

impl Subscriber for CallbackLog {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.is_event() && number(*metadata.level()) <= self.max_level
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        let mut text = Text(String::new());
        event.record(&mut text);
        text.0.retain(|letter| letter != '\0');
        // The text has no 0 bytes any more.
        let Ok(message) = CString::new(text.0) else { return };
        // SAFETY: the promise of the caller who gave the function.
        unsafe { (self.callback)(self.user, number(*event.metadata().level()), message.as_ptr()) };
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

/// Returns the number of a level in C.
fn number(level: Level) -> u32 {
    match level {
        Level::ERROR => ANTUMBRA_LOG_ERROR,
        Level::WARN => ANTUMBRA_LOG_WARN,
        Level::INFO => ANTUMBRA_LOG_INFO,
        Level::DEBUG => ANTUMBRA_LOG_DEBUG,
        Level::TRACE => ANTUMBRA_LOG_DEBUG + 1,
    }
}

/// The text of an event: its message, then its other fields.
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        let start = if self.0.is_empty() { "" } else { ", " };
        // Writing to a string cannot fail.
        let _ = match field.name() {
            "message" => write!(self.0, "{start}{value:?}"),
            name => write!(self.0, "{start}{name}: {value:?}"),
        };
    }
}
