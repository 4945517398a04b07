//! Tests of whole scenes, and their shared parts.

mod ground;
mod layout;
mod meshes;
mod models;
mod paths;
mod views;

use std::collections::HashMap;

use cull::Aabb;
use glam::{IVec2, Vec3};
use scene::{Object, Scene};

fn is_ground(scene: &Scene, object: &Object) -> bool {
    scene.mesh_of(object).unwrap().name.starts_with("ground")
}

/// The boxes of a scene's objects, in cells of the x-z plane.
struct Boxes {
    bounds: Vec<Aabb>,
    cells: HashMap<IVec2, Vec<u32>>,
}

const CELL_M: f32 = 16.0;

fn cell_of(x: f32, z: f32) -> IVec2 {
    IVec2::new((x / CELL_M).floor() as i32, (z / CELL_M).floor() as i32)
}

impl Boxes {
    /// Creates the boxes of the objects that `chosen` accepts, all enlarged by `margin_m`.
    fn new(scene: &Scene, margin_m: f32, chosen: impl Fn(&Object) -> bool) -> Self {
        let mut boxes = Self { bounds: Vec::new(), cells: HashMap::new() };
        for object in scene.objects.iter().filter(|object| chosen(object)) {
            let Aabb { min, max } = scene.bounds_of(object).unwrap();
            let bounds =
                Aabb { min: min - Vec3::splat(margin_m), max: max + Vec3::splat(margin_m) };
            let number = boxes.bounds.len() as u32;
            boxes.bounds.push(bounds);
            let low = cell_of(bounds.min.x, bounds.min.z);
            let high = cell_of(bounds.max.x, bounds.max.z);
            for x in low.x..=high.x {
                for z in low.y..=high.y {
                    boxes.cells.entry(IVec2::new(x, z)).or_default().push(number);
                }
            }
        }
        boxes
    }

    fn in_cell(&self, cell: IVec2) -> &[u32] {
        self.cells.get(&cell).map_or(&[], Vec::as_slice)
    }

    /// Returns a box that contains the point.
    fn around(&self, point: Vec3) -> Option<Aabb> {
        let holds = |number: &u32| {
            let Aabb { min, max } = self.bounds[*number as usize];
            point.cmpge(min).all() && point.cmple(max).all()
        };
        let number = self.in_cell(cell_of(point.x, point.z)).iter().find(|number| holds(number));
        number.map(|&number| self.bounds[number as usize])
    }

    /// Returns the nearest box along a ray of at most `reach_m`, and its distance.
    fn first_hit(&self, eye: Vec3, towards: Vec3, reach_m: f32) -> Option<(u32, f32)> {
        let inverse = Vec3::ONE / towards;
        let mut nearest: Option<(u32, f32)> = None;
        let mut cell = cell_of(eye.x, eye.z);
        let step = IVec2::new(towards.x.signum() as i32, towards.z.signum() as i32);
        loop {
            for &number in self.in_cell(cell) {
                let Aabb { min, max } = self.bounds[number as usize];
                let a = (min - eye) * inverse;
                let b = (max - eye) * inverse;
                let enter = a.min(b).max_element().max(0.0);
                let leave = a.max(b).min_element();
                if enter <= leave && nearest.is_none_or(|(_, distance)| enter < distance) {
                    nearest = Some((number, enter));
                }
            }
            // The borders at which the ray leaves this cell (Amanatides and Woo, 1987).
            let border = |cell: i32, step: i32| (cell + i32::from(step > 0)) as f32 * CELL_M;
            let exit_x = (border(cell.x, step.x) - eye.x) * inverse.x;
            let exit_z = (border(cell.y, step.y) - eye.z) * inverse.z;
            let exit = exit_x.min(exit_z);
            if exit > reach_m || nearest.is_some_and(|(_, distance)| distance <= exit) {
                return nearest.filter(|&(_, distance)| distance <= reach_m);
            }
            if exit_x < exit_z { cell.x += step.x } else { cell.y += step.y }
        }
    }
}
