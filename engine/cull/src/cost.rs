//! The costs and savings of tests, corrected by the times of frames.

pub(crate) mod contents;
pub(crate) mod corrections;
pub(crate) mod decaying_rate;
pub(crate) mod learned_costs;
pub(crate) mod predication_costs;
pub(crate) mod table;
