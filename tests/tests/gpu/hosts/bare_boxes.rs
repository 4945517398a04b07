//! The executor with another owner of objects than the renderer: a host that draws boxes by a
//! pipeline of its own, with neither meshes nor materials.

use cull::{Aabb, Camera, CullView, LeafIndex, Strategy};
use glam::Vec3;
use gpu::{Device, FrameRing, Readback, Target};
use occlusion::{
    AntumbraMethod, CulledScene, DrawRequest, Error, MeshDrawId, Method, MethodRequest,
    OcclusionState,
};
use tests::host_walk::{boxes, camera};
use tests::numbered_boxes::{NumberedBoxes, TargetBoxes, scene_of_boxes};
use tests::walk::images_that_differ;
use tests::{Driver, run};

const SIZE: [u32; 2] = [160, 90];
const FRAMES: u64 = 18;

/// Everything that a host keeps to draw its boxes by our answers.
struct Host {
    device: Device,
    frames: FrameRing,
    scene: CulledScene,
    objects: TargetBoxes,
    state: OcclusionState,
    images: Vec<Readback>,
}

impl Host {
    fn new(device: &Device, boxes: &[Aabb]) -> Self {
        let target = Target::new(device, SIZE, "bare boxes").unwrap();
        let attachments = target.attachments();
        let scene = scene_of_boxes(device, boxes, attachments, None).unwrap();
        let boxes = NumberedBoxes::new(device, scene.leaves(), attachments).unwrap();
        Self {
            device: device.clone(),
            frames: FrameRing::new(device, 2).unwrap(),
            images: Vec::new(),
            state: scene.new_view(&target).unwrap(),
            scene,
            objects: TargetBoxes { target, boxes },
        }
    }

    /// Draws a frame by a plan, as a renderer does. The frame's results and image are read when it
    /// is over.
    fn draw(&mut self, strategy: Strategy, camera: &Camera) {
        let Self { device, frames, scene, objects, state, images } = self;
        let view = CullView::new(camera, SIZE, device.adapter().limits.sub_pixel_precision_bits);
        let mut frame = frames.begin().unwrap();
        state.collect(device.completed().unwrap(), scene);
        let request = MethodRequest { strategy, view: &view, visible: &[], after: None };
        AntumbraMethod.plan(state, scene, &request, 4096);
        AntumbraMethod.record(&mut frame, state, scene, objects, &request).unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        objects.target.copy_to(frame.commands(), &image);
        images.push(image);
        let tick = frame.submit(None).unwrap();
        state.submitted(tick, scene, None);
    }
}

#[test]
fn an_owner_of_bare_boxes_gets_the_same_image_and_draws_less() {
    run(Driver::Lavapipe, |device| {
        let boxes = boxes();
        let [mut plain, mut culled] = [(); 2].map(|()| Host::new(device, &boxes));
        // No wait between the frames, so that results are late. The eye jumps to another side of
        // the wall, so that hidden boxes show at once.
        for frame in 0..FRAMES {
            let camera = camera(frame);
            plain.draw(Strategy::FRUSTUM, &camera);
            culled.draw(Strategy::ANTUMBRA, &camera);
        }
        device.wait_idle().unwrap();
        for (frame, images) in plain.images.iter().zip(&culled.images).enumerate() {
            assert_eq!(images_that_differ(images.0, images.1), 0, "frame {frame}");
        }
        for host in [&mut plain, &mut culled] {
            let completed = host.device.completed().unwrap();
            host.state.collect(completed, &host.scene);
        }
        let drawn = |host: &mut Host| host.state.drain_stats().next_back().unwrap().draws;
        let [all, few] = [&mut plain, &mut culled].map(drawn);
        assert!(few > 1 && few < all / 2, "{few} of {all} boxes drawn");
    });
}

#[test]
fn a_plan_of_many_rounds_is_refused_as_lists() {
    run(Driver::Lavapipe, |device| {
        let mut host = Host::new(device, &boxes());
        let camera = Camera::look_at([0.0, 0.0, 3.0], [0.0, 0.0, 0.0]);
        let view = CullView::new(&camera, SIZE, device.adapter().limits.sub_pixel_precision_bits);
        let mut scope = host.scene.begin(host.frames.begin().unwrap()).unwrap();
        let planned = scope.plan(&mut host.state, &view).unwrap();
        assert!(planned.state().plan().rounds.len() > 1, "{:?}", planned.state().plan().rounds);
        let refused = scope.list(planned).err().unwrap();
        assert!(matches!(refused, Error::DrawsAmongTests(_)), "{refused}");
        assert!(refused.to_string().contains("DrawPhases::Two"), "{refused}");
        // The frame lacks the view, and is given up.
        assert!(matches!(scope.submit(None), Err(Error::Incomplete)));
        assert!(host.state.visible_lists().is_empty() && host.state.revealed_lists().is_empty());
        // The next frame draws.
        host.draw(Strategy::ANTUMBRA, &camera);
        device.wait_idle().unwrap();
        host.state.collect(device.completed().unwrap(), &host.scene);
        let draws: u64 = host.state.drain_stats().map(|outcome| outcome.draws).sum();
        assert!(draws > 0 && draws < 900, "{draws} drawn");
    });
}

/// Checks that a method which executes a plan that it did not make, or a scene with changes that
/// the frame lacks, is refused, and that the next frame is drawn.
#[test]
fn a_method_out_of_order_is_refused() {
    run(Driver::Lavapipe, |device| {
        let mut host = Host::new(device, &boxes());
        let camera = Camera::look_at([0.0, 0.0, 3.0], [0.0, 0.0, 0.0]);
        let view = CullView::new(&camera, SIZE, device.adapter().limits.sub_pixel_precision_bits);
        let request =
            MethodRequest { strategy: Strategy::ANTUMBRA, view: &view, visible: &[], after: None };
        let Host { frames, scene, objects, state, .. } = &mut host;
        let record = |frame: &mut _, state: &mut _, scene: &mut _, objects: &mut TargetBoxes| {
            AntumbraMethod.record(frame, state, scene, objects, &request).map(drop)
        };
        let mut frame = frames.begin().unwrap();
        let refused = record(&mut frame, state, scene, objects).unwrap_err();
        assert!(matches!(refused, Error::NoPlan), "{refused}");
        let broken = CullView { anchor: Vec3::NAN, ..view };
        let of_broken = MethodRequest { view: &broken, ..request };
        AntumbraMethod.plan(state, scene, &of_broken, 4096);
        let refused = record(&mut frame, state, scene, objects).unwrap_err();
        assert!(matches!(refused, Error::NoPlan), "the view is not a number: {refused}");
        AntumbraMethod.plan(state, scene, &request, 4096);
        scene.parts_mut().leaves.mark_dirty(LeafIndex(0), MeshDrawId(0));
        let refused = record(&mut frame, state, scene, objects).unwrap_err();
        assert!(matches!(refused, Error::NoPlan), "the scene has changed: {refused}");
        AntumbraMethod.plan(state, scene, &request, 4096);
        let refused = record(&mut frame, state, scene, objects).unwrap_err();
        assert!(matches!(refused, Error::NotUploaded(_)), "{refused}");
        drop(frame);
        let mut scope = scene.begin(frames.begin().unwrap()).unwrap();
        scope.draw(state, &view, objects).unwrap();
        scope.submit(None).unwrap();
        device.wait_idle().unwrap();
    });
}

/// Checks a view on a part of its target whose owner restricts no rendering: draws and tests have
/// the view's viewport.
#[test]
fn a_view_on_a_part_of_its_target_is_exact() {
    run(Driver::Lavapipe, |device| {
        let [plain, culled] = [Strategy::FRUSTUM, Strategy::ANTUMBRA].map(|strategy| {
            let mut host = Host::new(device, &boxes());
            for frame in 0..FRAMES {
                let camera = camera(frame);
                let bits = device.adapter().limits.sub_pixel_precision_bits;
                let view = CullView::new(&camera, [SIZE[0] / 2, SIZE[1] - 20], bits);
                let view = CullView { origin: [70, 13], ..view };
                let request = DrawRequest { strategy, ..DrawRequest::from(&view) };
                let mut scope = host.scene.begin(host.frames.begin().unwrap()).unwrap();
                scope.draw(&mut host.state, request, &mut host.objects).unwrap();
                let image = Readback::new(device, SIZE).unwrap();
                host.objects.target.copy_to(scope.commands(), &image);
                host.images.push(image);
                scope.submit(None).unwrap();
            }
            device.wait_idle().unwrap();
            host.state.collect(device.completed().unwrap(), &host.scene);
            host
        });
        let mut hosts = [plain, culled];
        for frame in 0..FRAMES as usize {
            let [plain, culled] = hosts.each_ref().map(|host| &host.images[frame]);
            let seen = plain.rgba8().unwrap().chunks_exact(4).any(|pixel| pixel[..3] != [0; 3]);
            assert!(seen, "frame {frame}");
            assert_eq!(images_that_differ(plain, culled), 0, "frame {frame}");
        }
        let [all, few] = hosts
            .each_mut()
            .map(|host| host.state.drain_stats().map(|outcome| outcome.draws).sum::<u64>());
        assert!(few < all / 2, "{few} of {all} boxes drawn");
    });
}
