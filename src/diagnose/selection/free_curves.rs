//! How free curves alone would explain a session that names explain at several places. It names nothing.

use super::joint_fit::JointFit;
use super::selected::SelectionContext;
use std::collections::HashSet;

impl SelectionContext<'_, '_, '_> {
    /// Log odds of free curves alone beside a set of named effects at several places, softened by what forms of the catalogue lack.
    ///
    /// One cause that no form describes is often followed by several forms together, each of which takes a part of it.
    pub(crate) fn odds_of_free_curves(&self, joint: &JointFit) -> f64 {
        let places: HashSet<_> = joint.found.iter().map(|found| found.chosen.effect.place).collect();
        let is_named = joint.found.first().is_some_and(|first| !first.chosen.is_free());
        if places.len() < 2 || !is_named {
            return f64::NEG_INFINITY;
        }
        self.only_free.set(true);
        let nothing = JointFit::empty(self);
        let mut free = nothing.clone();
        self.grow(&mut free, None);
        self.only_free.set(false);
        let standing = joint.standing(self);
        let gained = (standing - nothing.standing(self)).max(0.0);
        (free.standing(self) - standing) / (1.0 + self.limits.thresholds.softening * gained)
    }
}
