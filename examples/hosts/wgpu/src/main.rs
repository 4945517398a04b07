//! A host that draws by wgpu: draws the walk with frustum culling and with occlusion culling,
//! compares all images bit for bit, and ends with 1 if any differs or the validation layer said
//! anything.

mod adapter;
mod integration;
mod renderer;

use std::collections::VecDeque;
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;

use adapter::adapter;
use antumbra_wgpu::WgpuDevice;
use antumbra_wgpu::cull::Strategy;
use integration::CulledWalk;
use renderer::{FRAMES_IN_FLIGHT, WgpuRenderer};
use walk::{BoxScene, DrawnWalk, FRAMES, HostInstance, camera};

/// Draws the walk and returns its images.
fn draw(device: &Arc<WgpuDevice>, strategy: Strategy) -> Result<DrawnWalk, Box<dyn Error>> {
    let scene = BoxScene::new();
    let renderer = Arc::new(WgpuRenderer::new(device, &scene));
    let mut culled = CulledWalk::new(&renderer, &scene)?;
    let mut walked = DrawnWalk::default();
    let mut sent = VecDeque::new();
    for number in 1..=FRAMES {
        if sent.len() == FRAMES_IN_FLIGHT {
            let oldest = sent.pop_front().ok_or("no frame is on its way")?;
            walked.images.push(renderer.wait(oldest)?);
        }
        sent.push_back(culled.draw(&camera(number), strategy)?);
    }
    for frame in sent {
        walked.images.push(renderer.wait(frame)?);
    }
    walked.draws = culled.finish()?;
    Ok(walked)
}

fn run() -> Result<bool, Box<dyn Error>> {
    let wanted = std::env::args().nth(1).unwrap_or_default();
    // wgpu turns on the swapchain of a device that has one, which needs surfaces.
    let host = HostInstance::new(&[ash::khr::surface::NAME])?;
    let descriptor = wgpu::DeviceDescriptor {
        required_features: wgpu::Features::IMMEDIATES,
        required_limits: wgpu::Limits { max_immediate_size: 128, ..Default::default() },
        ..Default::default()
    };
    let adapter = adapter(&host, host.find(&wanted)?)?;
    let device = Arc::new(WgpuDevice::open(&adapter, &descriptor)?);
    let [plain, culled] =
        [Strategy::FRUSTUM, Strategy::ANTUMBRA].map(|strategy| draw(&device, strategy));
    let is_same = walk::report("wgpu", &plain?, &culled?);
    drop((device, adapter));
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
