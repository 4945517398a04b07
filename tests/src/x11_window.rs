//! A window on X11. The test that owns it moves it and reads its pixels.

use std::ffi::CString;
use std::num::NonZeroU32;
use std::ptr::NonNull;
use std::sync::Arc;

use crate::xvfb::Xvfb;
use raw_window_handle::{
    DisplayHandle, HandleError, HasDisplayHandle, HasWindowHandle, RawDisplayHandle,
    RawWindowHandle, WindowHandle, XcbDisplayHandle, XcbWindowHandle, XlibDisplayHandle,
    XlibWindowHandle,
};
use x11_dl::xlib::{Display, XErrorEvent, Xlib};
use x11rb::COPY_DEPTH_FROM_PARENT;
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    ConfigureWindowAux, ConnectionExt, CreateWindowAux, ImageFormat, WindowClass,
};
use x11rb::xcb_ffi::XCBConnection;

/// The library through which Vulkan talks to the server.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Library {
    /// libxcb, through `VK_KHR_xcb_surface`.
    Xcb,
    /// libX11, through `VK_KHR_xlib_surface`.
    Xlib,
}

/// A window, with a separate connection for the test.
pub struct X11Window {
    connection: XCBConnection,
    xlib: Option<(Xlib, NonNull<Display>)>,
    /// The window's id at the server.
    pub id: u32,
}

// SAFETY: the display is opened for threads, and only Vulkan uses it.
unsafe impl Send for X11Window {}
// SAFETY: as above.
unsafe impl Sync for X11Window {}

/// Ignores errors about a destroyed window: Xlib's default handler would end the program.
unsafe extern "C" fn ignore_error(_display: *mut Display, _error: *mut XErrorEvent) -> i32 {
    0
}

impl X11Window {
    /// Returns a window of `size` pixels, on the screen.
    pub fn open(server: &Xvfb, library: Library, size: [u32; 2]) -> Arc<Self> {
        let name = CString::new(server.display()).unwrap();
        let xlib = (library == Library::Xlib).then(|| {
            let xlib = Xlib::open().expect("libX11: run `ci/setup` first");
            // SAFETY: called before any other function of Xlib; the name is a string.
            let display = unsafe {
                (xlib.XInitThreads)();
                (xlib.XSetErrorHandler)(Some(ignore_error));
                (xlib.XOpenDisplay)(name.as_ptr())
            };
            (xlib, NonNull::new(display).expect("a display"))
        });
        let (connection, screen) = XCBConnection::connect(Some(&name)).unwrap();
        let root = connection.setup().roots[screen].root;
        let id = connection.generate_id().unwrap();
        let [width, height] = size.map(|side| side as u16);
        let class = WindowClass::INPUT_OUTPUT;
        let aux = CreateWindowAux::new();
        connection
            .create_window(
                COPY_DEPTH_FROM_PARENT,
                id,
                root,
                0,
                0,
                width,
                height,
                0,
                class,
                x11rb::COPY_FROM_PARENT,
                &aux,
            )
            .unwrap();
        let window = Self { connection, xlib, id };
        window.show();
        Arc::new(window)
    }

    /// Waits until the server has handled all requests.
    fn settle(&self) {
        self.connection.get_input_focus().unwrap().reply().unwrap();
    }

    /// Changes the size in pixels, and waits until the server has done so.
    pub fn resize(&self, size: [u32; 2]) {
        let aux = ConfigureWindowAux::new().width(size[0]).height(size[1]);
        self.connection.configure_window(self.id, &aux).unwrap();
        self.settle();
    }

    /// Moves the window on the screen.
    pub fn place(&self, x: i32, y: i32) {
        self.connection.configure_window(self.id, &ConfigureWindowAux::new().x(x).y(y)).unwrap();
        self.settle();
    }

    /// Takes the window off the screen.
    pub fn hide(&self) {
        self.connection.unmap_window(self.id).unwrap();
        self.settle();
    }

    /// Puts the window on the screen.
    pub fn show(&self) {
        self.connection.map_window(self.id).unwrap();
        self.settle();
    }

    /// Destroys the window while swapchains may still have it.
    pub fn destroy(&self) {
        self.connection.destroy_window(self.id).unwrap();
        self.settle();
    }

    /// Returns the pixels of the window now: red, green, blue; rows from the top.
    pub fn pixels(&self, size: [u32; 2]) -> Vec<[u8; 3]> {
        let [width, height] = size.map(|side| side as u16);
        let format = ImageFormat::Z_PIXMAP;
        let image = self.connection.get_image(format, self.id, 0, 0, width, height, u32::MAX);
        let image = image.unwrap().reply().expect("a window on the screen");
        image.data.chunks_exact(4).map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect()
    }
}

impl Drop for X11Window {
    fn drop(&mut self) {
        if let Some((xlib, display)) = &self.xlib {
            // SAFETY: opened by this window, whose surfaces are gone.
            unsafe { (xlib.XCloseDisplay)(display.as_ptr()) };
        }
    }
}

impl HasWindowHandle for X11Window {
    fn window_handle(&self) -> Result<WindowHandle<'_>, HandleError> {
        let raw = match &self.xlib {
            Some(_) => RawWindowHandle::Xlib(XlibWindowHandle::new(self.id.into())),
            None => RawWindowHandle::Xcb(XcbWindowHandle::new(NonZeroU32::new(self.id).unwrap())),
        };
        // SAFETY: the id belongs to the window as long as this lives. If the window is destroyed
        // before, the server reports an error, which tests expect.
        Ok(unsafe { WindowHandle::borrow_raw(raw) })
    }
}

impl HasDisplayHandle for X11Window {
    fn display_handle(&self) -> Result<DisplayHandle<'_>, HandleError> {
        let raw = match &self.xlib {
            Some((_, display)) => {
                RawDisplayHandle::Xlib(XlibDisplayHandle::new(Some(display.cast()), 0))
            }
            None => {
                let connection = NonNull::new(self.connection.get_raw_xcb_connection());
                RawDisplayHandle::Xcb(XcbDisplayHandle::new(connection, 0))
            }
        };
        // SAFETY: the connection is open as long as this lives.
        Ok(unsafe { DisplayHandle::borrow_raw(raw) })
    }
}
