//! A window, and the device that draws in it.

use std::sync::Arc;
use std::time::Duration;

use antumbra::gpu;
use antumbra::gpu::{Device, DisplayLink, Instance, Surface, WindowSystem};
use winit::dpi::PhysicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::display::no_display;
use bench::choices::{DeviceChoice, ValidationChoice};
use bench::options::FrameSize;
use bench::run;
use bench::run_error::RunError;

/// The options of a new window.
#[derive(Clone, Debug)]
pub struct WindowOptions<'a> {
    /// The title.
    pub title: &'a str,
    /// The size in pixels.
    pub size: FrameSize,
    /// The checks of the validation layer.
    pub validation: ValidationChoice,
    /// The device that draws.
    pub device: &'a DeviceChoice,
}

/// A window, and the device that draws in it. Later fields are dropped first.
pub struct WindowDevice {
    /// The window.
    pub window: Arc<Window>,
    /// The connection to the window's display.
    pub display: DisplayLink,
    /// The instance.
    pub instance: Instance,
    /// The Vulkan surface of the window.
    pub surface: Surface,
    /// The device.
    pub device: Device,
    /// The refresh period of the window's monitor, if it is known.
    pub refresh: Option<Duration>,
}

impl WindowDevice {
    /// Opens a window and a device for it.
    ///
    /// # Errors
    /// No display, or no suitable device.
    pub fn open(
        event_loop: &ActiveEventLoop,
        options: &WindowOptions<'_>,
    ) -> Result<Self, RunError> {
        let size = PhysicalSize::new(options.size.width, options.size.height);
        let attributes =
            Window::default_attributes().with_title(options.title).with_inner_size(size);
        let window = Arc::new(event_loop.create_window(attributes).map_err(no_display)?);
        let display = DisplayLink::watch(&window);
        let system = WindowSystem::of(&window)?;
        let instance = run::open_instance(options.validation, Some(system))?;
        let surface = Surface::new(&instance, Arc::clone(&window) as Arc<dyn gpu::Window>)?;
        let wanted = run::wanted(options.device);
        let adapter = instance.pick_adapter_for(&surface, wanted.as_deref())?;
        let device = run::open_device(&instance, &adapter)?;
        let monitor = window.current_monitor();
        let rate = monitor.and_then(|monitor| monitor.refresh_rate_millihertz());
        let refresh = rate
            .filter(|rate| *rate > 0)
            .map(|rate| Duration::from_secs_f64(1e3 / f64::from(rate)));
        Ok(Self { window, display, instance, surface, device, refresh })
    }
}
