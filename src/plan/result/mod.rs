//! A plan as it comes out: order, mounting, forecast, advice.
//!
//! | file | question |
//! |---|---|
//! | `plan_result` | what is a plan? |
//! | `mounting` | which parts of the kit make a test's bar and carry its spindle ball? |
//! | `placing` | how does the pivot get to its place? |
//! | `marks` | by which moves along the bar do programs mark their runs in the readings? |
//! | `finish` | in which order, and what comes out? |
//! | `planning` | how is a plan made, from start to end? |
//! | `advice` | which option leaves an error out, which would bring it below the goal? |

pub(crate) mod advice;
pub(crate) mod finish;
pub(crate) mod marks;
pub(crate) mod mounting;
pub(crate) mod placing;
pub(crate) mod plan_result;
pub(crate) mod planning;
