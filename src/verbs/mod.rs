//! One file per verb: reads files, calls the rooms, hands results to `report`, writes files whole or not at all.

<<<<<<< HEAD
pub mod check;
pub mod identify;
=======
pub mod clearance;
>>>>>>> 98b1838 (Clearance of every sweep: bodies on links, ball-bar kit, certified collision checks, fiveaxis clearance)
pub mod output;
pub mod progress;
pub mod save;
pub mod simulate;

/// Why a verb stopped: one message for the user, exit code 2.
pub type Refusal = Box<dyn std::error::Error>;
