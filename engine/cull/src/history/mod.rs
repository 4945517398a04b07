//! The history: a record of each node, and its changes by answers.

pub(crate) mod answers;
pub(crate) mod record;
pub(crate) mod records;
pub(crate) mod results;
