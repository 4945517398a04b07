//! Looks at a program's window on X11, strikes its keys, resizes, hides and closes it.

use std::time::{Duration, Instant};

use tests::xvfb::Xvfb;
use x11rb::CURRENT_TIME;
use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ClientMessageEvent, ConfigureWindowAux, ConnectionExt, CreateWindowAux, EventMask, ImageFormat,
    InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, MapState, PropMode, SELECTION_NOTIFY_EVENT,
    SelectionNotifyEvent, WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// The one window of a server.
pub struct Seen {
    connection: RustConnection,
    root: u32,
    pub window: u32,
}

impl Seen {
    /// Waits until there is a window on the screen.
    pub fn wait_for(server: &Xvfb) -> Self {
        let (connection, screen) = RustConnection::connect(Some(server.display())).unwrap();
        let root = connection.setup().roots[screen].root;
        let began = Instant::now();
        loop {
            let tree = connection.query_tree(root).unwrap().reply().unwrap();
            let is_shown = |window: &u32| {
                let attributes = connection.get_window_attributes(*window).unwrap().reply();
                attributes.is_ok_and(|attributes| attributes.map_state == MapState::VIEWABLE)
            };
            if let Some(window) = tree.children.into_iter().find(is_shown) {
                return Self { connection, root, window };
            }
            assert!(began.elapsed() < Duration::from_secs(60), "no window opens");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn settle(&self) {
        self.connection.get_input_focus().unwrap().reply().unwrap();
    }

    /// What is in the window now: red, green, blue; rows from the top. Nothing while it is not all
    /// on the screen.
    pub fn pixels(&self) -> Option<Vec<[u8; 3]>> {
        let geometry = self.connection.get_geometry(self.window).unwrap().reply().ok()?;
        let (width, height) = (geometry.width, geometry.height);
        let format = ImageFormat::Z_PIXMAP;
        let image = self.connection.get_image(format, self.window, 0, 0, width, height, u32::MAX);
        let image = image.unwrap().reply().ok()?;
        Some(image.data.chunks_exact(4).map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect())
    }

    /// Waits until the window shows this.
    pub fn await_pixels(&self, expected: &[[u8; 3]], what: &str) {
        self.await_that(what, |found| found == expected);
    }

    /// Waits until the window shows something that is as it should be.
    pub fn await_that(&self, what: &str, is_right: impl Fn(&[[u8; 3]]) -> bool) {
        let began = Instant::now();
        while !self.pixels().is_some_and(|found| is_right(&found)) {
            assert!(began.elapsed() < Duration::from_secs(60), "never shows {what}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Strikes a key, by the symbol that it has in the server's layout.
    pub fn strike(&self, symbol: u32) {
        self.press(symbol, Duration::from_millis(20));
    }

    /// Holds a key for a while.
    pub fn press(&self, symbol: u32, time: Duration) {
        let setup = self.connection.setup();
        let (least, most) = (setup.min_keycode, setup.max_keycode);
        let mapping = self.connection.get_keyboard_mapping(least, most - least + 1);
        let mapping = mapping.unwrap().reply().unwrap();
        let per_code = usize::from(mapping.keysyms_per_keycode);
        let place = mapping.keysyms.chunks(per_code).position(|of_code| of_code[0] == symbol);
        let code = least + u8::try_from(place.expect("a key with that symbol")).unwrap();
        // Nobody gives the window the focus where no window manager is.
        self.connection.set_input_focus(InputFocus::PARENT, self.window, 0_u32).unwrap();
        self.settle();
        std::thread::sleep(Duration::from_millis(20));
        for event in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            self.connection.xtest_fake_input(event, code, 0, self.root, 0, 0, 0).unwrap();
            self.settle();
            std::thread::sleep(time);
        }
    }

    pub fn resize(&self, size: [u32; 2]) {
        let aux = ConfigureWindowAux::new().width(size[0]).height(size[1]);
        self.connection.configure_window(self.window, &aux).unwrap();
        self.settle();
    }

    pub fn hide(&self) {
        self.connection.unmap_window(self.window).unwrap();
        self.settle();
    }

    pub fn show(&self) {
        self.connection.map_window(self.window).unwrap();
        self.settle();
    }

    pub fn destroy(&self) {
        self.connection.destroy_window(self.window).unwrap();
        self.settle();
    }

    /// Drops a file into the window, as file managers do: a source's side of the protocol XDND.
    pub fn drop_file(&self, path: &std::path::Path) {
        let connection = &self.connection;
        let atom = |name: &[u8]| connection.intern_atom(false, name).unwrap().reply().unwrap().atom;
        let (selection, list) = (atom(b"XdndSelection"), atom(b"text/uri-list"));
        let source = connection.generate_id().unwrap();
        let (class, aux) = (WindowClass::INPUT_ONLY, CreateWindowAux::new());
        connection.create_window(0, source, self.root, 0, 0, 1, 1, 0, class, 0, &aux).unwrap();
        connection.set_selection_owner(source, selection, CURRENT_TIME).unwrap();
        let send = |name: &[u8], rest: [u32; 4]| {
            let [a, b, c, d] = rest;
            let event = ClientMessageEvent::new(32, self.window, atom(name), [source, a, b, c, d]);
            connection.send_event(false, self.window, EventMask::NO_EVENT, event).unwrap();
            self.settle();
        };
        const VERSION: u32 = 5 << 24;
        send(b"XdndEnter", [VERSION, list, 0, 0]);
        send(b"XdndPosition", [0, 0, CURRENT_TIME, atom(b"XdndActionCopy")]);
        let began = Instant::now();
        let asked = loop {
            match connection.poll_for_event().unwrap() {
                Some(Event::SelectionRequest(asked)) => break asked,
                Some(_) => {}
                None => std::thread::sleep(Duration::from_millis(5)),
            }
            assert!(began.elapsed() < Duration::from_secs(60), "it never asks for the file");
        };
        let uri = format!("file://{}\r\n", path.display());
        let (replace, window) = (PropMode::REPLACE, asked.requestor);
        let bytes = uri.as_bytes();
        connection.change_property8(replace, window, asked.property, list, bytes).unwrap();
        let answer = SelectionNotifyEvent {
            response_type: SELECTION_NOTIFY_EVENT,
            sequence: 0,
            time: asked.time,
            requestor: window,
            selection: asked.selection,
            target: asked.target,
            property: asked.property,
        };
        connection.send_event(false, window, EventMask::NO_EVENT, answer).unwrap();
        send(b"XdndDrop", [0, CURRENT_TIME, 0, 0]);
    }

    /// Closes the window as its frame's button does.
    pub fn close(&self) {
        let atom =
            |name: &[u8]| self.connection.intern_atom(false, name).unwrap().reply().unwrap().atom;
        let data = [atom(b"WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let event = ClientMessageEvent::new(32, self.window, atom(b"WM_PROTOCOLS"), data);
        self.connection.send_event(false, self.window, EventMask::NO_EVENT, event).unwrap();
        self.settle();
    }
}
