//! A machine from its data sheet, or a robot description made plannable: axes, simple solids, a surface, a nose. It reads and plans nothing.
//!
//! | file | question |
//! |---|---|
//! | `described` | what must a robot description get so that a plan can be made? |
//! | `sizes` | which figures of a data sheet are asked for, and what do they default to? |
//! | `allowed` | which figures of a data sheet make a machine? |
//! | `inclined` | which rotary axis is inclined, and how? |
//! | `figures` | what is one figure of a sheet? |
//! | `axes` | where do the axes stand? |
//! | `solids` | which bodies stand for the machine until someone measures it? |
//! | `parts` | what do the bodies share? |
//! | `swivel` | which of them stand about an inclined axis? |
//!
//! The reference point R lies under the spindle, [`GAUGE_MM`] below its nose, with all axes at zero. The spindle is vertical.

pub mod allowed;
mod axes;
mod described;
mod figures;
mod inclined;
mod made;
mod parts;
mod sizes;
mod solids;
mod swivel;

pub use described::{Wishes, plannable};
pub use figures::{GAUGE_MM, SizesError, TableSize, is_rotary, usual_range};
pub use inclined::{Inclined, Plane};
pub use made::Made;
pub use sizes::Sizes;

/// Machine and bodies of a data sheet.
pub fn machine_of(sizes: &Sizes) -> Result<Made, SizesError> {
    let frame = sizes.frame()?;
    Ok(Made { machine: axes::machine(sizes, &frame), bodies: solids::bodies(sizes, &frame), assumed: sizes.assumed() })
}
