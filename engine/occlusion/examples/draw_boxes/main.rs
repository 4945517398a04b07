//! Walks past a wall with a thousand boxes behind it, drawn by a pipeline of the example's own, and
//! prints how many boxes the GPU drew.

mod boxes;

use std::error::Error;

use antumbra_occlusion::{
    LeafTable, LeafTableInfo, MeshDraw, MeshDrawId, ObjectRenderer, OcclusionPasses,
    OcclusionState, PlanExecutor, ShaderSet, execute,
};
use boxes::{Boxes, INDICES};
use cull::{
    Aabb, Camera, CullConfig, CullView, Culler, DrawPhases, Hierarchy, Projection, Strategy,
};
use glam::{Vec3, vec3};
use gpu::{FrameRing, IndirectDraw};

/// Returns a wall and a thousand boxes, some of which show beside it.
fn bounds() -> Vec<Aabb> {
    let wall = Aabb::new(vec3(-4.0, -3.0, -6.0), vec3(4.0, 3.0, -5.5));
    let small = (0..1000).map(|number| {
        let [x, y, z] = [number % 20, number / 20 % 10, number / 200].map(|part| part as f32);
        let low = vec3(x * 0.7 - 7.0, y * 0.7 - 3.5, -12.0 - z * 1.3);
        Aabb::new(low, low + 0.45)
    });
    std::iter::once(wall).chain(small).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let device = gpu::open()?;
    let shaders = ShaderSet::embedded()?;
    let hierarchy = Hierarchy::build(&bounds())?;
    let draw = IndirectDraw { index_count: INDICES, instance_count: 1, ..Default::default() };
    let mesh_draws = [MeshDraw { draw, triangles: INDICES / 3 }].into();
    let info = LeafTableInfo { mesh_draws, predication: None, frames_in_flight: 2 };
    let leaves = LeafTable::new(&device, &hierarchy, info, |_object| MeshDrawId(0))?;
    let mut objects = Boxes::new(&device, &shaders, &leaves)?;
    let size = objects.target().size();
    let passes = OcclusionPasses::new(&device, &shaders, objects.target().attachments())?;
    let mut executor = PlanExecutor { passes, leaves };
    let testers = executor.testers(&device, objects.target(), DrawPhases::PerRound);
    let culler = Culler::with_testers(CullConfig::default(), testers);
    let mut state = OcclusionState::new(&device, &hierarchy, &executor.leaves, 2, culler)?;
    let mut frames = FrameRing::new(&device, 2)?;
    for step in 0..40_u8 {
        let eye = vec3(f32::from(step) * 0.1, 0.0, 3.0);
        let camera = Camera {
            eye,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(0.9),
            near: 0.1,
        };
        let view = CullView::new(&camera, size, device.adapter().limits.sub_pixel_precision_bits);
        let mut frame = frames.begin()?;
        state.collect(device.completed()?, &hierarchy, &executor.leaves);
        state.plan_frame(&hierarchy, &executor.leaves, Strategy::ANTUMBRA, &view, 4096);
        execute(&mut frame, &mut executor, &mut state, &mut objects, &shaders, &view)?;
        let tick = frame.submit(None)?;
        state.submitted(tick, &executor.leaves, None);
        // The outcomes of earlier frames, which are known by now.
        for outcome in state.drain_stats().filter(|outcome| outcome.frame.0 % 8 == 0) {
            println!("frame {}: {} of 1001 boxes drawn", outcome.frame.0, outcome.draws);
        }
    }
    Ok(())
}
