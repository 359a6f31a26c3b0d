//! What a setup can reach without collision, and how fast. Nothing is chosen.
//!
//! | file | question |
//! |---|---|
//! | `sweep_reach` | how far can the axis sweep before something comes too close? |
//! | `approach` | where does the machine park and how does it get from there to the start of a run? |
//! | `little_moves` | by which moves from park does an operator see the sense of the axes? |
//! | `pace` | how fast may a run be so that a control keeps its feed? |
//! | `out_of_reach` | is there anything to plan with these mounts and this kit? |

pub(crate) mod approach;
pub(crate) mod little_moves;
pub(crate) mod out_of_reach;
pub(crate) mod pace;
pub(crate) mod sweep_reach;
