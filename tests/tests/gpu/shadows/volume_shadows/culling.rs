//! Culling of shadow volumes: images equal those with the volumes of all casters, bit for bit,
//! although most volumes are left out. The eye and the lights move through a town.

use cull::Strategy;
use gpu::PredicationMode;
use shadows::{CasterCulling, ShadowCaching, ShadowMethod, ShadowOptions};
use tests::walk::pixels_that_differ;
use tests::{Driver, run, run_on_all};

use crate::shadows::shadow_maps::culling::{Side, scene};
use crate::shadows::shadow_maps::renderer_that_skips;

fn options(culling: CasterCulling) -> ShadowOptions {
    ShadowOptions { method: ShadowMethod::Volumes, culling, ..ShadowOptions::default() }
}

/// Draws frames of the town with and without culled volumes. Returns the triangles of casters in
/// both, and the tests.
fn compare(device: &gpu::Device, frames: u32) -> ([u64; 2], u32) {
    let scene = scene();
    let mut sides = [CasterCulling::Unculled, CasterCulling::Culled]
        .map(|culling| Side::new(device, &scene, options(culling)));
    let mut triangles = [0; 2];
    let mut tests = 0;
    for frame in 0..frames {
        let [expected, found] = sides.each_mut().map(|side| side.draw(frame, Strategy::ANTUMBRA));
        assert_eq!(pixels_that_differ(&expected, &found), 0, "pixels of frame {frame}");
        let [all, culled] = sides.each_ref().map(Side::stats);
        assert_eq!((all.casters, all.tests), (culled.casters, 0));
        triangles[0] += all.triangles;
        triangles[1] += culled.triangles + culled.revealed_triangles;
        tests += culled.tests;
    }
    (triangles, tests)
}

#[test]
fn lavapipe_images_are_those_with_all_volumes() {
    run(Driver::Lavapipe, |device| {
        let ([all, culled], tests) = compare(device, 45);
        println!("{culled} triangles of {all}, {tests} tests");
        assert!(culled * 2 < all && tests > 0, "{culled} triangles of {all}, {tests} tests");
    });
}

#[test]
fn draws_of_casters_take_no_count_of_the_objects_before() {
    run(Driver::Lavapipe, |device| {
        let scene = scene();
        let maps = ShadowOptions {
            method: ShadowMethod::Maps,
            caching: ShadowCaching::Uncached,
            ..ShadowOptions::default()
        };
        for culled in [options(CasterCulling::Culled), maps] {
            let all = ShadowOptions { culling: CasterCulling::Unculled, ..culled };
            let mut all = Side::new(device, &scene, all);
            let ways = PredicationMode::ALL;
            let mut sides =
                ways.map(|way| Side::of(renderer_that_skips(device, &scene, culled, Some(way))));
            for frame in 0..12 {
                let expected = all.draw(frame, Strategy::ANTUMBRA);
                for strategy in [Strategy::ANTUMBRA, methods::HZB] {
                    for (side, way) in sides.iter_mut().zip(ways) {
                        let found = side.draw(frame, strategy);
                        let wrong = pixels_that_differ(&expected, &found);
                        assert_eq!(wrong, 0, "{way:?}, {strategy}, frame {frame}");
                    }
                }
            }
        }
    });
}

#[test]
fn every_strategy_counts_the_same_volumes() {
    run_on_all(|device| {
        let scene = scene();
        let mut all = Side::new(device, &scene, options(CasterCulling::Unculled));
        let expected: Vec<_> = (0..3).map(|index| all.draw(index, Strategy::FRUSTUM)).collect();
        for strategy in [Strategy::FRUSTUM, Strategy::ANTUMBRA_QUERIES, methods::CHC] {
            let mut side = Side::new(device, &scene, options(CasterCulling::Culled));
            for (frame, expected) in (0..).zip(&expected) {
                let found = side.draw(frame, strategy);
                assert_eq!(pixels_that_differ(expected, &found), 0, "{strategy}, frame {frame}");
            }
        }
    });
}
