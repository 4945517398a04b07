//! The executor with another owner of objects than the renderer: a host that draws boxes by a
//! pipeline of its own, with neither meshes nor materials.

use std::sync::Arc;

use cull::{
    Aabb, Camera, CullConfig, CullView, Culler, DrawPhases, Hierarchy, Projection, Strategy,
};
use glam::{Vec3, vec3};
use gpu::{Commands, Device, FrameRing, IndirectDraw, Readback, RenderTarget, Target};
use occlusion::{
    AntumbraMethod, BucketId, Error, LeafTable, LeafTableInfo, MeshDraw, MeshDrawId, Method,
    MethodRequest, MethodScene, ObjectPass, ObjectRenderer, OcclusionPasses, OcclusionState,
    PlanExecutor, Rendering, ShaderSet, execute, list_draws,
};
use tests::numbered_boxes::{BOX_INDICES, NumberedBoxes};
use tests::walk::pixels_that_differ;
use tests::{Driver, run};

const SIZE: [u32; 2] = [160, 90];
const FRAMES: u32 = 24;

/// The owner of the boxes.
struct Boxes {
    target: Target,
    boxes: NumberedBoxes,
}

impl Boxes {
    fn new(device: &Device, leaves: &LeafTable) -> Self {
        let target = Target::new(device, SIZE, "bare boxes").unwrap();
        Self { boxes: NumberedBoxes::new(device, leaves, target.attachments()), target }
    }
}

impl ObjectRenderer for Boxes {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, view: &CullView, rendering: Rendering) -> RenderTarget {
        let clear = (rendering == Rendering::First).then_some([0.0, 0.0, 0.0, 1.0]);
        self.target.render_target(clear).within(view.origin, view.size)
    }

    fn bind(&self, commands: &Commands, view: &CullView, _bucket: BucketId, _pass: ObjectPass) {
        self.boxes.bind(commands, view);
    }
}

/// Everything that a host keeps to draw its boxes by our answers.
struct Host {
    device: Device,
    shaders: ShaderSet,
    frames: FrameRing,
    hierarchy: Hierarchy,
    executor: PlanExecutor,
    objects: Boxes,
    state: OcclusionState,
    images: Vec<Readback>,
}

impl Host {
    fn new(device: &Device, boxes: &[Aabb]) -> Self {
        let shaders = ShaderSet::embedded().unwrap();
        let hierarchy = Hierarchy::build(boxes).unwrap();
        let draw =
            IndirectDraw { index_count: BOX_INDICES, instance_count: 1, ..Default::default() };
        let info = LeafTableInfo {
            mesh_draws: Arc::new([MeshDraw { draw, triangles: BOX_INDICES / 3 }]),
            predication: None,
            frames_in_flight: 2,
        };
        let leaves = LeafTable::new(device, &hierarchy, info, |_| MeshDrawId(0)).unwrap();
        let objects = Boxes::new(device, &leaves);
        let passes = OcclusionPasses::new(device, &shaders, objects.target.attachments()).unwrap();
        let executor = PlanExecutor { passes, leaves };
        let testers = executor.testers(device, &objects.target, DrawPhases::PerRound);
        let culler = Culler::with_testers(CullConfig::default(), testers);
        let state = OcclusionState::new(device, &hierarchy, &executor.leaves, 2, culler).unwrap();
        Self {
            device: device.clone(),
            frames: FrameRing::new(device, 2).unwrap(),
            images: Vec::new(),
            shaders,
            hierarchy,
            executor,
            objects,
            state,
        }
    }

    /// Draws a frame, whose results and image come back when it is over.
    fn draw(&mut self, strategy: Strategy, camera: &Camera) {
        let Self { device, shaders, frames, hierarchy, executor, objects, state, images } = self;
        let view = CullView::new(camera, SIZE, device.adapter().limits.sub_pixel_precision_bits);
        let mut frame = frames.begin().unwrap();
        state.collect(device.completed().unwrap(), hierarchy, &executor.leaves);
        let mut scene = MethodScene { device, shaders, hierarchy, executor, objects };
        let request = MethodRequest { strategy, view: &view, visible: &[], after: None };
        AntumbraMethod.plan(state, &mut scene, &request, 4096);
        AntumbraMethod.record(&mut frame, state, &mut scene, &request).unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        objects.target.copy_to(frame.commands(), &image);
        images.push(image);
        let tick = frame.submit(None).unwrap();
        state.submitted(tick, &executor.leaves, None);
    }
}

/// Returns a wall, and a thousand boxes behind it of which those at its edge show.
fn boxes() -> Vec<Aabb> {
    let wall = Aabb::new(vec3(-4.0, -3.0, -6.0), vec3(4.0, 3.0, -5.5));
    let small = (0..1_000).map(|number| {
        let [x, y, z] = [number % 20, number / 20 % 10, number / 200].map(|part| part as f32);
        let low = vec3(x * 0.7 - 7.0, y * 0.7 - 3.5, -12.0 - z * 1.3 - 0.01 * x);
        Aabb::new(low, low + Vec3::splat(0.45))
    });
    std::iter::once(wall).chain(small).collect()
}

#[test]
fn an_owner_of_bare_boxes_gets_the_same_image_and_draws_less() {
    run(Driver::Lavapipe, |device| {
        let boxes = boxes();
        let [mut plain, mut culled] = [(); 2].map(|()| Host::new(device, &boxes));
        // Nothing waits between the frames, so that results are late; the eye jumps to another side
        // of the wall, so that hidden boxes show at once.
        for frame in 0..FRAMES {
            let side = (frame / 6 % 3) as f32 - 1.0;
            let eye = vec3(side * 9.0 + frame as f32 * 0.08, 0.0, 3.0);
            let camera = Camera {
                eye,
                forward: Vec3::NEG_Z,
                up: Vec3::Y,
                projection: Projection::perspective(0.9),
                near: 0.1,
            };
            plain.draw(Strategy::FRUSTUM, &camera);
            culled.draw(Strategy::ANTUMBRA, &camera);
        }
        device.wait_idle().unwrap();
        for (frame, images) in plain.images.iter().zip(&culled.images).enumerate() {
            let [plain, culled] = [images.0, images.1].map(|image| image.rgba8().unwrap());
            assert_eq!(pixels_that_differ(&plain, &culled), 0, "frame {frame}");
        }
        for host in [&mut plain, &mut culled] {
            let completed = host.device.completed().unwrap();
            host.state.collect(completed, &host.hierarchy, &host.executor.leaves);
        }
        let drawn = |host: &mut Host| host.state.drain_stats().next_back().unwrap().draws;
        let [all, few] = [&mut plain, &mut culled].map(drawn);
        assert!(few > 1 && few < all / 2, "{few} of {all} boxes drawn");
    });
}

/// Checks that a plan with draws among its tests is not listed, but still executed in its frame.
#[test]
fn a_plan_of_many_rounds_is_refused_as_lists_and_drawn_by_the_engine() {
    run(Driver::Lavapipe, |device| {
        let mut host = Host::new(device, &boxes());
        let Host { shaders, frames, hierarchy, executor, objects, state, .. } = &mut host;
        let camera = Camera {
            eye: vec3(0.0, 0.0, 3.0),
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(0.9),
            near: 0.1,
        };
        let view = CullView::new(&camera, SIZE, device.adapter().limits.sub_pixel_precision_bits);
        let mut frame = frames.begin().unwrap();
        state.plan_frame(hierarchy, &executor.leaves, Strategy::ANTUMBRA, &view, 4096);
        assert!(state.plan().rounds.len() > 1, "{:?}", state.plan().rounds);
        let refused = list_draws(&mut frame, executor, state, &view).err().unwrap();
        assert!(matches!(refused, Error::DrawsAmongTests(_)), "{refused}");
        assert!(refused.to_string().contains("DrawPhases::Two"), "{refused}");
        assert!(state.visible_lists().is_empty() && state.revealed_lists().is_empty());
        execute(&mut frame, executor, state, objects, &*shaders, &view).unwrap();
        let tick = frame.submit(None).unwrap();
        state.submitted(tick, &executor.leaves, None);
        device.wait_idle().unwrap();
        state.collect(device.completed().unwrap(), hierarchy, &executor.leaves);
        let draws: u64 = state.drain_stats().map(|outcome| outcome.draws).sum();
        assert!(draws > 0 && draws < 900, "{draws} drawn");
    });
}
