//! Whether files, set-up and readings can be believed at all, before any physics is looked for.

pub(crate) mod axis_lines;
pub(crate) mod ball_places;
pub(crate) mod contradictions;
pub(crate) mod data_fault;
pub(crate) mod doubts;
pub(crate) mod dwells;
pub(crate) mod examine;
pub(crate) mod exchanged;
pub(crate) mod frames;
pub(crate) mod gross_misfit;
pub(crate) mod misplaced;
pub(crate) mod mistakes;
pub(crate) mod quick_fit;
pub(crate) mod restated;
pub(crate) mod small_misfit;
pub(crate) mod standing;
pub(crate) mod suspicion;
