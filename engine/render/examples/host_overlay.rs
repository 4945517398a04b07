//! Draws a triangle and, over the finished image, a bar by commands of the host, like a user
//! interface: `host_overlay [FILE.png]`. The image of the scene alone does not show the bar.

use std::error::Error;

use antumbra_render::{FrameRequest, HostOverlay, Renderer, RendererOptions};
use cull::{Camera, Projection, Strategy};
use glam::Vec3;
use gpu::{Commands, OverlayImage, Readback, SampleCount};
use scene::{Mesh, Scene};

const SIZE: [u32; 2] = [320, 180];

/// A bar along the upper edge of images.
struct Bar {
    height: u32,
    /// Linear red, green and blue, and alpha.
    colour: [f32; 4],
}

impl HostOverlay for Bar {
    fn record(
        &self,
        commands: &Commands,
        image: &OverlayImage,
    ) -> Result<(), antumbra_render::Error> {
        // A host that calls Vulkan itself records into `commands.raw()` in the same place.
        let bar = image.render_target().within([0, 0], [image.size[0], self.height]);
        commands.rendering(bar.cleared_to(self.colour), |_| ());
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let red = corners.map(|corner| (corner, [0.8, 0.1, 0.1]));
    let scene = Scene::single(Mesh::of_triangles("triangle", &red));
    let device = gpu::open()?;
    let options = RendererOptions { size: SIZE, samples: SampleCount::Four, ..Default::default() };
    let mut renderer = Renderer::new(&device, &scene, &options)?;
    let mut view = renderer.new_view()?;
    let camera = Camera {
        eye: Vec3::Z * 3.0,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(0.9),
        near: 0.1,
    };
    let bar = Bar { height: 20, colour: [0.0, 1.0, 0.0, 1.0] };
    let whole = Readback::new(&device, SIZE)?;
    let alone = Readback::new(&device, SIZE)?;
    let request = FrameRequest {
        image: Some(&whole),
        scene_image: Some(&alone),
        overlay: Some(&bar),
        ..FrameRequest::new(Strategy::ANTUMBRA, camera)
    };
    renderer.render(&mut view, request)?;
    renderer.wait_idle(&mut view)?;
    let pixels = whole.rgba8()?;
    let green = |image: &[u8]| image.chunks(4).filter(|pixel| *pixel == [0, 255, 0, 255]).count();
    println!("over the image: {} green pixels", green(&pixels));
    println!("in the scene's image: {} green pixels", green(&alone.rgba8()?));
    let file = std::env::args().nth(1).unwrap_or_else(|| "overlay.png".to_owned());
    let mut png = png::Encoder::new(std::fs::File::create(&file)?, SIZE[0], SIZE[1]);
    png.set_color(png::ColorType::Rgba);
    png.write_header()?.write_image_data(&pixels)?;
    println!("{file}");
    Ok(())
}
