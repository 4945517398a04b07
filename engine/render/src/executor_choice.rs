//! The choice of the executor that skips hidden draws: of those that the device has and that can be
//! trusted the one that costs least.

use cull::SkippedWork;
use gpu::{Device, Predication};
use occlusion::{ChoiceRequest, OcclusionPasses, PriceChoice, ShaderSet};

use crate::calibration_scene;
use crate::error::Error;
use crate::frame_passes::FramePasses;
use crate::renderer::RendererOptions;
use crate::self_test::Trust;
use crate::shadows::can_skip;

/// Returns the executors that may be used for so many draws with a threshold: the wanted one, or
/// all, the device's usual one first. Where none can be trusted that one stays, and nothing is put
/// under a predicate ([`Renderer::trusted`](crate::Renderer::trusted)).
pub(crate) fn usable_executors(
    trust: &Trust,
    device: &Device,
    wanted: Option<Predication>,
    (draws, threshold_samples): (u64, u32),
) -> Result<Vec<Predication>, Error> {
    let first = Predication::choose(device, wanted, draws, threshold_samples)?;
    let has = |it| Predication::choose(device, Some(it), draws, threshold_samples).is_ok();
    let mut usable = trust.executors(first, has);
    if wanted.is_some() {
        usable.truncate(1);
    }
    if usable.is_empty() {
        usable.push(first);
    }
    Ok(usable)
}

/// Decides for a scene of so many leaves, those for spare objects too, by prices that are measured
/// if that is asked for. Casters are skipped alike, each range by itself.
pub(crate) fn decide(
    passes: &mut FramePasses,
    (occlusion_passes, shaders): (&OcclusionPasses, &ShaderSet),
    (trust, executors): (&Trust, &[Predication]),
    (leaves, options): (u32, &RendererOptions),
) -> Result<PriceChoice, Error> {
    let request = ChoiceRequest {
        executors,
        testers: trust.testers(occlusion_passes.testers(&passes.device, &passes.target)),
        work: SkippedWork::of_leaves(leaves),
        size: options.size,
    };
    let choice = PriceChoice::by(options.costs, &request, || {
        calibration_scene::measure(passes, (occlusion_passes, executors), shaders)
    });
    let device = &passes.device;
    if let Some(executor) = trust.caster_executor(choice.predication, |it| can_skip(device, it)) {
        passes.shadows.skip_by(executor, options.frames_in_flight.max(1))?;
    }
    Ok(choice)
}
