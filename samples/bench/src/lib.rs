//! The measuring tools of the engine, and the parts that the sample programs share: options,
//! reports, images, exit codes.
//!
//! The program `walkthrough`, step by step: [`args`] turns its command line into [`Options`],
//! [`outputs`] checks that its files can be written, [`run`] draws the frames in the order of
//! [`schedule`] and measures them with [`measurement`]. [`report`] and [`table`] present the
//! results. The program `budget` finds what each part of a frame costs ([`budget`]). With the
//! feature `charts`, `compare` makes one page of many such reports, and
//! `gpu_page` makes the page of a device.
#![forbid(unsafe_code)]

pub mod animated_png;
pub mod args;
pub mod budget;
pub mod camera_path;
pub mod choices;
pub mod colour_palette;
#[cfg(feature = "charts")]
pub mod compare;
pub mod destination;
pub mod exit_status;
pub mod eyes;
pub mod file_args;
#[cfg(feature = "charts")]
pub mod gpu_page;
pub mod image_difference;
pub mod input_file;
pub mod legend;
pub mod light_args;
pub mod measurement;
pub mod memory;
pub mod moving;
pub mod options;
pub mod outputs;
pub mod playback;
pub mod png_file;
pub mod progress;
pub mod projection;
pub mod provenance;
pub mod recorded_path;
pub mod report;
#[cfg(feature = "charts")]
pub mod result_page;
pub mod run;
pub mod run_error;
pub mod scene_file;
pub mod schedule;
pub mod section_args;
pub mod self_test_table;
pub mod shadow_choice;
pub mod signals;
pub mod statistics;
pub mod stopwatch;
pub mod strategy;
pub mod table;
pub mod terminal;
pub mod transparency;
pub mod walk;
pub mod walk_images;
pub mod walk_scene;

pub use args::Options;
