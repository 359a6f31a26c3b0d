//! Five-axis machine accuracy from double ball bar recordings.
//!
//! ```text
//! recording, machine file ─load─▶ Machine ─build─▶ Chain          (nominal, named error slots, no state)
//! Chain + errors + Session ─simulate─▶ Trace
//! Chain + Recordings       ─identify─▶ Fit                        (estimates, covariance, what cannot be told apart)
//! Fit + Recordings         ─diagnose─▶ Diagnosis                  (where, what, how much, how sure, what test next)
//! Chain + Bodies           ─plan─▶ Plan                           (setups reachable, collision-free, informative)
//! any of them              ─report─▶ terminal, JSON, HTML
//! ```
//!
//! | room | holds |
//! |---|---|
//! | [`units`] | quantities with units as users write them |
//! | [`statistics`] | noise, robust location and scale, evidence; no geometry |
//! | [`machine`] | the machine as its file describes it |
//! | [`chain`] | compiled kinematics: positions, lengths, closed-form derivatives |
//! | [`readings`] | what instruments read of a chain: lengths, points, poses, sockets, displacements; no rows |
//! | [`bodies`] | solids on links, mounting surfaces, the ball-bar kit |
//! | [`template`] | a machine and its bodies from the figures of a data sheet |
//! | [`session`] | tests, balls, recordings, planned paths |
//! | [`effects`] | forward models of physics beyond constant location errors: the catalogue |
//! | [`disturbances`] | effects of a machine with their sizes, as changes of what is read |
//! | [`collision`] | clearances at a pose and certified over motions |
//! | [`plan`] | setups: reachable, collision-free, informative; what stays undetermined |
//! | [`survey`] | all serial five-axis topologies planned on one envelope |
//! | [`nc`] | programs that run a plan on four controls |
//! | [`simulate`] | traces of a session, ideal or through an instrument |
//! | [`inverse`] | the tool in the workpiece and the axis positions for it, errors included |
//! | [`compensate`] | programs corrected for the errors of a machine |
//! | [`load`] | files to values: YAML, URDF, CSV; the only room that knows formats |
//! | [`methods`] | the thesis's estimators and ISO 230-4 figures of planar circles, by closed formulas |
//! | [`identify`] | location errors from recordings: fit, noise, what cannot be told apart |
//! | [`volume`] | what errors do to the tool tip over the work volume, by cause |
//! | [`control`] | numbers of a fit as controls take them, and what they cannot hold |
//! | [`history`] | errors of one machine over months: drifts and steps told from scatter |
//! | [`reconcile`] | results of several methods on one machine: disagreements, causes, the test that decides |
//! | [`import`] | captures in one piece, as gauges write them, to recordings |
//! | [`diagnose`] | the physics that a fit left out: where, what, how much, how sure |
//! | [`report`] | values to terminal tables, JSON, YAML and SVG |
//!
//! Large rooms hold rooms of their own, listed in their `mod.rs`: `plan` runs `places` → `reach` → `information` → `context` →
//! `reasons` → `search` → `result` over one immutable context, `diagnose` has its own, `identify` keeps what it fits in `model`,
//! `load` parts text from machine and session files, `report` parts pictures, words and files from what is reported.
//!
//! Invariants: rooms import only rooms above them, files of a room each other one way, and at most sixteen lie side by side
//! (`tests/house.rs`); rooms that compute do no I/O; lengths are mm and angles rad inside, µm and arcsec in output; a model
//! never changes after loading, estimates stand beside it.

#![forbid(unsafe_code)]

pub mod bodies;
pub mod chain;
pub mod collision;
pub mod compensate;
pub mod control;
pub mod diagnose;
pub mod disturbances;
pub mod effects;
pub mod history;
pub mod identify;
pub mod import;
pub mod inverse;
pub mod load;
pub mod machine;
pub mod methods;
pub mod nc;
pub mod plan;
pub mod readings;
pub mod reconcile;
pub mod report;
pub mod session;
pub mod simulate;
pub mod statistics;
pub mod survey;
pub mod template;
pub mod units;
pub mod volume;
