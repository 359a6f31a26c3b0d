//! A machine from its data sheet, or a robot description made plannable: axes, simple solids, a surface, a nose. It reads and plans nothing.
//!
//! | file | question |
//! |---|---|
//! | `described` | what must a robot description get so that a plan can be made? |
//! | `sizes` | which figures of a data sheet are asked for, and what do they default to? |
//! | `axes` | where do the axes stand? |
//! | `solids` | which bodies stand for the machine until someone measures it? |
//!
//! The reference point R lies under the spindle, [`GAUGE_MM`] below its nose, with all axes at zero. The spindle is vertical.

mod axes;
mod described;
mod sizes;
mod solids;

pub use described::{Wishes, plannable};
pub use sizes::{GAUGE_MM, Sizes, SizesError, TableSize};

use crate::bodies::Bodies;
use crate::machine::Machine;

/// Machine and bodies of a data sheet.
pub fn machine_of(sizes: &Sizes) -> Result<(Machine, Bodies), SizesError> {
    let frame = sizes.frame()?;
    Ok((axes::machine(sizes, &frame), solids::bodies(sizes, &frame)))
}
