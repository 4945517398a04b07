//! Shadows and samples per pixel in C. The images equal those with all objects drawn, options
//! change between frames, and errors name impossible options, which change nothing.

use capi::api::renderer::*;
use capi::api::shadows::*;
use capi::decisions::culler::{ANTUMBRA_STRATEGY_ANTUMBRA, ANTUMBRA_STRATEGY_FRUSTUM};
use capi::error::AntumbraResult::{self, BadArgument, BadStructSize, Ok};
use capi::layout::Versioned;
use capi::renderer::description::*;
use capi::renderer::frame::{AntumbraRenderDesc, AntumbraRenderer};
use capi::renderer::shadows::*;
use glam::{Affine3A, Vec3};
use gpu::Purpose;
use tests::host_device::Host;
use tests::{Driver, drivers};

use super::super::{expect, text};
use super::{CHost, SIZE, box_of, camera, mesh_desc, transform, vertices_of};

/// Shadow maps of a small scene.
static MAPS: AntumbraShadowDesc = AntumbraShadowDesc {
    method: ANTUMBRA_SHADOWS_MAPS,
    map_side: 512,
    cascades: 2,
    distance: 40.0,
    ..AntumbraShadowDesc::INIT
};

/// Returns a wall and two boxes in front of it, whose shadows fall on it.
fn objects() -> Vec<AntumbraMeshObject> {
    let object = |(min, size): (Vec3, Vec3)| {
        let transform = transform(Affine3A::from_translation(min) * Affine3A::from_scale(size));
        AntumbraMeshObject { mesh: 0, tint: 0, transform }
    };
    let wall = (Vec3::new(-6.0, -4.5, -9.0), Vec3::new(12.0, 9.0, 0.5));
    let [left, right] = [-2.5, 1.0].map(|x| (Vec3::new(x, -0.5, -6.5), Vec3::ONE));
    [wall, left, right].map(object).to_vec()
}

impl CHost<'_> {
    /// Returns a renderer of the wall.
    pub(super) fn lit(
        &mut self,
        change: impl FnOnce(&mut AntumbraRendererDesc),
    ) -> (AntumbraResult, AntumbraRenderer) {
        let mesh = box_of([0.8; 3]);
        let objects = objects();
        let vertices = vertices_of(&mesh);
        let mesh_desc = mesh_desc(&vertices, &mesh.indices);
        let meshes = [&raw const mesh_desc];
        let light =
            AntumbraSunlight { towards_sun: [0.4, 0.6, 1.0], sun: [1.0; 3], ..Versioned::INIT };
        let mut desc = AntumbraRendererDesc {
            width: SIZE[0],
            height: SIZE[1],
            meshes: meshes.as_ptr(),
            mesh_count: 1,
            objects: objects.as_ptr(),
            object_count: objects.len(),
            cost_model: ANTUMBRA_COST_MODEL_OFF,
            light: &raw const light,
            ..Versioned::INIT
        };
        change(&mut desc);
        self.create(&desc)
    }

    fn set_shadows(
        &mut self,
        renderer: AntumbraRenderer,
        desc: AntumbraShadowDesc,
    ) -> AntumbraResult {
        // SAFETY: pointers to values on this stack.
        unsafe { antumbra_renderer_set_shadows(self.context, renderer, &desc, &mut self.error) }
    }

    fn render(&mut self, renderer: AntumbraRenderer, strategy: u32) -> AntumbraResult {
        let camera = camera();
        let desc = AntumbraRenderDesc { strategy, camera: &camera, ..Versioned::INIT };
        // SAFETY: as above.
        unsafe { antumbra_renderer_render(self.context, renderer, &desc, &mut self.error) }
    }

    fn shadow_stats(&mut self, renderer: AntumbraRenderer) -> AntumbraShadowStats {
        let mut stats = AntumbraShadowStats::INIT;
        // SAFETY: as above.
        let result = unsafe {
            antumbra_renderer_shadow_stats(self.context, renderer, &mut stats, &mut self.error)
        };
        assert_eq!(result, Ok, "{}", text(&self.error));
        stats
    }
}

/// Returns the number of pixels of an image that are darker than in another.
fn darker(image: &[u8], other: &[u8]) -> usize {
    let sum = |pixel: &[u8]| pixel[..3].iter().map(|part| u32::from(*part)).sum::<u32>();
    let pixels = image.chunks_exact(4).zip(other.chunks_exact(4));
    pixels.filter(|(one, other)| sum(one) + 24 < sum(other)).count()
}

#[test]
fn shadows_in_c_are_the_same_with_all_drawn_and_options_change_them() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let off = AntumbraShadowDesc::INIT;
        let (created, renderer) = c.lit(|desc| desc.shadows = &raw const off);
        assert_eq!(created, Ok, "{}", text(&c.error));
        let lit = c.same_image(renderer);
        assert_eq!(c.shadow_stats(renderer).lights, 0);

        assert_eq!(c.set_shadows(renderer, MAPS), Ok, "{}", text(&c.error));
        let mapped = c.same_image(renderer);
        let shaded = darker(&mapped, &lit);
        assert!(shaded > 40, "{shaded} pixels are in shadow");
        // A map is drawn with few casters at first, then once with all.
        let kept = (0..20).map(|_| {
            assert!(c.same_image(renderer) == mapped, "however many casters are drawn");
            c.shadow_stats(renderer)
        });
        let kept = kept.last().unwrap();
        assert_eq!((kept.lights, kept.maps, kept.drawn_maps), (1, 2, 0), "{kept:?}");
        let afresh = AntumbraShadowDesc {
            caching: ANTUMBRA_SHADOW_CACHING_UNCACHED,
            culling: ANTUMBRA_CASTER_CULLING_UNCULLED,
            ..MAPS
        };
        assert_eq!(c.set_shadows(renderer, afresh), Ok, "{}", text(&c.error));
        assert!(c.same_image(renderer) == mapped, "maps that are kept are as good");
        let drawn = c.shadow_stats(renderer);
        assert_eq!((drawn.drawn_maps, drawn.culled_maps), (2, 0), "{drawn:?}");
        assert!(drawn.triangles >= 3 * 12 && drawn.casters >= 3, "{drawn:?}");
        let soft = AntumbraShadowDesc { penumbra: 1.5, ..MAPS };
        assert_eq!(c.set_shadows(renderer, soft), Ok, "{}", text(&c.error));
        assert!(c.same_image(renderer) != mapped, "penumbras are wider");

        let volumes = AntumbraShadowDesc { method: ANTUMBRA_SHADOWS_VOLUMES, ..off };
        assert_eq!(c.set_shadows(renderer, volumes), Ok, "{}", text(&c.error));
        let counted = darker(&c.same_image(renderer), &lit);
        assert!(counted > 40 && counted.abs_diff(shaded) < 40, "{counted} and {shaded}");
        assert_eq!(c.set_shadows(renderer, off), Ok, "{}", text(&c.error));
        assert!(c.same_image(renderer) == lit);
        c.finish();
        host.finish();
    }
}

#[test]
fn four_samples_smooth_edges_and_keep_shadows() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let [one, four] = [0, 4].map(|samples| {
            let (created, renderer) = c.lit(|desc| {
                desc.shadows = &raw const MAPS;
                desc.samples = samples;
            });
            assert_eq!(created, Ok, "{}", text(&c.error));
            let plain = c.image(renderer, ANTUMBRA_STRATEGY_FRUSTUM);
            if samples == 0 || driver == Driver::Lavapipe {
                let culled = c.image(renderer, ANTUMBRA_STRATEGY_ANTUMBRA);
                assert!(plain == culled, "{samples} samples: the images differ");
            } else {
                // This driver evaluates depth and coverage of a sample at different positions.
                let refused = c.render(renderer, ANTUMBRA_STRATEGY_ANTUMBRA);
                expect(refused, BadArgument, "one sample per pixel", &c.error);
            }
            assert_eq!(c.shadow_stats(renderer).lights, 1);
            plain
        });
        let pixels = one.chunks_exact(4).zip(four.chunks_exact(4));
        let differs = |(one, four): &(&[u8], &[u8])| {
            one.iter().zip(four.iter()).any(|(one, four)| one.abs_diff(*four) > 8)
        };
        let differing = pixels.filter(differs).count();
        // SwiftShader resolves several samples without the sRGB encoding.
        if driver == Driver::Lavapipe {
            let edges = 20..one.len() / 16;
            assert!(edges.contains(&differing), "{differing} pixels at edges differ");
        }
        c.finish();
        host.finish();
    }
}

#[test]
fn impossible_shadows_and_samples_are_named_and_change_nothing() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    let mut c = CHost::new(&host);
    let (created, renderer) = c.lit(|desc| desc.shadows = &raw const MAPS);
    assert_eq!(created, Ok, "{}", text(&c.error));
    let before = c.same_image(renderer);
    for (desc, result, words) in [
        (AntumbraShadowDesc { struct_size: 5, ..MAPS }, BadStructSize, "AntumbraShadowDesc"),
        (AntumbraShadowDesc { method: 3, ..MAPS }, BadArgument, "no ANTUMBRA_SHADOWS_.. 3"),
        (AntumbraShadowDesc { filter: 6, ..MAPS }, BadArgument, "ANTUMBRA_SHADOW_FILTER_.. 6"),
        (AntumbraShadowDesc { bias: 3, ..MAPS }, BadArgument, "ANTUMBRA_SHADOW_BIAS_.. 3"),
        (AntumbraShadowDesc { caching: 2, ..MAPS }, BadArgument, "ANTUMBRA_SHADOW_CACHING_.. 2"),
        (AntumbraShadowDesc { culling: 9, ..MAPS }, BadArgument, "ANTUMBRA_CASTER_CULLING_.. 9"),
        (AntumbraShadowDesc { cascades: 9, ..MAPS }, BadArgument, "it has 1 to 8"),
        (AntumbraShadowDesc { map_side: 1000, ..MAPS }, BadArgument, "a power of two"),
        (AntumbraShadowDesc { map_side: 1 << 31, ..MAPS }, BadArgument, "2147483648"),
        (AntumbraShadowDesc { distance: -1.0, ..MAPS }, BadArgument, "have no size"),
        (AntumbraShadowDesc { distance: f32::NAN, ..MAPS }, BadArgument, "have no size"),
        (AntumbraShadowDesc { penumbra: f32::INFINITY, ..MAPS }, BadArgument, "penumbras"),
        (AntumbraShadowDesc { cascade_blend: 0.6, ..MAPS }, BadArgument, "0 to 0.5"),
    ] {
        let refused = c.set_shadows(renderer, desc);
        expect(refused, result, words, &c.error);
        let (refused, _) = c.lit(|renderer_desc| renderer_desc.shadows = &raw const desc);
        expect(refused, result, words, &c.error);
        assert!(c.same_image(renderer) == before, "{words}: something changed");
    }
    for samples in [2, 3, 8, u32::MAX] {
        let (refused, _) = c.lit(|desc| desc.samples = samples);
        expect(refused, BadArgument, "1 or 4 samples", &c.error);
    }
    let volumes = AntumbraShadowDesc { method: ANTUMBRA_SHADOWS_VOLUMES, ..MAPS };
    let (refused, _) = c.lit(|desc| {
        desc.samples = 4;
        desc.shadows = &raw const volumes;
    });
    expect(refused, BadArgument, "take shadow maps, or one sample", &c.error);
    let (created, plain) = c.lit(|_| {});
    assert_eq!(created, Ok, "{}", text(&c.error));
    let refused = c.set_shadows(plain, MAPS);
    expect(refused, BadArgument, "without desc.shadows", &c.error);
    c.finish();
    host.finish();
}
