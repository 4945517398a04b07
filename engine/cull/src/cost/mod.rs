//! What tests cost and save, and what frames teach about that.

pub(crate) mod contents;
pub(crate) mod corrections;
pub(crate) mod cost_model;
pub(crate) mod decaying_rate;
pub(crate) mod table;
