//! The smallest complete program on the engine: a triangle in a window, or one frame with
//! --headless.
#![forbid(unsafe_code)]

use std::{error::Error, io::Write, process::ExitCode, sync::Arc};

use antumbra::glam::Vec3;
use antumbra::scene::{Mesh, Scene};
use antumbra::{
    Camera, Device, FrameRequest, Projection, Readback, RenderView, Renderer, Strategy, Swapchain,
};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};
use winit::{application::ApplicationHandler, event::WindowEvent};

const USAGE: &str = "usage: triangle [--headless]";

struct Triangle(Renderer, RenderView);

impl Triangle {
    fn new(device: &Device) -> Result<Self, Box<dyn Error>> {
        let red = ([-1.0, -0.8, 0.0], [1.0, 0.1, 0.1]);
        let green = ([1.0, -0.8, 0.0], [0.1, 1.0, 0.1]);
        let blue = ([0.0, 0.9, 0.0], [0.1, 0.1, 1.0]);
        let mesh = Mesh::of_triangles("triangle", &[red, green, blue]);
        let renderer = Renderer::new(device, &Scene::single(mesh), &Default::default())?;
        let view = renderer.new_view()?;
        Ok(Self(renderer, view))
    }

    fn frame(&mut self, image: Option<&Readback>) -> Result<(), Box<dyn Error>> {
        let eye = Vec3::Z * 3.0;
        let forward = Vec3::NEG_Z;
        let up = Vec3::Y;
        let camera =
            Camera { eye, forward, up, projection: Projection::perspective(0.9), near: 0.1 };
        let request = FrameRequest::new(Strategy::ANTUMBRA, camera);
        self.0.render(&mut self.1, FrameRequest { image, ..request })?;
        Ok(())
    }
}

#[derive(Default)]
struct App(Option<(Triangle, Swapchain, Arc<Window>)>, Option<Box<dyn Error>>);

impl App {
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), Box<dyn Error>> {
        let window = Arc::new(event_loop.create_window(Window::default_attributes())?);
        let (device, swapchain) = antumbra::open_with_window(window.clone())?;
        self.0 = Some((Triangle::new(&device)?, swapchain, window));
        Ok(())
    }

    fn show(&mut self) -> Result<(), Box<dyn Error>> {
        let Some((triangle, swapchain, window)) = &mut self.0 else { return Ok(()) };
        window.request_redraw();
        // A hidden window may hold earlier frames back; then no frame begins.
        if swapchain.is_ready()? {
            let size: [u32; 2] = window.inner_size().into();
            // Images have the size of the window, which may be 0.
            if !size.contains(&0) {
                triangle.0.resize(size)?;
            }
            triangle.frame(None)?;
            triangle.0.present(swapchain, size)?;
        }
        Ok(())
    }

    fn end_if_failed(&mut self, event_loop: &ActiveEventLoop, done: Result<(), Box<dyn Error>>) {
        if let Err(error) = done {
            self.1.get_or_insert(error);
            event_loop.exit();
        }
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let opened = self.open(event_loop);
        self.end_if_failed(event_loop, opened);
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::RedrawRequested => {
                let shown = self.show();
                self.end_if_failed(event_loop, shown);
            }
            WindowEvent::CloseRequested | WindowEvent::Destroyed => event_loop.exit(),
            _ => {}
        }
    }
}

fn in_a_window() -> Result<(), Box<dyn Error>> {
    let mut app = App::default();
    let event_loop = EventLoop::new().map_err(|_| "there is no display; try --headless")?;
    event_loop.run_app(&mut app)?;
    app.1.map_or(Ok(()), Err)
}

fn headless() -> Result<(), Box<dyn Error>> {
    let mut triangle = Triangle::new(&antumbra::open()?)?;
    let image = Readback::new(triangle.0.device(), triangle.0.size())?;
    triangle.frame(Some(&image))?;
    triangle.0.wait_idle(&mut triangle.1)?;
    let pixels = image.rgba8()?;
    let middle = pixels.len() / 2 + 4 * 640;
    let colour = &pixels[middle..middle + 3];
    Ok(writeln!(std::io::stdout(), "the middle is {colour:?}")?)
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let ended = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => in_a_window(),
        ["--headless"] => headless(),
        ["--help"] => writeln!(std::io::stdout(), "{USAGE}").map_err(Into::into),
        _ => Err(USAGE.into()),
    };
    let Err(error) = ended else { return ExitCode::SUCCESS };
    eprintln!("triangle: {error}");
    ExitCode::FAILURE
}
