//! The depth pyramid of today's engines (niagara and Bevy, two phases; the pyramid of Greene, Kass
//! and Miller 1993, "Hierarchical Z-Buffer Visibility"): the GPU makes all decisions.
//!
//! ```text
//! remembered  leaves visible in the last frame and in the frustum -> list of draws
//! visible     clear; draw the list
//! pyramid     depth image -> farthest depths at every level
//! tests       everything in the frustum against the pyramid -> list of leaves that show and were
//!             not drawn; leaves that show -> the next frame
//! revealed    draw the list
//! surfaces    both lists again, for their colour, in scenes with surfaces
//! read back   counts -> mapped memory of this slot
//! ```
//!
//! The proof that the image is exact is in `pyramid.glsl`: an object that phase 2 leaves out is, at
//! each sample that it could own, farther than the draws of phase 1.

mod build;
mod cull;
mod state;

use ::cull::{CullView, Hierarchy, Strategy};
use gpu::{
    Access, Buffer, BufferSlice, Commands, Device, Frame, IndirectDraw, MemoryBarrier, MemoryKind,
    OptionalFeature, vk,
};
use occlusion::{
    BucketId, CulledScene, Error, Method, MethodConstructor, MethodRequest, MethodStats,
    MethodSupport, OcclusionState, Rect, Rendering, ShadedObjects, ShaderSet, UpcomingDraws,
    render, render_last,
};

pub use build::{HzbLevel, HzbPass, hzb_levels};
use cull::{Counters, HzbCullIo, HzbCullPass, ListKind, Phase};
use state::{COUNTER_BYTES, HzbState};

/// The strategy of this method.
pub const HZB: Strategy =
    Strategy::new("hzb", "two phases against a depth pyramid, on the GPU").gpu_driven();

/// The method. Its GPU objects are created for the first frame.
#[derive(Default)]
struct HzbMethod {
    frame: Option<HzbFrame>,
}

/// Returns the method's constructor.
pub(crate) fn method() -> MethodConstructor {
    MethodConstructor::new(|| Box::new(HzbMethod::default()))
}

impl Method for HzbMethod {
    fn strategies(&self) -> &[Strategy] {
        &[HZB]
    }

    fn supports(&self, strategy: Strategy, support: &MethodSupport<'_>) -> Result<(), Error> {
        support.needs_one_draw_per_leaf(strategy)?;
        HzbFrame::check(support.scene.device(), support.scene.hierarchy(), support.size)
    }

    fn prepare(
        &mut self,
        scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        shaders: &ShaderSet,
    ) -> Result<(), Error> {
        if self.frame.is_none() {
            self.frame = Some(HzbFrame::of(scene, objects, shaders)?);
        }
        Ok(())
    }

    fn record(
        &mut self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        scene: &mut CulledScene,
        objects: &mut dyn ShadedObjects,
        request: &MethodRequest<'_>,
    ) -> Result<MethodStats, Error> {
        if let Some(pyramid) = &self.frame {
            pyramid.record(frame, state, scene, objects, request.view)?;
        }
        Ok(MethodStats::default())
    }

    fn reloaded(
        &self,
        scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        shaders: &ShaderSet,
    ) -> Result<Box<dyn Method>, Error> {
        let frame = self.frame.as_ref().map(|_| HzbFrame::of(scene, objects, shaders));
        Ok(Box::new(Self { frame: frame.transpose()? }))
    }

    /// Drops the pyramid and its buffers, whose size depends on the target; the next frame makes
    /// new ones.
    fn resized(&mut self) {
        self.frame = None;
    }
}

/// The passes and the list of draws, which all views share.
struct HzbFrame {
    pyramid: HzbPass,
    cull: HzbCullPass,
    list: Buffer,
    list_kind: ListKind,
    /// The offset of the second phase's list. It overwrites the first list unless both are drawn
    /// again.
    second_bytes: u64,
    counters: Buffer,
    leaf_count: u32,
}

/// The lists that are kept once a frame has been drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lists {
    /// The list of the second phase; the first list is not needed any more.
    One,
    /// The lists of both phases, which are drawn again.
    Both,
}

/// The largest alignment of storage buffers on any device.
const MOST_ALIGNMENT_BYTES: u64 = 256;

impl HzbFrame {
    fn of(
        scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        shaders: &ShaderSet,
    ) -> Result<Self, Error> {
        let lists = if objects.shades_later() { Lists::Both } else { Lists::One };
        let size = objects.target().size();
        Self::new(scene.device(), shaders, scene.hierarchy(), size, lists)
    }

    /// Compiles the passes and makes room for the leaves of `hierarchy`.
    fn new(
        device: &Device,
        shaders: &ShaderSet,
        hierarchy: &Hierarchy,
        size: [u32; 2],
        lists: Lists,
    ) -> Result<Self, Error> {
        Self::check(device, hierarchy, size)?;
        let limits = &device.adapter().limits;
        let leaf_count = hierarchy.leaf_objects().len() as u32;
        let has_counts = device.capabilities().has(OptionalFeature::DrawIndirectCount)
            && leaf_count <= limits.max_draw_indirect_count;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let indirect = vk::BufferUsageFlags::INDIRECT_BUFFER;
        let from = vk::BufferUsageFlags::TRANSFER_SRC;
        let to = vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = |name, size_bytes, usage| {
            Buffer::new(device, name, size_bytes, storage | usage, MemoryKind::Device)
        };
        let list_bytes = u64::from(leaf_count.max(1)) * IndirectDraw::BYTES;
        let second_bytes = match lists {
            Lists::One => 0,
            Lists::Both => list_bytes.next_multiple_of(MOST_ALIGNMENT_BYTES),
        };
        Ok(Self {
            pyramid: HzbPass::new(device, shaders, size)?,
            cull: HzbCullPass::new(device, shaders)?,
            list: buffer("pyramid draws", second_bytes + list_bytes, indirect)?,
            list_kind: if has_counts { ListKind::Compact } else { ListKind::EveryLeaf },
            second_bytes,
            counters: buffer("pyramid counters", COUNTER_BYTES, indirect | from | to)?,
            leaf_count,
        })
    }

    /// Checks that the device can hold the leaves of `hierarchy` and images of `size`.
    fn check(device: &Device, hierarchy: &Hierarchy, size: [u32; 2]) -> Result<(), Error> {
        let limits = &device.adapter().limits;
        let leaf_count = hierarchy.leaf_objects().len() as u32;
        let most = u64::from(limits.max_compute_work_group_count[0]) * 64;
        if u64::from(leaf_count) > most {
            let what = "the number of objects for the pyramid strategy".to_owned();
            let wanted = leaf_count.into();
            return Err(gpu::Error::TooLarge { what, wanted, limit: most }.into());
        }
        HzbPass::check(device, size)
    }

    /// Records a frame of one view.
    fn record(
        &self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        view: &CullView,
    ) -> Result<(), Error> {
        state.check(scene)?;
        state.begin_unplanned(frame, scene, view)?;
        let mut kept = match state.take_method_state::<HzbState>() {
            Some(kept) => kept,
            None => {
                let slots = state.frames_in_flight();
                Box::new(HzbState::new(scene.device(), scene.hierarchy(), slots)?)
            }
        };
        kept.begin(scene.device(), scene.hierarchy(), state.plan().frame, frame.slot())?;
        let commands = frame.commands();
        objects.prepare_draws(commands, UpcomingDraws::All);
        // Earlier frames, of this view or another, may still read the buffers that are written
        // here.
        let earlier = [Access::ComputeWrite, Access::IndirectRead, Access::CopyRead];
        let between = MemoryBarrier::between;
        commands.barrier(between(&earlier, &[Access::CopyWrite]));
        kept.forget_unless_next(commands);
        commands.fill(self.counters.whole(), 0);
        commands.barrier(between(
            &[Access::CopyWrite, Access::ComputeWrite],
            &[Access::ComputeRead, Access::ComputeWrite],
        ));
        self.record_phases(commands, &kept, scene, objects, view);
        state.put_method_state(kept);
        Ok(())
    }

    fn record_phases(
        &self,
        commands: &Commands,
        kept: &HzbState,
        scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        view: &CullView,
    ) {
        let io = HzbCullIo {
            boxes: scene.leaves().boxes(),
            leaves: scene.leaves().predicates().draws(),
            seen: kept.seen(),
            list: self.list(Phase::First),
            counters: self.counters.whole(),
            depths: self.pyramid.depths(),
            leaf_count: self.leaf_count,
            list_kind: self.list_kind,
        };
        commands.pass("cull remembered", |commands| {
            self.cull.record(commands, &io, view, Phase::First);
        });
        objects.target().prepare(commands);
        commands.pass("draw visible", |commands| {
            render(objects, commands, view, Rendering::First, |commands, objects| {
                objects.bind(commands, view, BucketId(0));
                self.draw(commands, Phase::First);
            });
        });
        commands.pass("depth pyramid", |commands| {
            self.pyramid.record(commands, objects.target(), Rect::of(view));
        });
        commands.pass("test boxes", |commands| {
            // The list of phase 1 has already been drawn.
            let between = MemoryBarrier::between;
            commands.barrier(between(&[Access::IndirectRead], &[Access::ComputeWrite]));
            let io = HzbCullIo { list: self.list(Phase::Second), ..io };
            self.cull.record(commands, &io, view, Phase::Second);
        });
        objects.target().prepare(commands);
        commands.pass("draw revealed", |commands| {
            render_last(objects, commands, view, Rendering::Next, |commands, objects| {
                objects.bind(commands, view, BucketId(0));
                self.draw(commands, Phase::Second);
            });
        });
        objects.shade(scene, commands, view, &|commands, bind| {
            bind(commands, BucketId(0));
            self.draw(commands, Phase::First);
            self.draw(commands, Phase::Second);
        });
        commands.pass("copy results", |commands| {
            kept.read_back(commands, self.counters.whole());
        });
    }

    /// Returns the memory for the list of `phase`. It can be bound even in a scene without leaves.
    fn list(&self, phase: Phase) -> BufferSlice {
        let start = if phase == Phase::Second { self.second_bytes } else { 0 };
        self.list.whole().part(start, u64::from(self.leaf_count.max(1)) * IndirectDraw::BYTES)
    }

    /// Draws the list of `phase`.
    fn draw(&self, commands: &Commands, phase: Phase) {
        if self.leaf_count == 0 {
            return;
        }
        let list = self.list(phase);
        match self.list_kind {
            ListKind::EveryLeaf => commands.draw_indirect(list),
            ListKind::Compact => {
                let at = u64::from(phase == Phase::Second) * size_of::<Counters>() as u64;
                commands.draw_indirect_count(list, self.counters.whole().part(at, 4));
            }
        }
    }
}
