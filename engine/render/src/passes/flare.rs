//! The flare pass: counts the samples of blocks at the places of lights, and adds glows and ghosts
//! to a finished image.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{
    Attachments, Blend, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline,
    GraphicsPipelineInfo, OptionalFeature, StorageLayout,
};

use occlusion::{Error, ShaderSet};

/// The number of levels by which the count of a transmitted block resolves the transmittance of a
/// pixel.
pub(crate) const TRANSMITTANCE_LEVELS: u32 = 32;

/// The vertices of two triangles.
const SQUARE_VERTICES: u32 = 6;

/// The pass of lens flares.
pub struct FlarePass {
    total: GraphicsPipeline,
    visible: GraphicsPipeline,
    /// `None` if fragment shaders cannot write the transmittance.
    transmitted: Option<GraphicsPipeline>,
    sprites: GraphicsPipeline,
}

/// The samples of a block to count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockCount {
    /// All samples in the image.
    Total,
    /// The samples at which the finished depth is not nearer.
    Visible,
    /// The samples at which the finished depth is not nearer, [`TRANSMITTANCE_LEVELS`] times each,
    /// less the levels that transparent objects take.
    Transmitted,
}

/// The buffers of the counts. Blocks, transmittance and the finished depth are read; nothing is
/// written.
#[derive(Clone, Copy)]
pub struct FlareBlockIo {
    /// A [`FlareBlockRow`] per block.
    pub blocks: BufferSlice,
    /// The light that transparent objects take at each pixel of the blocks, if there are any.
    pub transmittance: Option<BufferSlice>,
}

impl FlareBlockIo {
    /// Returns the counts of each block, in the order of their queries.
    pub fn kinds(&self) -> &'static [BlockCount] {
        const KINDS: [BlockCount; 3] =
            [BlockCount::Total, BlockCount::Visible, BlockCount::Transmitted];
        let count = if self.transmittance.is_some() { 3 } else { 2 };
        KINDS.get(..count).unwrap_or(&KINDS)
    }
}

/// A block in the form that the shaders read.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct FlareBlockRow {
    /// Upper left corner in the image of the view (pixels).
    pub low: [i32; 2],
    /// The upper left corner in the target (pixels).
    pub target_low: [i32; 2],
    /// The length of a side (pixels).
    pub side: u32,
    /// The stored depth of the light.
    pub depth: f32,
    /// The index of its first pixel among the pixels of all blocks.
    pub first_cell: u32,
    /// Padding, 0.
    pub unused: u32,
}

/// The shape of a sprite.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct FlareShape(u32);

impl FlareShape {
    /// A glow, brightest in its middle.
    pub const GLOW: Self = Self(0);
    /// A disk with a bright rim.
    pub const GHOST: Self = Self(1);
}

/// A soft sprite of a flare, in the form that the shaders read.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct FlareSprite {
    /// The middle, in normalised device coordinates.
    pub middle: [f32; 2],
    /// The horizontal and vertical radius, in normalised device coordinates.
    pub radius: [f32; 2],
    /// The linear red, green and blue that its brightest point adds.
    pub colour: [f32; 3],
    /// The shape.
    pub shape: FlareShape,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    clip_per_pixel: [f32; 2],
    levels: u32,
}

const _: () = assert!(size_of::<Constants>() == 12);
const _: () = assert!(size_of::<FlareBlockRow>() == 32);
const _: () = assert!(size_of::<FlareSprite>() == 32);

impl FlarePass {
    /// Compiles the pass for renderings to `attachments`.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let block = shaders.find("flare_block.vert")?;
        let sprite = shaders.find("flare.vert")?;
        let counted = |name, depth| GraphicsPipelineInfo {
            storage: StorageLayout::new::<Constants>(1),
            depth,
            attachments,
            // A transmitted block has [`TRANSMITTANCE_LEVELS`] instances.
            instance_bytes: size_of::<FlareBlockRow>() as u32 / TRANSMITTANCE_LEVELS,
            ..GraphicsPipelineInfo::of(name, block)
        };
        let transmitted = GraphicsPipelineInfo {
            fragment: Some(shaders.find("flare_block.frag")?),
            storage: StorageLayout::new::<Constants>(2),
            ..counted("transmitted flares", DepthMode::TestOnly)
        };
        let sprites = GraphicsPipelineInfo {
            fragment: Some(shaders.find("flare.frag")?),
            storage: StorageLayout { buffers: 1, ..StorageLayout::default() },
            depth: DepthMode::Ignored,
            // With an alpha of 0, this adds.
            blend: Blend::Premultiplied,
            attachments,
            ..GraphicsPipelineInfo::of("lens flares", sprite).numbered::<FlareSprite>()
        };
        let pipeline = |info| GraphicsPipeline::new(device, &info);
        let can_transmittance = device.capabilities().has(OptionalFeature::FragmentStores);
        Ok(Self {
            total: pipeline(counted("flares in the image", DepthMode::Ignored))?,
            visible: pipeline(counted("visible flares", DepthMode::TestOnly))?,
            transmitted: can_transmittance.then(|| pipeline(transmitted)).transpose()?,
            sprites: pipeline(sprites)?,
        })
    }

    /// Binds everything for one kind of count. The caller then records [`FlarePass::draw_block`]
    /// for each block.
    pub fn bind_blocks(
        &self,
        commands: &Commands,
        kind: BlockCount,
        io: &FlareBlockIo,
        view: &CullView,
    ) {
        let bind = |pipeline, buffers: &[BufferSlice]| {
            commands.bind(pipeline, buffers);
            let clip_per_pixel = view.size.map(|side| 2.0 / side as f32);
            commands.push_constants(pipeline, &Constants { clip_per_pixel, levels: levels(kind) });
        };
        match (kind, &self.transmitted, io.transmittance) {
            (BlockCount::Total, ..) => bind(&self.total, &[io.blocks]),
            (BlockCount::Transmitted, Some(pipeline), Some(transmittance)) => {
                bind(pipeline, &[io.blocks, transmittance])
            }
            _ => bind(&self.visible, &[io.blocks]),
        }
    }

    /// Draws a block, for a query to count.
    pub fn draw_block(&self, commands: &Commands, kind: BlockCount, number: u32) {
        let levels = levels(kind);
        commands.draw_instances(SQUARE_VERTICES, number * levels..(number + 1) * levels);
    }

    /// Adds sprites to the colour that is being rendered to.
    pub fn draw_sprites(&self, commands: &Commands, sprites: BufferSlice, count: u32) {
        commands.bind(&self.sprites, &[sprites]);
        commands.draw_instances(SQUARE_VERTICES, 0..count);
    }
}

/// Returns the number of times that a count draws each block.
fn levels(kind: BlockCount) -> u32 {
    if kind == BlockCount::Transmitted { TRANSMITTANCE_LEVELS } else { 1 }
}
