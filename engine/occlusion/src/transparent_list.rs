//! Objects that can be hidden but do not hide others. They are drawn over the finished image, back
//! to front.
//!
//! ```text
//! prepare    before the rendering that holds the finished depth: the draws, without instances
//! test       in it: the boxes of the objects, in one draw; a fragment that passes the finished
//!            depth switches on the draws of its object
//! decide     between the renderings
//! draw       the draws in their order, in one call per run of draws in one bucket
//! ```
//!
//! If no sample of an object's box is visible, no sample of the object is: leaving it out changes
//! nothing, and the order of the other objects stays the same.

use std::ops::Range;

use cull::{Aabb, CullView};
use gpu::{
    Access, BOX_VERTICES, Buffer, BufferSlice, Commands, Device, DrawLink, Frame, IndirectDraw,
    LeafDrawBuffers, MemoryBarrier, MemoryKind, Predicates, Viewport, vk,
};

use crate::error::Error;
use crate::leaf_table::{BucketDraw, BucketId};
use crate::passes::{LeafBoxIo, LeafLinks, OcclusionPasses, ProxyBox};

/// The draws of one view's transparent objects in their order. The GPU skips the draws of hidden
/// objects.
pub struct TransparentList {
    device: Device,
    /// The draws that fragments enable.
    enabled: Option<Buffer>,
    /// The list of objects that the pass writes. It is not read.
    listed: Buffer,
    commands: Vec<IndirectDraw>,
    links: Vec<DrawLink>,
    firsts: Vec<u32>,
    boxes: Vec<ProxyBox>,
    /// Runs of draws in one bucket.
    runs: Vec<(BucketId, Range<u32>)>,
    io: Option<ListIo>,
}

/// A list in the memory of its frame.
#[derive(Clone, Copy)]
struct ListIo {
    draws: BufferSlice,
    /// The boxes that are tested, if there are any.
    tested: Option<TestedIo>,
}

#[derive(Clone, Copy)]
struct TestedIo {
    boxes: BufferSlice,
    links: LeafLinks,
    object_count: u32,
}

impl TransparentList {
    /// Creates an empty list.
    ///
    /// # Errors
    /// No memory, a failed call.
    pub fn new(device: &Device) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let bytes = (gpu::LISTED_LEAVES as u64 + 1) * 4;
        Ok(Self {
            device: device.clone(),
            enabled: None,
            listed: Buffer::new(device, "transparent list", bytes, usage, MemoryKind::Device)?,
            commands: Vec::new(),
            links: Vec::new(),
            firsts: Vec::new(),
            boxes: Vec::new(),
            runs: Vec::new(),
            io: None,
        })
    }

    /// Starts the list of a view over, without objects.
    pub fn clear(&mut self) {
        self.commands.clear();
        self.links.clear();
        self.firsts.clear();
        self.boxes.clear();
        self.runs.clear();
        self.io = None;
    }

    /// Adds an object that is drawn after all objects added before. The object is drawn without a
    /// test if it has no box, or if the near plane of `view` cuts the box.
    pub fn push(&mut self, view: &CullView, bounds: Option<Aabb>, draws: &[BucketDraw]) {
        let bounds = bounds.filter(|bounds| view.margin.proxy(bounds).is_some());
        let first = self.commands.len() as u32;
        let drawn = |bucket_draw: &&BucketDraw| {
            bucket_draw.draw.index_count > 0 && bucket_draw.draw.instance_count > 0
        };
        for BucketDraw { bucket, draw, .. } in draws.iter().filter(drawn) {
            let number = self.commands.len() as u32;
            self.links.push(DrawLink { next: number + 2, instance_count: draw.instance_count });
            let instance_count = if bounds.is_some() { 0 } else { draw.instance_count };
            self.commands.push(IndirectDraw { instance_count, ..*draw });
            match self.runs.last_mut().filter(|(last, _)| last == bucket) {
                Some((_, run)) => run.end += 1,
                None => self.runs.push((*bucket, number..number + 1)),
            }
        }
        if self.commands.len() as u32 == first {
            return;
        }
        if let Some(last) = self.links.last_mut() {
            last.next = DrawLink::NO_DRAW;
        }
        self.firsts.push(first + 1);
        self.boxes.push(ProxyBox::from(bounds.unwrap_or(Aabb::EMPTY)));
    }

    /// Returns true if the list draws nothing.
    pub fn is_empty(&self) -> bool {
        self.commands.is_empty()
    }

    /// Writes the list into the memory of a frame. All objects are drawn without a test if `passes`
    /// lacks the [pass](OcclusionPasses::leaf_boxes) that tests boxes: some devices do not support
    /// it, and some drivers cannot be trusted with it.
    ///
    /// # Errors
    /// No memory, a failed call.
    pub fn write(&mut self, frame: &mut Frame<'_>, passes: &OcclusionPasses) -> Result<(), Error> {
        if self.is_empty() {
            return Ok(());
        }
        if passes.leaf_boxes.is_none() {
            for (draw, link) in self.commands.iter_mut().zip(&self.links) {
                draw.instance_count = link.instance_count;
            }
        }
        let uploads = frame.uploads();
        let is_tested = self.commands.iter().any(|draw| draw.instance_count == 0);
        let tested = is_tested.then(|| -> Result<TestedIo, Error> {
            let firsts = uploads.push(&self.firsts)?;
            let links = uploads.push(&self.links)?;
            Ok(TestedIo {
                boxes: uploads.push(&self.boxes)?,
                links: LeafLinks { firsts, links },
                object_count: self.firsts.len() as u32,
            })
        });
        let tested = tested.transpose()?;
        self.io = Some(ListIo { draws: uploads.push(&self.commands)?, tested });
        let bytes = self.commands.len() as u64 * IndirectDraw::BYTES;
        if tested.is_some()
            && self.enabled.as_ref().is_none_or(|enabled| enabled.size_bytes() < bytes)
        {
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER
                | vk::BufferUsageFlags::TRANSFER_DST
                | vk::BufferUsageFlags::INDIRECT_BUFFER;
            let name = "transparent draws";
            let bytes = bytes.next_power_of_two();
            self.enabled = Some(Buffer::new(&self.device, name, bytes, usage, MemoryKind::Device)?);
        }
        Ok(())
    }

    /// Clears the draws that the boxes decide about, before the boxes are tested. Outside of
    /// rendering.
    pub fn prepare(&self, commands: &Commands) {
        let Some((io, _, LeafDrawBuffers { draws, list })) = self.tested() else { return };
        let between = MemoryBarrier::between;
        // The previous view or frame may still read and write these buffers.
        let uses = [Access::IndirectRead, Access::FragmentWrite];
        commands.barrier(between(&uses, &[Access::CopyWrite]));
        commands.copy_buffer(io.draws, draws);
        commands.fill(list.part(0, 4), 0);
        commands.barrier(between(&[Access::CopyWrite], &uses));
    }

    /// Tests the boxes against the finished depth, which is being rendered to.
    pub fn test(&self, passes: &OcclusionPasses, commands: &Commands, view: &CullView) {
        let (Some((_, tested, leaf_draws)), Some(pass)) = (self.tested(), &passes.leaf_boxes)
        else {
            return;
        };
        commands.label("transparent boxes", |commands| {
            // The owner may have set another viewport.
            commands.set_viewport(&Viewport::covering(view.origin, view.size));
            let links = Some(tested.links);
            pass.bind(commands, &LeafBoxIo { boxes: tested.boxes, leaf_draws, links }, view);
            commands.draw_instances(BOX_VERTICES, 0..tested.object_count);
        });
    }

    /// Records the barrier from the tests of the boxes to the draws. Outside of rendering.
    pub fn decide(&self, commands: &Commands) {
        if self.tested().is_some() {
            let enabled = [Access::IndirectRead, Access::FragmentWrite];
            commands.barrier(MemoryBarrier::between(&[Access::FragmentWrite], &enabled));
        }
    }

    /// Draws the objects in their order to the current attachments. `bind` is called with the
    /// bucket of each run of draws, before the run.
    pub fn draw(
        &self,
        predicates: &Predicates,
        commands: &Commands,
        bind: &dyn Fn(&Commands, BucketId),
    ) {
        let Some(io) = &self.io else { return };
        let draws = self.tested().map_or(io.draws, |(_, _, enabled)| enabled.draws);
        for (bucket, run) in &self.runs {
            bind(commands, *bucket);
            predicates.draw_after_counted(commands, draws.elements::<IndirectDraw>(run.clone()));
        }
    }

    fn tested(&self) -> Option<(ListIo, TestedIo, LeafDrawBuffers)> {
        let io = self.io?;
        let draws = self.enabled.as_ref()?.whole();
        Some((io, io.tested?, LeafDrawBuffers { draws, list: self.listed.whole() }))
    }
}
