//! Whether free curves alone explain better what names explain at several places. It names nothing.

use super::joint_fit::JointFit;
use super::selected::{OtherSet, SelectionContext};
use crate::effects::{DESCRIBED_BY_CURVE, DESCRIBED_BY_NAME};
use std::collections::HashSet;

impl SelectionContext<'_, '_, '_> {
    /// Holds a set of named effects at several places against free curves alone, and takes the likelier of the two. The other one
    /// stays beside it.
    ///
    /// One cause that no form describes is often followed by several forms together, each of which takes a part of it.
    pub(crate) fn hold_against_free_curves(&self, joint: &mut JointFit) {
        let places: HashSet<_> = joint.found.iter().map(|found| found.chosen.effect.place).collect();
        let is_named = joint.found.first().is_some_and(|first| !first.chosen.is_free());
        if places.len() < 2 || !is_named {
            return;
        }
        let nothing = JointFit::empty(self);
        let mut free = nothing.clone();
        self.only_free.set(true);
        self.grow(&mut free, None);
        self.only_free.set(false);
        let thresholds = &self.limits.thresholds;
        let standing = joint.standing(self);
        let gained = (standing - nothing.standing(self)).max(0.0);
        let softened = (free.standing(self) - standing) / (1.0 + thresholds.softening * gained);
        let log_odds = softened + thresholds.undescribed.ln();
        // the set is told of which more may be claimed
        let is_free = log_odds + (DESCRIBED_BY_CURVE / DESCRIBED_BY_NAME).ln() > 0.0;
        let mut other = free;
        if is_free {
            std::mem::swap(joint, &mut other);
            joint.weigh(self);
        }
        let log_odds = if is_free { -log_odds } else { log_odds };
        joint.other = Some(OtherSet { columns: std::mem::take(&mut other.columns[0]), log_odds });
    }
}
