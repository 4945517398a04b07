//! The choice of the executor that skips hidden draws: of those that the device has and that can be
//! trusted the one that costs least.

use cull::SkippedWork;
use occlusion::{ChoiceRequest, CullingSetup, DeviceCosts, OcclusionPasses, ShaderSet};

use crate::calibration_scene;
use crate::error::Error;
use crate::renderer::RendererOptions;
use crate::scene_renderer::SceneRenderer;
use crate::shadows::{can_skip, caster_executor};

/// Decides for a scene of so many draws, one per leaf, those for spare objects too, by costs that
/// are measured if that is asked for. Casters are skipped alike, each range by itself.
pub(crate) fn decide(
    passes: &mut SceneRenderer,
    occlusion_passes: &OcclusionPasses,
    shaders: &ShaderSet,
    draws: u64,
    options: &RendererOptions,
) -> Result<CullingSetup, Error> {
    let device = passes.device.clone();
    let quirks = occlusion_passes.quirks();

    let executors =
        quirks.usable_executors(&device, options.predication, draws, options.threshold_samples)?;
    let work = SkippedWork::of_leaves(draws as u32);
    let request = ChoiceRequest { executors: &executors, work };
    let choice = CullingSetup::by(options.cost_model, &request, || {
        let of_executors = &executors[..];
        let measured = calibration_scene::measure(
            passes,
            occlusion_passes,
            of_executors,
            shaders,
            &options.cancellation,
        );
        // What is given up is no failure of the device to warn of: the renderer is refused below.
        if options.cancellation.is_cancelled() { Ok(DeviceCosts::default()) } else { measured }
    });
    options.cancellation.check()?;
    let can = |predication| can_skip(&device, predication);
    if let Some(executor) = caster_executor(quirks, choice.predication, can) {
        passes.shadows.skip_by(executor, options.frames_in_flight.max(1))?;
    }
    Ok(choice)
}
