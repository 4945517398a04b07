//! The methods of the literature and of today's engines, a file each: they run on the same scenes,
//! frames and passes as Antumbra's own, so that comparisons compare methods and nothing else.
//!
//! A renderer supports the methods that it is given ([`ALL`]). A new method is a file with a type
//! that implements [`occlusion::Method`], and a line in [`ALL`].
//!
//! ```
//! # use antumbra_methods as methods;
//! use cull::{BlockingOptions, Strategy};
//!
//! let options = BlockingOptions::default();
//! let mut all = methods::ALL.iter().map(|new| new(&options));
//! assert!(all.any(|method| method.carries_out(Strategy::Coherent)));
//! ```
#![forbid(unsafe_code)]

mod batched;
mod blocking;
mod chc;
mod depth_pyramid;
mod ideal;
mod naive;
mod next_frame;
mod stop_and_wait;

use occlusion::MethodConstructor;

pub use depth_pyramid::{PyramidLevel, PyramidPass, pyramid_levels};

/// The constructors of all methods.
pub const ALL: &[MethodConstructor] = &[
    naive::method,
    batched::method,
    next_frame::method,
    stop_and_wait::method,
    chc::method,
    depth_pyramid::method,
    ideal::method,
];

#[cfg(test)]
mod tests {
    use cull::{BlockingOptions, Strategy};
    use occlusion::{Method, PlannedMethod};

    use super::*;

    #[test]
    fn each_strategy_is_carried_out_by_one_method() {
        let made = ALL.iter().map(|new| new(&BlockingOptions::default()));
        let mut methods: Vec<Box<dyn Method>> = made.collect();
        methods.push(Box::new(PlannedMethod));
        for strategy in Strategy::ALL {
            let count = methods.iter().filter(|method| method.carries_out(strategy)).count();
            assert_eq!(count, 1, "{strategy}");
        }
    }
}
