//! All that this host writes to have its scene drawn on its own device.

use std::error::Error;
use std::sync::Arc;

use cull::{Aabb, Camera, Strategy};
use glam::Affine3A;
use gpu::{Device, FinishedImage, HostQueue, HostQueueLock};
use render::{CostModel, FrameRequest, RenderView, Renderer, RendererOptions};
use scene::{Mesh, MeshId, Object, Scene};
use walk::{AshDevice, BoxScene};

/// The linear colours of the boxes, a mesh each.
const COLOURS: [[f32; 3]; walk::BUCKETS as usize] = [[0.8, 0.7, 0.5], [0.1, 0.3, 0.6]];

/// The engine's renderer, and one view of the scene.
pub struct DrawnScene {
    renderer: Renderer,
    view: RenderView,
}

impl DrawnScene {
    /// Adopts the host's device, and uploads the scene.
    pub fn new(
        host: &AshDevice,
        lock: Arc<dyn HostQueueLock>,
        walk: &BoxScene,
    ) -> Result<Self, Box<dyn Error>> {
        // SAFETY: as described; the host destroys its device behind `DrawnScene::finish`.
        let device = unsafe { Device::adopt(description(host, lock)) }?;
        // Tests are made whether they pay or not: the program counts what they hide.
        let size = walk::SIZE;
        let cost_model = CostModel::Off; // a test of a box costs more than the box
        let options = RendererOptions { size, cost_model, ..Default::default() };
        let renderer = Renderer::new(&device, &scene_of(walk), &options)?;
        let view = renderer.new_view()?;
        Ok(Self { renderer, view })
    }

    /// Submits a frame to the host's queue, and returns its image with the state that it is in.
    pub fn draw(
        &mut self,
        camera: Camera,
        strategy: Strategy,
    ) -> Result<FinishedImage, Box<dyn Error>> {
        self.renderer.render(&mut self.view, &FrameRequest::new(strategy, camera))?;
        Ok(self.renderer.finished_image()?)
    }

    /// Frees everything, and returns the draws of the last frame.
    pub fn finish(mut self) -> Result<u64, Box<dyn Error>> {
        self.renderer.wait_idle(&mut self.view)?;
        Ok(self.view.drain_stats().next_back().map_or(0, |outcome| outcome.draws))
    }
}

/// Returns the scene: a mesh per colour, and an object per part.
fn scene_of(walk: &BoxScene) -> Scene {
    let corner = |number: u32| [0, 1, 2].map(|axis| (number >> axis & 1) as f32);
    let mesh = |colour: [f32; 3]| {
        let corners: Vec<_> = walk::INDICES.iter().map(|index| (corner(*index), colour)).collect();
        Mesh::of_triangles("box", &corners)
    };
    let objects = walk.parts.iter().map(|part| {
        let Aabb { min, max } = part.bounds;
        let transform = Affine3A::from_translation(min) * Affine3A::from_scale(max - min);
        Object { mesh: MeshId(part.bucket), transform, tint: u32::MAX }
    });
    let mut scene = Scene::single(mesh(COLOURS[0]));
    scene.meshes.push(mesh(COLOURS[1]));
    scene.objects = objects.collect();
    scene
}

/// Describes the host's device and its queue.
fn description(host: &AshDevice, lock: Arc<dyn HostQueueLock>) -> gpu::HostDevice {
    gpu::HostDevice {
        extensions: host.extensions(),
        features: host.needs.features(),
        queue: Some(HostQueue { raw: host.queue, lock }),
        ..gpu::HostDevice::new(
            host.instance.entry.clone(),
            host.instance.raw.clone(),
            host.physical,
            host.raw.clone(),
            host.queue_family,
        )
    }
}
