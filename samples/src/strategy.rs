//! The strategies a walk compares, by the names they have on the command line and in reports.

pub use cull::Strategy;
