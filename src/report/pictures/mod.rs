//! Plots as SVG text, and the row of figures at the head of a page.

pub(crate) mod cards;
pub(crate) mod course;
pub(crate) mod frame;
pub mod polar;
pub mod residual_plot;
pub mod trace_plots;
