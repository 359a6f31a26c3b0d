//! Five-axis machine accuracy from double ball bar recordings.
//!
//! ```text
//! recording, machine file ─load─▶ Machine ─build─▶ Chain          (nominal, named error slots, no state)
//! Chain + errors + Session ─simulate─▶ Trace
//! Chain + Recordings       ─identify─▶ Fit                        (estimates, covariance, what cannot be told apart)
//! any of them              ─report─▶ terminal, JSON, HTML
//! ```
//!
//! | room | holds |
//! |---|---|
//! | [`units`] | quantities with units as users write them |
//! | [`machine`] | the machine as its file describes it |
//! | [`chain`] | compiled kinematics: positions, lengths, closed-form derivatives |
//! | [`session`] | tests, balls, recordings, planned paths |
//! | [`effects`] | forward models of physics beyond constant location errors: the catalogue |
//! | [`load`] | files to values: YAML, URDF, CSV; the only room that knows formats |
//! | [`simulate`] | traces of a session, ideal or through an instrument |
//! | [`methods`] | the thesis's estimators and ISO 230-4 figures of planar circles, by closed formulas |
//! | [`identify`] | location errors from recordings: fit, noise, what cannot be told apart |
//! | [`report`] | values to terminal tables, JSON, YAML and SVG |
//!
//! Invariants: rooms import only rooms above them; rooms that compute do no I/O; lengths are mm and angles rad
//! inside, µm and arcsec in output; a model never changes after loading, estimates stand beside it.

pub mod bodies;
pub mod chain;
<<<<<<< HEAD
pub mod effects;
pub mod identify;
pub mod load;
pub mod machine;
pub mod methods;
pub mod report;
=======
pub mod collision;
pub mod load;
pub mod machine;
pub mod plan;
>>>>>>> 98b1838 (Clearance of every sweep: bodies on links, ball-bar kit, certified collision checks, fiveaxis clearance)
pub mod session;
pub mod simulate;
pub mod units;
