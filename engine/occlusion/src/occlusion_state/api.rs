//! The interface of views by concern.

mod planning;
