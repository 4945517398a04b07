//! The volume pass: stencil shadow volumes against an existing depth, and a mask of the pixels that
//! are in the shadow of each light.
//!
//! ```text
//! copy depth      depth -> depth with a stencil beside it
//! per light       extrude casters (a geometry shader, or a compute pass before), those of a group
//!                 that is culled under predicates
//!                 count their boundaries in the stencil
//!                 set the light's bits in the mask where the count is not 0
//! ```

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use glam::Vec4;
use gpu::{
    Access, AttachmentStore, Buffer, BufferSlice, Commands, DepthMode, DepthRange, Device, Frame,
    GraphicsPipeline, GraphicsPipelineInfo, IndirectDraw, MemoryBarrier, MemoryKind,
    OptionalFeature, StencilMode, StencilTarget, StorageLayout, Target, VertexLayout, vk,
};
use occlusion::{Error, ShaderSet};
use shadows::{LitArea, VolumeCounting, VolumeEnd};

use super::opaque::POSITIONS;
use super::volume_constants::{VolumeConstants, VolumeGroup};
use super::volume_extruder::{Batch, Extruder};
use crate::resources::instance::Instance;

/// The shader stage that extrudes volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VolumePath {
    /// A geometry shader. For devices with [`OptionalFeature::GeometryShaders`].
    GeometryShader,
    /// A compute pass, which every device has.
    Compute,
}

impl VolumePath {
    /// Returns the path for a device.
    pub fn of(device: &Device) -> Self {
        if device.capabilities().has(OptionalFeature::GeometryShaders) {
            Self::GeometryShader
        } else {
            Self::Compute
        }
    }
}

/// An object that casts a shadow.
#[derive(Clone, Copy, Debug)]
pub struct VolumeCaster {
    /// The draw of its triangles with adjacency, six indices each. The first instance is its leaf.
    pub draw: IndirectDraw,
    /// The group that it is drawn with.
    pub group: VolumeGroup,
}

/// A light, and the objects that may cast shadows on visible surfaces.
#[derive(Clone, Copy, Debug)]
pub struct VolumeLight<'a> {
    /// The light in homogeneous coordinates: a point with w = 1, or the direction towards it with
    /// w = 0.
    pub light: Vec4,
    /// The far ends of its volumes.
    pub ends: &'a [VolumeEnd],
    /// The bits that are set in the mask where the light is shadowed.
    pub bits: u32,
    /// The layer of the mask.
    pub layer: u32,
    /// The part of the view that the light reaches. Nothing is shadowed elsewhere.
    pub area: LitArea,
    /// The objects.
    pub casters: VolumeCasters<'a>,
}

/// The objects that cast shadows under a light.
#[derive(Clone, Copy, Debug)]
pub enum VolumeCasters<'a> {
    /// All objects of a list.
    All(&'a [VolumeCaster]),
    /// Groups of objects, each with the index by which its owner knows it. The owner draws them,
    /// for [`VolumePath::GeometryShader`].
    Culled(&'a [(VolumeGroup, usize)]),
}

/// The buffers of the pass. Vertices, adjacency and instances are read; the mask is written.
#[derive(Clone, Copy)]
pub struct VolumeIo {
    /// The vertices of all meshes, also a storage buffer for [`VolumePath::Compute`].
    pub vertices: BufferSlice,
    /// The adjacency of all meshes ([`shadows::VolumeMesh::triangles`]), 32-bit indices; also a
    /// storage buffer for [`VolumePath::Compute`].
    pub adjacency: BufferSlice,
    /// An instance per leaf.
    pub instances: BufferSlice,
    /// The mask: 32 bits per pixel of the view, in rows from the top without gaps, with all layers
    /// that lights name.
    pub mask: BufferSlice,
}

/// The draws of the volumes of some lights in one frame.
pub struct VolumeDraws {
    lights: Vec<LightDraws>,
}

/// The draws of one light.
struct LightDraws {
    light: Vec4,
    ends: Vec<VolumeEnd>,
    area: LitArea,
    mask: MaskBits,
    work: Vec<(VolumeGroup, Work)>,
}

/// The bits of a light in the mask.
#[derive(Clone, Copy)]
struct MaskBits {
    bits: u32,
    layer: u32,
}

/// A closure that draws the culled group of an index.
pub type DrawGroup<'a> = &'a dyn Fn(&Commands, usize);

/// The casters of a group on the GPU.
enum Work {
    /// A group that its owner draws.
    Culled(usize),
    /// Indirect draws, for the geometry shader.
    Draws(BufferSlice),
    /// Jobs of the compute pass.
    Batch(Batch),
}

/// The pass that finds the pixels in shadow.
pub struct VolumePass {
    target: StencilTarget,
    depths: Buffer,
    /// A draw count that exceeds every number of draws.
    all: Buffer,
    passing: GraphicsPipeline,
    failing: GraphicsPipeline,
    mask: GraphicsPipeline,
    extruder: Option<Extruder>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct MaskConstants {
    width: u32,
    bits: u32,
    first: u32,
}

const _: () = assert!(size_of::<MaskConstants>() == 12);

impl VolumePass {
    /// Compiles the pass for views of at most `size` pixels.
    ///
    /// # Errors
    /// A size beyond the device's limits, a device that lacks what the path or the stencil needs
    /// ([`StencilTarget::new`]) or [`OptionalFeature::FragmentStores`], no memory, a failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        size: [u32; 2],
        path: VolumePath,
    ) -> Result<Self, Error> {
        device.require(OptionalFeature::FragmentStores, "a mask of shadows")?;
        let (target, depths) = images(device, size)?;
        let is_compute = path == VolumePath::Compute;
        let [passing, failing] = [StencilMode::CountPassing, StencilMode::CountFailing]
            .map(|stencil| volume_pipeline(device, shaders, path, stencil));
        let mask = GraphicsPipelineInfo {
            fragment: Some(shaders.find("volume_mask.frag")?),
            storage: StorageLayout::new::<MaskConstants>(1),
            depth: DepthMode::Ignored,
            stencil: StencilMode::Counted,
            attachments: StencilTarget::attachments(),
            ..GraphicsPipelineInfo::of("shadow mask", shaders.find("sky.vert")?)
        };
        let mask = GraphicsPipeline::new(device, &mask)?;
        let extruder = is_compute.then(|| Extruder::new(device, shaders)).transpose()?;
        let most = [device.adapter().limits.max_draw_indirect_count.max(1)];
        let all = device.upload("all volumes", &most, vk::BufferUsageFlags::INDIRECT_BUFFER)?;
        let passing = passing?;
        let failing = failing?;
        Ok(Self { target, depths, all, passing, failing, mask, extruder })
    }

    /// Draws views of at most `size` pixels from now on.
    ///
    /// # Errors
    /// A size beyond the device's limits, no memory. Nothing has changed then.
    pub fn resize(&mut self, device: &Device, size: [u32; 2]) -> Result<(), Error> {
        (self.target, self.depths) = images(device, size)?;
        Ok(())
    }

    /// Uploads the casters of lights, for [`VolumePass::record`] in the same frame.
    ///
    /// # Errors
    /// No memory.
    pub fn prepare(
        &self,
        frame: &mut Frame<'_>,
        lights: &[VolumeLight<'_>],
    ) -> Result<VolumeDraws, Error> {
        let mut prepared = Vec::with_capacity(lights.len());
        for light in lights {
            let mask = MaskBits { bits: light.bits, layer: light.layer };
            let mut work = Vec::new();
            let all = match light.casters {
                VolumeCasters::All(casters) => casters,
                VolumeCasters::Culled(groups) => {
                    let culled =
                        |(group, number): &(VolumeGroup, usize)| (*group, Work::Culled(*number));
                    work.extend(groups.iter().map(culled));
                    &[]
                }
            };
            for group in VolumeGroup::all(light.ends.len()) {
                let casters = all.iter().filter(|caster| is_in(caster, group));
                let draws: Vec<IndirectDraw> = casters.map(|caster| caster.draw).collect();
                if draws.is_empty() {
                    continue;
                }
                if self.extruder.is_none() {
                    work.push((group, Work::Draws(frame.uploads().push(&draws)?)));
                    continue;
                }
                for jobs in Extruder::batches(draws.into_iter()) {
                    work.push((group, Work::Batch(Batch::upload(frame, &jobs)?)));
                }
            }
            let VolumeLight { light, ends, area, .. } = *light;
            prepared.push(LightDraws { light, ends: ends.to_vec(), area, mask, work });
        }
        Ok(VolumeDraws { lights: prepared })
    }

    /// Records the pass for a view. The mask gets each light's bits at the pixels in the volumes of
    /// its casters, and is 0 elsewhere. `from` holds the depth of the view, and must be prepared
    /// again before drawing to it. If the view is larger than the pass, nothing is shadowed.
    /// `culled` draws culled groups.
    pub fn record(
        &mut self,
        commands: &Commands,
        io: &VolumeIo,
        view: &CullView,
        from: &mut Target,
        draws: &VolumeDraws,
        culled: DrawGroup<'_>,
    ) {
        commands.pass("count shadow volumes", |commands| {
            let fits = (0..2).all(|side| view.size[side] <= self.target.size()[side]);
            self.load_depth(commands, io, view, from);
            match &self.extruder {
                _ if !fits => {}
                None => self.draw_lights(commands, io, view, &draws.lights, culled),
                Some(extruder) => {
                    for (number, light) in (1..).zip(&draws.lights) {
                        let last = if number == draws.lights.len() {
                            AttachmentStore::Forget
                        } else {
                            AttachmentStore::Keep
                        };
                        self.draw_extruded(commands, io, view, extruder, light, last);
                    }
                }
            }
            let uses = [Access::FragmentRead, Access::CopyRead];
            commands.barrier(MemoryBarrier::between(&[Access::FragmentWrite], &uses));
        });
    }

    /// Copies the depth of a view, and clears the mask.
    fn load_depth(
        &mut self,
        commands: &Commands,
        io: &VolumeIo,
        view: &CullView,
        from: &mut Target,
    ) {
        let between = MemoryBarrier::between;
        let depths = self.depths.whole();
        commands.barrier(between(&[Access::CopyRead, Access::FragmentRead], &[Access::CopyWrite]));
        if self.extruder.is_some() {
            // Vertices may belong to poses that were just computed.
            commands.barrier(between(&[Access::ComputeWrite], &[Access::ComputeRead]));
        }
        from.copy_depth_to(commands, view.origin, view.size, depths);
        commands.fill(io.mask, 0);
        let next = [Access::CopyRead, Access::FragmentWrite];
        commands.barrier(between(&[Access::CopyWrite], &next));
        self.target.load_depth(commands, depths, view.size);
    }

    /// Draws the volumes of all lights by the geometry shader.
    fn draw_lights(
        &self,
        commands: &Commands,
        io: &VolumeIo,
        view: &CullView,
        lights: &[LightDraws],
        culled: DrawGroup<'_>,
    ) {
        // Only the mask is read afterwards.
        let target = self.target.render_target(view.size).forgotten();
        commands.rendering(target, |commands| {
            for light in lights {
                begin_light(commands, light);
                for (group, work) in &light.work {
                    let pipeline = self.pipeline(group.counting);
                    commands.bind(pipeline, &[io.instances]);
                    commands.bind_geometry(io.vertices, Some(io.adjacency));
                    let constants = VolumeConstants::new(view, light.light, &light.ends, *group);
                    commands.push_constants(pipeline, &constants);
                    match work {
                        Work::Draws(draws) => {
                            commands.draw_all_indirect(*draws, self.all.whole());
                        }
                        Work::Culled(number) => culled(commands, *number),
                        Work::Batch(_) => {}
                    }
                }
                self.draw_mask(commands, io, view, light.mask);
            }
        });
    }

    /// Extrudes the volumes of a light batch by batch, and draws each batch. Only extruding breaks
    /// the rendering, which begins with the stencil after the previous light and ends with the mask
    /// of this one.
    fn draw_extruded(
        &self,
        commands: &Commands,
        io: &VolumeIo,
        view: &CullView,
        extruder: &Extruder,
        light: &LightDraws,
        last: AttachmentStore,
    ) {
        let batches = light.work.iter().filter_map(|(group, work)| match work {
            Work::Batch(batch) => Some((group, batch)),
            _ => None,
        });
        let mut batches = batches.peekable();
        let mut is_first = true;
        while is_first || batches.peek().is_some() {
            let next = batches.next();
            if let Some((group, batch)) = next {
                let constants = VolumeConstants::new(view, light.light, &light.ends, *group);
                extruder.extrude(commands, io, batch, &constants);
            }
            let is_last = batches.peek().is_none();
            let mut target = self.target.render_target(view.size);
            target.depth_store = if is_last { last } else { AttachmentStore::Keep };
            self.target.prepare(commands);
            commands.rendering(target, |commands| {
                if is_first {
                    begin_light(commands, light);
                }
                commands.clip(light.area.origin, light.area.size);
                if let Some((group, _)) = next {
                    commands.bind(self.pipeline(group.counting), &[]);
                    extruder.draw(commands, self.all.whole());
                }
                if is_last {
                    self.draw_mask(commands, io, view, light.mask);
                }
            });
            is_first = false;
        }
    }

    fn draw_mask(&self, commands: &Commands, io: &VolumeIo, view: &CullView, mask: MaskBits) {
        let [width, height] = view.size;
        let MaskBits { bits, layer } = mask;
        let first = layer.saturating_mul(width).saturating_mul(height);
        commands.bind(&self.mask, &[io.mask]);
        commands.push_constants(&self.mask, &MaskConstants { width, bits, first });
        commands.draw(3, 0);
    }

    fn pipeline(&self, counting: VolumeCounting) -> &GraphicsPipeline {
        match counting {
            VolumeCounting::ZPass => &self.passing,
            VolumeCounting::ZFail => &self.failing,
        }
    }
}

/// Creates the depth with a stencil, and the buffer through which depths are copied to it.
fn images(device: &Device, size: [u32; 2]) -> Result<(StencilTarget, Buffer), Error> {
    let target = StencilTarget::new(device, size, "shadow volumes")?;
    let size_bytes = size.iter().map(|side| u64::from(*side)).product::<u64>() * 4;
    let usage = vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC;
    let depths = Buffer::new(device, "depths", size_bytes, usage, MemoryKind::Device)?;
    Ok((target, depths))
}

/// Clips to the area that a light reaches, and starts counting from 0 there.
fn begin_light(commands: &Commands, light: &LightDraws) {
    let LitArea { origin, size } = light.area;
    commands.clear_stencil(origin, size);
    commands.clip(origin, size);
}

fn is_in(caster: &VolumeCaster, group: VolumeGroup) -> bool {
    caster.group == group && caster.draw.index_count > 0
}

fn volume_pipeline(
    device: &Device,
    shaders: &ShaderSet,
    path: VolumePath,
    stencil: StencilMode,
) -> Result<GraphicsPipeline, Error> {
    let name = match stencil {
        StencilMode::CountPassing => "shadow volumes, z-pass",
        _ => "shadow volumes, z-fail",
    };
    let vertex = match path {
        VolumePath::GeometryShader => "volume.vert",
        VolumePath::Compute => "volume_extruded.vert",
    };
    let info = GraphicsPipelineInfo {
        depth: DepthMode::TestNearer,
        range: DepthRange::Clamped,
        stencil,
        attachments: StencilTarget::attachments(),
        ..GraphicsPipelineInfo::of(name, shaders.find(vertex)?)
    };
    let info = match path {
        VolumePath::GeometryShader => GraphicsPipelineInfo {
            geometry: Some(shaders.find("volume.geom")?),
            vertices: POSITIONS,
            storage: StorageLayout::new::<VolumeConstants>(1),
            topology: vk::PrimitiveTopology::TRIANGLE_LIST_WITH_ADJACENCY,
            ..info.numbered::<Instance>()
        },
        VolumePath::Compute => GraphicsPipelineInfo {
            vertices: VertexLayout {
                stride_bytes: size_of::<[f32; 4]>() as u32,
                attributes: &[(vk::Format::R32G32B32A32_SFLOAT, 0)],
                beside: None,
            },
            ..info
        },
    };
    Ok(GraphicsPipeline::new(device, &info)?)
}
