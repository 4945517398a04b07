//! The presentation of a picture, and the feedback on it afterwards.

pub(crate) mod feedback;
mod showing;
