//! How far a mesh reaches while it moves: the boxes that hold.
//!
//! `alone.rs` says why that of one clip holds, `together.rs` why that of
//! several mixed does, and why the union of the first is not enough. Both take a vertex to be anywhere in the
//! hull of what hangs on its joints, and morph targets' weights anywhere in their ranges.

use std::cell::Cell;

use cull::Aabb;
use glam::Vec3;

use crate::alone::Alone;
use crate::attached::{Attached, attached, joints_of};
use crate::bone_tracks::{bone_tracks, norm};
use crate::clip::{Clip, Excerpt, Interpolation};
use crate::form::{Binding, DeformedMesh};
use crate::morph::{morph_box, ranges};
use crate::refine::{Estimate, refine};
use crate::rig::Rig;
use crate::support::Directions;
use crate::together::{ALWAYS, together};

/// Why there is no box.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReachError {
    /// No vertices.
    #[error("the mesh has no vertices")]
    Empty,
    /// A morph target that is neither empty nor as long as the mesh.
    #[error("morph target {target} moves {deltas} vertices of {vertices}")]
    Target {
        /// Which target.
        target: usize,
        /// How many vertices it moves.
        deltas: usize,
        /// How many there are.
        vertices: usize,
    },
    /// Not as many joints or weights as the vertices need.
    #[error(
        "{vertices} vertices with {sets} sets of joints have {joints} joints and {weights} weights"
    )]
    Count {
        /// How many vertices there are.
        vertices: usize,
        /// Groups of four a vertex.
        sets: u32,
        /// Groups of joints.
        joints: usize,
        /// Groups of weights.
        weights: usize,
    },
    /// A joint that the skin has not.
    #[error("vertex {vertex} follows joint {joint}, which the skin has not, or has as unused")]
    NoJoint {
        /// Whose.
        vertex: usize,
        /// What it names.
        joint: u16,
    },
    /// Weights that are negative or are not 1 together.
    #[error("the weights of vertex {vertex} are negative or are not 1 together")]
    Weights {
        /// Whose.
        vertex: usize,
    },
    /// Numbers that are not finite, or become too large.
    #[error("it reaches beyond all finite numbers")]
    Unbounded,
}

/// Bones that are looked at for one clip, in all of its parts together: some 50 ms.
const MOST_BONES: usize = 300_000;
/// Vertices that are looked at for one clip of a mesh that is morphed only.
const MOST_VERTICES: usize = 10_000_000;
/// How long things take, in steps of about 100 ns: vertices that are morphed, what hangs on a joint, a bone
/// that is lifted to its parent.
const VERTICES_A_STEP: usize = 20;
const ATTACHED_STEPS: usize = 4;
const TOGETHER_STEPS: usize = 100;
/// What boxes are enlarged by, relative to their largest coordinate: single precision, here and on a GPU.
const ROUNDING: f32 = 1e-4;
/// The same relative to the largest numbers that are added on the way.
const DETAIL_ROUNDING: f32 = 2e-6;

/// How far a mesh reaches. Make it once a mesh, ask it once a clip: not in the frame loop.
///
/// Which box an object has: while none of the clips that move it plays, [`Reach::rest_bounds`]; while one
/// plays alone, its [`Reach::clip_bounds`]; while several do, [`Reach::blend_bounds`] of these, or of all.
#[derive(Clone, Debug)]
pub struct Reach<'a> {
    rig: &'a Rig,
    mesh: DeformedMesh<'a>,
    directions: Directions,
    /// What hangs on the joints, if nothing changes it.
    attached: Option<Vec<Attached>>,
    /// The largest size of a number that is added on the way to a vertex.
    detail: f32,
    spent_steps: Cell<u64>,
}

impl<'a> Reach<'a> {
    /// The reach of a mesh on its rig.
    ///
    /// # Errors
    /// Slices that do not fit each other; joints that are not there; weights that are negative or not 1
    /// together; numbers that are not finite.
    pub fn new(rig: &'a Rig, mesh: DeformedMesh<'a>) -> Result<Self, ReachError> {
        check(&mesh)?;
        let directions = Directions::new();
        let sizes = mesh.positions.iter().map(|position| Vec3::from(*position).length());
        let largest = sizes.fold(0.0, f32::max);
        let bound = |binding: &Binding| {
            let joints = binding.skeleton.joints.iter().flatten().map(|joint| joint.inverse_bind);
            joints.map(|bind| norm(&bind) * largest + bind.translation.length()).fold(0.0, f32::max)
        };
        let detail = mesh.binding.as_ref().map_or(largest, bound);
        let spent_steps = Cell::new(0);
        let mut reach = Self { rig, mesh, directions, attached: None, detail, spent_steps };
        if let Some(binding) = mesh.binding.as_ref().filter(|_| mesh.targets.is_empty()) {
            reach.spend(binding.joints.len().saturating_mul(4 * ATTACHED_STEPS));
            reach.attached = Some(attached(&mesh, binding, &reach.directions, &[]));
        }
        Ok(reach)
    }

    /// The box of the mesh while nothing plays.
    ///
    /// # Errors
    /// [`ReachError::Unbounded`].
    pub fn rest_bounds(&self) -> Result<Aabb, ReachError> {
        self.excerpt_bounds(&Excerpt::default())
    }

    /// A box that no vertex leaves while a clip plays alone, and all else is at rest.
    ///
    /// # Errors
    /// [`ReachError::Unbounded`].
    pub fn clip_bounds(&self, clip: &Clip) -> Result<Aabb, ReachError> {
        self.excerpt_bounds(&clip.into())
    }

    /// The same of a clip of which all that concerns the mesh is here.
    ///
    /// # Errors
    /// [`ReachError::Unbounded`].
    pub fn excerpt_bounds(&self, clip: &Excerpt<'_>) -> Result<Aabb, ReachError> {
        let steps_s = step_times_s(clip);
        let duration_s = clip.duration_s();
        let Some(binding) = &self.mesh.binding else {
            let work = self.mesh.positions.len().saturating_mul(1 + self.mesh.targets.len());
            let clip = std::slice::from_ref(clip);
            return self.usable(refine(duration_s, &steps_s, MOST_VERTICES / work, |span| {
                self.spend(work / VERTICES_A_STEP + 1);
                let ranges = ranges(self.rig, &self.mesh, clip, span);
                let [inner, outer] = morph_box(&self.mesh, &ranges);
                Estimate { inner, outer }
            }));
        };
        let bones = &binding.skeleton.bones;
        let attached = self.attached(binding, std::slice::from_ref(clip));
        let tracks = bone_tracks(binding.skeleton, clip);
        let mut alone = Alone::new(self.rig, bones, tracks, &attached, &self.directions);
        let most_parts = MOST_BONES / alone.work();
        let work = alone.work();
        self.usable(refine(duration_s, &steps_s, most_parts, |span| {
            self.spend(work);
            alone.estimate(span)
        }))
    }

    /// A box that no vertex leaves while **any** of these clips play, at any times, in any layers, mixed with
    /// any weights. If they may be mixed with the rig at rest, a clip without channels must be among them.
    ///
    /// # Errors
    /// [`ReachError::Unbounded`].
    pub fn blend_bounds(&self, clips: &[&Clip]) -> Result<Aabb, ReachError> {
        let excerpts: Vec<Excerpt> = clips.iter().map(|clip| Excerpt::from(*clip)).collect();
        self.blend_bounds_of(&excerpts)
    }

    /// The same of clips of which all that concerns the mesh is here.
    ///
    /// # Errors
    /// [`ReachError::Unbounded`].
    pub fn blend_bounds_of(&self, clips: &[Excerpt<'_>]) -> Result<Aabb, ReachError> {
        self.spend(clips.iter().map(Excerpt::keys).fold(0, usize::saturating_add));
        let Some(binding) = &self.mesh.binding else {
            let [_, outer] = morph_box(&self.mesh, &ranges(self.rig, &self.mesh, clips, ALWAYS));
            return self.usable(outer);
        };
        let bones = &binding.skeleton.bones;
        let tracks: Vec<_> = clips.iter().map(|clip| bone_tracks(binding.skeleton, clip)).collect();
        let attached = self.attached(binding, clips);
        self.spend(bones.len().saturating_mul(TOGETHER_STEPS));
        let all = together(self.rig, bones, &tracks, &attached, &self.directions);
        let Some(support) = all else { return Err(ReachError::Unbounded) };
        let along = |axis: Vec3| self.directions.along(&support, axis);
        self.usable(Aabb::new(
            -Vec3::new(along(-Vec3::X), along(-Vec3::Y), along(-Vec3::Z)),
            Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)),
        ))
    }

    /// What was done to find boxes since it was made, in steps of about 100 ns.
    pub fn spent_steps(&self) -> u64 {
        self.spent_steps.get()
    }

    fn spend(&self, steps: usize) {
        self.spent_steps.set(self.spent_steps.get().saturating_add(steps as u64));
    }

    fn attached(
        &self,
        binding: &Binding,
        clips: &[Excerpt<'_>],
    ) -> std::borrow::Cow<'_, [Attached]> {
        match &self.attached {
            Some(attached) => attached.into(),
            None => {
                let corners = binding.joints.len().saturating_mul(4);
                self.spend(corners.saturating_mul(ATTACHED_STEPS + self.mesh.targets.len()));
                let ranges = ranges(self.rig, &self.mesh, clips, ALWAYS);
                attached(&self.mesh, binding, &self.directions, &ranges).into()
            }
        }
    }

    /// The box with what rounding may add, if it is finite.
    fn usable(&self, bounds: Aabb) -> Result<Aabb, ReachError> {
        let rounding = bounds.largest_coordinate() * ROUNDING + self.detail * DETAIL_ROUNDING;
        let bounds = bounds.enlarged(rounding);
        let is_usable = bounds.is_finite() && !bounds.is_empty();
        if is_usable { Ok(bounds) } else { Err(ReachError::Unbounded) }
    }
}

/// When something jumps, ascending.
fn step_times_s(clip: &Excerpt<'_>) -> Vec<f32> {
    let tracks = clip.channels.iter().map(|channel| &channel.track);
    let steps = tracks.filter(|track| track.interpolation == Interpolation::Step);
    let mut times_s: Vec<f32> = steps.flat_map(|track| track.times_s.iter().copied()).collect();
    times_s.sort_by(f32::total_cmp);
    times_s.dedup();
    times_s
}

pub(crate) fn check(mesh: &DeformedMesh) -> Result<(), ReachError> {
    let vertices = mesh.positions.len();
    if vertices == 0 {
        return Err(ReachError::Empty);
    }
    let targets = mesh.targets.iter().enumerate();
    let wrong = targets.clone().find(|(_, target)| !target.is_empty() && target.len() != vertices);
    if let Some((target, deltas)) = wrong {
        return Err(ReachError::Target { target, deltas: deltas.len(), vertices });
    }
    let all = mesh.positions.iter().chain(mesh.targets.iter().copied().flatten());
    if all.flatten().any(|number| !number.is_finite()) {
        return Err(ReachError::Unbounded);
    }
    let Some(binding) = &mesh.binding else { return Ok(()) };
    let (joints, weights, sets) = (binding.joints.len(), binding.weights.len(), binding.sets);
    let needed = vertices.checked_mul(sets as usize);
    if needed != Some(joints) || needed != Some(weights) {
        return Err(ReachError::Count { vertices, sets, joints, weights });
    }
    for vertex in 0..vertices {
        check_vertex(binding, vertex)?;
    }
    Ok(())
}

fn check_vertex(binding: &Binding, vertex: usize) -> Result<(), ReachError> {
    for (joint, _) in joints_of(binding, vertex) {
        let is_there = binding.skeleton.joints.get(usize::from(joint)).is_some_and(Option::is_some);
        if !is_there {
            return Err(ReachError::NoJoint { vertex, joint });
        }
    }
    let sets = binding.sets as usize;
    let rows = binding.weights.get(vertex * sets..(vertex + 1) * sets).unwrap_or_default();
    let is_negative = rows.iter().flatten().any(|weight| *weight < 0.0);
    let sum: f32 = rows.iter().flatten().sum();
    let is_whole = (sum - 1.0).abs() <= 1e-4;
    if is_negative || !is_whole { Err(ReachError::Weights { vertex }) } else { Ok(()) }
}
