//! What a pacer does with what it is told, a file each.

mod learn;
mod queue;
mod schedule;
mod search;
mod timings;
