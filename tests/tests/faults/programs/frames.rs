//! Programs without a window.

use cull::{ObjectId, Strategy};
use gpu::{Device, DeviceOptions, PredicationMode, Readback};
use occlusion::ShaderSet;
use render::{CostModel, RendererOptions, SpareCapacity};
use scene::{Object, ObjectChange, PreparedMesh};
use shadows::{ShadowMethod, ShadowOptions};

use super::running::Running;
use super::{Outcome, Program, ProgramKind, SIZE, Stage, aside, device_options};

impl Program {
    pub(super) fn options(&self) -> RendererOptions {
        let predication = match self.kind {
            ProgramKind::Conditional => Some(PredicationMode::Conditional),
            ProgramKind::Counts => Some(PredicationMode::Counts),
            ProgramKind::Instances => Some(PredicationMode::Instances),
            ProgramKind::Compacted => Some(PredicationMode::Compacted),
            _ => None,
        };
        let method = match self.kind {
            ProgramKind::Shadows => ShadowMethod::Maps,
            ProgramKind::Volumes => ShadowMethod::Volumes,
            _ => ShadowMethod::Off,
        };
        let sides =
            ShadowOptions { sun_side: 64, spot_side: 64, cascades: 2, ..Default::default() };
        RendererOptions {
            size: SIZE,
            predication,
            // Everything that may be hidden is tested, whatever the clock says.
            cost_model: CostModel::Off,
            methods: methods::all(),
            shadows: ShadowOptions { method, ..sides },
            ..Default::default()
        }
    }

    fn strategies(&self) -> &'static [Strategy] {
        match self.kind {
            ProgramKind::Methods => {
                &[methods::STOP_AND_WAIT, methods::CHC, methods::HZB, methods::BATCHED]
            }
            _ => &[Strategy::ANTUMBRA],
        }
    }

    /// Draws all cameras, and returns the last image.
    pub(super) fn walk(&self, device: &Device) -> Outcome {
        self.show(&mut Running::new(device, &self.scene, &self.options())?)
    }

    pub(super) fn show(&self, running: &mut Running) -> Outcome {
        running.draw(&self.cameras, self.strategies())
    }

    /// Changes the scene between frames.
    pub(super) fn stream(&self, stage: &Stage) -> Outcome {
        let device = stage.device(&device_options())?;
        let spare =
            SpareCapacity { meshes: 4, vertices: 4096, indices: 8192, ..Default::default() };
        let options = RendererOptions {
            spare,
            spare_objects: 8,
            upload_bytes_per_frame: 256,
            ..self.options()
        };
        let mut running = Running::new(&device, &self.scene, &options)?;
        let first = self.scene.objects[0];
        let transform = aside(first.transform);
        let renderer = &mut running.renderer;
        renderer.update(&[ObjectChange::Move { object: ObjectId(0), transform }])?;
        let mesh = PreparedMesh::new(self.scene.meshes[0].clone())?;
        let added = renderer.add_meshes(vec![mesh])?;
        let object = Object { mesh: added[0], transform: aside(transform), ..first };
        renderer.update(&[ObjectChange::Add { object }])?;
        self.show(&mut running)?;
        let small = [SIZE[0] / 2, SIZE[1] / 2];
        running.image = Readback::new(&device, small)?;
        running.renderer.resize(small)?;
        for _ in 0..100 {
            self.show(&mut running)?;
            if !running.renderer.is_uploading() {
                break;
            }
        }
        running.renderer.update(&[ObjectChange::Remove { object: ObjectId(1) }])?;
        self.show(&mut running)
    }

    /// Draws with other shaders from the middle on, on a device with a file of pipelines whose
    /// clocks are read.
    pub(super) fn reload(&self, stage: &Stage) -> Outcome {
        let folder = std::env::temp_dir().join(format!("antumbra-faults-{}", std::process::id()));
        let pipeline_cache = Some(folder.join("pipelines.bin"));
        let device = stage.device(&DeviceOptions { pipeline_cache, ..device_options() })?;
        let mut running = Running::new(&device, &self.scene, &self.options())?;
        let _not_every_device_has_them = device.clocks()?;
        running.renderer.time_passes()?;
        let before = self.show(&mut running)?;
        let camera = self.cameras[self.cameras.len() - 1];
        running.change(camera, &before, |renderer| Ok(renderer.reload(ShaderSet::embedded()?)?))?;
        self.show(&mut running)
    }
}
