//! The limits on a file's demands.

const MIB: u64 = 1 << 20;

/// The limits on a file's demands. Reading a file takes at most [`Limits::memory_bound`] bytes at
/// any time. The counts bound the resulting scene.
///
/// All limits are inclusive and checked before memory is allocated.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Bytes of the file itself. Default: 1 GiB.
    pub file_bytes: u64,
    /// Bytes of the file's JSON. Default: 256 MiB.
    pub json_bytes: u64,
    /// Bytes that the JSON takes once it is read, by a cautious estimate: an empty node has two
    /// characters in the file, but some hundred bytes in memory. Default: 1 GiB.
    pub json_memory_bytes: u64,
    /// Bytes of all buffers together that are outside of the file, in data URIs, or decompressed.
    /// Default: 1 GiB.
    pub buffer_bytes: u64,
    /// Pixels along a side of an image. Default: 16384.
    pub image_side: u32,
    /// Bytes of all images together, decoded to four bytes per pixel. Compressed blocks count as
    /// decoded, since some devices do not support them. Default: 2 GiB.
    pub image_bytes: u64,
    /// Bytes in use at any time for decoding images, in addition to the images. An image that needs
    /// more is refused. Default: 2 GiB.
    pub image_scratch_bytes: u64,
    /// Elements of all accessors together, even if accessors share bytes. Default: 2^29.
    pub elements: u64,
    /// Vertices of all meshes, counted as in [`Source`](crate::Source). Default: 2^25.
    pub vertices: u64,
    /// Vertices of all primitives, counted by the lengths of their accessors: with vertices that no
    /// index refers to, and once per primitive. A single primitive may have [`Limits::vertices`].
    /// Default: 2^28.
    pub listed_vertices: u64,
    /// Corners of the triangles of all meshes, counted like [`Limits::vertices`]. Default: 2^27.
    pub corners: u64,
    /// Nodes. Default: 2^20.
    pub nodes: u64,
    /// Vertices of skinned meshes, once per place of the mesh. Default: the number that a renderer
    /// supports on any device, about 3.3 million.
    pub skinned_vertices: u64,
    /// Primitives on nodes, once per instance of the node. Default: the number that a renderer
    /// supports on any device, 2^21.
    pub objects: u64,
    /// Joints of skins, once per primitive that uses the skin. Default: 2^21.
    pub joints: u64,
    /// Nodes between the joints of a skin and their common ancestor, for each skin and each set of
    /// its joints that a mesh uses. Default: 2^24.
    pub bones: u64,
    /// Lights on the nodes of the scene. Default, and largest value: 2^16.
    pub lights: u64,
    /// Numbers in the inputs and outputs of all animation channels. Default: 2^26.
    pub key_values: u64,
    /// Numbers in the morph targets, joints and weights of all meshes, once per node or instance of
    /// the mesh. Default: 2^27.
    pub morph_values: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 1024 * MIB,
            json_bytes: 256 * MIB,
            json_memory_bytes: 1024 * MIB,
            buffer_bytes: 1024 * MIB,
            image_side: 16384,
            image_bytes: 2048 * MIB,
            image_scratch_bytes: 2048 * MIB,
            elements: 1 << 29,
            vertices: 1 << 25,
            listed_vertices: 1 << 28,
            corners: 1 << 27,
            nodes: 1 << 20,
            objects: scene::limits::OBJECTS_ANYWHERE,
            skinned_vertices: scene::limits::SKINNED_VERTICES_ANYWHERE,
            joints: 1 << 21,
            bones: 1 << 24,
            lights: 1 << 16,
            key_values: 1 << 26,
            morph_values: 1 << 27,
        }
    }
}

impl Limits {
    /// Returns the most bytes in use at any time while a file is read: 10.1 GiB with the defaults,
    /// for a file that exhausts all limits.
    ///
    /// It is the sum of the file, its JSON (in several forms), its buffers (compressed and
    /// decompressed), its images, and the scratch memory of decoding, plus 48 MiB for tables and
    /// stacks.
    pub fn memory_bound(&self) -> u64 {
        [
            self.file_bytes,
            self.json_memory_bytes.saturating_mul(3),
            self.buffer_bytes.saturating_mul(2),
            self.image_bytes,
            self.image_scratch_bytes,
            48 * MIB,
        ]
        .into_iter()
        .fold(0, u64::saturating_add)
    }
}
