//! A host that draws by vk-graph: draws the walk with frustum culling and with occlusion culling,
//! compares all images bit for bit, and ends with 1 if any differs or the validation layer said
//! anything.

mod device;
mod integration;
mod renderer;

use std::collections::VecDeque;
use std::error::Error;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};

use cull::Strategy;
use device::GraphDevice;
use integration::GraphCulling;
use renderer::{FRAMES_IN_FLIGHT, GraphRenderer};
use vk_graph::pool::hash::HashPool;
use walk::{BoxScene, DrawnWalk, FRAMES, HostInstance, camera};

/// Draws the walk and returns its images.
fn draw(
    host: &HostInstance,
    device: &Arc<GraphDevice>,
    strategy: Strategy,
) -> Result<DrawnWalk, Box<dyn Error>> {
    let scene = BoxScene::new();
    let renderer = Arc::new(GraphRenderer::new(device, &scene)?);
    let culling = Arc::new(Mutex::new(GraphCulling::new(host, &renderer, &scene)?));
    let mut pool = HashPool::new(&device.raw);
    let mut walked = DrawnWalk::default();
    let mut sent = VecDeque::new();
    // A frame of an engine has a number above 0.
    for number in 1..=FRAMES {
        let over = number.saturating_sub(FRAMES_IN_FLIGHT);
        if over > 0 {
            let oldest: renderer::SentFrame = sent.pop_front().ok_or("no frame is on its way")?;
            walked.images.push(oldest.wait()?);
        }
        let camera = camera(number);
        sent.push_back(renderer.draw(&mut pool, &culling, number, over, camera, strategy)?);
    }
    for frame in sent {
        walked.images.push(frame.wait()?);
    }
    let culling = Arc::into_inner(culling).ok_or("a graph still holds the culling")?;
    walked.draws = culling.into_inner()?.finish()?;
    Arc::into_inner(renderer).ok_or("the renderer is still in use")?.destroy();
    Ok(walked)
}

fn run() -> Result<bool, Box<dyn Error>> {
    let wanted = std::env::args().nth(1).unwrap_or_default();
    let host = HostInstance::new(&[])?;
    let device = Arc::new(GraphDevice::new(&host, host.find(&wanted)?)?);
    let [plain, culled] =
        [Strategy::FRUSTUM, Strategy::ANTUMBRA].map(|strategy| draw(&host, &device, strategy));
    let is_same = walk::report("vk-graph", &plain?, &culled?);
    drop(device);
    let messages = host.destroy();
    println!("vk-graph: {messages} messages of the validation layer");
    Ok(is_same && messages == 0)
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("vk-graph: {error}");
            ExitCode::FAILURE
        }
    }
}
