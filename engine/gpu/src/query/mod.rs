//! Rings that ask the GPU and get answers frames later, and draws that hang on what it says.

pub(crate) mod flag_ring;
pub(crate) mod occlusion_pool;
pub(crate) mod part_draws;
pub(crate) mod predicates;
pub(crate) mod query_pages;
pub(crate) mod query_ring;
pub(crate) mod recorded;
pub(crate) mod ring;
pub(crate) mod words;
