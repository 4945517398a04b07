//! A host that draws by wgpu: draws the walk with frustum culling and with occlusion culling,
//! compares all images bit for bit, and ends with 1 if any differs or the validation layer said
//! anything.

mod device;
mod integration;
mod renderer;

use std::collections::VecDeque;
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;

use cull::Strategy;
use device::WgpuDevice;
use integration::WgpuCulling;
use renderer::{FRAMES_IN_FLIGHT, WgpuRenderer};
use walk::{BoxScene, DrawnWalk, FRAMES, HostInstance, camera};

/// Draws the walk and returns its images.
fn draw(
    host: &HostInstance,
    device: &Arc<WgpuDevice>,
    strategy: Strategy,
) -> Result<DrawnWalk, Box<dyn Error>> {
    let scene = BoxScene::new();
    let renderer = Arc::new(WgpuRenderer::new(device, &scene));
    let mut culling = WgpuCulling::new(host, &renderer, &scene)?;
    let mut walked = DrawnWalk::default();
    let mut sent = VecDeque::new();
    // A frame of an engine has a number above 0.
    for number in 1..=FRAMES {
        let over = number.saturating_sub(FRAMES_IN_FLIGHT);
        if over > 0 {
            let oldest = sent.pop_front().ok_or("no frame is on its way")?;
            walked.images.push(renderer.wait(oldest)?);
        }
        let image = renderer.new_image();
        let frame = culling.encode(number, over, &camera(number), strategy, &image)?;
        sent.push_back(renderer.submit(frame, image));
    }
    for frame in sent {
        walked.images.push(renderer.wait(frame)?);
    }
    walked.draws = culling.finish()?;
    Ok(walked)
}

fn run() -> Result<bool, Box<dyn Error>> {
    let wanted = std::env::args().nth(1).unwrap_or_default();
    // wgpu turns on the swapchain of a device that has one, which needs surfaces.
    let host = HostInstance::new(&[ash::khr::surface::NAME])?;
    let device = Arc::new(WgpuDevice::new(&host, host.find(&wanted)?)?);
    let [plain, culled] =
        [Strategy::FRUSTUM, Strategy::ANTUMBRA].map(|strategy| draw(&host, &device, strategy));
    let is_same = walk::report("wgpu", &plain?, &culled?);
    drop(device);
    let messages = host.destroy();
    println!("wgpu: {messages} messages of the validation layer");
    Ok(is_same && messages == 0)
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("wgpu: {error}");
            ExitCode::FAILURE
        }
    }
}
