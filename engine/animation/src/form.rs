//! Meshes whose vertices move, as plain slices.

use crate::rig::NodeId;
use crate::skeleton::Skeleton;

/// How the vertices of a mesh hang on a skeleton.
#[derive(Clone, Copy, Debug)]
pub struct Binding<'a> {
    /// What they hang on.
    pub skeleton: &'a Skeleton,
    /// For each vertex `sets` groups of four joints of the skin.
    pub joints: &'a [[u16; 4]],
    /// How much they hang on each: none negative, together 1 for each vertex.
    pub weights: &'a [[f32; 4]],
    /// Groups of four a vertex.
    pub sets: u32,
}

/// A mesh whose vertices move: morphed first, then skinned.
#[derive(Clone, Copy, Debug)]
pub struct DeformedMesh<'a> {
    /// Where its vertices are before anything moves them.
    pub positions: &'a [[f32; 3]],
    /// What its morph targets add to them; each is empty or as long as `positions`.
    pub targets: &'a [&'a [[f32; 3]]],
    /// The node of the file that has the mesh: its weights move the targets.
    pub node: NodeId,
    /// What it hangs on. Boxes are in the space of [`Skeleton::space`]; without, in that of `node`.
    pub binding: Option<Binding<'a>>,
}
