//! What the sample programs share: options, measuring, reports, pictures.
//!
//! The `walkthrough` program, step by step: [`args`] turns its command line into [`Options`],
//! [`outputs`] makes sure that what it will write can be written, [`run`] draws the frames that
//! [`schedule`] orders and measures them with [`measurement`], [`report`] and [`table`] tell.
//! The program `compare` makes one page of many such reports: [`compare`].
#![forbid(unsafe_code)]

pub mod args;
pub mod choices;
pub mod compare;
pub mod course;
pub mod destination;
pub mod eyes;
pub mod film;
pub mod hud;
pub mod input_file;
pub mod measurement;
pub mod memory;
pub mod moving;
pub mod options;
pub mod outputs;
pub mod picture;
pub mod pictures;
pub mod progress;
pub mod provenance;
pub mod recorded_path;
pub mod report;
pub mod run;
pub mod scene_file;
pub mod schedule;
pub mod signals;
pub mod statistics;
pub mod stopwatch;
pub mod strategy;
pub mod table;
pub mod terminal;
pub mod verdict;
pub mod walk;
pub mod walk_scene;
pub mod window;

pub use options::Options;
