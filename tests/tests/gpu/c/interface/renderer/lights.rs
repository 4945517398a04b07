//! The shadows of single lights in C, which are those of the same lights in Rust.

use std::ptr::{from_ref, null};

use capi::api::shadows::antumbra_renderer_set_light_shadow;
use capi::error::AntumbraResult::{self, BadArgument, BadStructSize, Ok};
use capi::layout::Versioned;
use capi::renderer::frame::AntumbraRenderer;
use capi::renderer::shadows::AntumbraLightShadowDesc;
use gpu::Purpose;
use render::LightShadow;
use tests::host_device::Host;
use tests::{Driver, drivers};

use super::super::{expect, text};
use super::CHost;
use super::files::RustFile;

/// The sun and the lamp of the file.
const SUN: u32 = 0;
const LAMP: u32 = 1;

impl CHost<'_> {
    fn set_light_shadow(
        &mut self,
        renderer: AntumbraRenderer,
        light: u32,
        desc: Option<AntumbraLightShadowDesc>,
    ) -> AntumbraResult {
        let desc = desc.as_ref().map_or(null(), from_ref);
        let error = &mut self.error;
        // SAFETY: pointers to values that live as long as the call.
        unsafe { antumbra_renderer_set_light_shadow(self.context, renderer, light, desc, error) }
    }
}

#[test]
fn lights_of_a_file_cast_shadows_one_by_one() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let file = c.file();
        let renderer = c.of_file(file);
        c.play_all(renderer);
        c.advance(renderer, 0.4);
        let both = c.seen(renderer, 0);
        let mut rust = RustFile::new(&host);
        assert!(both == rust.seen(0.4, 0));

        let off = AntumbraLightShadowDesc { is_off: 1, ..Versioned::INIT };
        let soft = AntumbraLightShadowDesc { penumbra: 0.6, ..Versioned::INIT };
        assert_eq!(c.set_light_shadow(renderer, LAMP, Some(off)), Ok, "{}", text(&c.error));
        let of_sun = c.seen(renderer, 0);
        assert!(of_sun != both, "the shadow of the lamp");
        rust.set_light_shadow(LAMP, LightShadow { is_cast: false, penumbra_m: 0.0 });
        assert!(of_sun == rust.seen(0.4, 0), "not as in Rust");
        assert_eq!(c.set_light_shadow(renderer, SUN, Some(soft)), Ok, "{}", text(&c.error));
        let soft = c.seen(renderer, 0);
        assert!(soft != of_sun, "the penumbra of the sun");
        rust.set_light_shadow(SUN, LightShadow { is_cast: true, penumbra_m: 0.6 });
        assert!(soft == rust.seen(0.4, 0), "not as in Rust");
        for light in [SUN, LAMP] {
            assert_eq!(c.set_light_shadow(renderer, light, None), Ok, "{}", text(&c.error));
        }
        assert!(c.seen(renderer, 0) == both, "the options of all lights again");
        drop(rust);
        c.finish();
        host.finish();
    }
}

#[test]
fn impossible_shadows_of_lights_are_named_and_change_nothing() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    let mut c = CHost::new(&host);
    let file = c.file();
    let renderer = c.of_file(file);
    let before = c.seen(renderer, 0);
    let desc = AntumbraLightShadowDesc::INIT;
    for (light, desc, result, words) in [
        (2, desc, BadArgument, "light 2"),
        (SUN, AntumbraLightShadowDesc { is_off: 2, ..desc }, BadArgument, "desc.is_off is 2"),
        (SUN, AntumbraLightShadowDesc { penumbra: -1.0, ..desc }, BadArgument, "light 0"),
        (SUN, AntumbraLightShadowDesc { penumbra: f32::NAN, ..desc }, BadArgument, "light 0"),
        (SUN, AntumbraLightShadowDesc { struct_size: 7, ..desc }, BadStructSize, "LightShadowDesc"),
    ] {
        let refused = c.set_light_shadow(renderer, light, Some(desc));
        expect(refused, result, words, &c.error);
    }
    assert!(c.seen(renderer, 0) == before, "something changed");
    let (created, bare) = c.lit(|_| {});
    assert_eq!(created, Ok, "{}", text(&c.error));
    let refused = c.set_light_shadow(bare, SUN, Some(desc));
    expect(refused, BadArgument, "without desc.shadows", &c.error);
    c.finish();
    host.finish();
}
