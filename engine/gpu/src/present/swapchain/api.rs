//! Presenting a frame, and the feedback on it afterwards.

pub(crate) mod feedback;
mod showing;
