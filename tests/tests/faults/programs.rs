//! The programs under test: small, whole, and the same each time.

mod adopted;
mod adopted_in_c;
mod frames;
mod recovering;
mod window;

use std::cell::{Cell, RefCell};
use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use cull::Camera;
use glam::Affine3A;
use gpu::{
    Device, DeviceOptions, Instance, InstanceOptions, Validation, ValidationLog, WindowSystem,
};
use scene::Scene;
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
    /// Surfaces under lights with shadow maps.
    Shadows,
    /// Surfaces under lights with shadow volumes.
    Volumes,
    /// A mesh that is uploaded during frames, objects that move, a new size.
    Streaming,
    /// Other shaders in the middle, and a pipeline cache in a file.
    Reload,
    /// A changed scene, which goes on on another device when the device is lost.
    Recovering,
    /// As above, in a window.
    RecoveringInWindow,
    /// A window that changes its size.
    Window,
    /// The device of a host, with its queue.
    Adopted,
    /// As above, through the C interface.
    AdoptedInC,
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
    server: Option<Xvfb>,
}

impl ProgramKind {
    /// Returns true if the driver can run the program.
    pub fn runs_on(self, driver: Driver) -> bool {
        let needs_more = matches!(self, Self::Conditional | Self::Counts | Self::Compacted);
        !needs_more || driver == Driver::Lavapipe
    }
}

impl Program {
    /// Creates the scene of a program.
    pub fn new(kind: ProgramKind) -> Self {
        let has_window = matches!(kind, ProgramKind::Window | ProgramKind::RecoveringInWindow);
        let server = has_window.then(Xvfb::start);
        if matches!(kind, ProgramKind::Shadows | ProgramKind::Volumes) {
            let scene =
                shadow_scene::scene(&shadow_scene::boxes()[..20], &shadow_scene::lights()[..2]);
            return Self { kind, scene, cameras: vec![shadow_scene::camera(); 3], server };
        }
        let made = scenes::city(60, 7).expect("a city");
        let cameras = tests::walk::cameras_along(&made, scenes::PathKind::Street, 3);
        Self { kind, scene: made.scene, cameras, server }
    }

    /// Runs the program from the instance to its end.
    ///
    /// # Errors
    /// Whatever a call of the engine returns.
    pub fn run(&self, stage: &Stage) -> Outcome {
        match self.kind {
            ProgramKind::Recovering => self.recover(stage),
            ProgramKind::RecoveringInWindow => self.recover_in_window(stage),
            ProgramKind::Window => self.show(stage),
            ProgramKind::Adopted => self.draw_for_host(stage),
            ProgramKind::AdoptedInC => self.draw_in_c(stage),
            ProgramKind::Streaming => self.stream(stage),
            ProgramKind::Reload => self.reload(stage),
            _ => self.walk(&stage.device(&device_options())?),
        }
    }
}

/// Moves an object to the side.
fn aside(transform: Affine3A) -> Affine3A {
    Affine3A::from_translation(glam::Vec3::X * 0.5) * transform
}

/// A window that a test opened.
type TestWindow = Arc<tests::x11_window::X11Window>;
