//! The programs under test: small, whole, and the same each time.

mod adopted;
mod adopted_in_c;
mod content;
mod executor;
mod executor_in_c;
mod frames;
mod recovering;
mod running;
mod window;

pub use window::Unshown;

use std::cell::{Cell, RefCell};
use std::error::Error;
use std::time::Duration;

use cull::Camera;
use glam::Affine3A;
use gpu::{
    Device, DeviceOptions, Instance, InstanceOptions, Validation, ValidationLog, WindowSystem,
};
use scene::Scene;
use tests::weston::Weston;
use tests::xvfb::Xvfb;
use tests::{Driver, every_call, shadow_scene};

/// A program under test.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgramKind {
    /// Frames without a window; draws are skipped by conditional rendering.
    Conditional,
    /// As above; draws are skipped by counts.
    Counts,
    /// As above; draws are skipped by instance counts.
    Instances,
    /// As above; draws are copied into lists.
    Compacted,
    /// The methods that wait for results, and a depth pyramid.
    Methods,
    /// Surfaces under lights with shadow maps; a light comes, and an object moves.
    Shadows,
    /// As above, with shadow volumes.
    Volumes,
    /// A mesh that is uploaded during frames, objects that move, a new size.
    Streaming,
    /// Other shaders in the middle, and a pipeline cache in a file.
    Reload,
    /// A changed scene, which continues on another device when the device is lost.
    Recovering,
    /// As above, in a window.
    RecoveringInWindow,
    /// A file with textures that is loaded while another scene is drawn.
    Loading,
    /// A skinned mesh with a morph target that plays.
    Animated,
    /// Objects, meshes, materials, textures and lights that come and go.
    ComeAndGo,
    /// An end while another thread fills textures.
    Closing,
    /// A window that changes its size.
    Window,
    /// A window on Wayland.
    WindowWayland,
    /// The device of a host, with its queue.
    Adopted,
    /// As above, through the C interface.
    AdoptedInC,
    /// The device of a host, which records and submits itself.
    Executor,
    /// As above, through the C interface.
    ExecutorInC,
}

/// The parts of a run that outlive its program.
pub struct Stage {
    /// The driver of the run.
    pub driver: Driver,
    validation: Validation,
    log: RefCell<Option<ValidationLog>>,
    /// True once a program can recover from the loss of its device.
    has_begun: Cell<bool>,
}

/// The image that a program ends with, or the reason why it has none.
pub type Outcome = Result<Vec<u8>, Box<dyn Error>>;

/// The size of the images.
pub const SIZE: [u32; 2] = [64, 48];

/// The bound of every wait. No fault alone makes a run wait so long.
const WAIT_BOUND: Duration = Duration::from_secs(20);

impl Stage {
    /// Creates the stage of one run.
    pub fn new(driver: Driver, validation: Validation) -> Self {
        Self { driver, validation, log: RefCell::default(), has_begun: Cell::default() }
    }

    fn note_begun(&self) {
        self.has_begun.set(true);
    }

    /// Returns true if the program must recover from a loss of its device.
    pub fn has_begun(&self) -> bool {
        self.has_begun.get()
    }

    /// Returns what the validation layer has said, if the program came so far.
    pub fn messages(&self) -> Vec<gpu::Message> {
        self.log.borrow().as_ref().map(ValidationLog::drain).unwrap_or_default()
    }

    fn instance(&self, windows: Option<WindowSystem>) -> Result<Instance, gpu::Error> {
        let application = "faults".to_owned();
        let options = InstanceOptions { application, validation: self.validation, windows };
        let instance = Instance::new(every_call::entry(), &options)?;
        self.log.replace(Some(instance.validation_log().clone()));
        Ok(instance)
    }

    fn device(&self, options: &DeviceOptions) -> Result<Device, gpu::Error> {
        let instance = self.instance(None)?;
        let adapter = instance.pick_adapter(Some(self.driver.device_name()))?;
        Device::new(&instance, &adapter, options)
    }
}

fn device_options() -> DeviceOptions {
    DeviceOptions { wait_bound: WAIT_BOUND, ..Default::default() }
}

/// A program with its scene.
pub struct Program {
    kind: ProgramKind,
    scene: Scene,
    cameras: Vec<Camera>,
    display: Option<Display>,
}

/// A server of windows.
enum Display {
    X11(Box<Xvfb>),
    Wayland(Weston),
}

impl ProgramKind {
    /// Returns true if the driver can run the program.
    pub fn runs_on(self, driver: Driver) -> bool {
        let needs_skips = matches!(self, Self::Conditional | Self::Counts | Self::Compacted);
        let needs_lavapipe = needs_skips || self == Self::WindowWayland;
        !needs_lavapipe || driver == Driver::Lavapipe
    }

    /// Returns true if the program shows its frames in a window.
    pub fn is_windowed(self) -> bool {
        matches!(self, Self::Window | Self::WindowWayland)
    }
}

impl Program {
    /// Creates the scene of a program.
    pub fn new(kind: ProgramKind) -> Self {
        let display = match kind {
            ProgramKind::Window | ProgramKind::RecoveringInWindow => {
                Some(Display::X11(Box::new(Xvfb::start())))
            }
            ProgramKind::WindowWayland => Some(Display::Wayland(Weston::start())),
            _ => None,
        };
        if matches!(kind, ProgramKind::Shadows | ProgramKind::Volumes | ProgramKind::ComeAndGo) {
            let scene =
                shadow_scene::scene(&shadow_scene::boxes()[..20], &shadow_scene::lights()[..2]);
            return Self { kind, scene, cameras: vec![shadow_scene::camera(); 3], display };
        }
        let made = scenes::city(60, 7).expect("a city");
        let cameras = tests::walk::cameras_along(&made, scenes::PathKind::Street, 3);
        Self { kind, scene: made.scene, cameras, display }
    }

    /// Returns the last image without shadows; `None` if the program has none.
    pub fn unshadowed(&self, stage: &Stage) -> Option<Outcome> {
        let has_shadows = matches!(self.kind, ProgramKind::Shadows | ProgramKind::Volumes);
        // This kind has the same scene, and no shadows.
        has_shadows.then(|| Self::new(ProgramKind::ComeAndGo).relight(stage))
    }

    /// Runs the program from the instance to its end.
    ///
    /// # Errors
    /// Whatever a call of the engine returns.
    pub fn run(&self, stage: &Stage) -> Outcome {
        match self.kind {
            ProgramKind::Recovering => self.recover(stage),
            ProgramKind::RecoveringInWindow => self.recover_in_window(stage),
            kind if kind.is_windowed() => self.show_in_window(stage),
            ProgramKind::Adopted => self.draw_for_host(stage),
            ProgramKind::AdoptedInC => self.draw_in_c(stage),
            ProgramKind::Shadows | ProgramKind::Volumes => self.relight(stage),
            ProgramKind::Streaming => self.stream(stage),
            ProgramKind::Reload => self.reload(stage),
            ProgramKind::Loading => self.load(stage),
            ProgramKind::Animated => self.animate(stage),
            ProgramKind::ComeAndGo => self.come_and_go(stage),
            ProgramKind::Closing => self.close_while_loading(stage),
            ProgramKind::Executor => self.execute(stage),
            ProgramKind::ExecutorInC => self.execute_in_c(stage),
            _ => self.walk(&stage.device(&device_options())?),
        }
    }
}

/// Moves an object to the side.
fn aside(transform: Affine3A) -> Affine3A {
    Affine3A::from_translation(glam::Vec3::X * 0.5) * transform
}
