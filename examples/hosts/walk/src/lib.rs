//! The scene of the host programs: a wall with a thousand boxes behind it, and a camera that walks
//! by.

#[cfg(feature = "ash")]
mod ash_device;
#[cfg(feature = "ash")]
mod ash_resources;
#[cfg(feature = "ash")]
mod instance;
#[cfg(feature = "ash")]
mod pipelines;

use std::ops::Range;

use cull::{Aabb, Camera, Projection};
use glam::{Vec3, vec3};

#[cfg(feature = "ash")]
pub use ash_device::AshDevice;
#[cfg(feature = "ash")]
pub use ash_resources::{AshBuffer, AshImage};
#[cfg(feature = "ash")]
pub use instance::HostInstance;
#[cfg(feature = "ash")]
pub use pipelines::{BoxGeometry, BoxPipelines, ViewConstants};

/// The size of the images in pixels.
pub const SIZE: [u32; 2] = [320, 180];

/// The number of frames of the walk.
pub const FRAMES: u64 = 48;

/// The number of buckets: pipelines that draw parts.
pub const BUCKETS: u32 = 2;

/// The vertex shader, compiled: a box per instance, two attributes of three floats each. Its push
/// constants are a matrix and the steps of the sub-pixel grid.
pub const BOX_VERT: &[u8] = include_bytes!("../shaders/box.vert.spv");

/// The fragment shaders of the buckets, compiled.
pub const FRAGMENTS: [&[u8]; BUCKETS as usize] =
    [include_bytes!("../shaders/plain.frag.spv"), include_bytes!("../shaders/striped.frag.spv")];

/// The triangles of a box, whose corners have the numbers 0 to 7: a bit per axis.
pub const INDICES: [u32; 36] = [
    0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, //
    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5,
];

/// A part of an object: a box, drawn in a bucket. Its number is that of its instance.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// The box.
    pub bounds: Aabb,
    /// The pipeline that draws it.
    pub bucket: u32,
}

/// An object: a range of parts, and the box around them.
#[derive(Clone, Debug)]
pub struct WalkObject {
    /// The box around all parts.
    pub bounds: Aabb,
    /// The numbers of the parts.
    pub parts: Range<u32>,
}

/// The objects, and the parts of all of them.
#[derive(Clone, Debug, Default)]
pub struct BoxScene {
    /// The objects.
    pub objects: Vec<WalkObject>,
    /// The parts.
    pub parts: Vec<Part>,
}

impl BoxScene {
    /// Creates the wall, and the boxes behind it, of which each seventh has a lid of the other
    /// bucket.
    #[must_use]
    pub fn new() -> Self {
        let mut scene = Self::default();
        scene.add(&[Part {
            bounds: Aabb::new(vec3(-4.0, -3.0, -6.0), vec3(4.0, 3.0, -5.5)),
            bucket: 0,
        }]);
        for number in 0..1_000 {
            let [x, y, z] = [number % 20, number / 20 % 10, number / 200].map(|part| part as f32);
            let low = vec3(x * 0.7 - 7.0, y * 0.7 - 3.5, -12.0 - z * 1.3 - 0.01 * x);
            let high = low + Vec3::splat(0.45);
            let lid = Aabb::new(vec3(low.x, high.y + 0.01, low.z), high + vec3(0.0, 0.06, 0.0));
            let parts = [(Aabb::new(low, high), number % 2), (lid, (number + 1) % 2)]
                .map(|(bounds, bucket)| Part { bounds, bucket });
            scene.add(if number % 7 == 0 { &parts } else { &parts[..1] });
        }
        scene
    }

    /// Returns the low and the high corner of each part, as the vertex shader reads them.
    #[must_use]
    pub fn corners(&self) -> Vec<[[f32; 3]; 2]> {
        self.parts
            .iter()
            .map(|part| [part.bounds.min.to_array(), part.bounds.max.to_array()])
            .collect()
    }

    fn add(&mut self, parts: &[Part]) {
        let first = self.parts.len() as u32;
        self.parts.extend(parts);
        let bounds = parts.iter().fold(Aabb::EMPTY, |all, part| all.union(&part.bounds));
        self.objects.push(WalkObject { bounds, parts: first..self.parts.len() as u32 });
    }
}

/// Returns the camera of a frame: it moves, and jumps to another side of the wall at times.
#[must_use]
pub fn camera(frame: u64) -> Camera {
    let side = (frame / 12 % 3) as f32 - 1.0;
    let eye = vec3(side * 9.0 + frame as f32 * 0.04, 0.0, 3.0);
    let projection = Projection::perspective(0.9);
    Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 }
}

/// Compares the images of two walks, prints the outcome, and returns true if they are the same to
/// the bit and something was left out.
#[must_use]
pub fn report(host: &str, plain: &DrawnWalk, culled: &DrawnWalk) -> bool {
    let differ = plain.images.iter().zip(&culled.images).filter(|(a, b)| a != b).count();
    let is_blank = culled.images.iter().any(|image| image.iter().all(|byte| *byte == image[0]));
    let complete = culled.images.len() as u64 == FRAMES && plain.images.len() as u64 == FRAMES;
    println!(
        "{host}: {} draws in the last frame with frustum culling, {} with occlusion culling; \
         {differ} of {} images differ",
        plain.draws,
        culled.draws,
        culled.images.len(),
    );
    complete && differ == 0 && !is_blank && culled.draws < plain.draws / 2
}

/// A walk that was drawn.
#[derive(Clone, Debug, Default)]
pub struct DrawnWalk {
    /// The bytes of the image of each frame.
    pub images: Vec<Vec<u8>>,
    /// The draws of the last frame that is known.
    pub draws: u64,
}
