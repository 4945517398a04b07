//! The interface of tables by kind.

pub(super) mod bucketed;
