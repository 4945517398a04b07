//! The methods of a [`Session`](super::session::Session) and of an open window, one file per topic.

mod act;
mod comparing;
mod enter;
mod hands;
mod identify;
mod lighting;
mod page;
mod recover;
