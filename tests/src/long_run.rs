//! A renderer whose scene and settings change by random calls, as those of a program that runs for
//! days do. Its images with culling are those without, and a recovery changes no pixel.

mod calls;
mod content;

use std::collections::BTreeMap;
use std::sync::Arc;

use cull::{Camera, ObjectId, SectionPlanes, Strategy};
use gpu::{Device, Readback};
use render::{FrameRequest, RenderView, Renderer};
use scene::{LightId, Object, ObjectChange, Scene, SkinnedMeshId, TransparentId};

use crate::every_call::{self, Fault, FaultPlan, Lasts};
use crate::walk::pixels_that_differ;
use crate::window_fixture::Random;

pub use calls::Call;
use content::{Came, PANES, SHADOWS, first_camera, first_scene, options};

/// The sizes of images; the first one at first.
const SIZES: [[u32; 2]; 4] = [[64, 36], [27, 48], [33, 17], [80, 30]];

/// The most frames until a loss is noticed, or everything has arrived.
const MOST_FRAMES: usize = 200;

/// The ways to lose a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// The renderer continues on another device, though nothing failed.
    Feigned,
    /// A call reports the loss, through the entry of [`every_call`].
    Injected,
}

/// A renderer, and the model of what it shows.
pub struct LongRun {
    renderer: Renderer,
    /// A view of all strategies, and one without occlusion culling.
    views: [RenderView; 2],
    images: [Readback; 2],
    open: Box<dyn Fn() -> Device>,
    loss: Loss,
    random: Random,
    first: Arc<Scene>,
    objects: BTreeMap<ObjectId, Object>,
    came: Vec<Came>,
    lights: Vec<LightId>,
    strategies: Vec<Strategy>,
    strategy: Strategy,
    camera: Camera,
    /// The number of frames so far.
    pub frames: u64,
    /// The number of images that were compared.
    pub compared: u64,
    /// The number of devices that were lost.
    pub losses: u64,
    /// The calls so far, newest last; a failure names them.
    calls: Vec<Call>,
    seed: u64,
}

impl LongRun {
    /// Creates the renderer of a seed on a device, and others by `open` when it is lost.
    pub fn new(seed: u64, loss: Loss, open: Box<dyn Fn() -> Device>) -> Self {
        let device = open();
        let first = Arc::new(first_scene());
        let mut renderer = Renderer::new(&device, &first, &options(SIZES[0])).expect("a renderer");
        renderer.keep_scene(Arc::clone(&first)).expect("it is unchanged");
        let strategies = methods::strategies().into_iter();
        Self {
            views: [(); 2].map(|()| renderer.new_view().expect("a view")),
            images: images(&device, SIZES[0]),
            renderer,
            open,
            loss,
            random: Random::new(seed),
            objects: (0..).map(ObjectId).zip(first.objects.iter().copied()).collect(),
            first,
            came: Vec::new(),
            lights: Vec::new(),
            strategies: strategies.filter(|s| s.is_exact() && !s.needs_still_scene()).collect(),
            strategy: Strategy::ANTUMBRA,
            camera: first_camera(),
            frames: 0,
            compared: 0,
            losses: 0,
            calls: Vec::new(),
            seed,
        }
    }

    /// Makes a random call of those of long runs, in which costly ones are rare, and draws.
    pub fn step(&mut self) {
        let call = Call::by_weight(&mut self.random);
        self.make(call);
        self.frame();
    }

    /// Makes a random call of those of short sequences, each almost as often as the others, and
    /// draws and compares some frames.
    pub fn step_and_compare(&mut self) {
        let call = Call::of_all(&mut self.random);
        self.make(call);
        for _ in 0..self.random.below(3) {
            self.frame();
        }
        self.compare();
    }

    /// Draws a frame without reading anything back.
    pub fn frame(&mut self) {
        let drawn = self.draw();
        drawn.unwrap_or_else(|error| panic!("{error}: {}", self.context()));
    }

    fn draw(&mut self) -> Result<(), render::Error> {
        self.frames += 1;
        let request = FrameRequest::new(self.strategy, self.camera);
        self.renderer.render(&mut self.views[0], request)?;
        self.views[0].drain_stats();
        Ok(())
    }

    /// Compares an image of the present strategy with that of frustum culling, bit for bit, and
    /// returns it.
    pub fn compare(&mut self) -> Vec<u8> {
        self.settle();
        for (place, strategy) in [self.strategy, Strategy::FRUSTUM].into_iter().enumerate() {
            let request = FrameRequest::new(strategy, self.camera);
            let request = FrameRequest { image: Some(&self.images[place]), ..request };
            self.renderer.render(&mut self.views[place], request).expect("a frame");
        }
        self.renderer.device().wait_idle().expect("it works");
        let [found, expected] = [0, 1].map(|place| {
            self.views[place].drain_stats();
            self.images[place].rgba8().expect("it is over").to_vec()
        });
        self.frames += 2;
        self.compared += 1;
        let wrong = pixels_that_differ(&found, &expected);
        if wrong > 0 {
            let again = self.strategies_again(&expected);
            panic!("{wrong} pixels differ, and in later frames {again}: {}", self.context());
        }
        found
    }

    /// Returns the pixels of later frames that differ from an image, by strategy.
    fn strategies_again(&mut self, expected: &[u8]) -> String {
        let strategies = [self.strategy, Strategy::FRUSTUM, Strategy::ANTUMBRA, Strategy::FRUSTUM];
        let again = strategies.map(|strategy| {
            let request = FrameRequest::new(strategy, self.camera);
            let request = FrameRequest { image: Some(&self.images[0]), ..request };
            self.renderer.render(&mut self.views[0], request).expect("a frame");
            self.renderer.device().wait_idle().expect("it works");
            let found = self.images[0].rgba8().expect("it is over");
            format!("{} with {strategy}", pixels_that_differ(&found, expected))
        });
        again.join(", ")
    }

    /// Draws until everything has arrived on the GPU: what is on its way shows earlier in one of
    /// two frames.
    fn settle(&mut self) {
        for _ in 0..MOST_FRAMES {
            if !self.renderer.is_uploading() {
                return;
            }
            self.frame();
        }
        panic!("uploads do not end: {}", self.context());
    }

    /// Loses the device and continues on another one, with the same image.
    pub fn lose_device(&mut self) {
        let before = self.compare();
        if self.loss == Loss::Injected {
            self.lose_by_a_fault();
        }
        let device = (self.open)();
        self.renderer.recover(&device).unwrap_or_else(|error| panic!("{error}"));
        every_call::stop();
        self.images = images(&device, self.renderer.size());
        self.losses += 1;
        let after = self.compare();
        let wrong = pixels_that_differ(&before, &after);
        assert_eq!(wrong, 0, "pixels after a recovery differ: {}", self.context());
    }

    fn lose_by_a_fault(&mut self) {
        let calls = ["vkQueueSubmit2", "vkWaitSemaphores", "vkGetSemaphoreCounterValue"];
        let call = calls[self.random.below(calls.len() as u32) as usize];
        let fault = Fault {
            call: every_call::number_of(call).expect("the registry has it"),
            nth: self.random.below(3) as usize,
            code: gpu::vk::Result::ERROR_DEVICE_LOST,
            lasts: Lasts::Forever,
        };
        every_call::install(FaultPlan { first: Some(fault), second: None });
        for _ in 0..MOST_FRAMES {
            match self.draw() {
                Ok(()) => {}
                Err(render::Error::Gpu(error)) if error.is_device_lost() => return,
                Err(error) => panic!("{call}: {error}: {}", self.context()),
            }
        }
        panic!("nobody noticed the loss by {call}");
    }

    /// Returns to the first scene and settings: two renderers at rest have the same objects of
    /// Vulkan, whatever they did before.
    pub fn rest(&mut self) {
        let remove = self.objects.keys().map(|object| ObjectChange::Remove { object: *object });
        let remove: Vec<ObjectChange> = remove.collect();
        self.renderer.update(&remove).expect("they are there");
        self.objects.clear();
        for came in std::mem::take(&mut self.came) {
            came.remove(&mut self.renderer);
        }
        let add = self.first.objects.iter().map(|object| ObjectChange::Add { object: *object });
        let add: Vec<ObjectChange> = add.collect();
        let added = self.renderer.update(&add).expect("there is room").added;
        self.objects = added.into_iter().zip(self.first.objects.iter().copied()).collect();
        let renderer = &mut self.renderer;
        // The hierarchy's logs of changes are bounded, but by megabytes: this empties them.
        renderer.rebuild_hierarchy().expect("a hierarchy");
        renderer.remove_lights(&self.lights).expect("they are there");
        self.lights.clear();
        let surfaces = self.first.surfaces.as_ref().expect("surfaces");
        for (light, to) in (0..).map(LightId).zip(&surfaces.lights) {
            renderer.set_light(light, *to).expect("it is there");
        }
        for (pane, first) in (0..PANES).map(TransparentId).zip(&surfaces.transparent) {
            renderer.move_transparent(pane, first.transform).expect("it is there");
        }
        renderer.set_pose(SkinnedMeshId(0), &[], &[0.0]).expect("it is there");
        renderer.set_section(SectionPlanes::default()).expect("none");
        renderer.set_edges(Default::default()).expect("none");
        renderer.set_outlined(&[]).expect("none");
        renderer.set_shadows(SHADOWS).expect("the first ones");
        renderer.set_frames_in_flight(2).expect("as at first");
        self.strategy = Strategy::ANTUMBRA;
        self.camera = first_camera();
        self.resize(SIZES[0]);
        for _ in 0..8 {
            self.compare();
        }
    }

    fn resize(&mut self, size: [u32; 2]) {
        self.renderer.resize(size).expect("a small size");
        self.images = images(self.renderer.device(), size);
    }

    /// Returns what repeats a failure.
    fn context(&self) -> String {
        let newest = &self.calls[self.calls.len().saturating_sub(20)..];
        format!(
            "seed {}, frame {}, {} at {:?}, {} in flight, {:?}, {} section planes, {:?}, {} lights, \
             after {newest:?}",
            self.seed,
            self.frames,
            self.strategy,
            self.renderer.size(),
            self.renderer.frames_in_flight(),
            self.renderer.shadows().method,
            self.renderer.section().planes().len(),
            self.renderer.edges().mode,
            self.lights.len()
        )
    }
}

fn images(device: &Device, size: [u32; 2]) -> [Readback; 2] {
    [(); 2].map(|()| Readback::new(device, size).expect("memory"))
}
