//! Section planes that move through a scene, and their effect on plans.

use antumbra_cull::{
    Aabb, Camera, CullConfig, CullView, Culler, Decision, FramePlan, Hierarchy, ObjectId,
    Projection, SectionMember, SectionMode, SectionPlane, SectionPlanes, Strategy,
};
use glam::{DVec3, Vec3};

use crate::random::Random;

/// Planes that move from frame to frame; none by default.
#[derive(Debug, Default)]
pub struct Cuts {
    planes: Vec<(DVec3, f64)>,
    mode: SectionMode,
    drag_m: f32,
}

impl Cuts {
    /// Creates random planes, and chooses objects that they leave whole.
    pub fn random(random: &mut Random, hierarchy: &mut Hierarchy) -> Self {
        for object in (0..hierarchy.leaf_objects().len() as u32).map(ObjectId) {
            if random.chance(0.1) {
                hierarchy.set_section_member(object, SectionMember::Whole);
            }
        }
        let mut plane = || {
            let normal = [Vec3::X, Vec3::NEG_Z, Vec3::Y, random.point(-1.0, 1.0)][random.below(4)];
            (normal.as_dvec3(), f64::from(random.between(-8.0, 8.0)))
        };
        let planes = (0..6).map(|_| plane()).collect();
        let mut cuts = Self {
            planes,
            mode: [SectionMode::Intersection, SectionMode::Union][random.below(2)],
            drag_m: [0.0, 0.1, 2.0][random.below(3)],
        };
        cuts.planes.truncate(1 + random.below(6));
        cuts
    }

    /// Moves the planes by one frame.
    pub fn drag(&mut self, random: &mut Random) -> SectionPlanes {
        for (_, offset_m) in &mut self.planes {
            *offset_m += f64::from(random.between(-self.drag_m, self.drag_m));
        }
        let plane = |(normal, offset_m): &(DVec3, f64)| SectionPlane::new(*normal, *offset_m);
        let planes: Vec<SectionPlane> =
            self.planes.iter().filter_map(|vector| plane(vector).ok()).collect();
        SectionPlanes::new(&planes, self.mode).unwrap()
    }
}

fn row(count: u32) -> Vec<Aabb> {
    let at = |x: u32| Vec3::new(x as f32 * 2.0 - count as f32, 0.0, -30.0);
    (0..count).map(|x| Aabb::new(at(x), at(x) + 1.0)).collect()
}

fn view(section: SectionPlanes) -> CullView {
    let camera = Camera {
        eye: Vec3::ZERO,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(1.5),
        near: 0.1,
    };
    CullView { section, ..CullView::new(&camera, [64, 64], 8) }
}

fn planned(hierarchy: &Hierarchy, view: &CullView) -> (Culler, FramePlan) {
    let mut culler = Culler::new(CullConfig::default());
    let mut plan = FramePlan::default();
    culler.plan(hierarchy, Strategy::FRUSTUM, view, 0, &mut plan);
    (culler, plan)
}

#[test]
fn what_is_cut_away_counts_as_culled_unless_it_is_whole() {
    let mut hierarchy = Hierarchy::build(&row(20)).unwrap();
    let right = SectionPlane::new(DVec3::X, 0.0).unwrap();
    let section = SectionPlanes::new(&[right], SectionMode::Intersection).unwrap();
    let all = planned(&hierarchy, &view(SectionPlanes::default())).1.draws.len();
    assert_eq!(all, 20);
    let view = view(section);
    let (culler, plan) = planned(&hierarchy, &view);
    assert_eq!(plan.draws.len(), 10);
    assert_eq!(hierarchy.objects_in_frustum(&view), 10);
    let decision = |culler: &Culler, hierarchy: &Hierarchy, plan: &FramePlan, object| {
        culler.explain(hierarchy, &view, plan, ObjectId(object)).map(|explain| explain.decision)
    };
    assert_eq!(decision(&culler, &hierarchy, &plan, 3), Some(Decision::CutAway));
    assert_eq!(decision(&culler, &hierarchy, &plan, 13), Some(Decision::Drawn));
    hierarchy.set_section_member(ObjectId(3), SectionMember::Whole);
    let (culler, plan) = planned(&hierarchy, &view);
    assert_eq!(plan.draws.len(), 11);
    assert_eq!(hierarchy.objects_in_frustum(&view), 11);
    assert_eq!(decision(&culler, &hierarchy, &plan, 3), Some(Decision::Drawn));
}

#[test]
fn views_that_are_drawn_at_once_are_cut_each_by_its_own_planes() {
    let hierarchy = Hierarchy::build(&row(20)).unwrap();
    let half = |normal| {
        let plane = SectionPlane::new(normal, -5.0).unwrap();
        view(SectionPlanes::new(&[plane], SectionMode::Intersection).unwrap())
    };
    let pair = [half(DVec3::X), half(DVec3::NEG_X)];
    let mut plan = FramePlan::default();
    let views = antumbra_cull::MultiView::new(&pair).unwrap();
    Culler::new(CullConfig::default()).plan(&hierarchy, Strategy::FRUSTUM, views, 0, &mut plan);
    let [left, right] = pair.map(|view| hierarchy.objects_in_frustum(&view) as usize);
    assert!(left > 0 && right > 0 && plan.draws.len() == left + right);
}
