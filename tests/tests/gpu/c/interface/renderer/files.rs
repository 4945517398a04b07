//! Renderers of a file in C: textured, animated, with shadows. Their images equal those of the same
//! file in Rust, at several times, and continue after the loss of a device.

use std::ffi::CString;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::ptr::null;
use std::sync::{Arc, Mutex};

use capi::api::device::antumbra_device_destroy;
use capi::api::playback::*;
use capi::api::renderer::*;
use capi::api::scene_file::*;
use capi::decisions::camera::AntumbraCamera;
use capi::decisions::culler::{ANTUMBRA_STRATEGY_ANTUMBRA, ANTUMBRA_STRATEGY_FRUSTUM};
use capi::error::AntumbraResult::{BadArgument, DeviceLost, Ok, UnknownHandle};
use capi::executor::queue::AntumbraQueueDesc;
use capi::layout::Versioned;
use capi::renderer::description::*;
use capi::renderer::frame::{AntumbraRenderDesc, AntumbraRenderer};
use capi::renderer::scene_file::*;
use capi::renderer::shadows::*;
use cull::{ClipY, DepthConvention, Strategy, ViewProjection};
use gpu::{Features, Purpose};
use import::SceneAnimator;
use render::{CostModel, FrameRequest, LightShadow, Renderer, RendererOptions};
use scene::LightId;
use shadows::{ShadowMethod, ShadowOptions};
use tests::fault_injection::FaultInjection;
use tests::host_device::Host;
use tests::{Driver, drivers};

use super::super::{expect, text};
use super::loss::lose;
use super::{CHost, SIZE, adopt, box_of, mesh_desc, vertices_of};

/// Small shadow maps.
pub(super) static MAPS: AntumbraShadowDesc = AntumbraShadowDesc {
    method: ANTUMBRA_SHADOWS_MAPS,
    map_side: 256,
    cascades: 2,
    distance: 40.0,
    penumbra: 0.1,
    ..AntumbraShadowDesc::INIT
};

/// Returns the path of the file: a wall with crates behind it, one that spins, one that is lifted,
/// a flag with bones, a sun, a lamp that swings, a camera that glides and one that is still.
pub(super) fn yard() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../engine/capi/examples/files/yard.gltf")
}

/// Returns the description of a renderer of a file.
pub(super) fn desc_of(file: AntumbraSceneFile) -> AntumbraRendererDesc {
    AntumbraRendererDesc {
        width: SIZE[0],
        height: SIZE[1],
        scene_file: file,
        shadows: &raw const MAPS,
        cost_model: ANTUMBRA_COST_MODEL_OFF,
        ..Versioned::INIT
    }
}

impl CHost<'_> {
    /// Loads the file.
    pub(super) fn file(&mut self) -> AntumbraSceneFile {
        let path = CString::new(yard().to_str().unwrap()).unwrap();
        let desc = AntumbraSceneFileDesc { path: path.as_ptr(), ..Versioned::INIT };
        let mut file = AntumbraSceneFile { id: 0 };
        // SAFETY: pointers to values on this stack, here and below.
        let loaded =
            unsafe { antumbra_scene_file_load(self.context, &desc, &mut file, &mut self.error) };
        assert_eq!(loaded, Ok, "{}", text(&self.error));
        file
    }

    /// Returns a renderer of the file.
    pub(super) fn of_file(&mut self, file: AntumbraSceneFile) -> AntumbraRenderer {
        let (created, renderer) = self.create(&desc_of(file));
        assert_eq!(created, Ok, "{}", text(&self.error));
        renderer
    }

    /// Plays all clips that can play together from the time 0 on.
    pub(super) fn play_all(&mut self, renderer: AntumbraRenderer) {
        let all = ANTUMBRA_ALL_CLIPS;
        // SAFETY: as above.
        let played = unsafe {
            antumbra_renderer_play(self.context, renderer, null(), all, 0.0, 0.0, &mut self.error)
        };
        assert_eq!(played, Ok, "{}", text(&self.error));
    }

    /// Moves the scene to a time.
    pub(super) fn advance(&mut self, renderer: AntumbraRenderer, seconds: f64) {
        // SAFETY: as above.
        let moved =
            unsafe { antumbra_renderer_advance(self.context, renderer, seconds, &mut self.error) };
        assert_eq!(moved, Ok, "{}", text(&self.error));
    }

    /// Returns a camera of the file.
    pub(super) fn camera(&mut self, renderer: AntumbraRenderer, index: u32) -> AntumbraCamera {
        let mut camera = AntumbraCamera::INIT;
        // SAFETY: as above.
        let told = unsafe {
            antumbra_renderer_camera(self.context, renderer, index, &mut camera, &mut self.error)
        };
        assert_eq!(told, Ok, "{}", text(&self.error));
        camera
    }

    /// Returns the image of a camera of the file, which is the same with all objects drawn.
    #[track_caller]
    pub(super) fn seen(&mut self, renderer: AntumbraRenderer, index: u32) -> Vec<u8> {
        let camera = self.camera(renderer, index);
        let strategies = [ANTUMBRA_STRATEGY_FRUSTUM, ANTUMBRA_STRATEGY_ANTUMBRA];
        let [plain, culled] = strategies.map(|strategy| {
            let desc = AntumbraRenderDesc { strategy, camera: &camera, ..Versioned::INIT };
            self.image_of(renderer, &desc)
        });
        assert!(plain == culled, "the images differ");
        plain
    }
}

/// The file in a renderer in Rust.
pub(super) struct RustFile<'a> {
    host: &'a Host,
    lock: Arc<Mutex<()>>,
    renderer: Renderer,
    animator: SceneAnimator,
    cameras: Vec<import::SceneCamera>,
}

impl<'a> RustFile<'a> {
    pub(super) fn new(host: &'a Host) -> Self {
        let lock = Arc::new(Mutex::new(()));
        let device = host.adopt(Some(host.share_queue(lock.clone())));
        let go_on = &mut |_| ControlFlow::Continue(());
        let loaded = import::load(&yard(), &Default::default(), go_on).unwrap();
        let (scene, mut animator, cameras, _) = SceneAnimator::of(loaded);
        let options = RendererOptions {
            size: SIZE,
            cost_model: CostModel::Off,
            shadows: ShadowOptions {
                method: ShadowMethod::Maps,
                sun_side: MAPS.map_side,
                cascades: MAPS.cascades,
                distance_m: Some(MAPS.distance),
                penumbra_m: MAPS.penumbra,
                ..ShadowOptions::default()
            },
            ..RendererOptions::default()
        };
        let mut renderer = Renderer::new(&device, &scene, &options).unwrap();
        animator.play(&animator.compatible(None), 0.0, 0.0);
        renderer.apply(animator.changes(0.0)).unwrap();
        Self { host, lock, renderer, animator, cameras }
    }

    /// Sets the shadow of a light.
    pub(super) fn set_light_shadow(&mut self, light: u32, shadow: LightShadow) {
        self.renderer.set_light_shadow(LightId(light), Some(shadow)).unwrap();
    }

    /// Returns the image of a camera at a time, with all objects drawn.
    pub(super) fn seen(&mut self, seconds: f64, camera: usize) -> Vec<u8> {
        self.renderer.apply(self.animator.changes(seconds)).unwrap();
        let camera = self.animator.seen_by(&self.cameras[camera], SIZE);
        let matrix = self.renderer.view_of(&camera).view_proj;
        let viewpoint = ViewProjection { matrix, depth: DepthConvention::Reversed, y: ClipY::Down };
        let mut view = self.renderer.new_view().unwrap();
        self.renderer.render(&mut view, FrameRequest::new(Strategy::FRUSTUM, viewpoint)).unwrap();
        let image = self.host.copy(&*self.lock, &self.renderer.finished_image().unwrap());
        self.renderer.wait_idle(&mut view).unwrap();
        image
    }
}

#[test]
fn a_file_in_c_looks_as_in_rust_at_every_time_and_is_at_rest_without_clips() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let file = c.file();
        let renderer = c.of_file(file);
        let at_rest = c.seen(renderer, 0);
        let mut colours: Vec<&[u8]> = at_rest.chunks_exact(4).collect();
        colours.sort_unstable();
        colours.dedup();
        assert!(colours.len() > 300, "{} colours of textures and shadows", colours.len());

        let mut rust = RustFile::new(&host);
        c.play_all(renderer);
        let mut images = vec![at_rest.clone()];
        for seconds in [0.7, 1.6, 0.2] {
            c.advance(renderer, seconds);
            for camera in [1, 0] {
                let image = c.seen(renderer, camera);
                assert!(
                    image == rust.seen(seconds, camera as usize),
                    "{seconds} s: not as in Rust"
                );
                assert!(!images.contains(&image), "{seconds} s: nothing moved");
                images.push(image);
            }
        }
        drop(rust);
        // The camera was cut to and fro; now it stays.
        for _ in 0..4 {
            c.seen(renderer, 0);
        }
        let stats = c.stats(renderer);
        assert!(stats.drawn < stats.total && stats.total == 17, "the wall hides: {stats:?}");

        // Without clips everything returns to rest; another renderer of the file was there always.
        let x = c.context;
        // SAFETY: pointers to values on this stack.
        unsafe {
            let played = antumbra_renderer_play(x, renderer, null(), 0, 2.0, 0.0, &mut c.error);
            assert_eq!(played, Ok, "{}", text(&c.error));
        }
        c.advance(renderer, 2.0);
        // Places are computed in another way than in the file's scene, so last bits may differ.
        let bytes = c.seen(renderer, 0).into_iter().zip(&at_rest);
        let most = bytes.map(|(byte, at_rest)| byte.abs_diff(*at_rest)).max();
        assert!(most <= Some(2), "not at rest: {most:?}");
        let other = c.of_file(file);
        // SAFETY: as above.
        let gone = unsafe { antumbra_scene_file_destroy(x, file, &mut c.error) };
        assert_eq!(gone, Ok, "{}", text(&c.error));
        assert!(c.seen(other, 0) == at_rest, "one file, two scenes");
        let everything = c.seen(other, ANTUMBRA_CAMERA_OVERVIEW);
        assert!(everything != at_rest, "the overview is another view");
        c.finish();
        host.finish();
    }
}

#[test]
fn meshes_and_objects_of_the_host_are_added_to_the_scene_of_a_file() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    let mut c = CHost::new(&host);
    let file = c.file();
    let mut desc = desc_of(file);
    desc.spare_objects = 1;
    desc.spare_meshes = 1;
    desc.spare_vertices = 36;
    desc.spare_indices = 36;
    let (created, renderer) = c.create(&desc);
    assert_eq!(created, Ok, "{}", text(&c.error));
    let before = c.seen(renderer, 0);
    let mesh = box_of([0.1, 0.2, 0.9]);
    let vertices = vertices_of(&mesh);
    let desc = mesh_desc(&vertices, &mesh.indices);
    let columns = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, -0.5, 0.0, 2.5];
    let transform = AntumbraTransform { columns };
    let x = c.context;
    let mut ids = [0; 2];
    // SAFETY: pointers to values on this stack.
    unsafe {
        let error = &mut c.error;
        let mesh = &&raw const desc;
        let added = antumbra_renderer_add_meshes(x, renderer, mesh, 1, &mut ids[0], error);
        assert_eq!(added, Ok, "{}", text(error));
        let object = AntumbraMeshObject { mesh: ids[0], tint: 0, transform };
        let added = antumbra_renderer_add_objects(x, renderer, &object, 1, &mut ids[1], error);
        assert_eq!(added, Ok, "{}", text(error));
    }
    c.image(renderer, ANTUMBRA_STRATEGY_ANTUMBRA);
    let after = c.seen(renderer, 0);
    let is_blue = |pixel: &[u8]| pixel[2] > pixel[0].saturating_add(60);
    let blue = |image: &[u8]| image.chunks_exact(4).filter(|pixel| is_blue(pixel)).count();
    let [before, after] = [before, after].map(|image| blue(&image));
    assert!(after > before + 30, "{after} blue pixels, {before} without the box");

    // Without its objects the file goes on, and moves no object of the host in their place.
    let all: Vec<u32> = (0..17).collect();
    c.play_all(renderer);
    // SAFETY: as above.
    unsafe {
        let error = &mut c.error;
        let at = all.as_ptr();
        let gone = antumbra_renderer_remove_objects(x, renderer, at, all.len(), error);
        assert_eq!(gone, Ok, "{}", text(error));
        let more = vec![AntumbraMeshObject { mesh: ids[0], tint: 0, transform }; all.len()];
        let mut taken = all.clone();
        let at = more.as_ptr();
        let put = taken.as_mut_ptr();
        let added = antumbra_renderer_add_objects(x, renderer, at, all.len(), put, error);
        assert_eq!(added, Ok, "{}", text(error));
        taken.sort_unstable();
        assert_eq!(taken, all, "ids are used again");
    }
    c.advance(renderer, 0.0);
    let still = c.seen(renderer, 1);
    c.advance(renderer, 0.7);
    let still_later = c.seen(renderer, 1);
    let differing = still.iter().zip(&still_later).filter(|(one, other)| one != other).count();
    let [still, still_later] = [still, still_later].map(|image| blue(&image));
    assert!(still > 0 && still == still_later, "{differing} bytes differ");
    c.finish();
    host.finish();
}

#[test]
fn mistakes_with_files_clips_and_cameras_are_named_and_change_nothing() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    let mut c = CHost::new(&host);
    let file = c.file();
    let mesh = box_of([0.5; 3]);
    let vertices = vertices_of(&mesh);
    let mesh_desc = mesh_desc(&vertices, &mesh.indices);
    let meshes = [&raw const mesh_desc];
    let light = AntumbraSunlight::INIT;
    let good = desc_of(file);
    let object = AntumbraMeshObject {
        mesh: 0,
        tint: 0,
        transform: AntumbraTransform { columns: [0.0; 12] },
    };
    let of_meshes = AntumbraRendererDesc {
        scene_file: AntumbraSceneFile { id: 0 },
        meshes: meshes.as_ptr(),
        mesh_count: 1,
        ..good
    };
    for (desc, result, words) in [
        (AntumbraRendererDesc { scene_file: file, ..of_meshes }, BadArgument, "desc.meshes is set"),
        (
            AntumbraRendererDesc { objects: &raw const object, object_count: 1, ..good },
            BadArgument,
            "desc.objects is set beside desc.scene_file",
        ),
        (
            AntumbraRendererDesc { light: &raw const light, ..good },
            BadArgument,
            "desc.light is set",
        ),
        (
            AntumbraRendererDesc { scene_file: AntumbraSceneFile { id: c.device.id }, ..good },
            UnknownHandle,
            "no scene file",
        ),
    ] {
        let (refused, _) = c.create(&desc);
        expect(refused, result, words, &c.error);
    }
    let renderer = c.of_file(file);
    c.play_all(renderer);
    c.advance(renderer, 0.7);
    let before = c.seen(renderer, 0);
    let (created, plain) = c.create(&of_meshes);
    assert_eq!(created, Ok, "{}", text(&c.error));
    let x = c.context;
    let e = &raw mut c.error;
    let mut camera = AntumbraCamera::INIT;
    let known_and_unknown = [1, 7];
    let clips = known_and_unknown.as_ptr();
    // SAFETY: pointers to values on this stack.
    let refused = unsafe {
        let play = |renderer, count, seconds, fade| {
            let result = antumbra_renderer_play(x, renderer, clips, count, seconds, fade, e);
            (result, text(&*e).to_owned())
        };
        let camera = &raw mut camera;
        let told = |result| (result, text(&*e).to_owned());
        [
            (play(renderer, 2, 0.0, 0.0), "clips[1] is 7, and the file has 4 clips"),
            (play(renderer, 1, f64::NAN, 0.0), "seconds is NaN"),
            (play(renderer, 1, 0.0, f64::INFINITY), "fade_seconds is inf"),
            (play(renderer, 1, 0.0, -1.0), "fade_seconds is -1, below 0"),
            (play(plain, 1, 0.0, 0.0), "AntumbraRendererDesc::scene_file"),
            (told(antumbra_renderer_advance(x, renderer, f64::NAN, e)), "seconds is NaN"),
            (told(antumbra_renderer_advance(x, plain, 0.0, e)), "created from meshes"),
            (told(antumbra_renderer_camera(x, renderer, 2, camera, e)), "the file has 2 cameras"),
            (told(antumbra_renderer_camera(x, plain, 0, camera, e)), "created from meshes"),
        ]
    };
    for ((result, message), words) in refused {
        assert_eq!(result, BadArgument, "{message}");
        assert!(message.contains(words), "\"{message}\" does not say \"{words}\"");
    }
    assert_eq!(camera.width, 0, "an error writes nothing");
    assert!(c.seen(renderer, 0) == before, "something changed");
    c.finish();
    host.finish();
}

/// Checks that clips go on after the loss of a device as if nothing had happened.
#[test]
fn a_playing_file_continues_on_another_device_of_the_host() {
    for driver in drivers() {
        let entry = FaultInjection::default().entry();
        let through =
            |entry| Host::through(entry, driver, Purpose::Renderer, &[], Features::default());
        let host = through(entry.clone());
        let next_host = through(entry);
        let mut c = CHost::new(&host);
        let lost_device = c.device;
        let file = c.file();
        let twin = c.of_file(file);
        let desc = AntumbraRendererDesc { keeps_scene: 1, ..desc_of(file) };
        let (created, renderer) = c.create(&desc);
        assert_eq!(created, Ok, "{}", text(&c.error));
        for renderer in [twin, renderer] {
            c.play_all(renderer);
            c.advance(renderer, 0.6);
        }
        let at_loss = c.seen(twin, 0);
        assert!(c.seen(renderer, 0) == at_loss);
        c.advance(twin, 1.3);
        let later = c.seen(twin, 0);

        lose();
        let camera = c.camera(renderer, 0);
        let frame = AntumbraRenderDesc { camera: &camera, ..Versioned::INIT };
        // SAFETY: pointers to values on this stack, here and below.
        let told = unsafe { antumbra_renderer_render(c.context, renderer, &frame, &mut c.error) };
        expect(told, DeviceLost, "vkQueueSubmit2", &c.error);
        FaultInjection::default().install();
        let queue = AntumbraQueueDesc { queue: next_host.queue, ..Versioned::INIT };
        let (adopted, device, error) = adopt(&next_host, c.context, &queue, |_| {});
        assert_eq!(adopted, Ok, "{}", text(&error));
        // SAFETY: the twin is not used again, and the work of its device is over.
        unsafe {
            let done = antumbra_renderer_recover(c.context, renderer, device, &mut c.error);
            assert_eq!(done, Ok, "{}", text(&c.error));
            assert_eq!(antumbra_renderer_destroy(c.context, twin, &mut c.error), Ok);
            host.wait_idle();
            assert_eq!(antumbra_device_destroy(c.context, lost_device, &mut c.error), Ok);
        }
        c.host = &next_host;
        c.device = device;
        assert!(c.seen(renderer, 0) == at_loss, "{driver:?}: another time");
        c.advance(renderer, 1.3);
        assert!(c.seen(renderer, 0) == later, "{driver:?}: another way");
        c.finish();
        next_host.finish();
        host.finish();
    }
}
