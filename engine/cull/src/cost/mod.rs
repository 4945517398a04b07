//! The cost and the saving of tests, corrected by the times of frames.

pub(crate) mod contents;
pub(crate) mod corrections;
pub(crate) mod cost_model;
pub(crate) mod decaying_rate;
pub(crate) mod skip_prices;
pub(crate) mod table;
