//! Impossible plans and scenes: the refusal of each names it, and later frames are right.

use cull::{Aabb, CullView, DrawPhases, HierarchyError, Strategy};
use gpu::{Attachments, FrameRing, PredicationMode, Target, vk};
use occlusion::{
    BucketError, CulledScene, CulledSceneOptions, DrawRequest, Error, HostObject, OcclusionPasses,
    ShaderSet, TargetError,
};
use tests::{Driver, open, run, run_on_all};

use super::boxes::SIZE;
use super::growth::{assert_all_equal, grid};
use super::host::{Host, Recorder};
use super::{camera, wall};

fn options() -> CulledSceneOptions<'static> {
    CulledSceneOptions {
        draw_capacity: 16,
        bucket_count: 3,
        predication: Some(PredicationMode::Instances),
        ..Default::default()
    }
}

fn scene(device: &gpu::Device, options: CulledSceneOptions<'_>) -> Result<CulledScene, Error> {
    CulledScene::new(device, Attachments::default(), &options)
}

#[test]
fn views_of_other_scenes_and_sizes_are_refused() {
    run(Driver::Lavapipe, |device| {
        let mut host = Host::new(device, 3, PredicationMode::Instances, Recorder::Engine);
        host.wall = host.add(vec![wall(3)])[0];
        host.add(grid(100));
        let eye = camera(0.5, 0.0);
        (0..3).for_each(|_| host.draw(Strategy::ANTUMBRA, &eye));
        let bits = device.adapter().limits.sub_pixel_precision_bits;
        let view = CullView::new(&eye, SIZE, bits);
        let other = Host::new(device, 3, PredicationMode::Instances, Recorder::Engine);
        let error = host.refused(&view, &mut other.new_view());
        assert!(matches!(error, Error::ForeignView), "{error}");
        (0..3).for_each(|_| host.draw(Strategy::ANTUMBRA, &eye));
        let large = CullView::new(&eye, SIZE.map(|pixels| pixels + 1), bits);
        let error = host.refused(&large, &mut host.new_view());
        assert!(matches!(error, Error::Target(TargetError::ViewSize { .. })), "{error}");
        (0..3).for_each(|_| host.draw(Strategy::ANTUMBRA, &eye));
        assert_all_equal(device, &host, "after mistakes");
    });
}

#[test]
fn frames_of_other_rings_are_refused() {
    run(Driver::Lavapipe, |device| {
        let mut scene = scene(device, options()).unwrap();
        let mut large = FrameRing::new(device, 3).unwrap();
        let refused = scene.begin(large.begin().unwrap()).err().unwrap();
        assert!(matches!(refused, Error::FramesInFlight { ring: 3, scene: 2 }), "{refused}");
        let mut first = FrameRing::new(device, 2).unwrap();
        scene.begin(first.begin().unwrap()).unwrap().submit(None).unwrap();
        let mut second = FrameRing::new(device, 2).unwrap();
        let refused = scene.begin(second.begin().unwrap()).err().unwrap();
        assert!(matches!(refused, Error::OtherRing), "{refused}");
        scene.set_frames_in_flight(2);
        scene.begin(second.begin().unwrap()).unwrap().submit(None).unwrap();
        device.wait_idle().unwrap();
    });
}

#[test]
fn lists_without_their_tests_are_refused() {
    run(Driver::Lavapipe, |device| {
        let target = Target::new(device, SIZE, "lists").unwrap();
        let options = CulledSceneOptions { draw_phases: DrawPhases::Two, ..options() };
        let mut scene = CulledScene::new(device, target.attachments(), &options).unwrap();
        let mut state = scene.new_view(&target).unwrap();
        let bits = device.adapter().limits.sub_pixel_precision_bits;
        let view = CullView::new(&camera(0.0, 0.0), SIZE, bits);
        let mut frames = FrameRing::new(device, 2).unwrap();
        let mut scope = scene.begin(frames.begin().unwrap()).unwrap();
        let planned = scope.plan(&mut state, &view).unwrap();
        drop(scope.list(planned).unwrap());
        let refused = scope.submit(None).unwrap_err();
        assert!(matches!(refused, Error::TestsMissing), "{refused}");
    });
}

#[test]
fn a_bad_box_adds_nothing() {
    run(Driver::Lavapipe, |device| {
        let mut scene =
            scene(device, CulledSceneOptions { object_capacity: 8, ..options() }).unwrap();
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
        let refused = |options| scene(device, options).err().unwrap();
        for objects in [usize::MAX, u32::MAX as usize, 1 << 30] {
            let error = refused(CulledSceneOptions { object_capacity: objects, ..options() });
            let is_named = matches!(
                error,
                Error::Hierarchy(HierarchyError::TooMany { .. } | HierarchyError::NoMemory { .. })
            );
            assert!(is_named, "{objects}: {error}");
        }
        let error = refused(CulledSceneOptions { bucket_count: u32::MAX, ..options() });
        assert!(matches!(error, Error::Buckets(BucketError::TooMany { .. })), "{error}");
        let error = refused(CulledSceneOptions { frames_in_flight: usize::MAX, ..options() });
        assert!(error.to_string().contains("frames in flight"), "{error}");
        let error = refused(CulledSceneOptions { draw_capacity: u32::MAX, ..options() });
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

#[test]
fn a_scope_refuses_what_it_cannot_plan_and_the_end_of_a_frame_in_parts() {
    run_on_all(|device| {
        let target = Target::new(device, SIZE, "parts").unwrap();
        let mut scene = scene(device, options()).unwrap();
        let mut state = scene.new_view(&target).unwrap();
        let bits = device.adapter().limits.sub_pixel_precision_bits;
        let view = CullView::new(&camera(0.0, 0.0), SIZE, bits);
        let mut frames = FrameRing::new(device, 2).unwrap();
        let mut scope = scene.begin(frames.begin().unwrap()).unwrap();
        let strategy = Strategy::new("chc", "a method that decides while it records");
        let request = DrawRequest { strategy, ..DrawRequest::from(&view) };
        let refused = scope.plan(&mut state, request).err().unwrap();
        assert!(matches!(refused, Error::NotPlanned(named) if named == strategy), "{refused}");
        drop(scope);

        // Draws among tests cannot be listed.
        let mut scope = scene.begin(frames.begin().unwrap()).unwrap();
        let planned = scope.plan(&mut state, &view).unwrap();
        assert!(matches!(scope.list(planned).err(), Some(Error::DrawsAmongTests(_))));
        let refused = scope.submit(None).unwrap_err();
        assert!(matches!(refused, Error::Incomplete), "{refused}");
    });
}

#[test]
fn a_frame_of_another_device_is_refused() {
    run(Driver::Lavapipe, |device| {
        let (_instance, other) = open(Driver::Lavapipe);
        let mut frames = FrameRing::new(&other, 2).unwrap();
        let mut scene = scene(device, options()).unwrap();
        let refused = scene.begin(frames.begin().unwrap()).err().unwrap();
        assert!(matches!(refused, Error::Gpu(gpu::Error::Foreign { .. })), "{refused}");
    });
}
