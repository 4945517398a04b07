//! The images of a walk: some frames, and one frame seen from above.

use std::path::{Path, PathBuf};

use antumbra::cull::Strategy;
use antumbra::gpu::Readback;
use antumbra::methods;
use antumbra::render::{DebugOverlay, Renderer};

use crate::Options;
use crate::camera_path::CameraTrack;
use crate::eyes::Eyes;
use crate::legend::{self, LegendEntry};
use crate::memory::copy_of;
use crate::moving::Moving;
use crate::png_file::write_png;
use crate::run_error::RunError;
use crate::signals::Signals;

/// The number of frames walked before an image, so that it shows a frame with a history and not a
/// first frame.
const WARM_UP_FRAMES: u32 = 8;
/// The number of frames walked before the frame seen from above: until the frontier is stable.
const SETTLING_FRAMES: u32 = 60;

/// Images that were asked for.
#[derive(Debug, Default)]
pub struct WalkImages {
    /// The files that were written.
    pub written: Vec<PathBuf>,
    /// The reasons why others were not.
    pub failures: Vec<RunError>,
}

impl WalkImages {
    /// Draws and writes the images that the options ask for into `folder`. Untimed, after the
    /// walk, by the last strategy asked for. Each is tried on its own; after a signal no more are
    /// begun.
    ///
    /// # Errors
    /// When the device fails.
    pub fn write(
        &mut self,
        renderer: &mut Renderer,
        path: &CameraTrack,
        moving: &mut Moving,
        options: &Options,
        folder: &Path,
        signals: &Signals,
    ) -> Result<(), RunError> {
        if let Some(shadows) = options.shadows.last() {
            renderer.set_shadows(shadows.options())?;
        }
        let image = Readback::new(renderer.device(), renderer.size())?;
        let mut save = |name: String, title: &str, entries: &[LegendEntry]| {
            let written = image.rgba8().map_err(RunError::from).and_then(|pixels| {
                let mut pixels = copy_of(&pixels)?;
                if !entries.is_empty() {
                    legend::draw(&mut pixels, options.asked.size.width as usize, title, entries);
                }
                let written = write_png(&folder.join(name), options.asked.size, &pixels);
                written.map_err(RunError::machine)
            });
            match written {
                Ok(path) => self.written.push(path),
                Err(error) => self.failures.push(error),
            }
        };
        for frame in options.image_frames() {
            if signals.received().is_some() {
                return Ok(());
            }
            walk_to(renderer, path, moving, options, frame, WARM_UP_FRAMES, &image)?;
            save(format!("frame_{frame:05}.png"), "", &[]);
            if options.asked.depth_complexity {
                let layers = DebugOverlay { has_depth_complexity: true, ..DebugOverlay::default() };
                renderer.set_debug_overlay(layers)?;
                walk_to(renderer, path, moving, options, frame, WARM_UP_FRAMES, &image)?;
                renderer.set_debug_overlay(DebugOverlay::default())?;
                let name = format!("depth_complexity_{frame:05}.png");
                save(name, legend::TITLE_OF_LAYERS, &legend::layers());
            }
        }
        if let Some(frame) = options.top_down.filter(|_| signals.received().is_none()) {
            let eyes = walk_to(renderer, path, moving, options, frame, SETTLING_FRAMES, &image);
            let mut eyes = eyes?;
            save(format!("top_down_{frame:05}_seen.png"), "", &[]);
            if let Some((history, view)) = eyes.first(renderer, &path.frame_camera(frame))? {
                let snapshot = renderer.snapshot(history, view)?;
                renderer.top_down(&snapshot, &image)?;
                let name = format!("top_down_{frame:05}.png");
                save(name, legend::TITLE_FROM_ABOVE, &legend::from_above());
            }
        }
        Ok(())
    }
}

/// Walks with fresh histories to `frame`, whose image is complete when this returns.
fn walk_to(
    renderer: &mut Renderer,
    path: &CameraTrack,
    moving: &mut Moving,
    options: &Options,
    frame: u32,
    warm_up: u32,
    image: &Readback,
) -> Result<Eyes, RunError> {
    // The ideal has visible sets only for frames of the walk, and would draw the same image.
    let mut products = options.strategies.iter().filter(|strategy| **strategy != methods::IDEAL);
    let strategy = products.next_back().copied().unwrap_or(Strategy::ANTUMBRA);
    let mut eyes = Eyes::new(renderer, options.asked.views, options.asked.projection)?;
    for walked in frame.saturating_sub(warm_up)..=frame {
        moving.show(renderer, walked)?;
        let image = (walked == frame).then_some(image);
        eyes.render(renderer, strategy, &path.frame_camera(walked), &[], image)?;
    }
    renderer.device().wait_idle().map_err(RunError::from)?;
    Ok(eyes)
}
