//! What is how far from what: one world of solids per machine beside its chain, the instrument placed test by test. It chooses nothing.
//!
//! A distance is positive when the solids are apart and negative by the depth when they overlap, mm. Solids that touch by
//! design are left out by rule: two of one link, two of links that one joint connects, two machine bodies that touch with
//! all axes at zero, the bar and the cups that hold its balls (their limit is the cone of the cup), a stand and the body
//! under it, a spindle stem and the body that clamps it.

mod convex;
mod distance;
mod frames;
mod instrument;
mod scene;
mod sweep;
mod travel;
mod world;

pub use convex::Convex;
pub use distance::{distance, distance_below, parry_shape, penetration};
pub use instrument::{Instrument, InstrumentError, Placement};
pub use scene::{BarEnds, Clearance, Scene, Scratch};
pub use sweep::{Clear, Hit, SweepClearance, certify, sweep_clearance};
pub use travel::{Aside, Leg, NoWay, clear_way};
pub use world::{Part, World};
