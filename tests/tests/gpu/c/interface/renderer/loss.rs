//! The loss of a device as our renderer in C reports it to a host.

use ash::vk;
use capi::api::device::antumbra_device_destroy;
use capi::api::renderer::{
    antumbra_renderer_destroy, antumbra_renderer_move_objects, antumbra_renderer_recover,
    antumbra_renderer_remove_objects, antumbra_renderer_render,
};
use capi::error::AntumbraResult::{BadArgument, DeviceLost, Ok};
use capi::executor::queue::AntumbraQueueDesc;
use capi::layout::Versioned;
use capi::renderer::description::{AntumbraRendererDesc, AntumbraTransform};
use capi::renderer::frame::{AntumbraFinishedImage, AntumbraRenderDesc};
use gpu::{Features, Purpose};
use tests::drivers;
use tests::fault_injection::{Fault, FaultInjection, calls};
use tests::host_device::Host;

use capi::api::renderer::antumbra_renderer_image;

use super::{CHost, SIZE, adopt, box_of, camera, expect, mesh_desc, objects, text, vertices_of};

/// Makes every submit of this thread report the loss of the device.
pub(super) fn lose() {
    let call = c"vkQueueSubmit2";
    let code = vk::Result::ERROR_DEVICE_LOST;
    let faults = vec![Fault { call, fails: 0..usize::MAX, code }];
    FaultInjection { faults, ..FaultInjection::default() }.install();
}

#[test]
fn a_lost_device_is_told_by_each_frame_and_the_renderer_goes() {
    for driver in drivers() {
        let entry = FaultInjection::default().entry();
        let host = Host::through(entry, driver, Purpose::Renderer, &[], Features::default());
        let mut c = CHost::new(&host);
        let mesh = box_of([0.8, 0.5, 0.2]);
        let objects = objects();
        let vertices = vertices_of(&mesh);
        let mesh_desc = mesh_desc(&vertices, &mesh.indices);
        let meshes = [&raw const mesh_desc];
        let desc = AntumbraRendererDesc {
            width: SIZE[0],
            height: SIZE[1],
            meshes: meshes.as_ptr(),
            mesh_count: 1,
            objects: objects.as_ptr(),
            object_count: objects.len(),
            ..Versioned::INIT
        };
        let (created, renderer) = c.create(&desc);
        assert_eq!(created, Ok, "{}", text(&c.error));
        c.same_image(renderer);
        lose();
        let camera = camera();
        let frame = AntumbraRenderDesc { camera: &camera, ..Versioned::INIT };
        for _ in 0..3 {
            // SAFETY: pointers to values on this stack.
            let told =
                unsafe { antumbra_renderer_render(c.context, renderer, &frame, &mut c.error) };
            expect(told, DeviceLost, "vkQueueSubmit2", &c.error);
        }
        assert!(calls(c"vkQueueSubmit2") > 0);
        // SAFETY: the context is no longer used.
        let gone = unsafe { antumbra_renderer_destroy(c.context, renderer, &mut c.error) };
        assert_eq!(gone, Ok, "{}", text(&c.error));
        // The loss is simulated: work on the device goes on, unlike on a lost device.
        FaultInjection::default().install();
        host.wait_idle();
        c.finish();
        host.finish();
    }
}

/// Checks that a renderer that keeps its scene has the same image on the next device of the host,
/// after changes, and that one that does not says what to do.
#[test]
fn a_renderer_that_keeps_its_scene_continues_on_another_device_of_the_host() {
    for driver in drivers() {
        let entry = FaultInjection::default().entry();
        let through =
            |entry| Host::through(entry, driver, Purpose::Renderer, &[], Features::default());
        let host = through(entry.clone());
        let next_host = through(entry);
        let mut c = CHost::new(&host);
        let lost_device = c.device;
        let mesh = box_of([0.8, 0.5, 0.2]);
        let objects = objects();
        let vertices = vertices_of(&mesh);
        let mesh_desc = mesh_desc(&vertices, &mesh.indices);
        let meshes = [&raw const mesh_desc];
        let forgetful = AntumbraRendererDesc {
            width: SIZE[0],
            height: SIZE[1],
            meshes: meshes.as_ptr(),
            mesh_count: 1,
            objects: objects.as_ptr(),
            object_count: objects.len(),
            ..Versioned::INIT
        };
        let (refused, _) = c.create(&AntumbraRendererDesc { keeps_scene: 2, ..forgetful });
        expect(refused, BadArgument, "desc.keeps_scene is 2", &c.error);
        let (created, other) = c.create(&forgetful);
        assert_eq!(created, Ok, "{}", text(&c.error));
        let (created, renderer) = c.create(&AntumbraRendererDesc { keeps_scene: 1, ..forgetful });
        assert_eq!(created, Ok, "{}", text(&c.error));
        let first_image = c.same_image(renderer);
        let moved = AntumbraTransform {
            columns: [2.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5, -1.0, -0.5, -3.0],
        };
        // SAFETY: pointers to values on this stack.
        unsafe {
            let gone = antumbra_renderer_remove_objects(c.context, renderer, &0, 1, &mut c.error);
            assert_eq!(gone, Ok, "{}", text(&c.error));
            let context = c.context;
            let told =
                antumbra_renderer_move_objects(context, renderer, &7, &moved, 1, &mut c.error);
            assert_eq!(told, Ok, "{}", text(&c.error));
        }
        let expected = c.same_image(renderer);
        assert!(expected != first_image, "nothing has changed");

        lose();
        let camera = camera();
        let frame = AntumbraRenderDesc { camera: &camera, ..Versioned::INIT };
        // SAFETY: pointers to values on this stack.
        let told = unsafe { antumbra_renderer_render(c.context, renderer, &frame, &mut c.error) };
        expect(told, DeviceLost, "vkQueueSubmit2", &c.error);
        let queue = AntumbraQueueDesc { queue: next_host.queue, ..Versioned::INIT };
        let (adopted, device, error) = adopt(&next_host, c.context, &queue, |_| {});
        assert_eq!(adopted, Ok, "{}", text(&error));
        // SAFETY: as above, here and below.
        let recover = |c: &mut CHost, renderer| unsafe {
            antumbra_renderer_recover(c.context, renderer, device, &mut c.error)
        };
        // The next device is lost, too.
        let failed = recover(&mut c, renderer);
        expect(failed, DeviceLost, "vkQueueSubmit2", &c.error);
        FaultInjection::default().install();
        let failed = recover(&mut c, other);
        expect(failed, BadArgument, "AntumbraRendererDesc::keeps_scene", &c.error);
        let done = recover(&mut c, renderer);
        assert_eq!(done, Ok, "{}", text(&c.error));
        let mut image = AntumbraFinishedImage::INIT;
        // SAFETY: as above.
        let none =
            unsafe { antumbra_renderer_image(c.context, renderer, &mut image, &mut c.error) };
        assert_eq!(none, BadArgument, "an image before the first frame");
        // SAFETY: the renderers of the lost device are gone, and its work is over.
        unsafe {
            assert_eq!(antumbra_renderer_destroy(c.context, other, &mut c.error), Ok);
            host.wait_idle();
            assert_eq!(antumbra_device_destroy(c.context, lost_device, &mut c.error), Ok);
        }
        c.host = &next_host;
        c.device = device;
        assert!(c.same_image(renderer) == expected, "{driver:?}: another image");
        assert!(c.stats(renderer).total as usize == objects.len() - 1);
        c.finish();
        next_host.finish();
        host.finish();
    }
}
