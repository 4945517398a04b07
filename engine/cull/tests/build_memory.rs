//! Checks that building a hierarchy takes at most the memory that it checks beforehand. The process
//! has one test and a counting allocator.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use antumbra_cull::{Aabb, BUILD_BYTES_PER_OBJECT, Hierarchy};
use glam::Vec3;
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

#[test]
fn building_takes_no_more_memory_than_it_asks_for() {
    // The first is built in chunks, the second as a whole.
    for count in [200_000, 60_000] {
        for occupied in [count, count / 2, 0] {
            build(count, occupied);
        }
    }
}

fn build(count: usize, occupied: usize) {
    let mut boxes: Vec<Aabb> = (0..count)
        .map(|n| {
            let corner = Vec3::new((n % 700) as f32, (n % 11) as f32, (n / 700) as f32) * 3.0;
            Aabb::new(corner, corner + 2.0)
        })
        .collect();
    boxes[occupied..].fill(Aabb::EMPTY);
    let asked_bytes = count * BUILD_BYTES_PER_OBJECT;
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let hierarchy = Hierarchy::build(&boxes).unwrap();
    let most_bytes = ALLOCATOR.peak_usage() - before;
    assert!(most_bytes >= asked_bytes, "it is asked for");
    let each = most_bytes as f64 / count as f64;
    assert!(most_bytes <= asked_bytes + 4096, "{each} bytes each of {occupied} occupied");
    drop(hierarchy);
}
