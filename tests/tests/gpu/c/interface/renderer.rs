//! The renderer in C, on a device and a queue of the host. Its images equal the images of the
//! renderer in Rust and of frustum culling. Frames in flight outlive their renderer.

mod files;
mod lights;
mod loss;
mod mistakes;
mod own_device;
mod shadows;
mod views;

use std::ffi::c_void;
use std::ptr::null_mut;
use std::sync::{Arc, Mutex};

use capi::api::context::{antumbra_context_create, antumbra_context_destroy};
use capi::api::renderer::*;
use capi::api::self_test::antumbra_self_test;
use capi::context::{AntumbraContext, AntumbraContextDesc};
use capi::decisions::camera::AntumbraCamera;
use capi::decisions::culler::{ANTUMBRA_STRATEGY_ANTUMBRA, ANTUMBRA_STRATEGY_FRUSTUM};
use capi::error::AntumbraError;
use capi::error::AntumbraResult::{self, BadArgument, Busy, Ok, UnknownHandle};
use capi::executor::device::AntumbraDevice;
use capi::executor::queue::AntumbraQueueDesc;
use capi::executor::quirks::*;
use capi::executor::scene::{ANTUMBRA_PREDICATION_BEST, ANTUMBRA_PREDICATION_INSTANCES};
use capi::layout::Versioned;
use capi::renderer::description::*;
use capi::renderer::frame::*;
use capi::renderer::self_test::AntumbraSelfTest;
use capi::renderer::view::AntumbraRendererStats;
use cull::{ClipY, DepthConvention, Strategy, ViewProjection};
use glam::{Affine3A, Mat4, Vec3};
use gpu::{FeatureStructures, FinishedImage, ImageState, Purpose, Tick};
use render::{FrameRequest, Renderer, RendererOptions};
use scene::{Mesh, Object, Scene};
use tests::host_device::Host;
use tests::{Driver, drivers};

use super::{adopt_with, expect, text};

const SIZE: [u32; 2] = [96, 64];
/// The wall and the boxes behind it.
const OBJECTS: usize = 101;

/// The lock of the host, with its calls and a renderer that it calls while it holds the queue.
#[derive(Default)]
struct Queue {
    held: bool,
    uses: u32,
    inner: Option<(*const AntumbraContext, AntumbraRenderer, AntumbraResult)>,
}

unsafe extern "C" fn hold(user: *mut c_void) {
    // SAFETY: the test passes this as user, and calls from one thread.
    let queue = unsafe { &mut *user.cast::<Queue>() };
    assert!(!std::mem::replace(&mut queue.held, true), "held twice");
    queue.uses += 1;
    if let Some((context, renderer, result)) = &mut queue.inner {
        // SAFETY: the context lives.
        *result = unsafe { antumbra_renderer_wait(*context, *renderer, null_mut()) };
    }
}

unsafe extern "C" fn give_back(user: *mut c_void) {
    // SAFETY: as above.
    let queue = unsafe { &mut *user.cast::<Queue>() };
    assert!(std::mem::replace(&mut queue.held, false), "not held");
}

/// A host in C with an adopted device.
struct CHost<'a> {
    host: &'a Host,
    context: *mut AntumbraContext,
    device: AntumbraDevice,
    error: AntumbraError,
    // Boxed: the device holds its address.
    queue: Box<Queue>,
}

/// Adopts a device with the queue of the host and changed features.
fn adopt(
    host: &Host,
    context: *mut AntumbraContext,
    queue: &AntumbraQueueDesc,
    change: impl FnOnce(&mut FeatureStructures),
) -> (AntumbraResult, AntumbraDevice, AntumbraError) {
    adopt_with(host, context, change, |desc| desc.queue = queue)
}

impl<'a> CHost<'a> {
    fn new(host: &'a Host) -> Self {
        let mut context = null_mut();
        let mut queue = Box::<Queue>::default();
        // SAFETY: pointers to values on this stack.
        let made = unsafe {
            antumbra_context_create(&AntumbraContextDesc::current(), &mut context, null_mut())
        };
        assert_eq!(made, Ok);
        let desc = AntumbraQueueDesc {
            queue: host.queue,
            lock: Some(hold),
            unlock: Some(give_back),
            user: (&raw mut *queue).cast(),
            ..Versioned::INIT
        };
        let (adopted, device, error) = adopt(host, context, &desc, |_| {});
        assert_eq!(adopted, Ok, "{}", text(&error));
        Self { host, context, device, error, queue }
    }

    fn create(&mut self, desc: &AntumbraRendererDesc) -> (AntumbraResult, AntumbraRenderer) {
        let desc = AntumbraRendererDesc { device: self.device, ..*desc };
        let mut renderer = AntumbraRenderer { id: 0 };
        // SAFETY: pointers to values on this stack.
        let result = unsafe {
            antumbra_renderer_create(self.context, &desc, &mut renderer, &mut self.error)
        };
        (result, renderer)
    }

    /// Renders a frame and copies its image.
    fn image(&mut self, renderer: AntumbraRenderer, strategy: u32) -> Vec<u8> {
        let camera = camera();
        let desc = AntumbraRenderDesc { strategy, camera: &camera, ..Versioned::INIT };
        self.image_of(renderer, &desc)
    }

    /// Renders a frame and copies its image.
    #[track_caller]
    fn image_of(&mut self, renderer: AntumbraRenderer, desc: &AntumbraRenderDesc) -> Vec<u8> {
        // SAFETY: pointers to values on this stack; the copy is over before the next frame.
        let result =
            unsafe { antumbra_renderer_render(self.context, renderer, desc, &mut self.error) };
        assert_eq!(result, Ok, "{}", text(&self.error));
        self.finished_image(renderer)
    }

    /// Copies the newest image by commands of the host.
    #[track_caller]
    fn finished_image(&mut self, renderer: AntumbraRenderer) -> Vec<u8> {
        let mut image = AntumbraFinishedImage::INIT;
        let error = &mut self.error;
        // SAFETY: as above.
        let result = unsafe { antumbra_renderer_image(self.context, renderer, &mut image, error) };
        assert_eq!(result, Ok, "{}", text(error));
        let AntumbraFinishedImage { format, image, view, state, timeline, value, .. } = image;
        let state = ImageState { layout: state.layout, stages: state.stages, access: state.access };
        let tick = Tick(value);
        let finished = FinishedImage { image, view, format, size: SIZE, state, timeline, tick };
        self.host.copy(&Mutex::new(()), &finished)
    }

    /// Returns the image, which is the same with and without occlusion culling.
    #[track_caller]
    fn same_image(&mut self, renderer: AntumbraRenderer) -> Vec<u8> {
        let strategies = [ANTUMBRA_STRATEGY_FRUSTUM, ANTUMBRA_STRATEGY_ANTUMBRA];
        let [plain, culled] = strategies.map(|strategy| self.image(renderer, strategy));
        assert!(plain == culled, "the images differ");
        plain
    }

    fn stats(&mut self, renderer: AntumbraRenderer) -> AntumbraRendererStats {
        let mut stats = AntumbraRendererStats::INIT;
        // SAFETY: pointers to values on this stack.
        unsafe {
            let context = self.context;
            let error = &mut self.error;
            assert_eq!(antumbra_renderer_wait(context, renderer, error), Ok);
            assert_eq!(antumbra_renderer_stats(context, renderer, &mut stats, error), Ok);
        }
        stats
    }

    fn finish(mut self) {
        // SAFETY: the context is no longer used.
        let destroyed = unsafe { antumbra_context_destroy(self.context, &mut self.error) };
        assert_eq!(destroyed, Ok, "{}", text(&self.error));
        assert!(!self.queue.held);
    }
}

fn camera() -> AntumbraCamera {
    let [width, height] = SIZE;
    let clip_from_world = matrix().to_cols_array();
    AntumbraCamera { clip_from_world, width, height, ..Versioned::INIT }
}

fn matrix() -> Mat4 {
    #[rustfmt::skip]
    let columns = [
        1.3, 0.0, 0.0, 0.0,
        0.0, -2.0, 0.0, 0.0,
        0.0, 0.0, 0.0, -1.0,
        -0.4, 0.0, 0.1, 3.0,
    ];
    Mat4::from_cols_array(&columns)
}

/// Returns a box of a colour, with corners at 0 and 1.
fn box_of(colour: [f32; 3]) -> Mesh {
    let corner = |number: u16| [0, 1, 2].map(|axis| f32::from(number >> axis & 1));
    const INDICES: [u16; 36] = [
        0, 3, 1, 0, 2, 3, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 7, 3, 2, 6, 7, 0, 6, 2, 0, 4, 6,
        1, 3, 7, 1, 7, 5,
    ];
    let corners: Vec<_> = INDICES.iter().map(|index| (corner(*index), colour)).collect();
    Mesh::of_triangles("box", &corners)
}

/// Returns the vertices of a mesh in C.
fn vertices_of(mesh: &Mesh) -> Vec<AntumbraVertex> {
    let vertex = |vertex: &scene::Vertex| AntumbraVertex {
        position: vertex.position,
        normal: scene::unpack_normal(vertex.normal).to_array(),
        colour: scene::unpack_unorm(vertex.colour),
    };
    mesh.vertices.iter().map(vertex).collect()
}

fn mesh_desc(vertices: &[AntumbraVertex], indices: &[u32]) -> AntumbraMeshDesc {
    AntumbraMeshDesc {
        vertices: vertices.as_ptr(),
        vertex_count: vertices.len(),
        indices: indices.as_ptr(),
        index_count: indices.len(),
        ..Versioned::INIT
    }
}

/// Returns a wall, and boxes behind it.
fn objects() -> Vec<AntumbraMeshObject> {
    let place = |number: usize| {
        let x = (number % 10) as f32;
        let y = (number / 10) as f32;
        (Vec3::new(x - 5.0, y - 5.0, -12.0), Vec3::splat(0.6))
    };
    let object = |number: usize| {
        let (min, size) = match number {
            0 => (Vec3::new(-4.5, -4.5, -5.0), Vec3::new(9.0, 9.0, 0.5)),
            _ => place(number - 1),
        };
        let transform = transform(Affine3A::from_translation(min) * Affine3A::from_scale(size));
        AntumbraMeshObject { mesh: 0, tint: 0, transform }
    };
    (0..OBJECTS).map(object).collect()
}

fn transform(from: Affine3A) -> AntumbraTransform {
    AntumbraTransform { columns: from.to_cols_array() }
}

/// Returns the image of the same scene by the renderer in Rust.
fn image_in_rust(host: &Host, mesh: &Mesh, objects: &[AntumbraMeshObject]) -> Vec<u8> {
    let lock = Arc::new(Mutex::new(()));
    let device = host.adopt(Some(host.share_queue(lock.clone())));
    let mut scene = Scene::single(mesh.clone());
    let object = |antumbra_mesh_object: &AntumbraMeshObject| Object {
        transform: Affine3A::from_cols_array(&antumbra_mesh_object.transform.columns),
        ..scene.objects[0]
    };
    scene.objects = objects.iter().map(object).collect();
    let options = RendererOptions { size: SIZE, ..Default::default() };
    let mut renderer = Renderer::new(&device, &scene, &options).unwrap();
    let mut view = renderer.new_view().unwrap();
    let viewpoint =
        ViewProjection { matrix: matrix(), depth: DepthConvention::Reversed, y: ClipY::Down };
    renderer.render(&mut view, FrameRequest::new(Strategy::FRUSTUM, viewpoint)).unwrap();
    let image = host.copy(&*lock, &renderer.finished_image().unwrap());
    renderer.wait_idle(&mut view).unwrap();
    image
}

#[test]
#[expect(clippy::too_many_lines, reason = "a whole host in C, in its order")]
fn images_in_c_are_those_in_rust_and_those_with_all_drawn() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let mesh = box_of([0.8, 0.5, 0.2]);
        let objects = objects();
        let vertices = vertices_of(&mesh);
        let desc = mesh_desc(&vertices, &mesh.indices);
        let meshes = [&raw const desc];
        let desc = AntumbraRendererDesc {
            width: SIZE[0],
            height: SIZE[1],
            meshes: meshes.as_ptr(),
            mesh_count: 1,
            objects: objects.as_ptr(),
            object_count: objects.len(),
            cost_model: ANTUMBRA_COST_MODEL_OFF,
            spare_objects: 2,
            spare_meshes: 1,
            spare_vertices: 36,
            spare_indices: 36,
            ..Versioned::INIT
        };
        let (created, renderer) = c.create(&desc);
        assert_eq!(created, Ok, "{}", text(&c.error));
        for _ in 0..4 {
            c.same_image(renderer);
        }
        let of_wall = c.same_image(renderer);
        assert!(of_wall == image_in_rust(&host, &mesh, &objects), "not as in Rust");
        let stats = c.stats(renderer);
        assert_eq!((stats.frame, stats.total), (10, OBJECTS as u64));
        assert!(stats.drawn < 20 && stats.tests > 0, "{stats:?}");
        assert_ne!(stats.predication, ANTUMBRA_PREDICATION_BEST, "one of them is in use");

        // Another mesh is added, with two objects in front of the wall.
        let x = c.context;
        let error = &raw mut c.error;
        let other = box_of([0.1, 0.2, 0.9]);
        let vertices = vertices_of(&other);
        let desc = mesh_desc(&vertices, &other.indices);
        let mut added_mesh = 9;
        let mut ids = [9; 2];
        let at = |x: f32| transform(Affine3A::from_translation(Vec3::new(x, -0.5, -3.5)));
        // SAFETY: pointers to values on this stack.
        unsafe {
            let result = antumbra_renderer_add_meshes(
                x,
                renderer,
                &&raw const desc,
                1,
                &mut added_mesh,
                error,
            );
            assert_eq!(result, Ok, "{}", text(&*error));
            let added = [-2.0, 1.0].map(|x| AntumbraMeshObject {
                mesh: added_mesh,
                tint: 0,
                transform: at(x),
            });
            let result = antumbra_renderer_add_objects(
                x,
                renderer,
                added.as_ptr(),
                2,
                ids.as_mut_ptr(),
                error,
            );
            assert_eq!(result, Ok, "{}", text(&*error));
        }
        assert_eq!((added_mesh, ids[0].min(ids[1]), ids[0].max(ids[1])), (1, 101, 102));
        // One frame copies the mesh to the GPU, the next one draws it.
        assert_eq!(c.stats(renderer).is_uploading, 1);
        assert!(c.image(renderer, ANTUMBRA_STRATEGY_ANTUMBRA) == of_wall);
        let of_two = c.same_image(renderer);
        assert!(of_two != of_wall, "the new objects are not drawn");
        let stats = c.stats(renderer);
        assert_eq!((stats.total, stats.is_uploading), (103, 0));

        // The wall moves aside, one of the two objects is removed, and the hidden boxes show.
        let places = [at(-1.0), at(30.0)];
        let gone = [ids[1]];
        let moved = [ids[0], 0];
        // SAFETY: as above.
        unsafe {
            let result = antumbra_renderer_move_objects(
                x,
                renderer,
                moved.as_ptr(),
                places.as_ptr(),
                2,
                error,
            );
            assert_eq!(result, Ok, "{}", text(&*error));
            let result = antumbra_renderer_remove_objects(x, renderer, gone.as_ptr(), 1, error);
            assert_eq!(result, Ok, "{}", text(&*error));
        }
        assert!(c.same_image(renderer) != of_two, "nothing moved");
        let stats = c.stats(renderer);
        assert!(stats.total == 102 && stats.drawn > 50, "{stats:?}");

        // SAFETY: as above.
        unsafe {
            let result = antumbra_renderer_remove_meshes(x, renderer, &added_mesh, 1, error);
            expect(result, BadArgument, "object", &*error);
            let result = antumbra_renderer_remove_objects(x, renderer, &ids[0], 1, error);
            assert_eq!(result, Ok, "{}", text(&*error));
            let result = antumbra_renderer_remove_meshes(x, renderer, &added_mesh, 1, error);
            assert_eq!(result, Ok, "{}", text(&*error));
        }
        c.same_image(renderer);
        c.finish();
        host.finish();
    }
}

#[test]
fn a_driver_is_tested_in_c_and_what_is_distrusted_is_not_used() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let mut found = AntumbraSelfTest::INIT;
        // SAFETY: pointers to values on this stack.
        let result = unsafe { antumbra_self_test(c.context, c.device, &mut found, &mut c.error) };
        assert_eq!(result, Ok, "{}", text(&c.error));
        assert_eq!((found.broken, found.can_cull), (0, 1), "{found:?}");
        let lacks_counts = found.not_tested & ANTUMBRA_ASSUMPTION_DRAW_COUNTS != 0;
        assert_eq!(lacks_counts, driver == Driver::SwiftShader, "{found:?}");

        let mesh = box_of([0.8, 0.5, 0.2]);
        let objects = objects();
        let vertices = vertices_of(&mesh);
        let desc = mesh_desc(&vertices, &mesh.indices);
        let meshes = [&raw const desc];
        let desc = AntumbraRendererDesc {
            width: SIZE[0],
            height: SIZE[1],
            meshes: meshes.as_ptr(),
            mesh_count: 1,
            objects: objects.as_ptr(),
            object_count: objects.len(),
            cost_model: ANTUMBRA_COST_MODEL_OFF,
            disabled: ANTUMBRA_ASSUMPTION_CONDITIONAL_RENDERING | ANTUMBRA_ASSUMPTION_DRAW_COUNTS,
            ..Versioned::INIT
        };
        let unknown = AntumbraRendererDesc { disabled: 1 << 20, ..desc };
        expect(c.create(&unknown).0, BadArgument, "0x100000", &c.error);
        let (created, renderer) = c.create(&desc);
        assert_eq!(created, Ok, "{}", text(&c.error));
        c.same_image(renderer);
        assert_eq!(c.stats(renderer).predication, ANTUMBRA_PREDICATION_INSTANCES);
        c.finish();
        host.finish();
    }
}

#[test]
fn frames_in_flight_outlive_their_renderer_and_the_lock_is_held_for_submits() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let mesh = box_of([0.5; 3]);
        let objects = objects();
        let camera = camera();
        let vertices = vertices_of(&mesh);
        let desc = mesh_desc(&vertices, &mesh.indices);
        let meshes = [&raw const desc];
        let desc = AntumbraRendererDesc {
            width: SIZE[0],
            height: SIZE[1],
            meshes: meshes.as_ptr(),
            mesh_count: 1,
            objects: objects.as_ptr(),
            object_count: objects.len(),
            cost_model: ANTUMBRA_COST_MODEL_OFF,
            ..Versioned::INIT
        };
        let (created, renderer) = c.create(&desc);
        assert_eq!(created, Ok, "{}", text(&c.error));
        let x = c.context;
        let error = &raw mut c.error;
        let before = c.queue.uses;
        c.queue.inner = Some((x, renderer, Ok));
        let frame = AntumbraRenderDesc { camera: &camera, ..Versioned::INIT };
        // SAFETY: pointers to values on this stack.
        unsafe {
            for _ in 0..2 {
                let result = antumbra_renderer_render(x, renderer, &frame, error);
                assert_eq!(result, Ok, "{}", text(&*error));
            }
            assert_eq!(antumbra_renderer_destroy(x, renderer, error), Ok);
            assert_eq!(antumbra_renderer_wait(x, renderer, error), UnknownHandle);
        }
        assert!(c.queue.uses >= before + 2, "{} uses", c.queue.uses);
        assert_eq!(c.queue.inner.map(|inner| inner.2), Some(Busy));
        c.queue.inner = None;
        c.finish();
        host.finish();
    }
}
