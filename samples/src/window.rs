//! The programs `city`, `shadows` and `viewer`, with and without a window.
//!
//! [`args`] and [`viewer_args`] turn command lines into a [`source`] and [options](show) of showing
//! it. The source becomes a [`loaded_scene`]: a renderer, and a [`scene_view`] with its cameras and
//! its motion. Files are loaded while frames continue ([`loading`]). A [`session`] draws one frame
//! at a time on request: of [`app`] when the pacer of its [`screen`] starts a frame, or of
//! [`headless`] without waiting. Keys and scripts trigger [`actions`].

pub mod actions;
mod api;
pub mod app;
pub mod args;
pub mod capture;
mod clearance;
mod clipboard;
pub mod clock;
pub mod comparison;
pub mod conditions;
mod detail;
pub mod differences;
pub mod display;
mod exactness_claim;
pub mod failures;
pub mod flares;
pub mod fly_camera;
mod fly_out;
pub mod frame_pacing_stats;
pub mod frame_times;
pub mod gamepad;
pub mod headless;
pub mod input;
mod keys_help;
pub mod leaving;
pub mod legends;
pub mod loaded_scene;
pub mod loading;
pub mod menu;
mod object_text;
mod opened;
mod page_text;
mod pending_scenes;
pub mod pointer;
pub mod profiler;
pub mod recovery;
mod scene_files;
pub mod scene_view;
pub mod screen;
pub mod screenshots;
pub mod script;
mod selection;
pub mod session;
pub mod shader_watch;
pub mod shadows_args;
pub mod show;
pub mod source;
pub mod title;
pub mod toast;
pub mod trace;
pub mod viewer_args;
pub mod window_device;

use std::process::ExitCode;

use bench::outputs::{OutputFile, Outputs, check_shaders};
use bench::run_error::{Blame, RunError};
use bench::signals::{Signal, Signals};
use bench::terminal::{Ending, ending};
use session::Files;
use show::ShowOptions;
use source::SceneSource;

/// Runs the program until its end; returns the signal that ended it, if there was one.
///
/// # Errors
/// No display; an unsuitable device or a bad file; messages of the validation layer.
pub fn run(source: &SceneSource, options: &ShowOptions) -> Result<Option<Signal>, RunError> {
    let files = Files::open(source, options)?;
    options.shaders.as_deref().map_or(Ok(()), check_shaders)?;
    let trace = OutputFile::of("--trace", options.trace.as_deref());
    let fly_out = OutputFile::of("--fly-out", options.fly_out.as_deref());
    let outputs = Outputs::prepare(options.out.as_deref(), trace.into_iter().chain(fly_out))?;
    let signals = Signals::watch()?;
    let ran = if options.is_headless {
        headless::run(source, options, files, &signals)
    } else {
        app::run(source, options, files, &signals)
    };
    drop(outputs);
    match ran {
        Err(error) if error.blame == Blame::Nobody => Ok(signals.received()),
        ran => ran.map(|()| signals.received()),
    }
}

/// Runs the program with the options of the command line, prints errors, and returns the exit code.
pub fn end(options: Result<(SceneSource, ShowOptions), RunError>) -> ExitCode {
    let mut ending = Ending::default();
    match options.and_then(|(source, options)| run(&source, &options)) {
        Ok(signal) => ending.interrupted(signal),
        Err(error) => return ending::refuse(&error, error.exit_code()),
    }
    ending.exit()
}
