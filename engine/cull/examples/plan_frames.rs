//! Plans frames of a wall with a thousand boxes behind it. Invented answers replace the GPU: only
//! the wall shows.

use std::error::Error;

use antumbra_cull::{
    Aabb, Answer, Camera, CullConfig, CullView, Culler, FramePlan, Hierarchy, Projection, Strategy,
};
use glam::{Vec3, vec3};

/// Returns a wall, and behind it ten layers of a hundred boxes.
fn boxes() -> Vec<Aabb> {
    let wall = Aabb::new(vec3(-9.0, -9.0, -6.0), vec3(9.0, 9.0, -5.0));
    let hidden = (0..1000).map(|number| {
        let [x, y, z] = [number % 10, number / 10 % 10, number / 100].map(|part| part as f32);
        let corner = vec3(x - 5.0, y - 5.0, -8.0 - z);
        Aabb::new(corner, corner + 0.5)
    });
    std::iter::once(wall).chain(hidden).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let hierarchy = Hierarchy::build(&boxes())?;
    let mut culler = Culler::new(CullConfig::default());
    let mut plan = FramePlan::default();
    let mut answers: Vec<Answer> = Vec::new();
    for frame in 0..100_u8 {
        // The results of the last frame. They may also come later, in any order, or never.
        culler.ingest(&hierarchy, answers.drain(..));

        let eye = vec3(f32::from(frame) * 0.001, 0.0, 0.0);
        let camera = Camera {
            eye,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(1.0),
            near: 0.1,
        };
        let view = CullView::new(&camera, [1280, 720], 8);
        culler.plan(&hierarchy, Strategy::ANTUMBRA, &view, 4096, &mut plan);

        let drawn = plan.draws.len() + plan.queried_draws.len();
        let tests = plan.tests.len();
        let behind: u32 = plan.tests.iter().map(|test| test.leaves.count).sum();
        if frame % 10 == 0 {
            println!("frame {frame}: {drawn} drawn, {tests} tests decide about {behind} more");
        }

        let tested = plan.tests.iter().map(|test| test.tag);
        let queried = plan.queried_draws.iter().map(|(_, tag)| *tag);
        answers.extend(tested.chain(queried).map(|tag| {
            let shows = hierarchy.bounds(tag.node).max.z > -7.0;
            Answer { tag, samples: u32::from(shows) }
        }));
    }
    Ok(())
}
