//! A culler, a device and a scene that advance frame by frame.

use antumbra_cull::{
    Aabb, Camera, CostTable, CullConfig, CullView, Culler, FramePlan, Hierarchy, Projection,
    SceneCosts, Strategy,
};
use glam::Vec3;

use crate::device::{Device, Mishaps, Solids};
use crate::image::Image;
use crate::random::Random;
use crate::scene::{Scene, city};

pub const SIZE: [u32; 2] = [48, 32];
pub const BUDGET: usize = 4_096;

/// A camera in a street of a city.
pub const STREET: Camera = Camera {
    eye: Vec3::new(-1.0, 1.7, 30.0),
    forward: Vec3::NEG_Z,
    up: Vec3::Y,
    projection: Projection::perspective(1.0),
    near: 0.1,
};

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
        self.step_by(camera, |culler, hierarchy, view, plan| {
            culler.plan(hierarchy, Strategy::ANTUMBRA, view, BUDGET, plan);
        });
    }

    /// Runs a frame of next-frame queries.
    pub fn step_next_frame(&mut self, camera: &Camera) {
        self.step_by(camera, Culler::plan_next_frame);
    }

    fn step_by(
        &mut self,
        camera: &Camera,
        plan: impl FnOnce(&mut Culler, &Hierarchy, &CullView, &mut FramePlan),
    ) {
        let view = CullView::new(camera, SIZE, 8);
        let answers = self.device.collect(self.culler.frame().0 + 1, &self.hierarchy);
        self.culler.ingest(&self.hierarchy, answers);
        plan(&mut self.culler, &self.hierarchy, &view, &mut self.plan);
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
        self.wrong_pixels(camera) == 0
    }

    /// Returns the number of pixels of the last frame that differ from those with everything drawn.
    pub fn wrong_pixels(&self, camera: &Camera) -> usize {
        let view = CullView::new(camera, SIZE, 8);
        let mut truth = Image::new(SIZE);
        for (solid, shift) in self.scene.solids.iter().zip(&self.scene.shifts) {
            truth.draw(&view, solid, *shift);
        }
        truth.depths.iter().zip(&self.device.images[0].depths).filter(|(a, b)| a != b).count()
    }
}

/// Returns a walk in a city of which everything around [`STREET`] is known.
pub fn settled_city() -> Walk {
    let mut walk = Walk::new(city(&mut Random::new(5), 10), 2);
    walk.steps(&STREET, 80);
    walk
}
