//! The pictures a walk leaves: some frames, and one moment seen from above.

use std::path::Path;

use cull::Strategy;
use gpu::Readback;
use render::Renderer;

use crate::Options;
use crate::course::Course;
use crate::eyes::Eyes;
use crate::moving::Moving;
use crate::picture::write_png;
use crate::run::RunError;

/// Frames walked before a picture, so that it shows a history at work and not a first frame.
const WARM_UP_FRAMES: u32 = 8;
/// The same before the moment seen from above: until the frontier has come to rest.
const SETTLING_FRAMES: u32 = 60;

/// Draws and writes what the options ask for into `folder`. Untimed, after the walk, by the last
/// strategy asked for.
///
/// # Errors
/// When the device fails or a file cannot be written.
pub fn write(
    renderer: &mut Renderer,
    path: &Course,
    moving: &mut Moving,
    options: &Options,
    folder: &Path,
) -> Result<(), RunError> {
    let picture = Readback::new(renderer.device(), renderer.size())?;
    let save = |name: String| {
        write_png(&folder.join(name), options.size, picture.rgba8()).map_err(RunError::machine)
    };
    for frame in options.picture_frames() {
        walk_to(renderer, path, moving, options, frame, WARM_UP_FRAMES, &picture)?;
        save(format!("frame_{frame:05}.png"))?;
    }
    if let Some(frame) = options.birds_eye {
        let mut eyes = walk_to(renderer, path, moving, options, frame, SETTLING_FRAMES, &picture)?;
        save(format!("birds_eye_{frame:05}_seen.png"))?;
        if let Some((history, view)) = eyes.first(renderer, &path.camera(frame)) {
            let moment = renderer.moment(history, view)?;
            renderer.birds_eye(&moment, &picture)?;
            save(format!("birds_eye_{frame:05}.png"))?;
        }
    }
    Ok(())
}

/// Walks with fresh histories to `frame`, whose picture is over when this returns.
fn walk_to(
    renderer: &mut Renderer,
    path: &Course,
    moving: &mut Moving,
    options: &Options,
    frame: u32,
    warm_up: u32,
    picture: &Readback,
) -> Result<Eyes, RunError> {
    // The ideal knows what is visible of the walk's own frames only, and draws the same picture.
    let mut products = options.strategies.iter().filter(|strategy| **strategy != Strategy::Ideal);
    let strategy = products.next_back().copied().unwrap_or(Strategy::Antumbra);
    let mut eyes = Eyes::new(renderer, options.views)?;
    for walked in frame.saturating_sub(warm_up)..=frame {
        moving.show(renderer, walked)?;
        let picture = (walked == frame).then_some(picture);
        eyes.render(renderer, strategy, &path.camera(walked), &[], picture)?;
    }
    renderer.device().drain().map_err(RunError::from)?;
    Ok(eyes)
}
