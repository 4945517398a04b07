//! All that this host writes to leave out what cannot be seen: it describes its objects, and draws
//! the lists of `antumbra-wgpu` in two render passes, with the tests between them.

use std::error::Error;
use std::sync::Arc;

use antumbra_wgpu::cull::{Camera, CullView, DepthConvention, Strategy};
use antumbra_wgpu::glam::{Mat4, vec3};
use antumbra_wgpu::gpu::IndirectDraw;
use antumbra_wgpu::occlusion::{
    BucketDraw, BucketId, CulledSceneOptions, DrawRequest, HostObject, OcclusionState,
};
use antumbra_wgpu::{WgpuCulling, WgpuTarget};
use walk::{BoxScene, ViewConstants};

use crate::renderer::{FRAMES_IN_FLIGHT, SentImage, WgpuRenderer};

/// The state of the engine for this host.
pub struct CulledWalk {
    culling: WgpuCulling,
    view: OcclusionState,
    target: WgpuTarget,
    renderer: Arc<WgpuRenderer>,
}

impl CulledWalk {
    /// Takes over the boxes and draws of all objects.
    pub fn new(renderer: &Arc<WgpuRenderer>, walk: &BoxScene) -> Result<Self, Box<dyn Error>> {
        let target = WgpuTarget::new(&renderer.gpu, &renderer.depth, DepthConvention::Reversed)?;
        let options = CulledSceneOptions {
            object_capacity: walk.objects.len(),
            draw_capacity: walk.parts.len() as u32,
            bucket_count: walk::BUCKETS,
            frames_in_flight: FRAMES_IN_FLIGHT,
            ..Default::default()
        };
        let mut culling = WgpuCulling::new(&renderer.gpu, &target, &options)?;
        let draw = |number: u32| BucketDraw {
            bucket: BucketId(walk.parts[number as usize].bucket),
            draw: IndirectDraw {
                index_count: walk::INDICES.len() as u32,
                instance_count: 1,
                first_instance: number,
                ..Default::default()
            },
            triangles: 12,
        };
        for object in &walk.objects {
            let draws: Vec<_> = object.parts.clone().map(draw).collect();
            let object = HostObject { bounds: object.bounds, draws: &draws };
            culling.scene.add(&[object], &mut Vec::new())?;
        }
        let view = culling.new_view(&target)?;
        Ok(Self { culling, view, target, renderer: renderer.clone() })
    }

    /// Draws and submits a frame.
    pub fn draw(
        &mut self,
        camera: &Camera,
        strategy: Strategy,
    ) -> Result<SentImage, Box<dyn Error>> {
        // A camera of the engine has y down, and wgpu's clip space up.
        let upwards = Mat4::from_scale(vec3(1.0, -1.0, 1.0));
        let matrix = upwards * CullView::new(camera, walk::SIZE, 0).view_proj;
        let view = self.target.view(matrix)?;
        let view_proj = matrix.to_cols_array();
        let constants = ViewConstants { view_proj, snap_steps: view.snap_steps };
        let request = DrawRequest { strategy, ..DrawRequest::from(&view) };
        let frame = self.culling.encode(&mut self.view, &mut self.target, request)?;
        let image = self.renderer.new_image();
        let first = self.renderer.encode(frame.visible(), &constants, None);
        let second = self.renderer.encode(frame.revealed(), &constants, Some(&image));
        let submission = frame.submit(&self.renderer.gpu.queue, [first], [second]);
        Ok(SentImage { submission, image })
    }

    /// Waits for all frames, and returns the draws of the last one.
    pub fn finish(mut self) -> Result<u64, Box<dyn Error>> {
        self.renderer.gpu.finish()?;
        self.culling.collect(&mut self.view)?;
        Ok(self.view.drain_stats().next_back().map_or(0, |outcome| outcome.draws))
    }
}
