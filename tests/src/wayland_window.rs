//! A window on Wayland. The test that owns it shows it, or never does.

use std::ffi::c_void;
use std::ptr::NonNull;
use std::sync::{Arc, Mutex};

use crate::weston::Weston;
use raw_window_handle::{
    DisplayHandle, HandleError, HasDisplayHandle, HasWindowHandle, RawDisplayHandle,
    RawWindowHandle, WaylandDisplayHandle, WaylandWindowHandle, WindowHandle,
};
use rustix::event::{PollFd, PollFlags, poll};
use wayland_client::globals::{GlobalListContents, registry_queue_init};
use wayland_client::protocol::{wl_compositor, wl_registry, wl_surface};
use wayland_client::{Connection, Dispatch, EventQueue, Proxy, QueueHandle, delegate_noop};
use wayland_protocols::xdg::shell::client::{xdg_surface, xdg_toplevel, xdg_wm_base};

/// The compositor's events about the window.
#[derive(Default)]
pub struct Events {
    configured: bool,
}

/// A window. It answers the compositor when [`Self::answer`] is called.
pub struct WaylandWindow {
    connection: Connection,
    queue: Mutex<(EventQueue<Events>, Events)>,
    surface: wl_surface::WlSurface,
    _roles: Option<(xdg_surface::XdgSurface, xdg_toplevel::XdgToplevel)>,
}

impl WaylandWindow {
    /// Returns a window that the compositor shows.
    pub fn open(compositor: &Weston) -> Arc<Self> {
        Self::with_role(compositor, true)
    }

    /// Returns a window that is never shown, so that the compositor never requests another image.
    pub fn open_hidden(compositor: &Weston) -> Arc<Self> {
        Self::with_role(compositor, false)
    }

    fn with_role(compositor: &Weston, is_shown: bool) -> Arc<Self> {
        let connection = Connection::from_socket(compositor.connect())
            .expect("libwayland-client: run `ci/setup` first");
        let (globals, mut queue) = registry_queue_init::<Events>(&connection).unwrap();
        let handle = queue.handle();
        let compositor: wl_compositor::WlCompositor = globals.bind(&handle, 1..=4, ()).unwrap();
        let surface = compositor.create_surface(&handle, ());
        let mut events = Events::default();
        let roles = is_shown.then(|| {
            let shell: xdg_wm_base::XdgWmBase = globals.bind(&handle, 1..=2, ()).unwrap();
            let role = shell.get_xdg_surface(&surface, &handle, ());
            let toplevel = role.get_toplevel(&handle, ());
            toplevel.set_title("swapchain test".to_owned());
            surface.commit();
            while !events.configured {
                queue.blocking_dispatch(&mut events).unwrap();
            }
            (role, toplevel)
        });
        queue.roundtrip(&mut events).unwrap();
        let queue = Mutex::new((queue, events));
        Arc::new(Self { connection, queue, surface, _roles: roles })
    }

    /// Answers the events since the last call, as an event loop would.
    pub fn answer(&self) {
        let mut queue = self.queue.lock().unwrap();
        let (queue, events) = &mut *queue;
        queue.flush().unwrap();
        // If another thread of the driver waits for the compositor, a read without data would wait
        // for that thread.
        if let Some(guard) = queue.prepare_read() {
            let mut sockets = [PollFd::from_borrowed_fd(guard.connection_fd(), PollFlags::IN)];
            let at_once = rustix::event::Timespec { tv_sec: 0, tv_nsec: 0 };
            if poll(&mut sockets, Some(&at_once)).unwrap() > 0 {
                let _nothing_came = guard.read();
            }
        }
        queue.dispatch_pending(events).unwrap();
    }
}

impl HasWindowHandle for WaylandWindow {
    fn window_handle(&self) -> Result<WindowHandle<'_>, HandleError> {
        let surface = NonNull::new(self.surface.id().as_ptr().cast::<c_void>()).unwrap();
        let raw = RawWindowHandle::Wayland(WaylandWindowHandle::new(surface));
        // SAFETY: the surface lives as long as this window.
        Ok(unsafe { WindowHandle::borrow_raw(raw) })
    }
}

impl HasDisplayHandle for WaylandWindow {
    fn display_handle(&self) -> Result<DisplayHandle<'_>, HandleError> {
        let display = NonNull::new(self.connection.backend().display_ptr().cast::<c_void>());
        let raw = RawDisplayHandle::Wayland(WaylandDisplayHandle::new(display.unwrap()));
        // SAFETY: the connection lives as long as this window.
        Ok(unsafe { DisplayHandle::borrow_raw(raw) })
    }
}

impl Dispatch<wl_registry::WlRegistry, GlobalListContents> for Events {
    fn event(
        _: &mut Self,
        _: &wl_registry::WlRegistry,
        _: wl_registry::Event,
        _: &GlobalListContents,
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
    }
}

impl Dispatch<xdg_wm_base::XdgWmBase, ()> for Events {
    fn event(
        _: &mut Self,
        shell: &xdg_wm_base::XdgWmBase,
        event: xdg_wm_base::Event,
        _: &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let xdg_wm_base::Event::Ping { serial } = event {
            shell.pong(serial);
        }
    }
}

impl Dispatch<xdg_surface::XdgSurface, ()> for Events {
    fn event(
        events: &mut Self,
        surface: &xdg_surface::XdgSurface,
        event: xdg_surface::Event,
        _: &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let xdg_surface::Event::Configure { serial } = event {
            surface.ack_configure(serial);
            events.configured = true;
        }
    }
}

delegate_noop!(Events: ignore wl_compositor::WlCompositor);
delegate_noop!(Events: ignore wl_surface::WlSurface);
delegate_noop!(Events: ignore xdg_toplevel::XdgToplevel);
