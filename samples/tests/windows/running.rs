//! Runs programs in a window, and `city` without one for the image to compare with.

use std::fs;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use tests::xvfb::Xvfb;

use harness::{Scratch, pixels, program, stderr};

pub const SIZE: &str = "320x180";
/// The longest wait for a program. A machine that runs other tests beside needs a minute for some.
const LIMIT: Duration = Duration::from_secs(240);
pub const ESCAPE: u32 = 0xff1b;
pub const TAB: u32 = 0xff09;

/// A program in a window. It is killed if a test fails before it ends.
pub struct Running {
    pub process: Child,
    log: std::path::PathBuf,
}

impl Running {
    pub fn start(mut command: Command, scratch: &Scratch) -> Self {
        let log = scratch.0.join("log");
        let file = fs::File::create(&log).unwrap();
        let process = command.stdout(Stdio::null()).stderr(file).spawn().unwrap();
        Self { process, log }
    }

    pub fn city(scratch: &Scratch, server: &Xvfb, arguments: &[&str]) -> Self {
        let all = ["--objects", "500", "--size", SIZE, "--device", "llvmpipe"];
        // The tests that pay depend on the machine; the keys that show tests need some.
        let all = [&all[..], &["--validation", "sync", "--cost-model", "off"], arguments].concat();
        Self::show(program(crate::CITY, &scratch.0, &all), scratch, server)
    }

    /// Starts a program in a window of `server`.
    pub fn show(mut command: Command, scratch: &Scratch, server: &Xvfb) -> Self {
        command.env("DISPLAY", server.display()).env("RUST_LOG", "samples=info,winit=error");
        command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        Self::start(command, scratch)
    }

    pub fn log(&self) -> String {
        fs::read_to_string(&self.log).unwrap()
    }

    pub fn await_text(&self, text: &str) {
        let began = Instant::now();
        while !self.log().contains(text) {
            assert!(began.elapsed() < LIMIT, "never said {text}: {}", self.log());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits for its end.
    pub fn end(&mut self) -> ExitStatus {
        let began = Instant::now();
        loop {
            if let Some(status) = self.process.try_wait().unwrap() {
                return status;
            }
            assert!(began.elapsed() < LIMIT, "it hangs: {}", self.log());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits for its end, and checks that it is a success without messages of the validation layer.
    pub fn end_well(mut self) {
        let status = self.end();
        assert!(status.success(), "{status}: {}", self.log());
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _is_over = self.process.kill();
        let _is_over = self.process.wait();
    }
}

/// Returns the image of a resting camera, drawn without a window.
pub fn headless(scratch: &Scratch, arguments: &[&str]) -> Vec<[u8; 3]> {
    let all = ["--headless", "--frames", "2", "--objects", "500", "--device", "llvmpipe"];
    let all = [&all[..], arguments, &["--out", "headless"]].concat();
    // Nothing is overwritten.
    let _absent = fs::remove_dir_all(scratch.0.join("headless"));
    let mut command = program(crate::CITY, &scratch.0, &all);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    pixels(&scratch.0.join("headless/frame_00001.png"))
}

/// Returns the pixels of a colour of the HUD: what draws it takes 2.2 for the exponent of sRGB.
pub fn of_colour(pixels: &[[u8; 3]], colour: [u8; 3]) -> usize {
    let is_near = |pixel: &&[u8; 3]| pixel.iter().zip(colour).all(|(a, b)| a.abs_diff(b) <= 3);
    pixels.iter().filter(is_near).count()
}
