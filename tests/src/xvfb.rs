//! An X server without a screen. Each test that needs a server starts its own.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use x11rb::rust_connection::RustConnection;

/// A running Xvfb, which is ended on drop.
pub struct Xvfb {
    server: Child,
    display: String,
    // The server ends with its last client, so it does not outlive a test, even after a crash.
    _client: RustConnection,
}

impl Xvfb {
    /// Starts a server with one screen of 1280x1024 pixels of 24 bits, on a display that is free.
    pub fn start() -> Self {
        // The server picks a free display, and reports its number when it is ready.
        let server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-terminate", "-nolisten", "tcp"])
            .args(["-screen", "0", "1280x1024x24"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut server = server.unwrap_or_else(|error| {
            panic!(
                "Xvfb does not start ({error}).\nRun `ci/setup --tests` first: this test needs it."
            )
        });
        let mut number = String::new();
        let says = server.stdout.take().expect("its output");
        BufReader::new(says).read_line(&mut number).expect("a display");
        assert!(!number.trim().is_empty(), "Xvfb ended without a display");
        let display = format!(":{}", number.trim());
        let (client, _) = RustConnection::connect(Some(&display)).expect("a connection to Xvfb");
        Self { server, display, _client: client }
    }

    /// Returns the server's display, as in the variable `DISPLAY`.
    pub fn display(&self) -> &str {
        &self.display
    }

    /// Ends the server, with any clients still connected.
    pub fn end(&mut self) {
        let _is_gone_already = self.server.kill();
        let _is_gone_already = self.server.wait();
    }
}

impl Drop for Xvfb {
    fn drop(&mut self) {
        self.end();
    }
}
