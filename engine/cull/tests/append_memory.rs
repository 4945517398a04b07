//! Checks that growing a hierarchy takes memory for the growth and for one part of the hierarchy,
//! not for a second hierarchy. The process has one test and a counting allocator.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use antumbra_cull::{Aabb, BUILD_BYTES_PER_OBJECT, Hierarchy};
use glam::Vec3;
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

#[test]
fn growing_by_one_asks_for_a_fraction_of_what_building_takes() {
    const COUNT: usize = 200_000;
    let boxes: Vec<Aabb> = (0..COUNT)
        .map(|n| {
            let corner = Vec3::new((n % 700) as f32, (n % 11) as f32, (n / 700) as f32) * 3.0;
            Aabb::new(corner, corner + 2.0)
        })
        .collect();
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let mut added = Vec::new();
    let mut reordered = Vec::new();
    hierarchy.insert_all(&boxes[..1], &mut added, &mut reordered).unwrap();
    let most_bytes = ALLOCATOR.peak_usage() - before;
    assert_eq!(added.len(), 1);
    // The largest vector may be copied while it grows by a sixteenth.
    let each = most_bytes as f64 / COUNT as f64;
    let building = BUILD_BYTES_PER_OBJECT as f64;
    assert!(each < building / 4.0, "{each} bytes per object, and building takes {building}");
}
