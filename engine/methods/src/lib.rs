//! The published methods and the methods of today's engines, a file each. They run on the same
//! scenes, frames and passes as Antumbra's own method, so that comparisons compare nothing but
//! methods.
//!
//! A renderer supports the methods that it is given ([`all`]). A new method is a file with a type
//! that implements [`occlusion::Method`], and a line in [`all`]. The decisions of a method that
//! waits for results are in the crate `cull`, as a [`cull::BlockingKind`], where a simulated GPU
//! tests them.
//!
//! ```
//! # use antumbra_methods as methods;
//! let mut all = methods::all().into_iter().map(|constructor| constructor.construct());
//! assert!(all.any(|method| method.strategies() == [methods::CHC]));
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod batched;
mod blocking;
mod chc;
mod hzb;
mod ideal;
mod naive;
mod next_frame;
mod stop_and_wait;

use cull::{BatchedOptions, ChcOptions, Strategy};
use occlusion::MethodConstructor;

pub use batched::{BATCHED, batched};
pub use chc::{CHC, chc};
pub use hzb::{HZB, HzbLevel, HzbPass, hzb_levels};

pub use ideal::IDEAL;
pub use naive::NAIVE;
pub use next_frame::NEXT_FRAME;
pub use stop_and_wait::STOP_AND_WAIT;

/// Returns the constructors of all methods, with their default options. If several methods have the
/// same strategy, a renderer takes the first: put a method with other options before these.
pub fn all() -> Vec<MethodConstructor> {
    vec![
        naive::method(),
        batched(BatchedOptions::default()),
        next_frame::method(),
        stop_and_wait::method(),
        chc(ChcOptions::default()),
        hzb::method(),
        ideal::method(),
    ]
}

/// Returns every strategy of a renderer with the methods of [`all`]: the baseline, the published
/// methods, Antumbra's own, and the ideal.
pub fn strategies() -> Vec<Strategy> {
    let theirs = all().into_iter().flat_map(|method| method.construct().strategies().to_vec());
    let mut all: Vec<Strategy> = theirs.chain(Strategy::PLANNED).collect();
    all.sort_by_key(|strategy| (*strategy != Strategy::FRUSTUM, strategy.needs_still_scene()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_strategy_is_carried_out_by_one_method() {
        let all = strategies();
        assert_eq!((all[0], all[all.len() - 1]), (Strategy::FRUSTUM, IDEAL));
        for strategy in &all {
            let same = all.iter().filter(|known| known.name() == strategy.name());
            assert_eq!(same.count(), 1, "{strategy}");
        }
    }
}
