//! The comparison of all strategies: reads a folder of reports, writes a page, a table and a picture.
//!
//! [`input`] reads the reports back, [`cases`] puts repetitions and parts together, [`figures`] and
//! [`exactness`] say what is reached.

pub mod axis;
pub mod bar_chart;
pub mod canvas;
pub mod cases;
pub mod exactness;
pub mod figures;
pub mod input;
pub mod labels;
pub mod line_chart;
pub mod palette;
pub mod plots;
pub mod spread;
#[cfg(test)]
pub(crate) mod testing;
