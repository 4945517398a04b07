//! The engine on both software drivers, under synchronization validation, without a window.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod attachments;
#[cfg(feature = "shader-compiler")]
mod bare_boxes;
mod bindless_textures;
mod blocking_query_pool;
#[cfg(feature = "shader-compiler")]
mod buckets;
mod c_interface;
mod calibration;
mod cold_starts;
mod compute_test;
mod coplanar;
mod counts;
mod depth_complexity;
mod detail;
mod driver_faults;
mod edge_on;
mod edges;
mod environment;
mod exactness;
mod explain;
mod far_away;
mod feature_soup;
mod finish;
mod flares;
mod frame_loop;
mod golden;
mod gpu_layer;
mod host_device;
#[cfg(feature = "shader-compiler")]
mod host_frames;
mod host_overlay;
mod host_quirks;
#[cfg(feature = "shader-compiler")]
mod host_scenes;
mod hud;
mod hzb;
mod ideal;
mod learning;
mod limits;
mod list_draws;
mod mesh_pieces;
mod misuse;
mod moving;
mod msaa;
mod multiview;
mod nothing_to_do;
mod object_pairs;
mod other_engines;
mod pick;
mod pictures;
mod poses;
mod projections;
mod relight;
#[cfg(feature = "shader-compiler")]
mod reload;
mod scene_rays;
mod sections;
mod self_test;
mod shading;
mod shadow_maps;
mod shadow_volumes;
mod skinning;
mod sorted_fragments;
mod strategies;
mod streaming;
mod subpixel;
mod tessellation;
mod testers;
mod textures;
mod threshold;
mod transparent;
mod vertex_surfaces;
mod views;
mod volume_shadows;
