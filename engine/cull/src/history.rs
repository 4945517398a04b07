//! The history: a record per node, and the changes of records by answers.

pub(crate) mod answers;
pub(crate) mod record;
pub(crate) mod records;
pub(crate) mod results;
