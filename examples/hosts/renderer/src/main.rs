//! A host that has a device and a queue but no renderer: the engine draws the walk on them with
//! frustum culling and with occlusion culling, and the host copies the images by commands of its
//! own. Compares all bit for bit, and ends with 1 if any differs or the validation layer said
//! anything.

mod copies;
mod integration;

use std::error::Error;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};

use copies::ImageCopies;
use cull::Strategy;
use gpu::Purpose;
use integration::DrawnScene;
use walk::{AshDevice, BoxScene, DrawnWalk, FRAMES, camera};

/// Draws the walk and returns its images.
fn draw(host: &Arc<AshDevice>, strategy: Strategy) -> Result<DrawnWalk, Box<dyn Error>> {
    let lock = Arc::new(Mutex::new(()));
    let copies = ImageCopies::new(host, &lock)?;
    let mut scene = DrawnScene::new(host, lock, &BoxScene::new())?;
    let mut walked = DrawnWalk::default();
    for number in 1..=FRAMES {
        let finished = scene.draw(camera(number), strategy)?;
        walked.images.push(copies.copy(&finished)?);
    }
    walked.draws = scene.finish()?;
    copies.destroy();
    Ok(walked)
}

fn run() -> Result<bool, Box<dyn Error>> {
    let wanted = std::env::args().nth(1).unwrap_or_default();
    let host = Arc::new(AshDevice::new(&wanted, Purpose::Renderer)?);
    let [plain, culled] =
        [Strategy::FRUSTUM, Strategy::ANTUMBRA].map(|strategy| draw(&host, strategy));
    let is_same = walk::report("renderer", &plain?, &culled?);
    let host = Arc::into_inner(host).ok_or("the device is still in use")?;
    let messages = host.destroy();
    println!("renderer: {messages} messages of the validation layer");
    Ok(is_same && messages == 0)
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("renderer: {error}");
            ExitCode::FAILURE
        }
    }
}
