//! A host in plain Vulkan: draws the walk with frustum culling and with occlusion culling, compares
//! all images bit for bit, and ends with 1 if any differs or the validation layer said anything.

mod integration;
mod renderer;

use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;

use cull::Strategy;
use gpu::Purpose;
use integration::AshCulling;
use renderer::{FRAMES_IN_FLIGHT, HostRenderer};
use walk::{AshDevice, BoxScene, DrawnWalk, FRAMES, camera};

/// Draws the walk and returns its images.
fn draw(host: &Arc<AshDevice>, strategy: Strategy) -> Result<DrawnWalk, Box<dyn Error>> {
    let scene = BoxScene::new();
    let renderer = Arc::new(HostRenderer::new(host, &scene)?);
    let mut culling = AshCulling::new(&renderer, &scene)?;
    let mut walked = DrawnWalk::default();
    // A frame of an engine has a number above 0.
    for number in 1..=FRAMES {
        let image = renderer.wait(number)?;
        let over = number.saturating_sub(FRAMES_IN_FLIGHT);
        walked.images.extend((over > 0).then_some(image));
        let commands = renderer.begin(number)?;
        culling.record(commands, number, over, &camera(number), strategy)?;
        renderer.submit(number)?;
    }
    for number in FRAMES + 1..=FRAMES + FRAMES_IN_FLIGHT {
        walked.images.push(renderer.wait(number)?);
    }
    walked.draws = culling.finish()?;
    if let Ok(renderer) = Arc::try_unwrap(renderer) {
        renderer.destroy();
    }
    Ok(walked)
}

fn run() -> Result<bool, Box<dyn Error>> {
    let wanted = std::env::args().nth(1).unwrap_or_default();
    let host = Arc::new(AshDevice::new(&wanted, Purpose::Executor)?);
    let [plain, culled] =
        [Strategy::FRUSTUM, Strategy::ANTUMBRA].map(|strategy| draw(&host, strategy));
    let is_same = walk::report("ash", &plain?, &culled?);
    let host = Arc::into_inner(host).ok_or("the device is still in use")?;
    let messages = host.destroy();
    println!("ash: {messages} messages of the validation layer");
    Ok(is_same && messages == 0)
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("ash: {error}");
            ExitCode::FAILURE
        }
    }
}
