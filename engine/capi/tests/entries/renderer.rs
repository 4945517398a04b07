//! Functions of renderers with invalid handles, which are refused without Vulkan.

use std::ptr::{null, null_mut};

use antumbra_capi::api::device_costs::*;
use antumbra_capi::api::renderer::*;
use antumbra_capi::api::renderer_view::*;
use antumbra_capi::api::self_test::antumbra_self_test;
use antumbra_capi::api::shadows::*;
use antumbra_capi::context::AntumbraContext;
use antumbra_capi::error::AntumbraResult::{self, BadPointer, Ok, UnknownHandle};
use antumbra_capi::executor::device::AntumbraDevice;
use antumbra_capi::executor::device_costs::AntumbraDeviceCosts;
use antumbra_capi::layout::Versioned;
use antumbra_capi::renderer::description::AntumbraRendererDesc;
use antumbra_capi::renderer::device_costs::AntumbraDeviceCostsDesc;
use antumbra_capi::renderer::frame::*;
use antumbra_capi::renderer::self_test::AntumbraSelfTest;
use antumbra_capi::renderer::shadows::*;
use antumbra_capi::renderer::view::*;

use crate::Host;

type Call<'a> = (&'a str, &'a dyn Fn(*const AntumbraContext, u64) -> AntumbraResult);

/// Checks that no call takes an invalid handle, and that destruction takes none.
fn refuse_handles(host: &Host, calls: &[Call]) {
    for (name, call) in calls {
        assert_eq!(call(null(), 5), BadPointer, "{name}");
        for id in [5, u64::MAX, host.hierarchy.id, host.culler.id] {
            assert_eq!(call(host.context, id), UnknownHandle, "{name} {id:#x}");
        }
        let nothing = if name.ends_with("destroy") { Ok } else { UnknownHandle };
        assert_eq!(call(host.context, 0), nothing, "{name}");
    }
}

#[test]
fn every_function_of_the_renderer_checks_its_handles() {
    let host = Host::new();
    let r = |id| AntumbraRenderer { id };
    let e = null_mut;
    let camera = crate::CAMERA;
    let frame = AntumbraRenderDesc { camera: &camera, ..Versioned::INIT };
    // SAFETY: of all closures: pointers to values that live as long as the call, or null.
    let calls: [Call; 18] = unsafe {
        [
            ("create", &|x, id| {
                let device = AntumbraDevice { id };
                let desc = AntumbraRendererDesc { device, width: 8, height: 8, ..Versioned::INIT };
                antumbra_renderer_create(x, &desc, &mut r(0), e())
            }),
            ("recover", &|x, id| antumbra_renderer_recover(x, r(id), AntumbraDevice { id }, e())),
            ("destroy", &|x, id| antumbra_renderer_destroy(x, r(id), e())),
            ("render", &|x, id| antumbra_renderer_render(x, r(id), &frame, e())),
            ("image", &|x, id| {
                let mut image = AntumbraFinishedImage::INIT;
                antumbra_renderer_image(x, r(id), &mut image, e())
            }),
            ("resize", &|x, id| antumbra_renderer_resize(x, r(id), 8, 8, e())),
            ("add_objects", &|x, id| {
                antumbra_renderer_add_objects(x, r(id), null(), 0, null_mut(), e())
            }),
            ("remove_objects", &|x, id| antumbra_renderer_remove_objects(x, r(id), null(), 0, e())),
            ("move_objects", &|x, id| {
                antumbra_renderer_move_objects(x, r(id), null(), null(), 0, e())
            }),
            ("add_meshes", &|x, id| {
                antumbra_renderer_add_meshes(x, r(id), null(), 0, null_mut(), e())
            }),
            ("remove_meshes", &|x, id| antumbra_renderer_remove_meshes(x, r(id), null(), 0, e())),
            ("stats", &|x, id| {
                let mut stats = AntumbraRendererStats::INIT;
                antumbra_renderer_stats(x, r(id), &mut stats, e())
            }),
            ("set_shadows", &|x, id| {
                antumbra_renderer_set_shadows(x, r(id), &AntumbraShadowDesc::INIT, e())
            }),
            ("shadow_stats", &|x, id| {
                let mut stats = AntumbraShadowStats::INIT;
                antumbra_renderer_shadow_stats(x, r(id), &mut stats, e())
            }),
            ("self_test", &|x, id| {
                let mut outcome = AntumbraSelfTest::INIT;
                antumbra_self_test(x, AntumbraDevice { id }, &mut outcome, e())
            }),
            ("device_costs_measure", &|x, id| {
                let device = AntumbraDevice { id };
                let desc =
                    AntumbraDeviceCostsDesc { device, width: 8, height: 8, ..Versioned::INIT };
                antumbra_device_costs_measure(x, &desc, &mut AntumbraDeviceCosts { id: 0 }, e())
            }),
            ("device_costs_destroy", &|x, id| {
                antumbra_device_costs_destroy(x, AntumbraDeviceCosts { id }, e())
            }),
            ("wait", &|x, id| antumbra_renderer_wait(x, r(id), e())),
        ]
    };
    refuse_handles(&host, &calls);
    let no_camera = AntumbraRenderDesc::INIT;
    // SAFETY: null is refused.
    unsafe {
        let x = host.context;
        let results = [
            antumbra_renderer_requirements(x, null(), null(), null_mut(), e()),
            antumbra_renderer_create(x, null(), &mut r(0), e()),
            antumbra_renderer_create(x, &Versioned::INIT, null_mut(), e()),
            antumbra_renderer_render(x, r(0), null(), e()),
            antumbra_renderer_render(x, r(0), &no_camera, e()),
            antumbra_renderer_image(x, r(0), null_mut(), e()),
            antumbra_renderer_add_objects(x, r(0), null(), 1, null_mut(), e()),
            antumbra_renderer_remove_objects(x, r(0), null(), 1, e()),
            antumbra_renderer_move_objects(x, r(0), null(), null(), 1, e()),
            antumbra_renderer_add_meshes(x, r(0), null(), 1, null_mut(), e()),
            antumbra_renderer_remove_meshes(x, r(0), null(), 1, e()),
            antumbra_renderer_stats(x, r(0), null_mut(), e()),
            antumbra_renderer_set_shadows(x, r(0), null(), e()),
            antumbra_renderer_shadow_stats(x, r(0), null_mut(), e()),
            antumbra_device_costs_measure(x, null(), &mut AntumbraDeviceCosts { id: 0 }, e()),
            antumbra_device_costs_measure(x, &Versioned::INIT, null_mut(), e()),
        ];
        assert_eq!(results, [BadPointer; 16]);
    }
}

#[test]
fn functions_of_views_lights_and_images_check_their_handles() {
    let host = Host::new();
    let r = |id| AntumbraRenderer { id };
    let v = |id| AntumbraRendererView { id };
    let e = null_mut;
    // SAFETY: of all closures: pointers to values that live as long as the call, or null.
    let calls: [Call; 5] = unsafe {
        [
            ("read_image", &|x, id| antumbra_renderer_read_image(x, r(id), null_mut(), 0, e())),
            ("set_light_shadow", &|x, id| {
                antumbra_renderer_set_light_shadow(x, r(id), 0, null(), e())
            }),
            ("view_create", &|x, id| antumbra_renderer_view_create(x, r(id), &mut v(0), e())),
            ("view_destroy of", &|x, id| antumbra_renderer_view_destroy(x, r(id), v(0), e())),
            ("view_stats", &|x, id| {
                let mut stats = AntumbraRendererStats::INIT;
                antumbra_renderer_view_stats(x, r(id), v(id), &mut stats, e())
            }),
        ]
    };
    refuse_handles(&host, &calls);
    let x = host.context;
    // SAFETY: null is refused.
    let results = unsafe {
        [
            antumbra_renderer_read_image(x, r(0), null_mut(), 4, e()),
            antumbra_renderer_view_create(x, r(0), null_mut(), e()),
            antumbra_renderer_view_stats(x, r(0), v(0), null_mut(), e()),
        ]
    };
    assert_eq!(results, [BadPointer; 3]);
}
