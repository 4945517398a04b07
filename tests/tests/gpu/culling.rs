//! Culling: images are exact with every strategy, and what is hidden is not drawn.

mod cold_starts;
mod compute_test;
mod coplanar;
mod counts;
mod detail;
mod edge_on;
mod exactness;
mod explain;
mod far_away;
pub(crate) mod feature_soup;
mod finish;
mod hzb;
mod ideal;
mod learning;
mod mesh_pieces;
mod moving;
mod multiview;
mod other_engines;
mod pick;
mod projections;
mod strategies;
mod subpixel;
mod testers;
mod threshold;
mod views;
