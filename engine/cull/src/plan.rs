//! The stages of a plan, one file each, and the parts of a plan.

pub(crate) mod budget;
pub(crate) mod candidates;
pub(crate) mod config;
pub(crate) mod cost_filter;
pub(crate) mod explain;
pub(crate) mod frame_plan;
pub(crate) mod fronts;
pub(crate) mod next_frame;
pub(crate) mod occluders;
pub(crate) mod phases;
pub(crate) mod plan_writer;
pub(crate) mod query_shares;
pub(crate) mod rounds;
pub(crate) mod shared_proxies;
pub(crate) mod strategy;
pub(crate) mod traverse;
