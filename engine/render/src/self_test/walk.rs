//! Walks of the self-test: frames of a street by each tester, compared with plain frustum culling,
//! and the boxes drawn by the passes of scenes with surfaces.

use cull::{Strategy, VisibilityTestSupport};
use gpu::{Device, OptionalFeature, Readback};
use occlusion::CostModel;

use super::check_result::CheckResult;
use super::probe_scene::{self, SIZE, WALK_FRAMES};
use crate::error::Error;
use crate::render_view::RenderView;
use crate::renderer::{Renderer, RendererOptions};
use crate::views::FrameRequest;

/// Size of the images of the walk.
const WALK_SIZE: [u32; 2] = [192, 108];

/// Returns the testers that the device supports.
pub(super) fn offered(device: &Device) -> VisibilityTestSupport {
    let flags = device.capabilities().has(OptionalFeature::FragmentStores);
    let compute = occlusion::ComputeTest::check(device, WALK_SIZE).is_ok();
    VisibilityTestSupport { flags, compute, leaf_tests: flags, ..VisibilityTestSupport::default() }
}

/// Returns the image of the boxes in a scene with surfaces, which draws depth before colour.
pub(super) fn shaded_probes(device: &Device, options: &RendererOptions) -> Result<Vec<u8>, Error> {
    let scene = probe_scene::probes().with_surfaces();
    let options = RendererOptions { size: SIZE, cost_model: CostModel::Off, ..options.clone() };
    let mut renderer = Renderer::new(device, &scene, &options)?;
    let mut view = renderer.new_view()?;
    let request = FrameRequest::new(Strategy::FRUSTUM, probe_scene::camera());
    image(&mut renderer, &mut view, request)
}

/// Walks with each strategy. Returns the results in their order.
pub(super) fn walks(
    device: &Device,
    options: &RendererOptions,
    strategies: [Strategy; 3],
) -> Result<Vec<CheckResult>, Error> {
    let options =
        RendererOptions { size: WALK_SIZE, cost_model: CostModel::Off, ..options.clone() };
    let mut renderer = Renderer::new(device, &probe_scene::street(), &options)?;
    let mut references = Vec::new();
    let mut view = renderer.new_view()?;
    for frame in 0..WALK_FRAMES {
        let request = FrameRequest::new(Strategy::FRUSTUM, probe_scene::walk_camera(frame));
        references.push(image(&mut renderer, &mut view, request)?);
    }
    strategies.into_iter().map(|strategy| walk(&mut renderer, strategy, &references)).collect()
}

/// Walks with one strategy.
fn walk(
    renderer: &mut Renderer,
    strategy: Strategy,
    references: &[Vec<u8>],
) -> Result<CheckResult, Error> {
    if let Err(error) = renderer.supports(strategy) {
        return Ok(CheckResult::Skipped(error.to_string()));
    }
    let mut view = renderer.new_view()?;
    let mut wrong = 0;
    for (frame, expected) in (0..).zip(references) {
        let request = FrameRequest::new(strategy, probe_scene::walk_camera(frame));
        let found = image(renderer, &mut view, request)?;
        wrong += usize::from(found != *expected);
    }
    let sentence = "frames differ from plain frustum culling";
    Ok(CheckResult::of_faults(wrong, references.len(), sentence))
}

/// Draws a frame and waits for its image.
fn image(
    renderer: &mut Renderer,
    view: &mut RenderView,
    request: FrameRequest<'_>,
) -> Result<Vec<u8>, Error> {
    let image = Readback::new(renderer.device(), renderer.size())?;
    renderer.render(view, FrameRequest { image: Some(&image), ..request })?;
    renderer.wait_idle(view)?;
    Ok(image.rgba8()?.to_vec())
}
