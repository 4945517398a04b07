//! The program without a window: it draws the same frames, a sixtieth of a second apart, and writes
//! them as images on request.

use std::path::Path;
use std::rc::Rc;

use antumbra::gpu::{Device, DeviceOptions, Readback};

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
use bench::run_error::RunError;
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
    let device_options =
        DeviceOptions { pipeline_cache: run::pipeline_cache_file(), ..Default::default() };
    let device = Device::new(&instance, &adapter, &device_options)?;
    let drawn = draw(&device, source, options, files, signals);
    drop(device);
    let log = instance.validation_log().clone();
    drop(instance);
    first_error([drawn, check_log(&log)])
}

fn draw(
    device: &Device,
    source: &SceneSource,
    options: &ShowOptions,
    files: Files,
    signals: &Signals,
) -> Result<(), RunError> {
    let size = [options.size.width, options.size.height];
    check_options(device, options, size)?;
    let loader = SceneLoader { device, options, size, cancellation: signals.cancellation() };
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
        return fly_out::run(device, options, loaded, file, signals);
    }
    let mut session = Session::new(device, options, files, loaded)?;
    let drawn = draw_frames(&loader, &mut session, signals);
    first_error([drawn, session.finish(options)])
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
    for frame in 0..options.frames.unwrap_or(1) {
        if signals.received().is_some() {
            break;
        }
        let mut has_acted = false;
        while let Some(action) = session.next_scripted() {
            if action == Action::Quit {
                return Ok(());
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
            device.wait_idle()?;
            let path = folder.join(format!("frame_{frame:05}.png"));
            // A lost image is reported at the end; later images are still written.
            let _kept = session.screenshots.write(image, &path);
        }
        session.after_frame()?;
    }
    Ok(())
}
