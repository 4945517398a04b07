//! The sky pass: a colour, or the light from all around, where nothing was drawn.

use bytemuck::{Pod, Zeroable};
use cull::{ProjectionKind, View};
use glam::Vec3;
use gpu::{
    Attachments, Blend, Commands, Device, GraphicsPipeline, GraphicsPipelineInfo, SampledArrays,
    StorageLayout,
};

use occlusion::{Error, ShaderSet};
use scene::SkyDisk;

use crate::shading::environment_texture::EnvironmentTexture;

/// The pass that draws one triangle over all of the area at the farthest depth: it shows where
/// nothing is nearer.
pub struct SkyPass {
    plain: GraphicsPipeline,
    around: GraphicsPipeline,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    sky: [f32; 4],
}

const _: () = assert!(size_of::<Constants>() == 16);

/// Rays through the image, and their places in it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct AroundConstants {
    middle: [f32; 4],
    right: [f32; 4],
    down: [f32; 4],
    size: [f32; 4],
    disk: [f32; 4],
    radiance: [f32; 4],
}

const _: () = assert!(size_of::<AroundConstants>() == 96);

/// The share of its radius over which the edge of a disk fades.
const DISK_EDGE: f32 = 0.15;

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
            storage: StorageLayout { textures: 1, ..StorageLayout::new::<AroundConstants>(0) },
            ..plain
        };
        Ok(Self {
            plain: GraphicsPipeline::new(device, &plain)?,
            around: GraphicsPipeline::new(device, &around)?,
        })
    }

    /// Draws the sky in a linear colour, against the depth that is there.
    pub fn draw(&self, commands: &Commands, sky: [f32; 3]) {
        let [red, green, blue] = sky;
        commands.bind(&self.plain, &[]);
        commands.push_constants(&self.plain, &Constants { sky: [red, green, blue, 1.0] });
        commands.draw(3, 0);
    }

    /// Draws an environment as a view sees it, with a factor of all light.
    pub(crate) fn draw_around(
        &self,
        commands: &Commands,
        environment: &EnvironmentTexture,
        (view, exposure): (&View, f32),
    ) {
        let radius_rad = environment.disk().map_or(0.0, |disk| disk.radius_rad);
        // The part of a unit vector that lies along the middle of the disk, at both ends of its
        // edge: small angles have no digits left in their cosine, so their distance is compared.
        let [outer, inner] =
            [1.0, 1.0 - DISK_EDGE].map(|share: f32| 2.0 * (0.5 * radius_rad * share).sin());
        let nowhere = SkyDisk { towards: Vec3::Y, radius_rad, radiance: [0.0; 3] };
        let disk = environment.disk().copied().unwrap_or(nowhere);
        let [x, y] = view.origin.map(|pixel| pixel as f32);
        let [width, height] = view.size.map(|side| side as f32);
        let constants = AroundConstants {
            middle: view.rays.middle.extend(exposure).to_array(),
            right: view.rays.right.extend(x).to_array(),
            down: view.rays.down.extend(y).to_array(),
            size: [width, height, 0.0, 0.0],
            disk: disk.towards.extend(outer).to_array(),
            radiance: Vec3::from_array(disk.radiance).extend(inner).to_array(),
        };
        // The rays of an orthographic view are parallel.
        let constants = match view.rays.kind {
            ProjectionKind::Perspective => constants,
            ProjectionKind::Orthographic => {
                let still = |[.., edge]: [f32; 4]| [0.0, 0.0, 0.0, edge];
                let middle = view.rays.forward.extend(exposure).to_array();
                let (right, down) = (still(constants.right), still(constants.down));
                AroundConstants { middle, right, down, ..constants }
            }
        };
        commands.bind_sampled(&self.around, &[], &[environment.sampled()], SampledArrays::NONE);
        commands.push_constants(&self.around, &constants);
        commands.draw(3, 0);
    }
}
