//! The choice of the executor that skips hidden draws: the cheapest of the executors that the
//! device supports and that can be trusted.

use cull::SkippedWork;
use occlusion::{ChoiceRequest, CullingSetup, OcclusionPasses, ShaderSet};

use crate::calibration_scene;
use crate::error::Error;
use crate::renderer::RendererOptions;
use crate::scene_renderer::SceneRenderer;
use crate::shadows::{can_skip, caster_executor};

/// Decides for a scene with `draws` draws, one per leaf, including spare objects. Measures the
/// costs if `options` request it. Casters are skipped by the same executor, each range
/// individually.
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
    let measure = || {
        let of_executors = &executors[..];
        let measured = calibration_scene::measure(
            passes,
            occlusion_passes,
            of_executors,
            shaders,
            &options.cancellation,
        );
        // A cancelled measurement must not warn of the device.
        options.cancellation.check()?;
        match measured {
            Ok(device_costs) => Ok(Some(device_costs)),
            // Nothing can be drawn on a lost device.
            Err(Error::Gpu(error)) if error.is_device_lost() => Err(Error::Gpu(error)),
            Err(error) => {
                tracing::warn!("the costs of this device could not be measured: {error}");
                Ok(None)
            }
        }
    };
    let choice = CullingSetup::by(options.cost_model, &request, measure)?;
    options.cancellation.check()?;
    let can = |predication| can_skip(&device, predication);
    if let Some(executor) = caster_executor(quirks, choice.predication, can) {
        passes.shadows.skip_by(executor, options.frames_in_flight.max(1))?;
    }
    Ok(choice)
}
