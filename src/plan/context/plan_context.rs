//! What a plan is made from: machine, solids, kit, wishes, and the setups within reach. It never changes once it is made.

use super::finer::Finer;
use super::settings::Settings;
use crate::bodies::{Bodies, Kit};
use crate::chain::Geometry;
use crate::collision::World;
use crate::machine::Machine;
use crate::plan::information::unknowns::Unknowns;
use crate::plan::places::candidate::Candidates;
use crate::plan::reach::approach::Parking;

/// What a plan is made from.
pub(crate) struct PlanContext<'a> {
    pub machine: &'a Machine,
    pub bodies: &'a Bodies,
    pub kit: &'a Kit,
    pub settings: &'a Settings,
    pub geometry: Geometry<'a>,
    /// Pairs of bodies that may come as near as the margin; setups are looked for among these.
    pub world: &'a World,
    /// All pairs of bodies; clearances are told of these.
    pub whole_world: &'a World,
    pub unknowns: Unknowns,
    pub all: &'a Candidates,
    /// Places and setups that were added as a choice was refined.
    pub finer: &'a Finer,
    pub parking: Parking,
}
