//! The program without a window: it draws the same frames, a sixtieth of a second apart, and writes
//! them as images on request.

use std::path::Path;
use std::rc::Rc;
use std::thread;

use antumbra::gpu::{Device, Readback};
use antumbra::pacing::{RecoverySchedule, Retry, Time};

use super::actions::Action;
use super::failures::{check_log, first_error};
use super::fly_camera::Steering;
use super::fly_out;
use super::loaded_scene::{SceneLoader, check_options};
use super::session::{Files, LightingRequest, Session};
use super::show::ShowOptions;
use super::source::SceneSource;
use bench::progress::LoadingBar;
use bench::run;
use bench::run_error::{Blame, RunError};
use bench::signals::Signals;
use bench::terminal::shown;

const FRAME_SECONDS: f32 = 1.0 / 60.0;
/// The number of frames between changes of the text.
const HUD_FRAMES: u32 = 15;

/// Draws the requested number of frames, or stops at a signal.
///
/// # Errors
/// An unsuitable device or a bad file; messages of the validation layer.
pub fn run(
    source: &SceneSource,
    options: &ShowOptions,
    files: Files,
    signals: &Signals,
) -> Result<(), RunError> {
    let instance = run::open_instance(options.validation, None)?;
    let adapter = instance.pick_adapter(run::wanted(&options.device).as_deref())?;
    let device = run::open_device(&instance, &adapter)?;
    let reopen = || {
        let adapter = instance.pick_adapter(run::wanted(&options.device).as_deref())?;
        run::open_device(&instance, &adapter)
    };
    let drawn = draw(device, &reopen, source, options, files, signals);
    let log = instance.validation_log().clone();
    drop(instance);
    first_error([drawn, check_log(&log)])
}

fn draw(
    device: Device,
    reopen: &dyn Fn() -> Result<Device, RunError>,
    source: &SceneSource,
    options: &ShowOptions,
    files: Files,
    signals: &Signals,
) -> Result<(), RunError> {
    let size = [options.size.width, options.size.height];
    check_options(&device, options, size)?;
    let cancellation = signals.cancellation();
    let loader = SceneLoader { device: &device, options, size, cancellation };
    let loaded = match source {
        SceneSource::File { .. } => {
            let bar = LoadingBar::for_terminal();
            loader.load(source, &mut |told| bar.told(told.what, told.fraction))?
        }
        _ => loader.load(source, &mut |_| {})?,
    };
    for note in &loaded.scene_view.notes {
        tracing::warn!("{}: {note}", shown(Path::new(&loaded.scene_view.name)));
    }
    if let Some(hint) = &loaded.scene_view.hint {
        tracing::info!("{hint}");
    }
    if let Some(file) = &options.fly_out {
        return fly_out::run(&device, options, loaded, file, signals);
    }
    let mut session = Session::new(&device, options, files, loaded)?;
    let mut drawn = draw_frames(&loader, &mut session, signals);
    let mut recovery = RecoverySchedule::default();
    while let Err(error) = &drawn
        && error.blame == Blame::LostDevice
        && let Retry::At(at) = recovery.lost(session.clock.now())
    {
        session.tell_loss(error);
        let device = match go_on(&mut session, &mut recovery, at, reopen) {
            Ok(device) => device,
            Err(error) => {
                drawn = Err(error);
                break;
            }
        };
        let cancellation = signals.cancellation();
        let loader = SceneLoader { device: &device, options, size, cancellation };
        drawn = draw_frames(&loader, &mut session, signals);
    }
    first_error([drawn, session.finish(options)])
}

/// Opens another device at the time `at`, or later, and continues on it.
fn go_on(
    session: &mut Session,
    recovery: &mut RecoverySchedule,
    mut at: Time,
    reopen: &dyn Fn() -> Result<Device, RunError>,
) -> Result<Device, RunError> {
    loop {
        thread::sleep(at.since(session.clock.now()));
        let recovered = reopen().and_then(|device| {
            session.recover(&device)?;
            session.search_again()?;
            Ok(device)
        });
        let error = match recovered {
            Ok(device) => return Ok(device),
            Err(error) => error,
        };
        let Retry::At(next) = recovery.failed(session.clock.now()) else { return Err(error) };
        at = next;
    }
}

fn draw_frames(
    loader: &SceneLoader<'_>,
    session: &mut Session,
    signals: &Signals,
) -> Result<(), RunError> {
    let SceneLoader { device, options, .. } = *loader;
    let size = [options.size.width, options.size.height];
    let image = options.out.as_ref().map(|_| Readback::new(device, size)).transpose()?;
    let image = image.map(Rc::new);
    tracing::info!("the frames begin");
    for frame in session.frame()..options.frames.unwrap_or(1) {
        if signals.received().is_some() {
            break;
        }
        let mut has_acted = false;
        while let Some(action) = session.next_scripted() {
            match action {
                Action::Quit => return Ok(()),
                // As after a loss.
                Action::AnotherDevice => {
                    return Err(RunError::lost_device("a script asks for another device"));
                }
                _ => {}
            }
            session.act(action)?;
            if let Some(LightingRequest { source, action }) = session.take_lighting_request() {
                session.light_up(loader.load(&source, &mut |_| {})?, action)?;
            }
            has_acted = true;
        }
        if session.take_stale_page() || has_acted || frame % HUD_FRAMES == 0 {
            session.lay_out(None, 1.0)?;
        }
        let seconds = if frame == 0 { 0.0 } else { FRAME_SECONDS };
        session.draw(&Steering::default(), seconds, image.as_ref())?;
        if let (Some(image), Some(folder)) = (&image, &options.out) {
            if let Err(error) = device.wait_idle().and_then(|()| image.rgba8().map(drop)) {
                session.repeat_frame();
                return Err(error.into());
            }
            let path = folder.join(format!("frame_{frame:05}.png"));
            // A lost image is reported at the end; later images are still written.
            let _kept = session.screenshots.write(image, &path);
        }
        session.after_frame()?;
    }
    Ok(())
}
