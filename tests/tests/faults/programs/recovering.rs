//! Programs that continue on another device when theirs is lost.

use std::error::Error;
use std::sync::Arc;

use cull::{ObjectId, Strategy};
use gpu::{
    Device, Instance, PresentSkipped, Readback, Surface, Swapchain, SwapchainOptions, WindowSystem,
};
use render::{FrameRequest, RenderView, Renderer, RendererOptions, SpareCapacity};
use scene::{Object, ObjectChange, PreparedMesh};
use tests::every_call::{self, Fault, FaultPlan, Lasts};
use tests::x11_window::{Library, X11Window};

use super::window::{Unshown, await_shown, show_surely};
use super::{Display, Outcome, Program, SIZE, Stage, aside, device_options};

/// The number of devices that a program opens after a loss before it gives up.
const ATTEMPTS: usize = 3;

/// A renderer of a changed scene, and what it has on its present device.
struct Film {
    renderer: Renderer,
    view: RenderView,
    image: Readback,
}

impl Program {
    /// Draws all cameras of a scene with changes, on as many devices as it takes, and returns the
    /// last image.
    pub(super) fn recover(&self, stage: &Stage) -> Outcome {
        let instance = stage.instance(None)?;
        let name = stage.driver.device_name();
        let open =
            || Device::new(&instance, &instance.pick_adapter(Some(name))?, &device_options());
        let mut film = self.film(&open()?)?;
        stage.note_begun();
        let mut pixels = Vec::new();
        for camera in &self.cameras {
            pixels = loop {
                match film.draw(camera) {
                    Ok(pixels) => break pixels,
                    Err(error) => film.go_on(error, || Ok(open()?))?,
                }
            };
        }
        Ok(pixels)
    }

    /// Shows all cameras in a window, on as many devices as it takes, and returns the last image.
    pub(super) fn recover_in_window(&self, stage: &Stage) -> Outcome {
        let Some(Display::X11(server)) = &self.display else { return Err("no server".into()) };
        let window: Arc<X11Window> = X11Window::open(server, Library::Xcb, SIZE);
        let instance = stage.instance(Some(WindowSystem::of(&window)?))?;
        let surface = Surface::new(&instance, Arc::clone(&window) as _)?;
        let device = presenting(&instance, &surface, stage)?;
        let mut swapchain = Swapchain::new(&device, &surface, &SwapchainOptions::default())?;
        let mut film = self.film(&device)?;
        drop(device);
        stage.note_begun();
        let mut pixels = Vec::new();
        for camera in &self.cameras {
            pixels = loop {
                let drawn = film.draw(camera);
                let shown = drawn.and_then(|pixels| {
                    show_surely(&film.renderer, &mut swapchain, SIZE).map(|()| pixels)
                });
                match shown {
                    Ok(pixels) => break pixels,
                    Err(error) => film.go_on(error, || presenting(&instance, &surface, stage))?,
                }
                let device = film.renderer.device();
                swapchain = Swapchain::new(device, &surface, &SwapchainOptions::default())?;
            };
        }
        await_shown(&window, &pixels)?;
        Ok(pixels)
    }

    /// Loses `count` devices one after the other, each in the middle of a frame, goes on after
    /// each, and compares the image. `note` is called after each loss.
    ///
    /// # Errors
    /// The first loss after which the image is not the right one.
    pub fn lose(&self, stage: &Stage, count: usize, mut note: impl FnMut(usize)) -> Outcome {
        let instance = stage.instance(None)?;
        let name = stage.driver.device_name();
        let open =
            || Device::new(&instance, &instance.pick_adapter(Some(name))?, &device_options());
        let mut film = self.film(&open()?)?;
        let camera = self.cameras.last().ok_or("a camera")?;
        film.draw(camera)?;
        let expected = film.draw(camera)?;
        let calls = ["vkQueueSubmit2", "vkWaitSemaphores", "vkGetSemaphoreCounterValue"];
        let calls = calls.map(|call| every_call::number_of(call).expect("a call of every frame"));
        for number in 0..count {
            let fault = Fault {
                call: calls[number % calls.len()],
                nth: 0,
                code: gpu::vk::Result::ERROR_DEVICE_LOST,
                lasts: Lasts::Forever,
            };
            every_call::install(FaultPlan { first: Some(fault), second: None });
            let lost = film.draw(camera).err().ok_or("a frame on a lost device")?;
            film.go_on(lost, || Ok(open()?))?;
            every_call::stop();
            if film.draw(camera)? != expected {
                return Err(format!("another image after loss {number}").into());
            }
            note(number);
        }
        Ok(expected)
    }

    fn film(&self, device: &Device) -> Result<Film, Box<dyn Error>> {
        let spare =
            SpareCapacity { meshes: 2, vertices: 4096, indices: 8192, ..Default::default() };
        let options = RendererOptions { spare, spare_objects: 2, ..self.options() };
        let mut renderer = Renderer::new(device, &self.scene, &options)?;
        renderer.keep_scene(Arc::new(self.scene.clone()))?;
        let first = self.scene.objects[0];
        let transform = aside(first.transform);
        let added = renderer.add_meshes(vec![PreparedMesh::new(self.scene.meshes[0].clone())?])?;
        renderer.update(&[
            ObjectChange::Move { object: ObjectId(0), transform },
            ObjectChange::Add { object: Object { mesh: added[0], ..first } },
        ])?;
        let view = renderer.new_view()?;
        Ok(Film { view, image: Readback::new(device, SIZE)?, renderer })
    }
}

/// Opens a device that can present.
fn presenting(
    instance: &Instance,
    surface: &Surface,
    stage: &Stage,
) -> Result<Device, Box<dyn Error>> {
    let adapter = instance.pick_adapter_for(surface, Some(stage.driver.device_name()))?;
    Ok(Device::new(instance, &adapter, &device_options())?)
}

impl Film {
    /// Draws a frame and returns its image.
    fn draw(&mut self, camera: &cull::Camera) -> Outcome {
        let request = FrameRequest {
            image: Some(&self.image),
            ..FrameRequest::new(Strategy::ANTUMBRA, *camera)
        };
        self.renderer.render(&mut self.view, request)?;
        self.renderer.wait_idle(&mut self.view)?;
        Ok(self.image.rgba8()?.to_vec())
    }

    /// Continues on another device if `error` is a loss; else returns it.
    fn go_on(
        &mut self,
        error: Box<dyn Error>,
        open: impl Fn() -> Result<Device, Box<dyn Error>>,
    ) -> Result<(), Box<dyn Error>> {
        if !is_lost(error.as_ref()) {
            return Err(error);
        }
        let mut last = error;
        for _ in 0..ATTEMPTS {
            let recovered = open().and_then(|device| {
                let image = Readback::new(&device, SIZE)?;
                self.renderer.recover(&device)?;
                self.image = image;
                Ok(())
            });
            match recovered {
                Ok(()) => return Ok(()),
                Err(error) => last = error,
            }
        }
        Err(last)
    }
}

fn is_lost(error: &(dyn Error + 'static)) -> bool {
    let of_gpu = error.downcast_ref::<gpu::Error>();
    let of_render = error.downcast_ref::<render::Error>();
    let of_render = of_render.and_then(|error| match error {
        render::Error::Gpu(error) => Some(error),
        _ => None,
    });
    let of_window = error.downcast_ref::<Unshown>();
    of_gpu.or(of_render).is_some_and(gpu::Error::is_device_lost)
        || of_window.is_some_and(|Unshown(reason)| *reason == PresentSkipped::DeviceLost)
}
