//! Faulty drivers, misuse and limits: each ends with a message, and nothing is lost.

mod driver_faults;
mod limits;
mod memory;
mod misuse;
mod nothing_to_do;
mod object_pairs;
mod portability;
mod recovery;
mod self_test;
