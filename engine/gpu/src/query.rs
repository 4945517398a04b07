//! Rings of tests on the GPU, whose results arrive frames later, and draws that depend on the
//! results.

pub(crate) mod blocking_query_pool;
pub(crate) mod flag_ring;
pub(crate) mod leaf_draw_ring;
pub(crate) mod occlusion_pool;
pub(crate) mod predicates;
pub(crate) mod query_reset;
pub(crate) mod query_ring;
pub(crate) mod recorded_queries;
pub(crate) mod result_buffer;
pub(crate) mod ring;
