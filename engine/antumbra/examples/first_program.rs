//! Walks 60 frames into a glTF scene, and writes the last image.

use antumbra::{Camera, Renderer, open_scene};

fn main() -> antumbra::Result<()> {
    let file = std::env::args().nth(1).ok_or("usage: first_program FILE.glb")?;
    let scene = open_scene(file)?;
    let mut renderer = Renderer::headless(&scene).size(1280, 720).build()?;
    let mut view = renderer.new_view()?;
    for step in 0..60_u8 {
        let z = -f32::from(step) * 0.1;
        renderer.render(&mut view, Camera::look_at([0.0, 1.7, z], [0.0, 1.7, z - 100.0]))?;
    }
    let last = renderer.finish(&mut view)?; // Waits: statistics and image.
    println!("{} of {} objects drawn", last.drawn, last.in_frustum);
    Ok(last.image.save_png("first.png")?)
}
