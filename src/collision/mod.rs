//! What is how far from what: one world of solids per machine beside its chain, the instrument placed test by test. It chooses nothing.
//!
//! A distance is positive when the solids are apart and negative by the depth when they overlap, mm. All pairs on different
//! links are compared, but for those that the machine file lists as touching by design. Of the instrument these touch by
//! design: the bar and the cups that hold its balls (their limit is the cone of the cup), the pivot's base and stem and the
//! one body on which they stand, the spindle's stem and the one body that holds it.

mod convex;
mod distance;
mod frames;
mod instrument;
mod meeting;
mod scene;
mod solids;
mod sweep;
mod travel;
mod world;

pub use convex::Convex;
pub use distance::{distance, parry_shape};
pub use instrument::{CONE_MARGIN_RAD, Instrument, InstrumentError, Placement};
pub use meeting::Meeting;
pub use scene::{BarEnds, Clearance, Scene, Scratch};
pub use sweep::{Clear, Hit, SweepClearance, certify, least_cone_rad, sweep_clearance};
pub use travel::{Aside, Leg, NoWay, clear_way};
pub use world::{Part, World};
