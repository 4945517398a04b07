//! The calls of a [`Session`](super::session::Session) and of an open window, a file per concern.

mod act;
mod comparing;
mod enter;
mod hands;
mod identify;
mod lighting;
mod page;
