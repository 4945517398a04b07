//! The loss of a device as our renderer in C reports it to a host.

use ash::vk;
use capi::api::renderer::{antumbra_renderer_destroy, antumbra_renderer_render};
use capi::error::AntumbraResult::{DeviceLost, Ok};
use capi::layout::Versioned;
use capi::renderer::description::AntumbraRendererDesc;
use capi::renderer::frame::AntumbraRenderDesc;
use gpu::{Features, Purpose};
use tests::Driver;
use tests::fault_injection::{Fault, FaultInjection, calls};
use tests::host_device::Host;

use super::{CHost, SIZE, box_of, camera, expect, mesh_desc, objects, text, vertices_of};

#[test]
fn a_lost_device_is_told_by_each_frame_and_the_renderer_goes() {
    for driver in Driver::ALL {
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
        let call = c"vkQueueSubmit2";
        let code = vk::Result::ERROR_DEVICE_LOST;
        let faults = vec![Fault { call, fails: 0..usize::MAX, code }];
        FaultInjection { faults, ..FaultInjection::default() }.install();
        let camera = camera();
        let frame = AntumbraRenderDesc { camera: &camera, ..Versioned::INIT };
        for _ in 0..3 {
            // SAFETY: pointers to values on this stack.
            let told =
                unsafe { antumbra_renderer_render(c.context, renderer, &frame, &mut c.error) };
            expect(told, DeviceLost, "vkQueueSubmit2", &c.error);
        }
        assert!(calls(call) > 0);
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
