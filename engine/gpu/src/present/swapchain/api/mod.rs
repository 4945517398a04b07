//! Showing a picture, and what is known of it afterwards.

pub(crate) mod feedback;
mod showing;
