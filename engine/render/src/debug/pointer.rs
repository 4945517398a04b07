//! The object under a pointer. Each frame finds it for its own image, and it is read back some
//! frames later without a wait.
//!
//! After a view is drawn, the objects along the ray of the pixel are drawn again, clipped to that
//! pixel, against the finished depth. A fragment that passes owns the pixel. The search uses the
//! frame's own matrices and buffers, so the answer is about the image that was shown, even if
//! things have moved since.

use crate::view_pass::ViewPass;
use std::collections::VecDeque;

use cull::{CullView, FrameId, Hierarchy, LeafIndex, ObjectId};
use glam::{DVec3, Vec2};
use gpu::{Access, Device, FlagRing, MemoryBarrier, OptionalFeature, ResultSource, Tick, Viewport};
use occlusion::OcclusionState;

use crate::attachment_schedule::AttachmentSchedule;
use crate::error::Error;
use crate::passes::SeenIo;

/// The words of an answer: the leaf and the depth.
const WORDS: usize = 2;

/// The object under the pointer, in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pointed {
    /// The frame of the view.
    pub frame: FrameId,
    /// The pixel, counted from the upper left corner of the view's part of the image.
    pub pixel: [u32; 2],
    /// The object that owns the pixel, and its visible point; `None` for the background.
    pub surface: Option<PointedSurface>,
}

/// A point of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointedSurface {
    /// The object.
    pub object: ObjectId,
    /// The depth value as stored by the rasteriser.
    pub depth: f32,
    /// The point in the world (metres), as precise as the depth.
    pub point: DVec3,
}

/// A frame with a request for the object under the pointer.
struct Asked {
    frame: FrameId,
    pixel: [u32; 2],
    view: CullView,
    /// The leaves along the ray, ascending, and their objects in that frame.
    candidates: Vec<(LeafIndex, ObjectId)>,
}

/// The pointer of a view, and its answers.
#[derive(Default)]
pub(crate) struct Pointer {
    pixel: Option<[u32; 2]>,
    ring: Option<FlagRing<FrameId>>,
    asked: VecDeque<Asked>,
    is_asking: bool,
    newest: Option<Pointed>,
}

impl Pointer {
    /// Requests the object at a pixel in each frame from now on; `None` ends this. The newest
    /// answer stays.
    pub(crate) fn point_at(&mut self, pixel: Option<[u32; 2]>) {
        self.pixel = pixel;
    }

    /// Returns true if the next frame looks for an object.
    pub(crate) fn is_pointing(&self) -> bool {
        self.pixel.is_some()
    }

    /// Returns the answer of the newest frame that is over.
    pub(crate) fn newest(&self) -> Option<&Pointed> {
        self.newest.as_ref()
    }

    /// Reads the answers of frames that are over.
    pub(crate) fn collect(&mut self, completed: Tick) {
        let Self { ring: Some(ring), asked, newest, .. } = self else { return };
        ring.collect(completed, |frames, words| {
            let ([frame, ..], [complement, depth_bits]) = (frames, words) else { return };
            // Frames that never ran give no answer.
            while let Some(of) = asked.pop_front_if(|asked| asked.frame <= *frame) {
                if of.frame == *frame {
                    *newest = Some(of.answer(*complement, f32::from_bits(*depth_bits)));
                }
            }
        });
    }

    /// Drops the ring, when the number of frames in flight changes.
    pub(crate) fn forget_ring(&mut self) {
        self.ring = None;
        self.asked.clear();
        self.is_asking = false;
    }

    /// Goes on without the answers so far, for a view whose frames are counted anew.
    pub(crate) fn follow_device(&mut self) {
        self.forget_ring();
        self.newest = None;
    }

    /// Notes that the frame was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        if let Some(ring) = self.ring.as_mut().filter(|_| self.is_asking) {
            ring.submitted(tick);
        }
        self.is_asking = false;
    }
}

impl Asked {
    fn answer(&self, complement: u32, depth: f32) -> Pointed {
        let leaf = LeafIndex(!complement);
        let found = self.candidates.binary_search_by_key(&leaf, |(leaf, _)| *leaf).ok();
        let surface = found.filter(|_| complement != 0).map(|found| {
            let (_, object) = self.candidates[found];
            let ndc = middle_of(self.pixel, self.view.size);
            let rays = &self.view.rays;
            let depth_m = f64::from(rays.depth_m_of(depth));
            let point = rays.point_f64(ndc, depth_m);
            PointedSurface { object, depth, point }
        });
        Pointed { frame: self.frame, pixel: self.pixel, surface }
    }
}

/// Returns the middle of a pixel in normalised device coordinates.
pub(crate) fn middle_of(pixel: [u32; 2], size: [u32; 2]) -> Vec2 {
    let [x, y] = [0, 1].map(|axis| (pixel[axis] as f32 + 0.5) / size[axis].max(1) as f32);
    Vec2::new(x, y) * 2.0 - 1.0
}

/// Checks that a device supports finding the object under a pointer.
pub(crate) fn check_pointer(device: &Device) -> Result<(), Error> {
    let wanted = "finding the object under the pointer";
    Ok(device.require(OptionalFeature::FragmentStores, wanted)?)
}

/// Records the search for the object under the pointer of a view, after everything of its frame is
/// drawn.
pub(crate) fn record_pointer(
    view_pass: &mut ViewPass<'_, '_>,
    pointer: &mut Pointer,
    visibility: &OcclusionState,
) -> Result<(), Error> {
    pointer.is_asking = false;
    let Some([x, y]) = pointer.pixel else { return Ok(()) };
    let view = view_pass.view;
    // The image may have become smaller.
    let pixel = [x.min(view.size[0].saturating_sub(1)), y.min(view.size[1].saturating_sub(1))];
    let candidates = candidates(view_pass.scene.hierarchy(), view, pixel);
    let ring = pointer.ring.get_or_insert_with(|| {
        let slots = visibility.frames_in_flight();
        FlagRing::new(visibility.device(), slots, ResultSource::Fragments, "pointer")
    });
    let now = visibility.plan().frame;
    ring.begin(view_pass.frame, std::iter::repeat_n(now, WORDS))?;
    let draws = candidates.iter().map(|(leaf, _)| view_pass.scene.leaves().draw(*leaf));
    let draws = view_pass.frame.uploads().push_iter(draws)?;
    pointer.is_asking = true;
    let has_draws = !candidates.is_empty();
    pointer.asked.push_back(Asked { frame: now, pixel, view: *view, candidates });
    let Some(pointed) = ring.results() else { return Ok(()) };
    let cleared = MemoryBarrier::between(&[Access::CopyWrite], &[Access::FragmentWrite]);
    let origin = [view.origin[0] + pixel[0], view.origin[1] + pixel[1]];
    let target = view_pass.prepare_tests(AttachmentSchedule::Pointer);
    let passes = &*view_pass.passes;
    view_pass.frame.commands().pass("find pointed object", |commands| {
        commands.barrier(cleared);
        if has_draws {
            commands.rendering(target.within(pixel, [1, 1]), |commands| {
                let Some(pass) = passes.pipelines.pointer.get() else { return };
                pass.bind(commands, &SeenIo { opaque: passes.opaque_io(), seen: pointed }, view);
                commands.set_viewport(&Viewport::covering(view.origin, view.size));
                commands.clip(origin, [1, 1]);
                commands.draw_indirect(draws);
                passes.point_at_caps(commands, view, pixel, pointed);
            });
        }
        ring.read_back(commands);
    });
    Ok(())
}

/// Returns the leaves that may own a sample of a pixel, ascending, and their objects. The device
/// decides about the positions of samples in a pixel.
fn candidates(
    hierarchy: &Hierarchy,
    view: &CullView,
    pixel: [u32; 2],
) -> Vec<(LeafIndex, ObjectId)> {
    let mut ranges = Vec::new();
    hierarchy.leaves_in(&view.frustum_of_pixel(pixel), view, &mut ranges);
    let objects = hierarchy.leaf_objects();
    let leaves = ranges.into_iter().flat_map(|range| {
        (range.first.0..range.first.0.saturating_add(range.count)).map(LeafIndex)
    });
    leaves.filter_map(|leaf| Some((leaf, *objects.get(leaf.0 as usize)?))).collect()
}
