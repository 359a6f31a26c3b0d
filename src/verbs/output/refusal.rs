//! Why a verb stopped. How it ends then is in `ending`.

/// Why a verb stopped: one message for the user; `ending` knows the exit code, which is 2 for most.
pub type Refusal = Box<dyn std::error::Error>;
