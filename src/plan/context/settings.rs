//! What a plan is asked for: goals, clearance, what may move and what is kept out of use. Nothing is chosen here.

use super::method::Method;
use crate::plan::information::uncertainty::Uncertainty;
use crate::plan::places::candidate::{Avoid, Coupled};
use crate::plan::places::following::FOLLOWED;

/// What a plan is to reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Standard deviation wanted of positions, mm.
    pub position_mm: f64,
    /// Standard deviation wanted of orientations, rad.
    pub orientation_rad: f64,
    /// Time allowed, min.
    pub minutes: Option<f64>,
}

/// Goals that are searched for as multiples of the default goal, as far as they are no looser than the goal asked for.
pub(crate) const RUNGS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 5.0];

/// Settings of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub goal: Goal,
    /// Least clearance of every sweep, mm.
    pub margin_mm: f64,
    pub avoid: Avoid,
    /// Following axes and circles; with circles the squareness of the linear axes is wanted too.
    pub coupled: Coupled,
    pub method: Option<Method>,
    /// Most pivot setups of a plan without a method; `None`: as many as pay.
    pub pivots: Option<usize>,
    /// Run tests again with the spindle indexed by 180° where that lowers the wanted errors' uncertainty.
    pub index_spindle: bool,
    /// Share of priors in an error's variance from which more tests are sought for it, 0 to 0.5: at 0.5 a fit calls it
    /// undetermined, and a fit's own noise moves its share by some tenths.
    pub sure_share: f64,
    /// Multiples of the default goal that are searched for beside the goal asked for; empty: that goal alone.
    pub rungs: Vec<f64>,
    pub uncertainty: Uncertainty,
    /// Programs mark their runs by moves along the bar.
    pub marks: bool,
    pub feed_mm_per_min: f64,
}

impl Default for Settings {
    fn default() -> Settings {
        let arcsec = std::f64::consts::PI / (180.0 * 3600.0);
        Settings {
            goal: Goal { position_mm: 4e-3, orientation_rad: 4.0 * arcsec, minutes: None },
            margin_mm: 5.0,
            avoid: Vec::new(),
            coupled: Coupled { follow: FOLLOWED.to_vec(), circles: false },
            method: None,
            pivots: None,
            index_spindle: false,
            sure_share: 0.3,
            rungs: RUNGS.to_vec(),
            uncertainty: Uncertainty::default(),
            marks: true,
            feed_mm_per_min: 500.0,
        }
    }
}
