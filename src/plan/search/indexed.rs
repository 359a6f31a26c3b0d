//! Tests run again with the spindle indexed by 180°: the spindle ball's own placement enters with the opposite sign across the spindle.
//!
//! What indexing takes away is where the ball sits in the spindle. The spindle's own line stays what positions refer to, and
//! along that line the ball stays where it is: no index shows its length.

use std::collections::HashSet;
use std::rc::Rc;

use crate::plan::context::choice::{Choice, Entry};
use crate::plan::context::error::IndexError;
use crate::plan::context::evaluation::{Evaluation, INDEX_MIN};
use crate::plan::information::posterior::Posterior;

/// Gain (fall of Σ ln σ² of the wanted errors) per minute from which a test is worth running again.
const LEAST_GAIN: f64 = 0.05;
/// How nearly the spindle must lie along a direction of R with all axes at zero: |sin| of the angle between.
const ALONG: f64 = 1e-9;

impl<'a> Evaluation<'a> {
    /// Direction of R about which the spindle is indexed.
    pub(crate) fn spindle_direction(&self) -> Result<usize, IndexError> {
        let along = self.context.machine.spindle.as_ref().ok_or(IndexError::NoSpindle)?.direction;
        let is_along = |k: &usize| (0..3).filter(|other| other != k).all(|other| along[other].abs() < ALONG);
        (0..3).find(is_along).ok_or(IndexError::Inclined { x: along.x, y: along.y, z: along.z })
    }

    /// Adds runs with the spindle indexed as long as one pays: each chosen test once, its ball on the spindle's line.
    pub(crate) fn repeat_indexed(&self, choice: &mut Choice<'a>, about: usize) {
        let mut posterior = Posterior::before(&self.context.unknowns);
        choice.chosen.iter().for_each(|&k| posterior.add(&choice.entries[k].block));
        let mut minutes = self.reached(choice).minutes;
        let first: Vec<usize> = choice.chosen.clone();
        let mut repeated: HashSet<usize> = HashSet::new();
        loop {
            let before = log_sum(&posterior.variances());
            let on_line = |k: &usize| self.context.all.places[choice.entries[*k].candidate.place].aside_mm == 0.0;
            let best = first
                .iter()
                .filter(|k| !repeated.contains(*k) && on_line(k))
                .map(|&k| {
                    let entry = &choice.entries[k];
                    let cost = self.run_minutes(entry) + INDEX_MIN;
                    let after = log_sum(&posterior.variances_with(&entry.block.indexed(about)));
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
                at_most_deg: None,
                indexed_about: Some(about),
            };
            posterior.add(&twin.block);
            choice.chosen.push(choice.entries.len());
            choice.entries.push(twin);
        }
    }
}

fn log_sum(variances: &[f64]) -> f64 {
    variances.iter().map(|variance| variance.ln()).sum()
}
