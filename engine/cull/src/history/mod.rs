//! What is remembered of each node, and how answers change it.

pub(crate) mod answers;
pub(crate) mod record;
pub(crate) mod records;
pub(crate) mod results;
