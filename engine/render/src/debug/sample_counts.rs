//! Counts of the visible samples of single objects. The GPU counts them for the objects that a view
//! watches, and they are read back some frames later without a wait.
//!
//! The counts serve levels of detail
//! ([`Renderer::choose_detail_seen`](crate::Renderer::choose_detail_seen)) and other decisions of a
//! program ("Efficient Occlusion Culling", GPU Gems, 29.8.2 and 29.9). After a frame is drawn, each
//! watched object in the frustum is drawn again under a precise query. Its proxy is drawn under two
//! queries, with the depth test and without. Counting does not change the image.

use crate::view_pass::ViewPass;
use cull::{Containment, CullView, FrameId, Generation, Hierarchy, ObjectId, PlaneMask};
use gpu::{Commands, Counting, Device, IndirectDraw, OptionalFeature, QueryIndex, QueryRing, Tick};
use occlusion::{CulledScene, OcclusionState, ProxyBox, ProxyIo, ProxyPass};

use crate::attachment_schedule::AttachmentSchedule;
use crate::debug::settled_counts::{SettledCounts, keep_newest};
use crate::error::Error;
use crate::scene_renderer::SceneRenderer;

/// The number of visible samples of an object in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VisibleSamples {
    /// The watched object.
    pub object: ObjectId,
    /// The frame of the count.
    pub frame: FrameId,
    /// The age of that frame in frames of the view. 0 only for objects outside of the frustum,
    /// since they need no count, and after [`Renderer::wait_idle`](crate::Renderer::wait_idle).
    pub age_frames: u64,
    /// The number of the object's samples at which nothing is nearer in the finished image: its
    /// pixels, unless two of its faces have the same depth. 0 outside of the frustum.
    pub samples: u32,
    /// The samples of the proxy. `None` if the near plane would cut the proxy or it contains the
    /// eye, and outside of the frustum.
    pub proxy: Option<ProxySamples>,
    /// The generation of the hierarchy when the frame was drawn.
    generation: Generation,
}

/// The samples of an object's proxy in a frame. The proxy is the object's box, slightly enlarged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ProxySamples {
    /// The number of samples of its front faces at which nothing is nearer.
    pub visible: u32,
    /// The number of all samples of its front faces in the image.
    pub total: u32,
}

impl ProxySamples {
    /// Returns the visible share of the proxy's samples in the image, 0 to 1; 0 if it has none.
    pub fn fraction(&self) -> f32 {
        if self.total == 0 { 0.0 } else { self.visible as f32 / self.total as f32 }
    }
}

impl VisibleSamples {
    /// Returns the visible share of the object's proxy, 0 to 1 ([`ProxySamples::fraction`]); `None`
    /// if the proxy was not counted.
    pub fn fraction(&self) -> Option<f32> {
        self.proxy.map(|proxy| proxy.fraction())
    }
}

/// The subject of a count. The queries of an object are consecutive, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CountKind {
    Object,
    ProxyVisible,
    ProxyTotal,
}

/// A count in flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct CountTag {
    kind: CountKind,
    object: ObjectId,
    frame: FrameId,
    generation: Generation,
}

impl CountTag {
    /// Returns the count of the object, without a count of the proxy.
    fn answer(self, samples: u32) -> VisibleSamples {
        let Self { object, frame, generation, .. } = self;
        VisibleSamples { object, frame, age_frames: 0, samples, proxy: None, generation }
    }
}

/// The counts of one view.
#[derive(Default)]
pub(crate) struct SampleCounts {
    /// The watched objects, ascending and without duplicates.
    watched: Vec<ObjectId>,
    /// The newest count of each object that has one, ascending by object.
    newest: Vec<VisibleSamples>,
    settled: SettledCounts,
    queries: Option<QueryRing<CountTag>>,
    /// True if the frame being recorded counts.
    is_asking: bool,
    asked: CountRequests,
    collected: Vec<VisibleSamples>,
}

/// The counts of a frame, kept to allocate nothing in the steady state.
#[derive(Default)]
struct CountRequests {
    tags: Vec<CountTag>,
    objects: Vec<(QueryIndex, IndirectDraw)>,
    /// The first of the two queries of each proxy, and the proxy.
    proxies: Vec<(QueryIndex, ProxyBox)>,
}

impl CountRequests {
    /// Lays out the queries of one object.
    fn push(&mut self, tag: CountTag, draw: IndirectDraw, proxy: Option<ProxyBox>) {
        let query = |tags: &Vec<CountTag>| QueryIndex(tags.len() as u32);
        self.objects.push((query(&self.tags), draw));
        self.tags.push(tag);
        if let Some(proxy) = proxy {
            self.proxies.push((query(&self.tags), proxy));
            self.tags.push(CountTag { kind: CountKind::ProxyVisible, ..tag });
            self.tags.push(CountTag { kind: CountKind::ProxyTotal, ..tag });
        }
    }
}

impl SampleCounts {
    pub(crate) fn watch(&mut self, objects: &[ObjectId]) {
        self.watched.clear();
        self.watched.extend_from_slice(objects);
        self.watched.sort_unstable();
        self.watched.dedup();
        let Self { watched, newest, settled, .. } = self;
        let is_watched = |known: &VisibleSamples| watched.binary_search(&known.object).is_ok();
        newest.retain(is_watched);
        settled.retain(is_watched);
    }

    pub(crate) fn is_watching(&self) -> bool {
        !self.watched.is_empty()
    }

    /// Drops the ring. The next frame that counts creates a new one for the number of frames in
    /// flight at that time.
    pub(crate) fn forget_ring(&mut self) {
        self.queries = None;
    }

    /// Goes on without the counts so far, for a view whose frames are counted anew.
    pub(crate) fn follow_device(&mut self) {
        let watched = std::mem::take(&mut self.watched);
        *self = Self { watched, ..Self::default() };
    }

    pub(crate) fn newest(&self) -> &[VisibleSamples] {
        &self.newest
    }

    /// Reads the available results and forgets objects that were removed. `now` is the newest
    /// frame. Never waits.
    pub(crate) fn collect(&mut self, completed: Tick, hierarchy: &Hierarchy, now: FrameId) {
        let mut collected = std::mem::take(&mut self.collected);
        collected.clear();
        if let Some(queries) = &mut self.queries {
            queries.collect(completed, |tag, samples| {
                if tag.kind == CountKind::Object {
                    collected.push(tag.answer(samples));
                } else if let Some(of_object) = collected.last_mut() {
                    let proxy = of_object.proxy.get_or_insert_default();
                    match tag.kind {
                        CountKind::ProxyVisible => proxy.visible = samples,
                        _ => proxy.total = samples,
                    }
                }
            });
        }
        for known in collected.drain(..) {
            self.keep(known);
        }
        self.collected = collected;
        let is_there = |visible_samples: &VisibleSamples| {
            hierarchy.is_same_object_since(visible_samples.object, visible_samples.generation)
        };
        self.newest.retain(is_there);
        self.settled.retain(is_there);
        self.age(now);
    }

    /// Keeps a count, unless a newer one is known or the object is not watched any more.
    fn keep(&mut self, known: VisibleSamples) {
        if self.watched.binary_search(&known.object).is_err() {
            return;
        }
        keep_newest(&mut self.newest, known);
        self.settled.take(known);
    }

    fn age(&mut self, now: FrameId) {
        for known in &mut self.newest {
            known.age_frames = now.0.saturating_sub(known.frame.0);
        }
    }

    /// Lays out the counts of `frame` in `view`. The counts of objects outside of the frustum are
    /// known at once.
    fn lay_out(&mut self, scene: &CulledScene, view: &CullView, frame: FrameId) {
        let hierarchy = scene.hierarchy();
        let mut asked = std::mem::take(&mut self.asked);
        asked.tags.clear();
        asked.objects.clear();
        asked.proxies.clear();
        let generation = hierarchy.generation();
        for place in 0..self.watched.len() {
            let object = self.watched[place];
            let there = (hierarchy.node_of(object), hierarchy.leaf_of(object));
            let (Some(node), Some(leaf)) = there else { continue };
            if !hierarchy.contains(object) {
                continue;
            }
            let tag = CountTag { kind: CountKind::Object, object, frame, generation };
            let bounds = hierarchy.bounds(node);
            let (place, _) = view.frustum.classify(&bounds, PlaneMask::ALL);
            if place == Containment::Outside || hierarchy.is_cut_away(node, view) {
                self.keep(tag.answer(0));
                continue;
            }
            let proxy = view.margin.proxy(&bounds).map(ProxyBox::from);
            asked.push(tag, scene.leaves().draw(leaf), proxy);
        }
        self.asked = asked;
    }

    /// Returns the counts that levels of detail are chosen by.
    pub(crate) fn settled(&self) -> &SettledCounts {
        &self.settled
    }

    /// Forgets the counts that levels of detail are chosen by, up to the counts of frame `now`.
    pub(crate) fn forget_settled(&mut self, now: FrameId) {
        self.settled.forget(now);
    }

    /// Notes that the frame was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick, now: FrameId, frames_in_flight: usize) {
        self.settled.settle(now, frames_in_flight as u64);
        if let Some(queries) = self.queries.as_mut().filter(|_| self.is_asking) {
            queries.submitted(tick);
        }
        self.is_asking = false;
        self.age(now);
    }
}

/// Counts the samples of the objects that the view watches, after everything of its frame is drawn.
pub(crate) fn count_samples(
    view_pass: &mut ViewPass<'_, '_>,
    counts: &mut SampleCounts,
    visibility: &OcclusionState,
) -> Result<(), Error> {
    counts.is_asking = false;
    if !counts.is_watching() {
        return Ok(());
    }
    counts.lay_out(view_pass.scene, view_pass.view, visibility.plan().frame);
    if counts.asked.tags.is_empty() {
        return Ok(());
    }
    let queries = match counts.queries.take() {
        Some(queries) => queries,
        None => {
            let device = visibility.device();
            let slots = visibility.frames_in_flight();
            QueryRing::new(device, slots, "sample counts")?
        }
    };
    let queries = counts.queries.insert(queries);
    queries.set_counting(Counting::Samples);
    queries.begin(view_pass.frame, &counts.asked.tags)?;
    let boxes = counts.asked.proxies.iter().map(|(_, proxy)| *proxy);
    let io = ProxyIo { boxes: view_pass.frame.uploads().push_iter(boxes)?, flags: None };
    counts.is_asking = true;
    let target = view_pass.prepare_tests(AttachmentSchedule::SampleCounts);
    let ViewPass { passes, frame, scene, view } = view_pass;
    frame.commands().pass("count samples", |commands| {
        commands.rendering(target, |commands| {
            draw_counted(
                passes,
                commands,
                &counts.asked,
                queries,
                &scene.passes().proxies,
                &io,
                view,
            );
        });
        queries.resolve(commands, 0..counts.asked.tags.len() as u32);
        queries.read_back(commands);
    });
    Ok(())
}

fn draw_counted(
    passes: &SceneRenderer,
    commands: &Commands,
    asked: &CountRequests,
    queries: &QueryRing<CountTag>,
    proxies: &ProxyPass,
    io: &ProxyIo,
    view: &CullView,
) {
    let Some(pass) = passes.pipelines.count.get() else { return };
    pass.bind_objects(commands, &passes.opaque_io(), view);
    for (query, draw) in &asked.objects {
        queries.scope(commands, *query, |commands| pass.draw(commands, draw));
    }
    if asked.proxies.is_empty() {
        return;
    }
    proxies.bind(commands, io, view);
    for (number, (query, _)) in (0..).zip(&asked.proxies) {
        queries.scope(commands, *query, |commands| proxies.draw(commands, number));
    }
    pass.bind_proxies(commands, io, view);
    for (number, (QueryIndex(visible), _)) in (0..).zip(&asked.proxies) {
        let total = QueryIndex(visible + 1);
        queries.scope(commands, total, |commands| pass.draw_proxy(commands, number));
    }
}

pub(crate) const COUNTING: &str = "counting visible samples";

/// Checks that a device counts samples. `wanted` is the purpose, for the error.
pub(crate) fn check_counts(device: &Device, wanted: &'static str) -> Result<(), Error> {
    Ok(device.require(OptionalFeature::PreciseQueries, wanted)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(object: u32, frame: u64, samples: u32) -> VisibleSamples {
        CountTag {
            kind: CountKind::Object,
            object: ObjectId(object),
            frame: FrameId(frame),
            generation: Generation(0),
        }
        .answer(samples)
    }

    fn watching(objects: &[u32]) -> SampleCounts {
        let objects: Vec<ObjectId> = objects.iter().copied().map(ObjectId).collect();
        let mut counts = SampleCounts::default();
        counts.watch(&objects);
        counts
    }

    #[test]
    fn the_newest_of_each_watched_object_is_kept() {
        let mut counts = watching(&[7, 2, 7]);
        for (object, frame, samples) in [(7, 3, 30), (2, 5, 50), (7, 2, 20), (9, 9, 90), (2, 6, 60)]
        {
            counts.keep(known(object, frame, samples));
        }
        assert_eq!(counts.newest(), [known(2, 6, 60), known(7, 3, 30)]);
        counts.age(FrameId(8));
        let ages: Vec<u64> = counts.newest().iter().map(|known| known.age_frames).collect();
        assert_eq!(ages, [2, 5]);
        counts.watch(&[ObjectId(7), ObjectId(1)]);
        assert_eq!(counts.newest().len(), 1);
        assert_eq!(counts.newest()[0].object, ObjectId(7));
    }

    #[test]
    fn what_is_gone_is_forgotten() {
        let cube = |x: f32| cull::Aabb::new(glam::Vec3::splat(x), glam::Vec3::splat(x + 1.0));
        let mut hierarchy = Hierarchy::build(&[cube(0.0), cube(2.0), cube(4.0)]).unwrap();
        let mut counts = watching(&[0, 1, 2]);
        for object in 0..3 {
            counts.keep(known(object, 1, 10));
        }
        hierarchy.remove(ObjectId(0)).unwrap();
        hierarchy.remove(ObjectId(2)).unwrap();
        let id = hierarchy.insert(cube(4.0)).unwrap();
        counts.collect(Tick::default(), &hierarchy, FrameId(2));
        assert_eq!(counts.newest().len(), 1, "{:?}", counts.newest());
        assert_eq!(counts.newest()[0].object, ObjectId(1));
        // A late count of an earlier object with the same id.
        counts.keep(known(id.0, 1, 10));
        counts.collect(Tick::default(), &hierarchy, FrameId(2));
        assert_eq!(counts.newest().len(), 1);
    }

    #[test]
    fn fractions_are_of_what_is_in_the_image() {
        let fraction = |visible, total| ProxySamples { visible, total }.fraction();
        assert_eq!([fraction(0, 0), fraction(0, 5), fraction(3, 4)], [0.0, 0.0, 0.75]);
        assert_eq!(known(1, 1, 5).fraction(), None);
    }
}
