//! Tests run again with the spindle indexed by 180°: the spindle ball's own placement enters with the opposite sign across the spindle.
//!
//! What indexing takes away is where the ball sits in the spindle. The spindle's own line stays what positions refer to, and
//! along that line the ball stays where it is: no index shows its length.

use std::collections::HashSet;
use std::rc::Rc;

use super::choose::{Choice, Desk, Entry};
use super::knowledge::Knowledge;

/// Minutes to index the spindle.
pub(super) const INDEX_MIN: f64 = 1.0;
/// Gain (fall of Σ ln σ² of the wanted errors) per minute from which a test is worth running again.
const LEAST_GAIN: f64 = 0.05;
/// How nearly the spindle must lie along a direction of R with all axes at zero: |sin| of the angle between.
const ALONG: f64 = 1e-9;

/// Why the spindle's index does not help.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IndexError {
    #[error("--index-spindle: the machine file has no 'spindle'; add its link, nose and direction")]
    NoSpindle,
    #[error(
        "--index-spindle: with all axes at zero the spindle points along ({x:.4}, {y:.4}, {z:.4}), none of R's directions; a session states the index about x, y or z only"
    )]
    Inclined { x: f64, y: f64, z: f64 },
}

impl<'a> Desk<'a> {
    /// Direction of R about which the spindle is indexed.
    pub(super) fn spindle_direction(&self) -> Result<usize, IndexError> {
        let along = self.bodies.spindle.as_ref().ok_or(IndexError::NoSpindle)?.direction;
        let is_along = |k: &usize| (0..3).filter(|other| other != k).all(|other| along[other].abs() < ALONG);
        (0..3).find(is_along).ok_or(IndexError::Inclined { x: along.x, y: along.y, z: along.z })
    }

    /// Adds runs with the spindle indexed as long as one pays: each chosen test once, its ball on the spindle's line.
    pub(super) fn repeat_indexed(&self, choice: &mut Choice<'a>, about: usize) {
        let mut knowledge = Knowledge::before(&self.unknowns);
        choice.chosen.iter().for_each(|&k| knowledge.add(&choice.entries[k].block));
        let mut minutes: f64 = choice.chosen.iter().map(|&k| self.run_minutes(&choice.entries[k])).sum();
        let first: Vec<usize> = choice.chosen.clone();
        let mut repeated: HashSet<usize> = HashSet::new();
        loop {
            let before = log_sum(&knowledge.variances());
            let on_line = |k: &usize| self.all.places[choice.entries[*k].candidate.place].aside_mm == 0.0;
            let best = first
                .iter()
                .filter(|k| !repeated.contains(*k) && on_line(k))
                .map(|&k| {
                    let entry = &choice.entries[k];
                    let cost = self.run_minutes(entry) + INDEX_MIN;
                    let after = log_sum(&knowledge.variances_with(&entry.block.indexed(about)));
                    ((before - after) / cost, cost, k)
                })
                .max_by(|a, b| a.0.total_cmp(&b.0).then(b.2.cmp(&a.2)));
            let Some((rate, cost, k)) = best else { break };
            let fits = self.budget.is_none_or(|budget| minutes + cost <= budget);
            if rate < LEAST_GAIN || !fits {
                break;
            }
            minutes += cost;
            repeated.insert(k);
            let twin = &choice.entries[k];
            let twin = Entry {
                candidate: twin.candidate,
                block: Rc::new(twin.block.indexed(about)),
                sweep: twin.sweep.clone(),
                indexed_about: Some(about),
            };
            knowledge.add(&twin.block);
            choice.chosen.push(choice.entries.len());
            choice.entries.push(twin);
        }
    }
}

fn log_sum(variances: &[f64]) -> f64 {
    variances.iter().map(|variance| variance.ln()).sum()
}
