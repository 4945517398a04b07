//! Plans and scenes that cannot be: each is refused by its name, and the frames after it are right.

use cull::{Aabb, HierarchyError, Strategy};
use gpu::{Attachments, PredicationMode, vk};
use occlusion::{
    BucketError, BucketTableInfo, Error, HostObject, HostScene, OcclusionPasses, PlanError,
    ShaderSet, TargetError,
};
use tests::run_on_all;

use super::growth::{assert_all_equal, grid};
use super::host::{Host, Mistake, Recorder};
use super::{camera, wall};

const INFO: BucketTableInfo = BucketTableInfo {
    bucket_count: 3,
    draw_capacity: 16,
    predication: Some(PredicationMode::Instances),
    frames_in_flight: 2,
};

fn scene(device: &gpu::Device, objects: usize, info: BucketTableInfo) -> Result<HostScene, Error> {
    let shaders = ShaderSet::embedded().unwrap();
    let attachments = Attachments::default();
    HostScene::new(device, OcclusionPasses::new(device, &shaders, attachments)?, objects, info)
}

#[test]
fn a_plan_is_executed_once_for_its_scene_and_its_views() {
    run_on_all(|device| {
        let mut host = Host::new(device, 3, PredicationMode::Instances, Recorder::Engine);
        host.wall = host.add(vec![wall(3)])[0];
        host.add(grid(100));
        // As large as the host's own.
        let other = scene(device, 128, INFO).unwrap();
        let eye = camera(0.5, 0.0);
        for mistake in [
            Mistake::NoPlan,
            Mistake::SamePlanAgain,
            Mistake::SceneChangedBehindThePlan,
            Mistake::OtherView,
            Mistake::LargeView,
            Mistake::OtherHierarchy,
            Mistake::OtherLeaves,
        ] {
            (0..3).for_each(|_| host.draw(Strategy::ANTUMBRA, &eye));
            let error = host.refused(&eye, mistake, &other);
            let is_named = match mistake {
                Mistake::NoPlan | Mistake::SamePlanAgain => {
                    matches!(error, Error::Plan(PlanError::Missing))
                }
                Mistake::SceneChangedBehindThePlan => {
                    matches!(error, Error::Plan(PlanError::SceneChanged))
                }
                Mistake::OtherView => matches!(error, Error::Plan(PlanError::OtherViews)),
                Mistake::LargeView => {
                    matches!(error, Error::Target(TargetError::ViewSize { .. }))
                }
                Mistake::OtherHierarchy | Mistake::OtherLeaves => {
                    matches!(error, Error::ForeignView)
                }
            };
            assert!(is_named, "{mistake:?}: {error}");
        }
        (0..3).for_each(|_| host.draw(Strategy::ANTUMBRA, &eye));
        assert_all_equal(device, &host, "behind mistakes");
    });
}

#[test]
fn a_bad_box_adds_nothing() {
    run_on_all(|device| {
        let mut scene = scene(device, 8, INFO).unwrap();
        let good = HostObject { bounds: Aabb::new([0.0; 3].into(), [1.0; 3].into()), draws: &[] };
        let bounds = Aabb::new([f32::NAN; 3].into(), [1.0; 3].into());
        let mut added = Vec::new();
        let error = scene.add(&[good, HostObject { bounds, ..good }], &mut added).unwrap_err();
        assert!(error.to_string().contains("object 1 has no usable"), "{error}");
        assert_eq!((added.len(), scene.hierarchy().free_leaves()), (0, 8));
    });
}

#[test]
fn sizes_that_cannot_be_are_refused_before_they_take_memory() {
    run_on_all(|device| {
        let refused = |objects, info| scene(device, objects, info).err().unwrap();
        for objects in [usize::MAX, u32::MAX as usize, 1 << 30] {
            let error = refused(objects, INFO);
            let is_named = matches!(
                error,
                Error::Hierarchy(HierarchyError::TooMany { .. } | HierarchyError::NoMemory { .. })
            );
            assert!(is_named, "{objects}: {error}");
        }
        let error = refused(1, BucketTableInfo { bucket_count: u32::MAX, ..INFO });
        assert!(matches!(error, Error::Buckets(BucketError::TooMany { .. })), "{error}");
        let error = refused(1, BucketTableInfo { frames_in_flight: usize::MAX, ..INFO });
        assert!(error.to_string().contains("frames in flight"), "{error}");
        let error = refused(1, BucketTableInfo { draw_capacity: u32::MAX, ..INFO });
        assert!(error.to_string().contains("the bytes of all draws"), "{error}");
        let shaders = ShaderSet::embedded().unwrap();
        for (attachments, words) in [
            (Attachments { depth: vk::Format::R8G8B8A8_UNORM, ..Default::default() }, "R8G8B8A8"),
            (
                Attachments { samples: vk::SampleCountFlags::TYPE_64, ..Default::default() },
                "TYPE_64 samples per pixel",
            ),
            (
                Attachments { samples: vk::SampleCountFlags::from_raw(3), ..Default::default() },
                "samples per pixel",
            ),
        ] {
            let error = OcclusionPasses::new(device, &shaders, attachments).err().unwrap();
            assert!(error.to_string().contains(words), "{error}");
        }
    });
}
