//! Mistakes of a host with a renderer: errors name each of them, and the next frame works.

use std::ptr::null;

use ash::vk;
use capi::api::renderer::*;
use capi::decisions::camera::{ANTUMBRA_DEPTH_STANDARD, AntumbraCamera};
use capi::error::AntumbraResult::{BadArgument, BadPointer, BadStructSize, Ok, Unsupported};
use capi::executor::queue::AntumbraQueueDesc;
use capi::layout::Versioned;
use capi::renderer::description::*;
use capi::renderer::frame::*;
use gpu::{FeatureStructures, Purpose};
use tests::Driver;
use tests::host_device::Host;

use super::super::{adopt_with, expect, no_error, text};
use super::{CHost, SIZE, adopt, box_of, camera, hold, mesh_desc, objects, vertices_of};

#[test]
fn a_device_that_cannot_have_a_renderer_is_refused_by_name() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    let mut c = CHost::new(&host);
    let queue = AntumbraQueueDesc { queue: host.queue, ..Versioned::INIT };
    let no_timelines = |all: &mut FeatureStructures| all.vulkan_12.timeline_semaphore = vk::FALSE;
    let (refused, _, error) = adopt(&host, c.context, &queue, no_timelines);
    expect(refused, Unsupported, "timelineSemaphore", &error);
    for (queue, result, words) in [
        (AntumbraQueueDesc::INIT, BadPointer, "desc.queue.queue"),
        (AntumbraQueueDesc { lock: Some(hold), ..queue }, BadArgument, "both or none"),
        (AntumbraQueueDesc { struct_size: 12, ..queue }, BadStructSize, "AntumbraQueueDesc"),
    ] {
        let (refused, _, error) = adopt(&host, c.context, &queue, |_| {});
        expect(refused, result, words, &error);
    }
    let (adopted, without_queue, _) = adopt_with(&host, c.context, |_| {}, |_| {});
    assert_eq!(adopted, Ok);
    let with_queue = std::mem::replace(&mut c.device, without_queue);
    let [width, height] = SIZE;
    let (refused, _) = c.create(&AntumbraRendererDesc { width, height, ..Versioned::INIT });
    expect(refused, BadArgument, "AntumbraDeviceDesc::queue", &c.error);
    c.device = with_queue;
    c.finish();
    host.finish();
}

/// Expects that a scene with a broken mesh is refused by the name of its mistake.
fn refuse_meshes(
    c: &mut CHost,
    good: &AntumbraRendererDesc,
    vertices: &[AntumbraVertex],
    desc: &AntumbraMeshDesc,
) {
    let mut broken = vertices.to_vec();
    broken[0].position[1] = f32::NAN;
    for (mesh, result, words) in [
        (mesh_desc(vertices, &[0, 1, 36]), BadArgument, "desc.meshes[0]"),
        (mesh_desc(vertices, &[0, 1]), BadArgument, "not a multiple of 3"),
        (mesh_desc(&broken, &[0, 1, 2]), BadArgument, "not a finite number"),
        (
            AntumbraMeshDesc { vertices: null(), ..*desc },
            BadPointer,
            "desc.meshes[0].vertices is null",
        ),
        (AntumbraMeshDesc { struct_size: 20, ..*desc }, BadStructSize, "AntumbraMeshDesc"),
    ] {
        let meshes = [&raw const mesh];
        let (refused, _) = c.create(&AntumbraRendererDesc { meshes: meshes.as_ptr(), ..*good });
        expect(refused, result, words, &c.error);
    }
}

#[test]
fn mistakes_of_a_scene_and_of_a_frame_are_named() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    let mut c = CHost::new(&host);
    let mesh = box_of([0.5; 3]);
    let vertices = vertices_of(&mesh);
    let objects = objects();
    let desc = mesh_desc(&vertices, &mesh.indices);
    let good_meshes = [&raw const desc];
    let good = AntumbraRendererDesc {
        width: SIZE[0],
        height: SIZE[1],
        meshes: good_meshes.as_ptr(),
        mesh_count: 1,
        objects: objects.as_ptr(),
        object_count: 3,
        ..Versioned::INIT
    };
    refuse_meshes(&mut c, &good, &vertices, &desc);
    let foreign = AntumbraMeshObject { mesh: 1, ..objects[0] };
    let dark = AntumbraSunlight { towards_sun: [f32::NAN; 3], ..Versioned::INIT };
    for (desc, result, words) in [
        (AntumbraRendererDesc { meshes: [null()].as_ptr(), ..good }, BadPointer, "desc.meshes[0]"),
        (AntumbraRendererDesc { objects: null(), ..good }, BadPointer, "desc.objects"),
        (
            AntumbraRendererDesc { objects: &foreign, object_count: 1, ..good },
            BadArgument,
            "object 0",
        ),
        (AntumbraRendererDesc { light: &dark, ..good }, BadArgument, "not finite"),
        (AntumbraRendererDesc { width: 0, ..good }, BadArgument, "0"),
        (AntumbraRendererDesc { frames_in_flight: 17, ..good }, BadArgument, "17 frames"),
        (AntumbraRendererDesc { cost_model: 5, ..good }, BadArgument, "ANTUMBRA_COST_MODEL_.. 5"),
        (AntumbraRendererDesc { struct_size: 28, ..good }, BadStructSize, "AntumbraRendererDesc"),
    ] {
        let (refused, _) = c.create(&desc);
        expect(refused, result, words, &c.error);
    }
    let (created, renderer) = c.create(&good);
    assert_eq!(created, Ok, "{}", text(&c.error));
    let x = c.context;
    let error = &mut no_error();
    let mut image = AntumbraFinishedImage::INIT;
    let mut id = 9;
    let camera = camera();
    let mut broken = camera;
    broken.clip_from_world[5] = f32::NAN;
    // SAFETY: pointers to values on this stack.
    unsafe {
        let result = antumbra_renderer_image(x, renderer, &mut image, error);
        expect(result, BadArgument, "not there yet", error);
        let result = antumbra_renderer_add_objects(x, renderer, &objects[0], 1, &mut id, error);
        expect(result, BadArgument, "objects[0]: ", error);
        expect(result, BadArgument, "AntumbraRendererDesc::spare_objects", error);
        let meshes = good_meshes.as_ptr();
        let result = antumbra_renderer_add_meshes(x, renderer, meshes, 1, &mut id, error);
        expect(result, BadArgument, "meshes", error);
        let result = antumbra_renderer_remove_objects(x, renderer, &7, 1, error);
        expect(result, BadArgument, "objects[0]: object 7 is not", error);
        let moves = [0, 7];
        let at = [objects[0].transform; 2];
        let result =
            antumbra_renderer_move_objects(x, renderer, moves.as_ptr(), at.as_ptr(), 2, error);
        expect(result, BadArgument, "objects[1]: object 7 is not", error);
        let result = antumbra_renderer_remove_meshes(x, renderer, [0, 9].as_ptr(), 2, error);
        expect(result, BadArgument, "meshes[0]: ", error);
        let result = antumbra_renderer_resize(x, renderer, 0, 5, error);
        expect(result, BadArgument, "0", error);
        assert_eq!(id, 9);
        for (camera, strategy, words) in [
            (AntumbraCamera { width: 8, ..camera }, 1, "antumbra_renderer_resize"),
            (AntumbraCamera { depth: ANTUMBRA_DEPTH_STANDARD, ..camera }, 1, "reversed depth"),
            (AntumbraCamera { clip_from_world: [0.0; 16], ..camera }, 1, ""),
            (broken, 1, "that is not finite"),
            (camera, 9, "STRATEGY_.. 9"),
        ] {
            let desc = AntumbraRenderDesc { strategy, camera: &camera, ..Versioned::INIT };
            let result = antumbra_renderer_render(x, renderer, &desc, error);
            expect(result, BadArgument, words, error);
        }
    }
    c.same_image(renderer);
    c.finish();
    host.finish();
}
