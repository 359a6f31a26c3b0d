//! Statements of where things stand that the lengths contradict: balls, axes, frames, and where each would be. It judges no physics.

pub(crate) mod axis_lines;
pub(crate) mod axis_order;
pub(crate) mod ball_places;
pub(crate) mod exchanged;
pub(crate) mod folded;
pub(crate) mod foreign;
pub(crate) mod frames;
pub(crate) mod loaded;
pub(crate) mod misplaced;
pub(crate) mod remounted;
pub(crate) mod restated;
pub(crate) mod spreads;
pub(crate) mod standing;
pub(crate) mod sweeps;
pub(crate) mod written_positions;
