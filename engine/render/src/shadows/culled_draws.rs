//! The draws of culled casters in a frame, as plain values: the draws that need no test, and the
//! ranges of draws that each test decides about.

use std::ops::Range;

use ::shadows::{LitArea, ShadowLightId};
use cull::{
    Aabb, BoxShadowVolumes, CullView, FrameId, FramePlan, Hierarchy, LeafIndex, NodeId, ObjectId,
    PendingTest, QueryKind, QueryTag, VisibilityTest,
};
use glam::Vec4;
use gpu::{DrawRange, PredicatedRange, Reveal};
use occlusion::BoxVolume;

use crate::resources::geometry::Geometry;

/// The scene and the view that casters are culled for.
pub(super) struct CastersInView<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) geometry: &'a Geometry,
    /// The box around everything that can receive shadows.
    pub(super) receivers: Aabb,
    /// Returns the number of triangles of a caster's draw.
    pub(super) triangles: fn(&Geometry, ObjectId, LeafIndex) -> u32,
    pub(super) view: &'a CullView,
}

/// Casters that would be drawn together without culling, such as the casters of a map.
#[derive(Clone, Copy)]
pub(super) struct CasterGroup<'a> {
    /// A number that the owner of the group chooses.
    pub(super) number: usize,
    /// The casters, ascending.
    pub(super) casters: &'a [LeafIndex],
}

/// The draws of a group.
pub(super) struct CulledGroup {
    pub(super) number: usize,
    /// The draws that need no test.
    pub(super) always: Range<u32>,
    /// The decisions about the other draws.
    pub(super) decisions: Range<u32>,
}

/// The subject of a test: the light whose history learns from it, if it has one, and the number of
/// triangles that are drawn if the test passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TestedCasters {
    pub(super) light: Option<ShadowLightId>,
    pub(super) triangles: u32,
}

/// The tests under one light.
pub(super) struct TestedLight {
    /// The light in homogeneous coordinates.
    pub(super) light: Vec4,
    /// The part of the view that the light reaches.
    pub(super) area: LitArea,
    pub(super) tests: Range<u32>,
}

/// The draws and tests of a frame.
#[derive(Default)]
pub(super) struct CulledDraws {
    pub(super) lights: Vec<TestedLight>,
    pub(super) groups: Vec<CulledGroup>,
    /// The caster of each draw.
    pub(super) leaves: Vec<LeafIndex>,
    pub(super) boxes: Vec<BoxVolume>,
    pub(super) tags: Vec<PendingTest<TestedCasters>>,
    pub(super) decided: Vec<PredicatedRange>,
    /// The number of triangles in the draws that need no test.
    pub(super) triangles: u64,
}

impl CulledDraws {
    pub(super) fn clear(&mut self) {
        self.lights.clear();
        self.groups.clear();
        self.leaves.clear();
        self.boxes.clear();
        self.tags.clear();
        self.decided.clear();
        self.triangles = 0;
    }

    /// Adds groups that are drawn whole.
    pub(super) fn add_untested(&mut self, scene: &CastersInView<'_>, groups: &[CasterGroup<'_>]) {
        for group in groups {
            self.add_group(group, |draws| {
                draws.draw_always(group.casters.iter().copied(), scene);
            });
        }
    }

    /// Adds groups of a local light that are drawn whole if a lit surface may be visible.
    pub(super) fn add_light(
        &mut self,
        scene: &CastersInView<'_>,
        volumes: &BoxShadowVolumes<'_>,
        area: LitArea,
        groups: &[CasterGroup<'_>],
    ) {
        // No test is possible if the eye is within the light's reach.
        let Some(proxy) = volumes.whole(scene.view) else {
            return self.add_untested(scene, groups);
        };
        let test = self.begin_light(volumes, area);
        let mut triangles = 0;
        for group in groups {
            self.add_group(group, |draws| {
                triangles += draws.decide(test, group.casters, scene);
            });
        }
        // No history learns from this test.
        let tag = QueryTag {
            node: NodeId(0),
            generation: scene.hierarchy.generation(),
            frame: FrameId(0),
            kind: QueryKind::Proxy,
            sample_threshold: 0,
        };
        self.add_test(tag, &proxy, TestedCasters { light: None, triangles }, volumes);
    }

    /// Adds groups of a light as its history planned them.
    pub(super) fn add_nodes(
        &mut self,
        light: ShadowLightId,
        plan: &FramePlan,
        scene: &CastersInView<'_>,
        volumes: &BoxShadowVolumes<'_>,
        area: LitArea,
        groups: &[CasterGroup<'_>],
    ) {
        let first_test = self.begin_light(volumes, area);
        let mut triangles = vec![0; plan.tests.len()];
        for group in groups {
            let is_here = |leaf: &LeafIndex| group.casters.binary_search(leaf).is_ok();
            self.add_group(group, |draws| {
                draws.draw_always(plan.draws.iter().copied().filter(is_here), scene);
                for ((number, test), triangles) in
                    (first_test..).zip(&plan.tests).zip(&mut triangles)
                {
                    let casters = casters_among(group.casters, test.leaves);
                    *triangles += draws.decide(number, casters, scene);
                }
            });
        }
        for (test, triangles) in plan.tests.iter().zip(triangles) {
            let contents = TestedCasters { light: Some(light), triangles };
            self.add_test(test.tag, &test.bounds, contents, volumes);
        }
    }

    /// Adds a group whose draws `add` adds, beginning with the draws that need no test.
    fn add_group(&mut self, group: &CasterGroup<'_>, add: impl FnOnce(&mut Self)) {
        let first = self.leaves.len() as u32;
        let first_decision = self.decided.len() as u32;
        add(self);
        let decisions = first_decision..self.decided.len() as u32;
        let decided = self.decided.get(first_decision as usize);
        let end = decided.map_or(self.leaves.len() as u32, |decided| decided.range.first);
        self.groups.push(CulledGroup { number: group.number, always: first..end, decisions });
    }

    fn draw_always(&mut self, casters: impl Iterator<Item = LeafIndex>, scene: &CastersInView<'_>) {
        let first = self.leaves.len();
        self.leaves.extend(casters);
        self.triangles += triangles_of(self.leaves.get(first..).unwrap_or_default(), scene);
    }

    /// Adds draws that depend on a test. Returns their number of triangles.
    fn decide(&mut self, test: u32, casters: &[LeafIndex], scene: &CastersInView<'_>) -> u32 {
        if casters.is_empty() {
            return 0;
        }
        let range = DrawRange { first: self.leaves.len() as u32, count: casters.len() as u32 };
        self.decided.push(PredicatedRange { result: test, range, reveal: Reveal::Draws });
        self.leaves.extend_from_slice(casters);
        triangles_of(casters, scene).try_into().unwrap_or(u32::MAX)
    }

    /// Begins the tests of a light. Returns the index of the first.
    fn begin_light(&mut self, volumes: &BoxShadowVolumes<'_>, area: LitArea) -> u32 {
        let first = self.boxes.len() as u32;
        let light = volumes.light().light;
        self.lights.push(TestedLight { light, area, tests: first..first });
        first
    }

    fn add_test(
        &mut self,
        tag: QueryTag,
        proxy: &Aabb,
        contents: TestedCasters,
        volumes: &BoxShadowVolumes<'_>,
    ) {
        self.boxes.push(BoxVolume::new(proxy, volumes.length(proxy)));
        self.tags.push(PendingTest { tag, tester: VisibilityTest::Flag, contents });
        if let Some(light) = self.lights.last_mut() {
            light.tests.end += 1;
        }
    }
}

/// Returns the casters in a range of leaves, out of ascending casters.
fn casters_among(casters: &[LeafIndex], range: cull::LeafRange) -> &[LeafIndex] {
    let start = casters.partition_point(|leaf| *leaf < range.first);
    let end = casters.partition_point(|leaf| leaf.0 < range.first.0 + range.count);
    casters.get(start..end).unwrap_or_default()
}

fn triangles_of(casters: &[LeafIndex], scene: &CastersInView<'_>) -> u64 {
    let object = |leaf: &LeafIndex| scene.hierarchy.leaf_objects().get(leaf.0 as usize);
    let count = |leaf| Some((scene.triangles)(scene.geometry, *object(leaf)?, *leaf));
    casters.iter().filter_map(count).map(u64::from).sum()
}
