//! The C interface of Antumbra, declared in `include/antumbra.h`.
//!
//! Three levels. *Decisions alone*: boxes in, plan out, answers in; no Vulkan. *Our executor in the
//! host's command buffer* (feature `vulkan`): the host keeps its device, queue, images, pipelines
//! and draws. *Our renderer on the host's device* (feature `renderer`): the host gives meshes and
//! objects, and gets images.
//!
//! # Rules of all functions
//! - The result is [`AntumbraResult`]. If it is not `Ok`, nothing was written to the outputs but
//!   the [`AntumbraError`], which says what to do. It may be null.
//! - A pointer to a struct with a `struct_size` points to a value whose `struct_size` is its size
//!   in bytes as the caller was compiled: also the [`AntumbraError`] and structs for output.
//! - 0 is the default of every field of such a struct, whatever value it stands for, unless the
//!   field is required: what an older caller does not have counts as 0. Reserved fields must be 0,
//!   also in structs that are plain values.
//! - A pointer and a count describe an array, which may be null if the count is 0. Input and output
//!   arrays do not overlap.
//! - Everything belongs to a context. Its handles are numbers, so a handle that is 0, was
//!   destroyed, or belongs to another context or kind is an error. A context is a pointer: a wrong
//!   one is found out where its memory can still be read, which is not always.
//! - Any function may be called on any thread. A function that changes an object needs it alone,
//!   one that reads shares it with others that read; otherwise the result is `Busy`, and nothing
//!   waits. [`antumbra_context_destroy`] comes after all other calls have returned.
//! - A panic inside becomes `Panic`. The object that was being changed then answers `Poisoned` to
//!   everything but its destruction.
//! - There is no global state of ours: two contexts know nothing of each other.
//!
//! [`antumbra_context_destroy`]: api::context::antumbra_context_destroy
//! [`AntumbraResult`]: error::AntumbraResult
//! [`AntumbraError`]: error::AntumbraError

#![allow(unsafe_code, reason = "C calls it, and Vulkan lies below")]
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]

pub mod api;
pub mod context;
pub mod decisions;
pub mod error;
#[cfg(feature = "vulkan")]
pub mod executor;
pub mod layout;
pub mod log;
mod pointers;
#[cfg(feature = "renderer")]
pub mod renderer;
pub mod structs;
mod table;
#[cfg(test)]
mod tests;
pub mod version;
