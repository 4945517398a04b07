//! The depth of a world and the mask of its shadows, drawn by the engine's passes.

use cull::{Aabb, Camera, CullView};
use glam::Vec4;
use gpu::{Access, Attachments, Buffer, Device, FrameRing, MemoryBarrier, MemoryKind, Target, vk};
use occlusion::ShaderSet;
use render::passes::{
    OpaqueIo, OpaquePass, VolumeCaster, VolumeCasters, VolumeGroup, VolumeIo, VolumeLight,
    VolumePass, VolumePath,
};
use scene::Light;
use shadows::{LitArea, NearSpan, VolumeCounting, VolumeEnd};

use super::world::World;

/// Layers of the mask.
const LAYERS: u32 = 2;

/// The choice of the counting method.
#[derive(Clone, Copy, PartialEq)]
pub enum Choice {
    /// The cheaper method where it is correct.
    ByEye,
    /// Z-fail for all casters.
    AllFail,
}

/// A world on a device, and the passes that draw it.
pub struct Renderings {
    size: [u32; 2],
    vertices: Buffer,
    indices: Buffer,
    adjacency: Buffer,
    instances: Buffer,
    mask: Buffer,
    readback: Buffer,
    target: Target,
    depth: OpaquePass,
    volumes: VolumePass,
    ring: FrameRing,
    /// The number of casters so far whose volumes ended at a plane.
    pub ended: u32,
}

impl Renderings {
    pub fn new(device: &Device, world: &World, size: [u32; 2], path: VolumePath) -> Self {
        use vk::BufferUsageFlags as Usage;
        let shaders = ShaderSet::embedded().unwrap();
        let storage = Usage::STORAGE_BUFFER;
        let index = Usage::INDEX_BUFFER;
        let size_bytes = u64::from(size[0] * size[1] * 4 * LAYERS);
        let both = storage | Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
        let memory =
            |name, usage, kind| Buffer::new(device, name, size_bytes, usage, kind).unwrap();
        let vertex = storage | Usage::VERTEX_BUFFER;
        Self {
            size,
            vertices: device.upload("vertices", &world.vertices, vertex).unwrap(),
            indices: device.upload("indices", &world.indices, index).unwrap(),
            adjacency: device.upload("adjacency", &world.adjacency, index | storage).unwrap(),
            instances: device.upload("instances", &world.instances, storage).unwrap(),
            mask: memory("mask", both, MemoryKind::Device),
            readback: memory("mask readback", Usage::TRANSFER_DST, MemoryKind::ReadBack),
            target: Target::new(device, size, "target").unwrap(),
            depth: OpaquePass::depth_only(device, &shaders, Attachments::default()).unwrap(),
            volumes: VolumePass::new(device, &shaders, size, path).unwrap(),
            ring: FrameRing::new(device, 2).unwrap(),
            ended: 0,
        }
    }

    pub fn view(&self, device: &Device, camera: &Camera) -> CullView {
        CullView::new(camera, self.size, device.adapter().limits.sub_pixel_precision_bits)
    }

    /// Returns the mask: one bit per light for each pixel.
    pub fn draw(
        &mut self,
        device: &Device,
        world: &World,
        camera: &Camera,
        lights: &[Vec4],
        choice: Choice,
    ) -> Vec<u32> {
        let view = self.view(device, camera);
        let span = NearSpan::points_of(&view.rays);
        let receivers =
            world.things.iter().fold(Aabb::EMPTY, |all, thing| all.union(&thing.bounds));
        let casters = lights.iter().map(|light| {
            let ends = VolumeEnd::of(&view, *light, &receivers);
            let caster = |thing: &super::world::Thing| {
                let counting = match choice {
                    Choice::ByEye => NearSpan(&span).counting(&thing.bounds, *light),
                    Choice::AllFail => VolumeCounting::ZFail,
                };
                let kind = thing.kind.towards(&thing.bounds, *light);
                let end = VolumeEnd::nearest(&ends, &thing.bounds);
                let group = VolumeGroup { counting, kind, end };
                VolumeCaster { draw: thing.volumes, group }
            };
            (world.things.iter().map(caster).collect::<Vec<_>>(), ends.clone())
        });
        let casters: Vec<_> = casters.collect();
        let lights = lights.iter().zip(&casters).enumerate();
        // The second light is in another layer.
        let lights: Vec<_> = lights
            .map(|(number, (light, (casters, ends)))| {
                let bits = 1 << number;
                let layer = number as u32 % LAYERS;
                let ended =
                    casters.iter().filter(|caster| ends[caster.group.end] != VolumeEnd::INFINITY);
                self.ended += ended.count() as u32;
                let casters = VolumeCasters::All(casters);
                let area = LitArea::whole(&view);
                VolumeLight { light: *light, ends, bits, layer, area, casters }
            })
            .collect();
        let mut frame = self.ring.begin().unwrap();
        let draws = self.volumes.prepare(&mut frame, &lights).unwrap();
        let commands = frame.commands();
        self.target.prepare(commands);
        commands.rendering(self.target.render_target(Some([0.0; 4])), |commands| {
            let io = OpaqueIo {
                section: None,
                vertices: self.vertices.whole(),
                indices: self.indices.whole(),
                instances: self.instances.whole(),
            };
            self.depth.bind(commands, &io, &view, &Light::afternoon());
            world.things.iter().for_each(|thing| commands.draw_indexed(&thing.draw));
        });
        let io = VolumeIo {
            vertices: self.vertices.whole(),
            adjacency: self.adjacency.whole(),
            instances: self.instances.whole(),
            mask: self.mask.whole(),
        };
        self.volumes.record(commands, &io, &view, &mut self.target, &draws, &|_, _| {});
        commands.copy_buffer(self.mask.whole(), self.readback.whole());
        let to_host = MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]);
        commands.barrier(to_host);
        frame.submit(None).unwrap();
        device.wait_idle().unwrap();
        let pixels = (self.size[0] * self.size[1]) as usize;
        let values = self.readback.read::<u32>(0..pixels * LAYERS as usize);
        let (first, second) = values.split_at(pixels);
        first.iter().zip(second).map(|(first, second)| first | second).collect()
    }
}
