//! A culler, a device and a scene that advance frame by frame.

use antumbra_cull::{
    Aabb, Camera, CostTable, CullConfig, CullView, Culler, FramePlan, Hierarchy, SceneCosts,
    Strategy,
};

use crate::device::{Device, Mishaps, Solids};
use crate::image::Image;
use crate::scene::Scene;

pub const SIZE: [u32; 2] = [48, 32];
pub const BUDGET: usize = 4_096;

pub struct Walk {
    pub scene: Scene,
    pub hierarchy: Hierarchy,
    pub culler: Culler,
    pub device: Device,
    pub plan: FramePlan,
}

impl Walk {
    pub fn new(bounds: Vec<Aabb>, latency: u64) -> Self {
        Self {
            hierarchy: Hierarchy::build(&bounds).unwrap(),
            scene: Scene::solid(bounds),
            culler: Culler::new(CullConfig::default()),
            device: Device::new(SIZE, 8, Mishaps::none(latency), 1),
            plan: FramePlan::default(),
        }
    }

    /// Returns a walk with a cost model and objects of 100 triangles.
    pub fn cost_driven(bounds: Vec<Aabb>, latency: u64, table: CostTable) -> Self {
        let mut walk = Self::new(bounds, latency);
        walk.culler.set_costs(table, SceneCosts { triangles_per_leaf: 100.0 }).unwrap();
        walk
    }

    pub fn step(&mut self, camera: &Camera) {
        let view = CullView::new(camera, SIZE, 8);
        let answers = self.device.collect(self.culler.frame().0 + 1, &self.hierarchy);
        self.culler.ingest(&self.hierarchy, answers);
        self.culler.plan(&self.hierarchy, Strategy::ANTUMBRA, &view, BUDGET, &mut self.plan);
        let solids = Solids { solids: &self.scene.solids, shifts: &self.scene.shifts };
        self.device.execute(&view, &self.hierarchy, &solids, &self.plan);
    }

    pub fn steps(&mut self, camera: &Camera, frames: usize) {
        for _ in 0..frames {
            self.step(camera);
        }
    }

    /// Counts the leaves that frustum culling would draw.
    pub fn count_in_frustum(&self, camera: &Camera) -> usize {
        let view = CullView::new(camera, SIZE, 8);
        let mut plan = FramePlan::default();
        let mut culler = Culler::new(CullConfig::default());
        culler.plan(&self.hierarchy, Strategy::FRUSTUM, &view, 0, &mut plan);
        plan.draws.len()
    }

    /// Returns true if the last frame's image is the same as with everything drawn.
    pub fn is_exact(&self, camera: &Camera) -> bool {
        let view = CullView::new(camera, SIZE, 8);
        let mut truth = Image::new(SIZE);
        for (solid, shift) in self.scene.solids.iter().zip(&self.scene.shifts) {
            truth.draw(&view, solid, *shift);
        }
        truth.depths == self.device.images[0].depths
    }
}
