//! Single frames: drawn, then awaited.

use cull::{Camera, Strategy};
use gpu::{Device, Readback};
use render::{FrameRequest, RenderView, Renderer, RendererOptions};
use scene::Scene;

/// Draws a frame and waits for its image.
pub fn image(
    renderer: &mut Renderer,
    view: &mut RenderView,
    strategy: Strategy,
    camera: Camera,
) -> Vec<u8> {
    let image = Readback::new(renderer.device(), renderer.size()).expect("memory");
    let request = FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera) };
    renderer.render(view, request).expect("a frame");
    renderer.wait_idle(view).expect("the frame ends");
    image.rgba8().expect("an image").to_vec()
}

/// Draws the first frame of a new renderer, with everything in view.
pub fn first_image(
    device: &Device,
    scene: &Scene,
    options: &RendererOptions,
    camera: Camera,
) -> Vec<u8> {
    let mut renderer = Renderer::new(device, scene, options).expect("a renderer");
    let mut view = renderer.new_view().expect("a view");
    image(&mut renderer, &mut view, Strategy::FRUSTUM, camera)
}
