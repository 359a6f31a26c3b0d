//! Pivot places and setups between those that every plan begins with, found as a choice is refined. Nothing is chosen here.

use std::cell::{Cell, OnceCell};

use crate::plan::places::candidate::{Candidate, PivotSite};

/// Most places and most lists of setups that are added for one plan.
const MOST: usize = 4096;

/// What is added as a choice is refined. Nothing that was handed out moves.
pub(crate) struct Finer {
    sites: Vec<OnceCell<PivotSite>>,
    lists: Vec<OnceCell<Vec<Candidate>>>,
    sites_used: Cell<usize>,
    lists_used: Cell<usize>,
}

impl Finer {
    pub fn new() -> Finer {
        let (sites, lists) = ((0..MOST).map(|_| OnceCell::new()), (0..MOST).map(|_| OnceCell::new()));
        Finer { sites: sites.collect(), lists: lists.collect(), sites_used: Cell::new(0), lists_used: Cell::new(0) }
    }

    pub fn site(&self, index: usize) -> Option<&PivotSite> {
        self.sites.get(index)?.get()
    }

    /// Setups added so far.
    pub fn count(&self) -> usize {
        self.lists.iter().filter_map(|list| list.get()).map(Vec::len).sum()
    }

    pub(crate) fn keep_site(&self, site: PivotSite) -> Option<usize> {
        let known = (0..self.sites_used.get()).find(|&index| self.site(index) == Some(&site));
        known.or_else(|| {
            let index = self.sites_used.get();
            self.sites.get(index)?.set(site).ok()?;
            self.sites_used.set(index + 1);
            Some(index)
        })
    }

    pub(crate) fn keep_list(&self, list: Vec<Candidate>) -> Option<&[Candidate]> {
        let index = self.lists_used.get();
        let slot = self.lists.get(index)?;
        self.lists_used.set(index + 1);
        Some(slot.get_or_init(|| list))
    }
}
