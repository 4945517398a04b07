//! The window system on which a window opens.

use bench::run_error::RunError;
use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

/// Opens the event loop on Wayland, or on X11 if `WAYLAND_DISPLAY` does not name a running
/// compositor.
///
/// # Errors
/// When there is no display.
pub fn event_loop() -> Result<EventLoop<()>, EventLoopError> {
    let mut builder = EventLoop::builder();
    // winit decides by the variables alone, and an event loop can be created only once.
    #[cfg(target_os = "linux")]
    if is_set("DISPLAY") && is_stale_wayland() {
        tracing::info!("WAYLAND_DISPLAY leads nowhere; the window opens on X11");
        winit::platform::x11::EventLoopBuilderExtX11::with_x11(&mut builder);
    }
    builder.build()
}

/// Returns the error of a missing display.
pub fn no_display(error: impl std::fmt::Display) -> RunError {
    // winit begins the text with the place in its own source.
    let text = error.to_string();
    let reason = text.rsplit_once(".rs:").map_or(text.as_str(), |(_, found)| {
        found.trim_start_matches(|c: char| c.is_ascii_digit() || c == ':' || c == ' ')
    });
    let reason = reason.trim_end_matches('.');
    RunError::machine(format!(
        "there is no display to open a window on ({reason}); --headless does without"
    ))
}

#[cfg(target_os = "linux")]
fn is_set(variable: &str) -> bool {
    std::env::var_os(variable).is_some_and(|value| !value.is_empty())
}

/// Returns true if the named Wayland display has no listener.
#[cfg(target_os = "linux")]
fn is_stale_wayland() -> bool {
    use std::os::unix::net::UnixStream;
    use std::path::PathBuf;

    // A socket that was handed down is open.
    if is_set("WAYLAND_SOCKET") || !is_set("WAYLAND_DISPLAY") {
        return false;
    }
    let name = std::env::var_os("WAYLAND_DISPLAY").unwrap_or_default();
    let folder = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from).unwrap_or_default();
    UnixStream::connect(folder.join(name)).is_err()
}
