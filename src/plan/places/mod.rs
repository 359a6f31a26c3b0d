//! Setups within reach of the axes: where the balls may be and how the axes bring them there. Nothing is checked for collisions.
//!
//! | file | question |
//! |---|---|
//! | `solver` | where do the balls and the linear axes go so that one axis can be swept on a bar of a given length? |
//! | `candidate` | what is a setup? |
//! | `drive`, `course` | how do the axes move: one alone, one followed by linear axes, two on a circle? |
//! | `run_in` | how far does a run go beyond its arc, and what do ranges cut from that? |
//! | `free_range` | what do avoided regions leave of an axis's range? |
//! | `ball_places` | where on mounts, stem and fixture may the balls be? |
//! | `pairing`, `starts` | which two balls, and with the other axes where? |
//! | `turning` | which setups turn one axis alone? |
//! | `slides` | can linear axes bring a ball anywhere, and over which arc do they stay where they may? |
//! | `following` | where can linear axes follow a rotary axis, the bar keeping its direction in the turning frame? |
//! | `circle_setups` | where can two linear axes draw a circle? |
//! | `candidates` | which of all these come into question? |

pub(crate) mod ball_places;
pub(crate) mod candidate;
pub(crate) mod candidates;
pub(crate) mod circle_setups;
pub(crate) mod course;
pub(crate) mod drive;
pub(crate) mod following;
pub(crate) mod free_range;
pub(crate) mod pairing;
pub(crate) mod run_in;
pub(crate) mod slides;
pub(crate) mod solver;
pub(crate) mod starts;
pub(crate) mod turning;
