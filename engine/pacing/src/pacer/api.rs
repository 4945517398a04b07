//! The reactions of a pacer to its input, one module each.

mod learn;
mod queue;
mod schedule;
mod search;
mod timings;
