//! Casters with their back to the light: a wall blocks light from either side, in maps and in
//! volumes.

use std::ops::ControlFlow;
use std::path::Path;

use cull::Strategy;
use import::LoadOptions;
use shadows::{ShadowBias, ShadowCaching, ShadowFilter, ShadowMethod, ShadowOptions};
use tests::run_on_all;

use super::{SIZE, image, renderer, shadows};

/// A wall of one side with the sun behind it, and a bulb in a box that faces outwards.
const FILES: [&str; 2] = ["wall_before_sun.gltf", "box_around_bulb.gltf"];

/// Returns the number of pixels whose red differs much.
fn apart(a: &[u8], b: &[u8]) -> usize {
    a.chunks_exact(4).zip(b.chunks_exact(4)).filter(|(a, b)| a[0].abs_diff(b[0]) > 24).count()
}

#[test]
fn maps_have_the_shadows_that_volumes_have() {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gpu/shadows/shadow_maps/one_sided");
    run_on_all(|device| {
        for name in FILES {
            // The original lights, since dimmed lights make shadows of little contrast.
            let options = LoadOptions { exposure: Some(1.0), ..LoadOptions::default() };
            let loaded =
                import::load(&folder.join(name), &options, &mut |_| ControlFlow::Continue(()))
                    .unwrap();
            let camera = loaded.default_camera(SIZE);
            let mut renderer = renderer(device, &loaded.scene, ShadowOptions::default());
            let mut draw = |options| {
                renderer.set_shadows(options).unwrap();
                let mut view = renderer.new_view().unwrap();
                let strategies = [Strategy::FRUSTUM, Strategy::ANTUMBRA, Strategy::ANTUMBRA];
                let images =
                    strategies.map(|strategy| image(&mut renderer, &mut view, strategy, camera));
                assert!(images[0] == images[1] && images[0] == images[2], "{name}: {options:?}");
                let [image, ..] = images;
                image
            };
            let lit = draw(ShadowOptions::default());
            let method = ShadowMethod::Volumes;
            let volumes = draw(ShadowOptions { method, ..ShadowOptions::default() });
            let dark = apart(&lit, &volumes);
            assert!(dark > 100, "{name}: {dark}");
            for bias in [ShadowBias::Plane, ShadowBias::Midpoint] {
                for caching in [ShadowCaching::Cached, ShadowCaching::Uncached] {
                    let maps = draw(ShadowOptions {
                        bias,
                        caching,
                        filter: ShadowFilter::Single,
                        distance_m: Some(40.0),
                        sun_side: 1024,
                        ..shadows()
                    });
                    // Edges of shadows are as wide as texels.
                    let wrong = apart(&maps, &volumes);
                    assert!(wrong * 10 < dark, "{name}, {bias:?}: {wrong} of {dark}");
                }
            }
        }
    });
}
