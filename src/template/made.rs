//! What a template makes. It makes nothing.

use crate::bodies::Bodies;
use crate::machine::Machine;

/// A machine ready to be written and planned.
#[derive(Debug, Clone, PartialEq)]
pub struct Made {
    pub machine: Machine,
    pub bodies: Bodies,
    /// What nobody stated, in sentences; the machine's caveats hold them too.
    pub assumed: Vec<String>,
}
