//! What is tried: the candidates of a session and a first look at all of them. It accepts nothing.

pub(crate) mod candidates;
pub(crate) mod ripples;
pub(crate) mod screen;
pub(crate) mod screening_grid;
