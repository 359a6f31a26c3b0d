//! Setups that are reachable, collision-free and informative, for any serial machine. It reads and writes no files.
//!
//! | file | question |
//! |---|---|
//! | `solver` | where do the balls and the linear axes go so that one axis can be swept on a bar of a given length? |
//! | `places` | where on mounts, stem and fixture may the balls be? |
//! | `candidates` | which places, bars, static positions and sweeps come into question? |
//! | `out_of_reach` | is there anything to plan with these mounts and this kit? |
//! | `course` | how do the axes move: one alone, one followed by linear axes, two on a circle? |
//! | `slides` | can linear axes bring a ball anywhere, and over which arc do they stay where they may? |
//! | `following` | where can linear axes follow a rotary axis, the bar keeping its direction in the turning frame? |
//! | `planar` | where can two linear axes draw a circle? |
//! | `run_in` | how far does a run go beyond its arc, and what do ranges cut from that? |
//! | `reach` | how far can the axis sweep before something comes too close? |
//! | `approach` | where does the machine park and how does it get from there to the start of a run? |
//! | `information` | what does a test tell about the wanted errors, given setup spreads and linear-axis uncertainty? |
//! | `knowledge` | what is known after some tests? |
//! | `settings` | what is a plan asked for? |
//! | `choose` | what lies on the desk, what does a test tell and cost, which of two choices is better? |
//! | `clearing` | is a setup clear, and is there a clear way to it? |
//! | `greedy` | which tests, one by one? |
//! | `indexed` | which tests pay when the spindle is indexed by 180°? |
//! | `pairs` | which two tell together what neither tells alone? |
//! | `one_pivot` | which tests, all from one pivot setup? |
//! | `searches` | which goals are searched for, and which choice is kept? |
//! | `finer` | which places and setups lie between those? |
//! | `refine` | what do they save of a choice? |
//! | `part` | what is the cheapest part of a choice that is as good? |
//! | `planned` | in which order, and what comes out? |
//! | `mounting` | which parts of the kit make a test's bar and carry its spindle ball? |
//! | `method` | the thesis's chapters 4 to 7 as choices from the same solver |
//! | `free_range` | what do avoided regions leave of an axis's range? |
//! | `untested` | which limit leaves an axis without a test, by how much? |
//! | `advice` | which option leaves an error out, which would bring it below the goal? |
//! | `unfit` | why does a method of the thesis not fit a machine? |
//! | `sight` | what can lengths show at all, whatever stands in the way? |
//! | `words` | what stays undetermined and why |

mod advice;
mod approach;
mod candidates;
mod choose;
mod clearing;
mod course;
mod finer;
mod following;
mod free_range;
mod greedy;
mod indexed;
mod information;
mod knowledge;
mod little_moves;
mod method;
mod mounting;
mod one_pivot;
mod out_of_reach;
mod pace;
mod pairs;
mod part;
mod places;
mod placing;
mod planar;
mod planned;
mod reach;
mod refine;
mod run_in;
mod searches;
mod settings;
mod sight;
mod slides;
mod solver;
mod unfit;
mod untested;
mod words;

pub use advice::plan_with_advice;
pub use approach::{Approach, Parking};
pub use candidates::{Avoid, Candidate, Candidates, Coupled, Misses, PivotSite, SpindlePlace, candidates};
pub use choose::{PlanError, plan};
pub use course::{Drive, Swing};
pub use following::FOLLOWED;
pub use free_range::free_parts;
pub use indexed::IndexError;
pub use information::{Block, Nuisance, Uncertainty, Unknowns};
pub use knowledge::Knowledge;
pub use little_moves::LittleMove;
pub use method::{Method, MethodError};
pub use mounting::{Arm, CupLooks, Mounting};
pub use out_of_reach::OutOfReach;
pub use pace::CHORD_MM;
pub use placing::Placing;
pub use planned::{OnePivot, Plan, PlannedTest, TradeOff};
pub use reach::{ClearArc, ClearSweep, longest_sweep};
pub use run_in::{
    CutRunIn, GRID_DEG, OFF_LIMIT, RUN_IN, RunEnd, bare_session, beyond_path, cut_run_ins, rows_with_run_in,
};
pub use settings::{Goal, Settings};
pub use solver::{Pull, Solved, Stance, Unreachable};
pub use words::ErrorForecast;
