//! A Wayland compositor without a screen. Each test that needs a compositor starts its own.

use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// A running weston, which is ended on drop.
pub struct Weston {
    compositor: Child,
    folder: PathBuf,
}

const SOCKET: &str = "wayland-test";

impl Weston {
    /// Starts a compositor with one output of 1024x640 pixels.
    pub fn start() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("antumbra-weston-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).expect("a folder for the compositor's socket");
        // Weston refuses a folder that other users can read.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let private = std::fs::Permissions::from_mode(0o700);
            std::fs::set_permissions(&folder, private).expect("a private folder");
        }
        let compositor = Command::new("weston")
            .args(["--backend=headless-backend.so", "--no-config", "--idle-time=0"])
            .args(["--width=1024", "--height=640", &format!("--socket={SOCKET}")])
            .env("XDG_RUNTIME_DIR", &folder)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let compositor = compositor.unwrap_or_else(|error| {
            panic!("weston does not start ({error}).\nRun `ci/setup --tests` first: this test needs it.")
        });
        let weston = Self { compositor, folder };
        drop(weston.connect());
        weston
    }

    /// Returns a separate connection to the compositor.
    pub fn connect(&self) -> UnixStream {
        let began = Instant::now();
        loop {
            match UnixStream::connect(self.folder.join(SOCKET)) {
                Ok(stream) => return stream,
                Err(error) if began.elapsed() > Duration::from_secs(20) => {
                    panic!("weston opens no socket: {error}")
                }
                Err(_) => std::thread::sleep(Duration::from_millis(10)),
            }
        }
    }

    /// Makes `command` open its windows on this compositor.
    pub fn environment(&self, command: &mut Command) {
        command.env("XDG_RUNTIME_DIR", &self.folder).env("WAYLAND_DISPLAY", SOCKET);
        command.env_remove("DISPLAY").env_remove("WAYLAND_SOCKET");
    }

    /// Stops the compositor, as if it were busy.
    pub fn freeze(&self) {
        self.signal("-STOP");
    }

    /// Continues the compositor.
    pub fn thaw(&self) {
        self.signal("-CONT");
    }

    fn signal(&self, signal: &str) {
        let sent = Command::new("kill").args([signal, &self.compositor.id().to_string()]).status();
        assert!(sent.expect("the command kill").success());
    }

    /// Ends the compositor, with any clients still connected.
    pub fn end(&mut self) {
        let _is_gone_already = self.compositor.kill();
        let _is_gone_already = self.compositor.wait();
    }
}

impl Drop for Weston {
    fn drop(&mut self) {
        self.end();
        let _stays_if_it_must = std::fs::remove_dir_all(&self.folder);
    }
}
