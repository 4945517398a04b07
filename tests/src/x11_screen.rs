//! The view of a user of a program's window on X11: reads its pixels, presses keys, and resizes,
//! hides and closes it.

use std::time::{Duration, Instant};

use crate::xvfb::Xvfb;
use x11rb::connection::Connection;
use x11rb::protocol::Event;
pub use x11rb::protocol::xproto::{BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT};
use x11rb::protocol::xproto::{
    ChangeWindowAttributesAux, ClientMessageEvent, ConfigureWindowAux, ConnectionExt,
    CreateWindowAux, EventMask, GrabMode, GrabStatus, ImageFormat, InputFocus, KEY_PRESS_EVENT,
    KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, MapState, PropMode, SELECTION_NOTIFY_EVENT,
    SelectionNotifyEvent, WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;
use x11rb::{CURRENT_TIME, NONE};

/// A window of a server.
pub struct Seen {
    connection: RustConnection,
    root: u32,
    /// The id of the window.
    pub window: u32,
}

impl Seen {
    /// Waits until there is a window on the screen.
    pub fn wait_for(server: &Xvfb) -> Self {
        Self::wait_until(server, |_, _| true)
    }

    /// Waits until there is a window of a size (pixels) on the screen, beside others.
    pub fn wait_for_size(server: &Xvfb, size: [u16; 2]) -> Self {
        Self::wait_until(server, |connection, window| {
            let geometry = connection.get_geometry(window).unwrap().reply();
            geometry.is_ok_and(|found| [found.width, found.height] == size)
        })
    }

    fn wait_until(server: &Xvfb, is_wanted: impl Fn(&RustConnection, u32) -> bool) -> Self {
        let (connection, screen) = RustConnection::connect(Some(server.display())).unwrap();
        let root = connection.setup().roots[screen].root;
        let began = Instant::now();
        loop {
            let tree = connection.query_tree(root).unwrap().reply().unwrap();
            let is_shown = |window: &u32| {
                let attributes = connection.get_window_attributes(*window).unwrap().reply();
                attributes.is_ok_and(|attributes| attributes.map_state == MapState::VIEWABLE)
                    && is_wanted(&connection, *window)
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

    /// Returns the pixels of the window now: red, green, blue; rows from the top. `None` while a
    /// part of the window is off the screen.
    pub fn pixels(&self) -> Option<Vec<[u8; 3]>> {
        let geometry = self.connection.get_geometry(self.window).unwrap().reply().ok()?;
        let width = geometry.width;
        let height = geometry.height;
        let format = ImageFormat::Z_PIXMAP;
        let image = self.connection.get_image(format, self.window, 0, 0, width, height, u32::MAX);
        let image = image.unwrap().reply().ok()?;
        Some(image.data.chunks_exact(4).map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect())
    }

    /// Waits until the window shows these pixels.
    pub fn await_pixels(&self, expected: &[[u8; 3]], what: &str) {
        self.await_that(what, |found| found == expected);
    }

    /// Waits until the window shows pixels that satisfy the condition.
    pub fn await_that(&self, what: &str, is_right: impl Fn(&[[u8; 3]]) -> bool) {
        let began = Instant::now();
        while !self.pixels().is_some_and(|found| is_right(&found)) {
            assert!(began.elapsed() < Duration::from_secs(60), "never shows {what}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Presses a key, by its symbol in the server's layout.
    pub fn strike(&self, symbol: u32) {
        self.press(symbol, Duration::from_millis(20));
    }

    /// Holds a key for a while.
    pub fn press(&self, symbol: u32, time: Duration) {
        self.press_code(self.code_of(symbol), time);
    }

    /// Returns the key code that has a symbol in the server's layout.
    pub fn code_of(&self, symbol: u32) -> u8 {
        let setup = self.connection.setup();
        let least = setup.min_keycode;
        let most = setup.max_keycode;
        let mapping = self.connection.get_keyboard_mapping(least, most - least + 1);
        let mapping = mapping.unwrap().reply().unwrap();
        let per_code = usize::from(mapping.keysyms_per_keycode);
        let place = mapping.keysyms.chunks(per_code).position(|of_code| of_code[0] == symbol);
        least + u8::try_from(place.expect("a key with that symbol")).unwrap()
    }

    /// Holds the key with a code for a while.
    pub fn press_code(&self, code: u8, time: Duration) {
        // Without a window manager, the window does not get the focus on its own.
        self.focus();
        for event in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            self.fake(event, code, [0, 0]);
            std::thread::sleep(time);
        }
    }

    /// Presses a key while another key is held.
    pub fn press_with(&self, held: u32, symbol: u32) {
        let held = self.code_of(held);
        self.focus();
        self.fake(KEY_PRESS_EVENT, held, [0, 0]);
        self.strike(symbol);
        self.fake(KEY_RELEASE_EVENT, held, [0, 0]);
    }

    /// Gives the window the focus.
    pub fn focus(&self) {
        self.connection.set_input_focus(InputFocus::PARENT, self.window, 0_u32).unwrap();
        self.settle();
        std::thread::sleep(Duration::from_millis(20));
    }

    /// Sends an input event as a device would.
    fn fake(&self, event: u8, detail: u8, place: [i16; 2]) {
        let [x, y] = place;
        self.connection.xtest_fake_input(event, detail, 0, self.root, x, y, 0).unwrap();
        self.settle();
    }

    /// Presses or releases a button of the mouse.
    pub fn button(&self, number: u8, event: u8) {
        self.fake(event, number, [0, 0]);
        std::thread::sleep(Duration::from_millis(20));
    }

    /// Presses and releases a button of the mouse.
    pub fn click(&self, number: u8) {
        self.button(number, BUTTON_PRESS_EVENT);
        self.button(number, BUTTON_RELEASE_EVENT);
    }

    /// Moves the mouse to a place on the screen.
    pub fn point_at(&self, place: [i16; 2]) {
        self.fake(MOTION_NOTIFY_EVENT, 0, place);
        std::thread::sleep(Duration::from_millis(20));
    }

    /// Moves the mouse, in small steps as a hand does.
    pub fn move_by(&self, steps: u16, place: [i16; 2]) {
        let [x, y] = place;
        const RELATIVE: u8 = 1;
        for _ in 0..steps {
            self.fake(MOTION_NOTIFY_EVENT, RELATIVE, [x, y]);
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Returns true if another client may grab the pointer.
    pub fn is_pointer_free(&self) -> bool {
        let root = self.root;
        let mode = GrabMode::ASYNC;
        let grab = self.connection.grab_pointer(
            false,
            root,
            EventMask::NO_EVENT,
            mode,
            mode,
            0_u32,
            0_u32,
            CURRENT_TIME,
        );
        let is_free = grab.unwrap().reply().unwrap().status == GrabStatus::SUCCESS;
        if is_free {
            self.connection.ungrab_pointer(CURRENT_TIME).unwrap();
            self.settle();
        }
        is_free
    }

    /// Waits until the window's title satisfies the condition.
    pub fn await_title(&self, is_right: impl Fn(&str) -> bool) {
        let atom = |name: &[u8]| self.connection.intern_atom(false, name).unwrap();
        let name = atom(b"_NET_WM_NAME").reply().unwrap().atom;
        let text = atom(b"UTF8_STRING").reply().unwrap().atom;
        let began = Instant::now();
        loop {
            let title = self.connection.get_property(false, self.window, name, text, 0, 256);
            let title = String::from_utf8(title.unwrap().reply().unwrap().value).unwrap();
            if is_right(&title) {
                return;
            }
            assert!(began.elapsed() < Duration::from_secs(60), "the title stays {title}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Listens to requests to a window manager.
    pub fn manage(&self) {
        let aux = ChangeWindowAttributesAux::new().event_mask(EventMask::SUBSTRUCTURE_NOTIFY);
        self.connection.change_window_attributes(self.root, &aux).unwrap();
        self.settle();
    }

    /// Waits until the window requests the full screen (true), or its old size (false).
    pub fn await_full_screen(&self) -> bool {
        let atom = |name: &[u8]| self.connection.intern_atom(false, name).unwrap();
        let state = atom(b"_NET_WM_STATE").reply().unwrap().atom;
        let full = atom(b"_NET_WM_STATE_FULLSCREEN").reply().unwrap().atom;
        let began = Instant::now();
        loop {
            match self.connection.poll_for_event().unwrap() {
                Some(Event::ClientMessage(asked)) if asked.type_ == state => {
                    let [action, which, ..] = asked.data.as_data32();
                    if which == full {
                        return action == 1;
                    }
                }
                Some(_) => {}
                None => std::thread::sleep(Duration::from_millis(5)),
            }
            assert!(began.elapsed() < Duration::from_secs(60), "it asks for no full screen");
        }
    }

    /// Changes the window's size (pixels).
    pub fn resize(&self, size: [u32; 2]) {
        let aux = ConfigureWindowAux::new().width(size[0]).height(size[1]);
        self.connection.configure_window(self.window, &aux).unwrap();
        self.settle();
    }

    /// Hides the window.
    pub fn hide(&self) {
        self.connection.unmap_window(self.window).unwrap();
        self.settle();
    }

    /// Shows the window again.
    pub fn show(&self) {
        self.connection.map_window(self.window).unwrap();
        self.settle();
    }

    /// Destroys the window, which a window system would never do.
    pub fn destroy(&self) {
        self.connection.destroy_window(self.window).unwrap();
        self.settle();
    }

    fn atom(&self, name: &[u8]) -> u32 {
        self.connection.intern_atom(false, name).unwrap().reply().unwrap().atom
    }

    /// Takes the ownership of a selection, and returns the window that owns it.
    fn own(&self, selection: &[u8]) -> u32 {
        let connection = &self.connection;
        let source = connection.generate_id().unwrap();
        let class = WindowClass::INPUT_ONLY;
        let aux = CreateWindowAux::new();
        connection.create_window(0, source, self.root, 0, 0, 1, 1, 0, class, 0, &aux).unwrap();
        connection.set_selection_owner(source, self.atom(selection), CURRENT_TIME).unwrap();
        self.settle();
        source
    }

    /// Hands over the selection when it is requested as `kind`. No other requests arrive.
    fn hand_over(&self, kind: &[u8], bytes: &[u8]) {
        let connection = &self.connection;
        let kind = self.atom(kind);
        let began = Instant::now();
        loop {
            assert!(
                began.elapsed() < Duration::from_secs(60),
                "it never asks for what is selected"
            );
            let Some(Event::SelectionRequest(asked)) = connection.poll_for_event().unwrap() else {
                std::thread::sleep(Duration::from_millis(5));
                continue;
            };
            let replace = PropMode::REPLACE;
            let window = asked.requestor;
            let is_it = asked.target == kind;
            if is_it {
                let property = asked.property;
                connection.change_property8(replace, window, property, kind, bytes).unwrap();
            }
            let answer = SelectionNotifyEvent {
                response_type: SELECTION_NOTIFY_EVENT,
                sequence: 0,
                time: asked.time,
                requestor: window,
                selection: asked.selection,
                target: asked.target,
                property: if is_it { asked.property } else { NONE },
            };
            connection.send_event(false, window, EventMask::NO_EVENT, answer).unwrap();
            self.settle();
            if is_it {
                return;
            }
        }
    }

    /// Presses Ctrl+V after `text` was copied in another window.
    pub fn paste(&self, control: u32, text: &str) {
        self.own(b"CLIPBOARD");
        self.press_with(control, 'v'.into());
        self.hand_over(b"UTF8_STRING", text.as_bytes());
    }

    /// Drops a file into the window as file managers do, by the source's side of the XDND protocol.
    pub fn drop_file(&self, path: &std::path::Path) {
        let source = self.own(b"XdndSelection");
        let send = |name: &[u8], rest: [u32; 4]| {
            let [a, b, c, d] = rest;
            let data = [source, a, b, c, d];
            let event = ClientMessageEvent::new(32, self.window, self.atom(name), data);
            self.connection.send_event(false, self.window, EventMask::NO_EVENT, event).unwrap();
            self.settle();
        };
        const VERSION: u32 = 5 << 24;
        const LIST: &[u8] = b"text/uri-list";
        send(b"XdndEnter", [VERSION, self.atom(LIST), 0, 0]);
        send(b"XdndPosition", [0, 0, CURRENT_TIME, self.atom(b"XdndActionCopy")]);
        self.hand_over(LIST, format!("file://{}\r\n", path.display()).as_bytes());
        send(b"XdndDrop", [0, CURRENT_TIME, 0, 0]);
    }

    /// Closes the window as the button of its frame does.
    pub fn close(&self) {
        let atom =
            |name: &[u8]| self.connection.intern_atom(false, name).unwrap().reply().unwrap().atom;
        let data = [atom(b"WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let event = ClientMessageEvent::new(32, self.window, atom(b"WM_PROTOCOLS"), data);
        self.connection.send_event(false, self.window, EventMask::NO_EVENT, event).unwrap();
        self.settle();
    }
}
