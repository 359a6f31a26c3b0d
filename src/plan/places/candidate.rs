//! A reachable setup: ball places, bar, axis positions and what moves. Where setups come from is in `candidates`.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::drive::Drive;
use super::solver::{Solved, Unreachable};
use crate::chain::LinkId;
use crate::session::Follow;

/// A ball place that several candidates share.
#[derive(Debug, Clone, PartialEq)]
pub struct PivotSite {
    /// Index of the mount.
    pub mount: usize,
    pub link: LinkId,
    pub at: Vector3<f64>,
    pub height_mm: f64,
}

/// Where the spindle ball is clamped.
#[derive(Debug, Clone, PartialEq)]
pub struct SpindlePlace {
    pub link: LinkId,
    pub at: Vector3<f64>,
    /// Distance from the tool axis, mm; above zero on a fixture.
    pub aside_mm: f64,
}

/// One reachable setup for the sweep of one axis, or for a circle of two.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The axis that turns; on a circle the linear axis that carries the cosine.
    pub axis: usize,
    /// Index of the pivot site.
    pub site: usize,
    /// Index of the spindle place.
    pub place: usize,
    pub bar_mm: f64,
    pub solved: Solved,
    /// Arc wanted, rad: of the axis, or on a circle.
    pub from: f64,
    pub to: f64,
    pub drive: Drive,
}

/// What is looked for beside sweeps of one axis alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Coupled {
    /// Ways in which linear axes may follow a rotary axis.
    pub follow: Vec<Follow>,
    /// Planar circles of the linear axes.
    pub circles: bool,
}

/// Everything that comes into question.
#[derive(Debug, Clone, Default)]
pub struct Candidates {
    pub sites: Vec<PivotSite>,
    pub places: Vec<SpindlePlace>,
    pub list: Vec<Candidate>,
    /// By axis: what kept setups from being reachable, the nearest miss of each limit.
    pub misses: BTreeMap<usize, Misses>,
}

/// What stood in the way for one axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Misses {
    /// Combinations of places, bars and static positions tried.
    pub tried: usize,
    /// Smallest overrun of each linear axis: position and by how much, mm.
    pub limits: BTreeMap<usize, (f64, f64)>,
    /// Those for which the bar was too short.
    pub too_short: usize,
    /// Smallest amount by which the longest bar was too short, mm.
    pub bar_short_mm: Option<f64>,
    pub singular: usize,
    /// Setups within all limits with this axis in an avoided region.
    pub avoided: BTreeMap<usize, usize>,
}

impl Misses {
    /// By how much the longest bar is too short, mm, where no bar was long enough anywhere.
    pub(crate) fn all_too_short_mm(&self) -> Option<f64> {
        self.bar_short_mm.filter(|_| self.too_short == self.tried)
    }

    /// The longest bar was too short by so much.
    pub(crate) fn note_short(&mut self, by_mm: f64) {
        self.bar_short_mm = Some(self.bar_short_mm.map_or(by_mm, |least| least.min(by_mm)));
    }

    pub(crate) fn note(&mut self, unreachable: &Unreachable) {
        match *unreachable {
            Unreachable::Limit { axis, at_mm, beyond_mm } => {
                let least = self.limits.entry(axis).or_insert((at_mm, beyond_mm));
                if beyond_mm < least.1 {
                    *least = (at_mm, beyond_mm);
                }
            }
            Unreachable::Singular => self.singular += 1,
            Unreachable::BarShort { .. } => {}
        }
    }
}

/// Axis regions kept out of use, mm or rad.
pub type Avoid = Vec<(usize, f64, f64)>;

/// Sweeps of one axis that setups are looked for: with which bars, over which arc, from where, outside which regions.
pub(crate) struct WantedSweep<'a> {
    pub axis: usize,
    /// Ends of the widest arc, rad.
    pub from: f64,
    pub to: f64,
    /// Lengths of the bars, mm.
    pub lengths_mm: &'a [f64],
    /// Positions by axis from which places of the linear axes are found, mm or rad.
    pub starts: &'a [Vec<f64>],
    pub avoid: &'a Avoid,
}
