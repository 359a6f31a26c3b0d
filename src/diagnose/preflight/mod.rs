//! Whether files, set-up and readings can be believed at all, before any physics is looked for.

pub(crate) mod axis_columns;
pub(crate) mod contradictions;
pub(crate) mod data_fault;
pub(crate) mod doubts;
pub(crate) mod dwells;
pub(crate) mod examine;
pub(crate) mod gross_misfit;
pub(crate) mod late_clock;
pub(crate) mod mistake_or_effect;
pub(crate) mod mistakes;
pub(crate) mod nearer;
pub(crate) mod places;
pub(crate) mod quick_fit;
pub(crate) mod readings;
pub(crate) mod small_misfit;
mod struck_together;
pub(crate) mod suspicion;
pub(crate) mod unchanging;
