//! The executor in the command buffers of a host, which owns device, queue, images and submits.

mod boxes;
mod disorder;
mod formats;
mod host;
mod mistakes;

use tests::drivers;

use host::{HostOptions, Submits, compare};

#[test]
fn a_host_that_submits_by_itself_gets_the_same_image_and_draws_less() {
    for driver in drivers() {
        let few = compare(driver, &HostOptions::default(), |_| Submits::Once);
        assert!(few.culled > 1 && few.culled < few.plain / 2, "{driver:?}: {few:?}");
    }
}
