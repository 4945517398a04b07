//! Casters of masked materials: volumes cannot have holes, so these casters have no volumes, and
//! the report says so.

use std::ops::ControlFlow;
use std::path::Path;

use cull::Strategy;
use import::LoadOptions;
use shadows::{ShadowMethod, ShadowOptions};
use tests::run_on_all;
use tests::walk::pixels_that_differ;

use super::{SIZE, image, renderer, volumes};

/// Draws a fence of a masked material over a ground, under a sun.
#[test]
fn masked_casters_without_a_shadow_are_told() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/gpu/shadows/volume_shadows/masked_caster.gltf");
    let loaded = import::load(&file, &LoadOptions::default(), &mut |_| ControlFlow::Continue(()));
    let loaded = loaded.unwrap();
    let camera = loaded.default_camera(SIZE);
    run_on_all(|device| {
        let mut renderer = renderer(device, &loaded.scene, ShadowOptions::default());
        let mut view = renderer.new_view().unwrap();
        let maps = ShadowOptions { method: ShadowMethod::Maps, ..ShadowOptions::default() };
        let mut draw = |options| {
            renderer.set_shadows(options).unwrap();
            let found = renderer.degradations();
            let image = image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera);
            (image, found.unshadowed_objects, found.texts())
        };
        let (lit, by_none, _) = draw(ShadowOptions::default());
        let (with_maps, by_maps, _) = draw(maps);
        let (with_volumes, by_volumes, texts) = draw(volumes());
        assert_eq!([by_none, by_maps, by_volumes], [0, 0, 1]);
        assert!(texts.iter().any(|text| text.contains("masked material casts no shadow")));
        let dark = pixels_that_differ(&lit, &with_maps);
        assert!(dark > 20, "maps have its shadow: {dark}");
        assert_eq!(pixels_that_differ(&lit, &with_volumes), 0, "volumes have none");
    });
}
