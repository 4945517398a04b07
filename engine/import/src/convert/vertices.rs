//! The vertices of primitives: their attributes as lists of finite numbers.

use glam::{Vec2, Vec3, Vec4};
use gltf::json;
use gltf::mesh::Semantic;
use scene::{MorphTarget, SkinWeights};

use super::geometry::Geometry;
use super::materials::MaterialUse;
use super::primitives::{Primitive, Variant};
use crate::notes::Notes;
use crate::{Cause, ImportError};

/// The limit of texture coordinates: beyond it, the spacing of floats is too coarse to address a
/// texture.
const LARGEST_UV: f32 = 1e6;

/// The used vertices of a primitive: other vertices are not read.
pub(super) struct Vertices<'a> {
    primitive: &'a Primitive<'a>,
    /// The used vertices in increasing order; `None` if all are used.
    picks: Option<&'a [u32]>,
}

impl<'a> Vertices<'a> {
    pub(super) fn new(primitive: &'a Primitive<'a>, picks: Option<&'a [u32]>) -> Self {
        Self { primitive, picks }
    }

    /// Returns all required attributes.
    pub(super) fn read(
        &self,
        positions: usize,
        variant: Variant,
        material: &MaterialUse,
        notes: &mut Notes,
    ) -> Result<Geometry, ImportError> {
        let mut geometry = Geometry { positions: self.vectors(positions), ..Geometry::default() };
        let is_broken = |position: &Vec3| !position.is_finite();
        if let Some(place) = geometry.positions.iter().position(is_broken) {
            let vertex = self.vertex(place);
            let reason = format!("the position of vertex {vertex} is not a finite number");
            return Err(self.primitive.error(Cause::Malformed, reason));
        }
        let of = |semantic| self.primitive.attribute(semantic);
        geometry.normals =
            of(Semantic::Normals).map(|accessor| self.vectors(accessor)).unwrap_or_default();
        if let Some(tangents) = of(Semantic::Tangents)
            && !geometry.normals.is_empty()
        {
            let tangents = self.floats::<4>(tangents).unwrap_or_default();
            geometry.tangents = tangents.into_iter().map(Vec4::from_array).collect();
        }
        for (uvs, set) in geometry.uvs.iter_mut().zip(material.sets) {
            match set.map(|set| of(Semantic::TexCoords(set))) {
                Some(Some(accessor)) => *uvs = self.uvs(accessor, notes),
                Some(None) => {
                    let what =
                        "it has no texture coordinates for a texture, which is shown by one texel";
                    notes.count(what, 1, || self.primitive.place());
                }
                None => {}
            }
        }
        if let Some(colours) = of(Semantic::Colors(0)) {
            geometry.colours = self.colours(colours, notes);
        }
        if let Some(joint_count) = variant.joints {
            geometry.skin = Some(self.skin(joint_count, geometry.positions.len(), notes));
        }
        if variant.is_morphed {
            geometry.targets = self.morph_targets()?;
        }
        Ok(geometry)
    }

    /// Returns the index in the file of the vertex at this place.
    fn vertex(&self, place: usize) -> usize {
        self.picks.and_then(|pick| pick.get(place)).map_or(place, |&vertex| vertex as usize)
    }

    fn floats<const N: usize>(&self, accessor: usize) -> Option<Vec<[f32; N]>> {
        self.primitive.source.picked_floats(accessor, self.picks)
    }

    fn vectors(&self, accessor: usize) -> Vec<Vec3> {
        let vectors = self.floats::<3>(accessor).unwrap_or_default();
        vectors.into_iter().map(Vec3::from_array).collect()
    }

    fn uvs(&self, accessor: usize, notes: &mut Notes) -> Vec<Vec2> {
        let mut broken = 0;
        let uvs = self.floats::<2>(accessor).unwrap_or_default().into_iter().map(|uv| {
            let uv = Vec2::from_array(uv);
            if uv.abs().max_element() <= LARGEST_UV && uv.is_finite() {
                return uv;
            }
            broken += 1;
            if uv.is_finite() {
                uv.clamp(Vec2::splat(-LARGEST_UV), Vec2::splat(LARGEST_UV))
            } else {
                Vec2::ZERO
            }
        });
        let uvs = uvs.collect();
        notes.count("a texture coordinate is huge or no number", broken, || self.primitive.place());
        uvs
    }

    fn colours(&self, accessor: usize, notes: &mut Notes) -> Vec<[f32; 4]> {
        let opaque = |[red, green, blue]: [f32; 3]| [red, green, blue, 1.0];
        let mut colours = self.floats::<4>(accessor).unwrap_or_else(|| {
            let colours = self.floats::<3>(accessor).unwrap_or_default();
            colours.into_iter().map(opaque).collect()
        });
        let mut broken = 0;
        let mut cut = 0;
        for colour in &mut colours {
            if colour.iter().any(|part| !part.is_finite()) {
                *colour = [1.0; 4];
                broken += 1;
            }
            cut += usize::from(colour.iter().any(|part| !(0.0..=1.0).contains(part)));
        }
        notes.count("a vertex has a colour below 0 or above 1, cut off there", cut, || {
            self.primitive.place()
        });
        notes.count(
            "a vertex has a colour that is not a number, and is white instead",
            broken,
            || self.primitive.place(),
        );
        colours
    }

    /// Returns all sets of joints and weights; the sum of weights is 1 per vertex.
    fn skin(&self, joint_count: u32, vertices: usize, notes: &mut Notes) -> SkinWeights {
        let source = self.primitive.source;
        let attribute = |semantic| self.primitive.attribute(semantic);
        let of_set = |set| {
            let joints =
                source.picked_integers::<4>(attribute(Semantic::Joints(set))?, self.picks)?;
            let weights = self.floats::<4>(attribute(Semantic::Weights(set))?)?;
            Some((joints, weights))
        };
        let sets: Vec<_> = (0..).map_while(of_set).collect();
        let mut skin = SkinWeights {
            joint_count,
            joints: Vec::with_capacity(vertices * sets.len()),
            weights: Vec::with_capacity(vertices * sets.len()),
            sets: sets.len() as u32,
        };
        let mut broken = 0;
        for vertex in 0..vertices {
            let start = skin.weights.len();
            for (joints, weights) in &sets {
                let joints = joints.get(vertex).copied().unwrap_or_default();
                let weights = weights.get(vertex).copied().unwrap_or_default();
                let weights =
                    weights.map(|weight| if weight.is_finite() { weight.max(0.0) } else { 0.0 });
                skin.joints.push(std::array::from_fn(|place| {
                    // A joint without weight need not exist.
                    let is_there = weights[place] > 0.0 && joints[place] < joint_count;
                    if is_there { joints[place] as u16 } else { 0 }
                }));
                skin.weights.push(weights);
            }
            let own = skin.weights.get_mut(start..).unwrap_or_default().as_flattened_mut();
            let sum: f64 = own.iter().map(|weight| f64::from(*weight)).sum();
            if sum > 0.0 {
                own.iter_mut().for_each(|weight| *weight = (f64::from(*weight) / sum) as f32);
            } else if let Some(first) = own.first_mut() {
                *first = 1.0;
                broken += 1;
            }
        }
        notes.count("a vertex has no weight, and hangs on its skin's first joint", broken, || {
            self.primitive.place()
        });
        skin
    }

    fn morph_targets(&self) -> Result<Vec<MorphTarget>, ImportError> {
        let deltas = |accessor: &Option<json::Index<json::Accessor>>| {
            let deltas = accessor.as_ref().and_then(|accessor| self.floats::<3>(accessor.value()));
            deltas.unwrap_or_default()
        };
        let finite = |delta: [f32; 3]| {
            if delta.iter().all(|part| part.is_finite()) { delta } else { [0.0; 3] }
        };
        let mut targets = Vec::with_capacity(self.primitive.targets().len());
        for (number, target) in self.primitive.targets().iter().enumerate() {
            let positions = deltas(&target.positions);
            let is_broken = |delta: &[f32; 3]| delta.iter().any(|part| !part.is_finite());
            if let Some(place) = positions.iter().position(is_broken) {
                let vertex = self.vertex(place);
                let reason = format!(
                    "morph target {number} moves vertex {vertex} by what is not a finite number"
                );
                return Err(self.primitive.error(Cause::Malformed, reason));
            }
            let normals = deltas(&target.normals).into_iter().map(finite).collect();
            let tangents = deltas(&target.tangents).into_iter().map(finite).collect();
            targets.push(MorphTarget { positions, normals, tangents });
        }
        Ok(targets)
    }
}
