//! Files that are valid are accepted, files that are not are refused: with a reason, in time, without a panic.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

#[path = "hostile/accepted.rs"]
mod accepted;
#[path = "hostile/assets.rs"]
mod assets;
#[path = "hostile/bombs.rs"]
mod bombs;
#[path = "hostile/chains.rs"]
mod chain;
#[path = "hostile/compressed.rs"]
mod compressed;
#[path = "hostile/containers.rs"]
mod containers;
#[path = "hostile/deviations.rs"]
mod deviations;
#[path = "hostile/disk.rs"]
mod disk;
#[path = "hostile/files.rs"]
mod files;
#[path = "hostile/motion.rs"]
mod motion;
#[path = "hostile/mutations.rs"]
mod mutations;
#[path = "hostile/refused.rs"]
mod refused;
#[path = "hostile/replaced.rs"]
mod replaced;
#[path = "hostile/target.rs"]
mod target;
#[path = "hostile/tolerated.rs"]
mod tolerated;
#[path = "hostile/unused.rs"]
mod unused;
