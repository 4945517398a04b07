//! From where a scene is first seen: what a pixel is in metres there decides how large points and
//! lines are.
//!
//! That is the first camera of the file, where it is at rest, else a view of the whole scene.
//! Whether the boxes that files give for their positions are right matters for nothing else.

use std::cell::OnceCell;
use std::collections::HashMap;

use animation::RigNodeId;
use cull::Aabb;
use glam::{Affine3A, Vec3};
use gltf::json::validation::Checked;
use gltf::mesh::Semantic;

use super::cameras::Lens;
use super::framing::overview;
use super::nodes::Tree;
use crate::Source;

/// How much larger than seen from where all is in sight points and lines are at most.
const MOST_TIMES: f32 = 2.0;

/// From where a scene is seen. Found when it is first asked for: most scenes have neither points
/// nor lines, and to look over all nodes takes its time.
pub(super) struct InitialView<'a> {
    source: &'a Source,
    tree: &'a Tree,
    /// Where the first camera is, with its lens.
    camera: Option<(RigNodeId, Lens)>,
    place: OnceCell<Place>,
}

/// A place from which a scene is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    eye: Vec3,
    /// The height of the picture for each metre of distance, and at any distance.
    heights_m: [f32; 2],
    most_height_m: f32,
}

impl<'a> InitialView<'a> {
    /// From a camera at a node, or from where all of the scene is seen.
    pub(super) fn of(
        source: &'a Source,
        tree: &'a Tree,
        camera: Option<(RigNodeId, Lens)>,
    ) -> Self {
        Self { source, tree, camera, place: OnceCell::new() }
    }

    /// Returns how high the picture is around the middle of a box, in the units of its own space.
    pub(super) fn height_at(&self, bounds: &Aabb, to_world: &Affine3A) -> f32 {
        let place = self.place.get_or_init(|| self.look());
        let distance = to_world.transform_point3(bounds.centre()).distance(place.eye);
        let height_m = place.heights_m[0] * distance + place.heights_m[1];
        let scale = to_world.matrix3.determinant().abs().cbrt();
        let height = height_m.min(place.most_height_m) / scale;
        if height.is_finite() && height > 0.0 { height } else { place.most_height_m }
    }

    fn look(&self) -> Place {
        let all = rough_bounds(self.source, self.tree);
        let around = overview(&all);
        let of_angle = |angle_rad: f32| 2.0 * (angle_rad * 0.5).tan();
        let distance = around.eye.distance(all.centre());
        let height_m = of_angle(around.fov_y) * distance;
        let (eye, heights_m) = match self.camera {
            None => (around.eye, [of_angle(around.fov_y), 0.0]),
            Some((node, lens)) => {
                let heights_m = match lens {
                    Lens::Perspective { angle_rad } => [of_angle(angle_rad), 0.0],
                    Lens::Parallel { half_height_m, .. } => [0.0, 2.0 * half_height_m],
                };
                (self.tree.world(node).translation.into(), heights_m)
            }
        };
        Place { eye, heights_m, most_height_m: height_m * MOST_TIMES }
    }
}

/// Around all meshes at rest, by what the file says of their positions.
fn rough_bounds(source: &Source, tree: &Tree) -> Aabb {
    let json = source.document.as_json();
    let mut known: HashMap<usize, Option<Aabb>> = HashMap::new();
    let mut all = Aabb::EMPTY;
    for (node, mesh) in (0..).map(RigNodeId).zip(&tree.meshes) {
        let primitives = mesh.and_then(|mesh| json.meshes.get(mesh as usize));
        let to_world = tree.world(node);
        for primitive in primitives.iter().flat_map(|mesh| &mesh.primitives) {
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            let Some(positions) = positions.map(|accessor| accessor.value()) else { continue };
            let bounds = *known.entry(positions).or_insert_with(|| said_bounds(source, positions));
            for corner in bounds.iter().flat_map(Aabb::corners) {
                let corner = to_world.transform_point3(corner);
                if corner.is_finite() {
                    all = all.union(&Aabb::new(corner, corner));
                }
            }
        }
    }
    let size = all.max - all.min;
    match all.is_usable() && size.max_element() > 0.0 {
        true => all,
        // A point alone has the size that it has in a scene of a metre.
        false => {
            let centre = if all.is_usable() { all.centre() } else { Vec3::ZERO };
            Aabb::new(centre - 0.5, centre + 0.5)
        }
    }
}

/// Returns what a file says of the positions of an accessor.
fn said_bounds(source: &Source, accessor: usize) -> Option<Aabb> {
    let accessor = source.document.as_json().accessors.get(accessor)?;
    let corner = |value: &Option<gltf::json::Value>| {
        let numbers = value.as_ref()?.as_array()?;
        let number = |place: usize| Some(numbers.get(place)?.as_f64()? as f32);
        Some(Vec3::new(number(0)?, number(1)?, number(2)?))
    };
    let (low, high) = (corner(&accessor.min)?, corner(&accessor.max)?);
    Some(Aabb::new(low.min(high), high.max(low)))
}
