//! Several views in one pass: one plan, one rendering, a layer per view; each layer is the image of
//! its view drawn alone without culling.
//!
//! Runs on SwiftShader, and on newer versions of lavapipe than 22.3. That version draws most of the
//! later views to the first layer, with and without culling, so its multiview is not used.

use cull::{Aabb, Camera, CullView, DrawPhases, MultiView, Projection, Strategy};
use glam::{Vec3, vec3};
use gpu::{
    Attachments, Device, Features, FrameRing, HostDevice, OptionalFeature, Predicates,
    PredicationMode, Purpose, Readback, Target,
};
use occlusion::{
    CulledScene, DrawRequest, Error, OcclusionPasses, OcclusionState, ShaderSet, TargetError,
};
use tests::host_device::Host as HostsDevice;
use tests::numbered_boxes::{NumberedBoxes, TargetBoxes, scene_of_boxes};
use tests::walk::pixels_that_differ;
use tests::{Driver, run_where};

const SIZE: [u32; 2] = [96, 64];
const FRAMES: u32 = 16;

/// Everything that a host keeps to draw its boxes in some views at once.
struct Host {
    device: Device,
    frames: FrameRing,
    scene: CulledScene,
    objects: TargetBoxes,
    state: OcclusionState,
    images: Vec<Readback>,
}

impl Host {
    fn new(device: &Device, boxes: &[Aabb], views: u32, predication: PredicationMode) -> Self {
        let target = Target::layered(device, SIZE, views, "layers").unwrap();
        let attachments = target.attachments();
        let scene = scene_of_boxes(device, boxes, attachments, Some(predication)).unwrap();
        let boxes = NumberedBoxes::new(device, scene.leaves(), attachments).unwrap();
        assert_eq!(scene.testers(&target, DrawPhases::PerRound).compute, views == 1);
        Self {
            device: device.clone(),
            frames: FrameRing::new(device, 2).unwrap(),
            images: Vec::new(),
            state: scene.new_view(&target).unwrap(),
            scene,
            objects: TargetBoxes { target, boxes },
        }
    }

    /// Draws a frame, whose results and image are read when it is over.
    fn draw(&mut self, strategy: Strategy, views: &[CullView]) {
        let Self { device, frames, scene, objects, state, images } = self;
        if views.len() > 1 {
            objects.boxes.take_views(device, views);
        }
        let views = MultiView::new(views).unwrap();
        let request = DrawRequest { strategy, ..DrawRequest::from(views) };
        let mut scope = scene.begin(frames.begin().unwrap()).unwrap();
        scope.draw(state, request, objects).unwrap();
        let [width, height] = SIZE;
        let layers = views.as_slice().len() as u32;
        let image = Readback::new(device, [width, height * layers]).unwrap();
        objects.target.copy_to(scope.commands(), &image);
        images.push(image);
        scope.submit(None).unwrap();
    }

    /// Returns the number of draws of all frames, each counted once for all views.
    fn draws(&mut self) -> u64 {
        self.state.collect(self.device.completed().unwrap(), &self.scene);
        self.state.drain_stats().map(|outcome| outcome.draws).sum()
    }
}

/// Returns a wall and boxes behind it. The boxes at the edge of the wall show.
fn boxes() -> Vec<Aabb> {
    let wall = Aabb::new(vec3(-4.0, -3.0, -6.0), vec3(4.0, 3.0, -5.5));
    let small = (0..600).map(|number| {
        let [x, y, z] = [number % 20, number / 20 % 10, number / 200].map(|part| part as f32);
        let low = vec3(x * 0.7 - 7.0, y * 0.7 - 3.5, -12.0 - z * 1.3 - 0.01 * x);
        Aabb::new(low, low + Vec3::splat(0.45))
    });
    std::iter::once(wall).chain(small).collect()
}

/// Returns the views of a frame. An eye jumps from side to side, so that hidden boxes show at once.
/// The eyes of a pair are far apart, so that they see different boxes.
fn views(device: &Device, count: usize, frame: u32) -> Vec<CullView> {
    let side = (frame / 4 % 3) as f32 - 1.0;
    let eye = vec3(side * 7.0 + frame as f32 * 0.08, 0.0, 3.0);
    let ahead = Camera {
        eye,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(0.9),
        near: 0.1,
    };
    let cameras: Vec<Camera> = match count {
        2 => [-1.5, 1.5].map(|aside| Camera { eye: eye + Vec3::X * aside, ..ahead }).into(),
        _ => [Vec3::NEG_Z, Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z]
            .map(|forward| Camera {
                forward,
                up: if forward.y == 0.0 { Vec3::Y } else { Vec3::X },
                projection: Projection::perspective(std::f32::consts::FRAC_PI_2),
                ..ahead
            })
            .into(),
    };
    let bits = device.adapter().limits.sub_pixel_precision_bits;
    cameras.iter().map(|camera| CullView::new(camera, SIZE, bits)).collect()
}

fn executors(device: &Device) -> Vec<PredicationMode> {
    let all = PredicationMode::ALL;
    all.into_iter()
        .filter(|predication| Predicates::linked(device, Some(*predication), 1, 1).is_ok())
        .collect()
}

/// Returns the images of `count` views in each frame, drawn one by one with everything in the
/// frustum.
fn alone(device: &Device, count: usize) -> Vec<Vec<u8>> {
    let mut host = Host::new(device, &boxes(), 1, executors(device)[0]);
    for frame in 0..FRAMES {
        for view in views(device, count, frame) {
            host.draw(Strategy::FRUSTUM, &[view]);
        }
    }
    device.wait_idle().unwrap();
    let images = host.images.chunks(count);
    images
        .map(|views| views.iter().flat_map(|view| view.rgba8().unwrap().to_vec()).collect())
        .collect()
}

fn compare(device: &Device, count: usize, cases: &[(Strategy, PredicationMode)]) {
    let expected = alone(device, count);
    let walk = |strategy, predication| {
        let mut host = Host::new(device, &boxes(), count as u32, predication);
        for frame in 0..FRAMES {
            host.draw(strategy, &views(device, count, frame));
        }
        device.wait_idle().unwrap();
        let what = format!("{count} views, {strategy}, {}", predication.name());
        for (frame, (expected, image)) in expected.iter().zip(&host.images).enumerate() {
            let wrong = pixels_that_differ(expected, &image.rgba8().unwrap());
            assert_eq!(wrong, 0, "frame {frame} of {what}");
        }
        host.draws()
    };
    let all = walk(Strategy::FRUSTUM, cases[0].1);
    for (strategy, predication) in cases {
        let drawn = walk(*strategy, *predication);
        assert!(drawn > 0 && drawn * 4 < all * 3, "{strategy}: {drawn} of {all}");
    }
}

#[test]
fn a_pair_in_one_pass_looks_like_each_eye_alone() {
    run_where(OptionalFeature::Multiview, |device| {
        let executors = executors(device);
        let mut cases: Vec<_> =
            executors.iter().map(|executor| (Strategy::ANTUMBRA, *executor)).collect();
        cases.extend(executors.iter().map(|executor| (Strategy::ANTUMBRA_QUERIES, *executor)));
        compare(device, 2, &cases);
    });
}

#[test]
fn the_faces_of_a_cube_in_one_pass_look_like_each_alone() {
    run_where(OptionalFeature::Multiview, |device| {
        compare(device, 6, &[(Strategy::ANTUMBRA, executors(device)[0])]);
    });
}

#[test]
fn a_device_without_multiview_is_told_by_its_name() {
    let without = OptionalFeature::Multiview.features();
    // The multiview of lavapipe 22.3 is not used, since it draws wrong images.
    for (driver, without) in
        [(Driver::SwiftShader, without), (Driver::Lavapipe, Features::default())]
    {
        let host = HostsDevice::new(driver, Purpose::Executor);
        let features = host.needs.features().without(without);
        let device = host.try_adopt(HostDevice { features, ..host.describe() }).unwrap();
        if device.capabilities().has(OptionalFeature::Multiview) {
            assert!(driver == Driver::Lavapipe, "{driver:?}: it was not enabled");
            assert!(!device.adapter().driver.contains("Mesa 22.3"), "its images are wrong");
            eprintln!("not tested: {} draws several views at once", device.adapter().name);
            drop(device);
            host.finish();
            continue;
        }
        let attachments = Attachments { views: 2, ..Attachments::default() };
        let passes = OcclusionPasses::new(&device, &ShaderSet::embedded().unwrap(), attachments);
        let error = passes.err().unwrap().to_string();
        assert!(error.contains("multiview"), "{error}");
        drop(device);
        host.finish();
    }
}

#[test]
fn views_without_a_layer_each_are_refused() {
    run_where(OptionalFeature::Multiview, |device| {
        let mut host = Host::new(device, &boxes(), 1, executors(device)[0]);
        let pair = views(device, 2, 0);
        let pair = MultiView::new(&pair).unwrap();
        let mut scope = host.scene.begin(host.frames.begin().unwrap()).unwrap();
        let refused = scope.draw(&mut host.state, pair, &mut host.objects);
        assert!(matches!(refused, Err(Error::Target(TargetError::Views { views: 2, target: 1 }))));
        assert!(Target::layered(device, SIZE, 7, "too many").is_err());
    });
}
