//! The sky pass: a colour or an environment where no object was drawn.

use bytemuck::{Pod, Zeroable};
use cull::{CullView, ProjectionKind, trigonometry};
use glam::Vec3;
use gpu::{
    Attachments, Blend, BufferSlice, Commands, Device, GraphicsPipeline, GraphicsPipelineInfo,
    SampledArrays, StorageLayout, TextureArray,
};

use occlusion::{Error, ShaderSet};
use scene::{Backdrop, Environment, Sky, SkyDisk};

/// The pass that draws a triangle over the whole area at the farthest depth, which is visible where
/// nothing is nearer.
pub struct SkyPass {
    plain: GraphicsPipeline,
    around: GraphicsPipeline,
    panorama: GraphicsPipeline,
}

/// The inputs of [`SkyPass::draw_around`]: the sky and, if there is one, the panorama are read.
#[derive(Clone, Copy)]
pub(crate) struct SkyIo<'a> {
    /// One [`SkyRow`].
    pub(crate) sky: BufferSlice,
    /// The panorama; `None` if the sky is computed.
    pub(crate) panorama: Option<&'a TextureArray>,
}

/// The backdrop of an environment, in the form that `sky_main.glsl` reads.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct SkyRow {
    /// The direction to the sun. Its last value and the last values of the colours are 0.
    pub towards_sun: [f32; 4],
    /// As in [`Sky`].
    pub zenith: [f32; 4],
    /// As in [`Sky`].
    pub horizon: [f32; 4],
    /// As in [`Sky`].
    pub ground: [f32; 4],
    /// As in [`Sky`].
    pub glow: [f32; 4],
    /// The direction to the middle of the disk, and the distance from there to its edge on the unit
    /// sphere.
    pub disk: [f32; 4],
    /// The radiance of the disk, and the distance at which its edge begins to fade.
    pub radiance: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    sky: [f32; 4],
}

const _: () = assert!(size_of::<Constants>() == 16);

/// Rays through the image, and their positions in it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct AroundConstants {
    middle: [f32; 4],
    right: [f32; 4],
    down: [f32; 4],
    size: [f32; 2],
}

const _: () = assert!(size_of::<AroundConstants>() == 56);

/// The share of a disk's radius over which its edge fades.
const DISK_EDGE: f32 = 0.15;

impl SkyRow {
    /// Returns the backdrop of an environment; for a panorama it is dark except for the disk.
    pub(crate) fn of(environment: &Environment) -> Self {
        let dark = [0.0; 3];
        let nowhere =
            Sky { towards_sun: Vec3::Y, zenith: dark, horizon: dark, ground: dark, glow: dark };
        let Sky { towards_sun, zenith, horizon, ground, glow } = match environment.backdrop() {
            Backdrop::Sky(sky) => *sky,
            Backdrop::Panorama(_) => nowhere,
        };
        let none = SkyDisk { towards: Vec3::Y, radius_rad: 0.0, radiance: dark };
        let disk = environment.disk().copied().unwrap_or(none);
        // Distances on the unit sphere at both ends of the disk's edge. They are compared in place
        // of cosines, which have too few digits for small angles.
        let distance = |share: f32| 2.0 * trigonometry::sin(0.5 * disk.radius_rad * share);
        let outer = distance(1.0);
        let inner = distance(1.0 - DISK_EDGE);
        let with = |[x, y, z]: [f32; 3], w| [x, y, z, w];
        Self {
            towards_sun: with(towards_sun.to_array(), 0.0),
            zenith: with(zenith, 0.0),
            horizon: with(horizon, 0.0),
            ground: with(ground, 0.0),
            glow: with(glow, 0.0),
            disk: with(disk.towards.to_array(), outer),
            radiance: with(disk.radiance, inner),
        }
    }
}

impl SkyPass {
    /// Compiles the pass for renderings to `attachments`.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let plain = GraphicsPipelineInfo {
            fragment: Some(shaders.find("sky.frag")?),
            storage: StorageLayout::new::<Constants>(0),
            blend: Blend::Opaque,
            attachments,
            ..GraphicsPipelineInfo::of("sky", shaders.find("sky.vert")?)
        };
        let around = GraphicsPipelineInfo {
            name: "sky around",
            fragment: Some(shaders.find("sky_around.frag")?),
            storage: StorageLayout::new::<AroundConstants>(1),
            ..plain
        };
        let panorama = GraphicsPipelineInfo {
            name: "sky panorama",
            fragment: Some(shaders.find("sky_panorama.frag")?),
            storage: StorageLayout { texture_arrays: 1, ..around.storage },
            ..plain
        };
        Ok(Self {
            plain: GraphicsPipeline::new(device, &plain)?,
            around: GraphicsPipeline::new(device, &around)?,
            panorama: GraphicsPipeline::new(device, &panorama)?,
        })
    }

    /// Draws the sky in a linear colour, against the present depth.
    pub fn draw(&self, commands: &Commands, sky: [f32; 3]) {
        let [red, green, blue] = sky;
        commands.bind(&self.plain, &[]);
        commands.push_constants(&self.plain, &Constants { sky: [red, green, blue, 1.0] });
        commands.draw(3, 0);
    }

    /// Draws an environment in a view, with a factor on all light.
    pub(crate) fn draw_around(
        &self,
        commands: &Commands,
        io: &SkyIo<'_>,
        view: &CullView,
        exposure: f32,
    ) {
        let [x, y] = view.origin.map(|pixel| pixel as f32);
        let constants = AroundConstants {
            middle: view.rays.middle.extend(exposure).to_array(),
            right: view.rays.right.extend(x).to_array(),
            down: view.rays.down.extend(y).to_array(),
            size: view.size.map(|side| side as f32),
        };
        // The rays of an orthographic view are parallel.
        let constants = match view.rays.kind {
            ProjectionKind::Perspective => constants,
            ProjectionKind::Orthographic => {
                let still = |[.., edge]: [f32; 4]| [0.0, 0.0, 0.0, edge];
                let middle = view.rays.forward.extend(exposure).to_array();
                let right = still(constants.right);
                let down = still(constants.down);
                AroundConstants { middle, right, down, ..constants }
            }
        };
        let arrays = io.panorama.as_slice();
        let pipeline = if arrays.is_empty() { &self.around } else { &self.panorama };
        commands.bind_sampled(pipeline, &[io.sky], &[], SampledArrays::Few(arrays));
        commands.push_constants(pipeline, &constants);
        commands.draw(3, 0);
    }
}
