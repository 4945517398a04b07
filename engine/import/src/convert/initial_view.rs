//! The initial view of a scene. Its pixel size in metres determines the size of points and lines.
//!
//! It is the first camera of the file at rest, else a view of the whole scene. Only this view
//! relies on the bounds that files state for positions.

use std::cell::OnceCell;
use std::collections::HashMap;

use animation::RigNodeId;
use cull::{Aabb, Projection};
use glam::{Affine3A, Vec3};
use gltf::json::validation::Checked;
use gltf::mesh::Semantic;

use super::framing::overview;
use super::nodes::Tree;
use crate::Source;

/// The largest size of points and lines, relative to their size in a view of the whole scene.
const MOST_TIMES: f32 = 2.0;

/// The initial view of a scene, computed on first use: most scenes have neither points nor lines,
/// and visiting all nodes takes time.
pub(super) struct InitialView<'a> {
    source: &'a Source,
    tree: &'a Tree,
    camera: Option<FirstCamera>,
    place: OnceCell<Place>,
}

/// A place from which a scene is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    eye: Vec3,
    projection: Projection,
    most_height_m: f32,
}

/// The first camera of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstCamera {
    pub(super) node: RigNodeId,
    pub(super) projection: Projection,
}

impl<'a> InitialView<'a> {
    /// Returns the view of a camera at a node, or of the whole scene without a camera.
    pub(super) fn of(source: &'a Source, tree: &'a Tree, camera: Option<FirstCamera>) -> Self {
        Self { source, tree, camera, place: OnceCell::new() }
    }

    /// Returns the height of the image at the distance of a box's middle, in units of the box's
    /// space.
    pub(super) fn height_at(&self, bounds: &Aabb, to_world: &Affine3A) -> f32 {
        let place = self.place.get_or_init(|| self.look());
        let distance = to_world.transform_point3(bounds.centre()).distance(place.eye);
        let height_m = place.projection.height_at(distance);
        let scale = to_world.matrix3.determinant().abs().cbrt();
        let height = height_m.min(place.most_height_m) / scale;
        if height.is_finite() && height > 0.0 { height } else { place.most_height_m }
    }

    fn look(&self) -> Place {
        let all = rough_bounds(self.source, self.tree);
        let around = overview(&all);
        let height_m = around.projection.height_at(around.eye.distance(all.centre()));
        let (eye, projection) = match self.camera {
            None => (around.eye, around.projection),
            Some(FirstCamera { node, projection }) => {
                (self.tree.world(node).translation.into(), projection)
            }
        };
        Place { eye, projection, most_height_m: height_m * MOST_TIMES }
    }
}

/// Returns a box around all meshes at rest, from the bounds that the file states.
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
    if all.is_usable() && size.max_element() > 0.0 {
        return all;
    }
    // A single point gets its size as in a scene of one metre.
    let centre = if all.is_usable() { all.centre() } else { Vec3::ZERO };
    Aabb::new(centre - 0.5, centre + 0.5)
}

/// Returns the bounds that a file states for the positions of an accessor.
fn said_bounds(source: &Source, accessor: usize) -> Option<Aabb> {
    let accessor = source.document.as_json().accessors.get(accessor)?;
    let corner = |value: &Option<gltf::json::Value>| {
        let numbers = value.as_ref()?.as_array()?;
        let number = |place: usize| Some(numbers.get(place)?.as_f64()? as f32);
        Some(Vec3::new(number(0)?, number(1)?, number(2)?))
    };
    let low = corner(&accessor.min)?;
    let high = corner(&accessor.max)?;
    Some(Aabb::new(low.min(high), high.max(low)))
}
