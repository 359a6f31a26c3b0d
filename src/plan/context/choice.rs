//! Tests chosen from candidates, and what a choice reaches and costs. How that is worked out is in `evaluation`.

use std::rc::Rc;

use crate::plan::information::block::Block;
use crate::plan::places::candidate::Candidate;
use crate::plan::reach::sweep_reach::ClearArc;

/// A candidate with what is known of it by now.
#[derive(Clone)]
pub(crate) struct Entry<'c> {
    pub candidate: &'c Candidate,
    pub block: Rc<Block>,
    pub sweep: Option<ClearArc>,
    /// Before there is a sweep: an arc that it does not exceed, where samples were looked at, deg.
    pub at_most_deg: Option<(f64, f64)>,
    /// Direction of R about which the spindle is indexed by 180° for this run.
    pub indexed_about: Option<usize>,
}

impl Entry<'_> {
    /// True when nothing is known of the arc but the axis's range.
    pub fn is_whole(&self) -> bool {
        self.sweep.is_none() && self.at_most_deg.is_none()
    }
}

/// Candidates looked at and the indices of those chosen, in order.
#[derive(Default)]
pub(crate) struct Choice<'c> {
    pub entries: Vec<Entry<'c>>,
    pub chosen: Vec<usize>,
}

impl<'c> Choice<'c> {
    /// The chosen entries alone.
    pub fn without_rest(&self) -> Choice<'c> {
        let entries: Vec<Entry<'c>> = self.chosen.iter().map(|&k| self.entries[k].clone()).collect();
        Choice { chosen: (0..entries.len()).collect(), entries }
    }
}

/// What a choice reaches and costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reached {
    /// Errors determined.
    pub determined: usize,
    /// Σ ln max(σ², goal²) with pivots and bars unknown.
    pub worth: f64,
    pub minutes: f64,
    /// Minutes, and some for runs in straight blocks.
    pub cost: f64,
    pub pivots: usize,
}

/// What a choice would take and reach if time were no limit, by wanted error.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Untimed {
    pub minutes: f64,
    pub determined: Vec<bool>,
    /// The goal, given the spindle ball.
    pub reaches: Vec<bool>,
    /// Why it is not determined with all the time that pays.
    pub reasons: Vec<Option<String>>,
}

/// The best plan whose tests all use one pivot setup.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnePivot {
    /// Errors determined.
    pub determined: usize,
    pub minutes: f64,
}
