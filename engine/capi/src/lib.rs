//! The C interface of Antumbra, declared in `include/antumbra.h`.
//!
//! The interface has three levels. *Decisions alone*: boxes in, plan out, answers in; no Vulkan.
//! *Our executor in the host's command buffer* (feature `vulkan`): the host keeps its device,
//! queue, images, pipelines and draws. *Our renderer* (feature `renderer`): the host gives meshes
//! and objects, or a file (feature `import`), and gets images. The device is the host's, or the
//! library opens one (feature `loaded`).
//!
//! # Rules of all functions
//! - A function returns an [`AntumbraResult`]. An error leaves the outputs unchanged, unless the
//!   function says otherwise; the message in the [`AntumbraError`] says what to do. The pointer to
//!   the error may be null.
//! - The field `struct_size` of a struct holds the size in bytes with which the caller was
//!   compiled. The caller sets it before every call, also in the [`AntumbraError`] and in structs
//!   for output.
//! - In a struct with a `struct_size`, every field that the caller does not set must be 0. A field
//!   of 0 has its default, which its documentation names. A required field has no default. Fields
//!   that an older caller does not have count as 0. Reserved fields must be 0 in all structs.
//! - A pointer and a count describe an array, which may be null if the count is 0. Input and output
//!   arrays do not overlap.
//! - Every object belongs to a context. Handles are numbers: a handle that is 0, was destroyed, or
//!   belongs to another context or kind of object is an error. A context is a pointer: a wrong
//!   pointer is only detected if the memory that it points to can be read.
//! - Any function may be called on any thread. A call that changes an object excludes all other
//!   calls with the object; calls that only read it may overlap. The result of a conflict is
//!   `Busy`, and no call waits. [`antumbra_context_destroy`] is called after all other calls have
//!   returned.
//! - A panic in the library becomes the result `Panic`. Later calls with the object that was being
//!   changed return `Poisoned`, except its destruction.
//! - The interface has no global state of its own: contexts are independent of each other.
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
