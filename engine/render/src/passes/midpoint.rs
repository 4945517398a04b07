//! The midpoint pass: shadow maps with depths halfway between the two sides of casters.

use ::shadows::MIDPOINT_TEXELS;
use bytemuck::{Pod, Zeroable};
use cull::{CullView, ProjectionKind};
use gpu::{
    Commands, DepthLayers, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo,
    SampledArrays, SampledTexture, StorageLayout,
};
use occlusion::{Error, ShaderSet};

/// The pass that writes midpoints to [`DepthLayers`], over cleared tiles.
pub(crate) struct MidpointPass {
    pipeline: GraphicsPipeline,
}

/// The inputs of the pass: the depths of both sides, at the places of the tiles, are read.
#[derive(Clone, Copy)]
pub(crate) struct MidpointIo<'a> {
    /// The nearest depths of the faces towards the light.
    pub(crate) fronts: SampledTexture<'a>,
    /// The nearest depths of the faces away from the light.
    pub(crate) backs: SampledTexture<'a>,
}

/// A tile of the pass.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct MidpointTile {
    /// The highest distance by which a front is moved, in depth: a constant, and a factor on its
    /// depth.
    reach: [f32; 2],
    layer: u32,
}

impl MidpointTile {
    /// Creates the tile of a light's view in a layer.
    pub(crate) fn new(view: &CullView, layer: u32) -> Self {
        let [_, scaled] = view.rays.depth;
        // The image is a square. Depth falls with the distance, either linearly or as its inverse.
        let side_m = 2.0 * view.rays.right.length();
        let texels = MIDPOINT_TEXELS / view.size[0].max(1) as f32;
        let reach = match view.rays.kind {
            ProjectionKind::Orthographic => [texels * side_m * scaled.abs(), 0.0],
            ProjectionKind::Perspective => [0.0, texels * side_m],
        };
        Self { reach, layer }
    }
}

impl MidpointPass {
    /// Compiles the pass.
    pub(crate) fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let info = GraphicsPipelineInfo {
            fragment: Some(shaders.find("midpoint.frag")?),
            storage: StorageLayout { textures: 2, ..StorageLayout::new::<MidpointTile>(0) },
            depth: DepthMode::TestAndWrite,
            attachments: DepthLayers::attachments(),
            ..GraphicsPipelineInfo::of("midpoints", shaders.find("sky.vert")?)
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &info)? })
    }

    /// Binds everything except the tile.
    pub(crate) fn bind(&self, commands: &Commands, io: &MidpointIo<'_>) {
        commands.bind_sampled(&self.pipeline, &[], &[io.fronts, io.backs], SampledArrays::NONE);
    }

    /// Draws a tile, which the viewport covers.
    pub(crate) fn draw(&self, commands: &Commands, tile: &MidpointTile) {
        commands.push_constants(&self.pipeline, tile);
        commands.draw(3, 0);
    }
}

#[cfg(test)]
mod tests {
    use cull::{Camera, Projection};
    use glam::Vec3;

    use super::*;

    /// Returns the depth at a distance in front of a view's eye.
    fn depth_at(view: &CullView, distance_m: f32) -> f32 {
        let clip = view.view_proj * (Vec3::NEG_Z * distance_m).extend(1.0);
        clip.z / clip.w
    }

    #[test]
    fn reaches_are_so_many_texels_deep_at_every_distance() {
        let perspective = Projection::perspective(1.0);
        let orthographic = Projection::Orthographic { height: 20.0, far: 60.0 };
        for (projection, side_at) in
            [(perspective, 2.0 * 0.5_f32.tan()), (orthographic, 20.0 / 10.0)]
        {
            let forward = Vec3::NEG_Z;
            let up = Vec3::Y;
            let camera = Camera { eye: Vec3::ZERO, forward, up, projection, near: 0.05 };
            let view = CullView::new(&camera, [512; 2], 8);
            let MidpointTile { reach: [constant, scaled], layer } = MidpointTile::new(&view, 3);
            assert_eq!(layer, 3);
            // A tile that widens is ten times as wide here as at 1 m.
            let side_m = 10.0 * side_at;
            let moved_m = 10.0 + MIDPOINT_TEXELS * side_m / 512.0;
            let near = depth_at(&view, 10.0);
            let far = depth_at(&view, moved_m);
            let found = constant + scaled * near;
            assert!((found / (near - far) - 1.0).abs() < 0.05, "{found} of {}", near - far);
        }
    }
}
