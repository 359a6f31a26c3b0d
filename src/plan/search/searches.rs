//! Which searches are run for a goal and for a time, and which of their choices is kept. How one search goes is `greedy`'s and `one_pivot`'s.
//!
//! Gain per minute at a loose goal can lead to dearer tests than at a tight one. So a goal is searched for at fixed goals too
//! that are tighter, and from every choice the cheapest part is taken that reaches the goal: what a tighter goal found, a
//! looser one finds as well.

use super::free_choice::Found;
use crate::plan::context::choice::{Choice, Entry, OnePivot, Untimed};
use crate::plan::context::evaluation::{Evaluation, goals};
use crate::plan::context::settings::{Goal, RUNGS, Settings};
use crate::plan::places::candidate::Candidate;
use crate::plan::reasons::forecast::{ErrorForecast, forecasts};

/// Rungs tighter than this are for goals tighter than the default alone.
const TIGHTEST_OF_DEFAULT: f64 = 0.5;
/// A goal that is looser than a rung by less than this needs no search of its own.
const NEAR: f64 = 4.0 * (1.0 + 1e-9);
/// A goal that is looser than a rung in one of both by more than this factor needs a search of its own.
const ALIKE: f64 = 1.5;

impl<'a> Evaluation<'a> {
    /// The cheapest choice found for the goal; with time given, that choice and what else fits in the time.
    pub(crate) fn searched(&mut self) -> (Choice<'a>, Option<OnePivot>) {
        let budget = self.budget.take();
        let (base, one_pivot) = self.cheapest();
        let base_minutes = self.reached(&base).minutes;
        self.budget = budget;
        let Some(minutes) = budget else { return (base, one_pivot) };
        if base_minutes > minutes {
            let entries: Vec<&Entry> = base.chosen.iter().map(|&k| &base.entries[k]).collect();
            let errors = forecasts(self, &entries);
            let reaches = |(error, goal): (&ErrorForecast, &f64)| error.sigma_relative <= goal * 1.001;
            self.untimed = Some(Untimed {
                minutes: base_minutes,
                determined: errors.iter().map(|error| error.determined).collect(),
                reaches: errors.iter().zip(&self.goals).map(reaches).collect(),
                reasons: errors.iter().map(|error| (!error.determined).then(|| error.reason.clone())).collect(),
            });
        }
        let list: &'a [Candidate] = &self.context.all.list;
        let mut best = self.greedy_from(list.iter(), &base);
        // more tests can leave a greater share of an error's variance to priors, and time too short for the goal may be
        // spent better otherwise
        let (other, other_one) = if base_minutes <= minutes {
            (base, one_pivot)
        } else {
            let found = self.once();
            let one_pivot = found.one_pivot.as_ref().and_then(|one| self.one_pivot(one));
            (found.choice, one_pivot)
        };
        if self.is_better(&self.reached(&other), &self.reached(&best)) {
            best = other;
        }
        (best, other_one)
    }

    /// One search for the goals as they are.
    fn once(&mut self) -> Found<'a> {
        match self.context.settings.pivots {
            Some(1) => Found { choice: self.one_pivot_choice(), one_pivot: None },
            _ => self.free_choice(),
        }
    }

    fn one_pivot(&self, choice: &Choice<'a>) -> Option<OnePivot> {
        let reached = self.reached(choice);
        (reached.pivots == 1).then_some(OnePivot { determined: reached.determined, minutes: reached.minutes })
    }

    /// The cheapest part of all choices found at rungs no looser than the goal that reaches it, and what one pivot reaches.
    fn cheapest(&mut self) -> (Choice<'a>, Option<OnePivot>) {
        if self.context.settings.rungs.is_empty() {
            let Found { choice, one_pivot } = self.once();
            let one = self.one_pivot(&choice).or_else(|| self.one_pivot(one_pivot.as_ref()?));
            return (choice, one);
        }
        let goal = self.context.settings.goal;
        let default = Settings::default().goal;
        let half = scaled(&default, TIGHTEST_OF_DEFAULT);
        let asked = self.goals.clone();
        let mut found: Vec<(Goal, Found<'a>)> = Vec::new();
        let mut refined: Vec<Choice<'a>> = Vec::new();
        for rung in self.rungs() {
            self.goals = goals(&self.context.unknowns, &rung);
            // what only a search of all pairs finds, one of these two rungs has found
            self.tries_all_pairs = is_within(&half, &rung) && is_within(&rung, &default);
            found.push((rung, self.once()));
            // a tighter rung is refined where it is what is asked for: what it finds serves a looser goal too seldom
            if is_within(&default, &rung) {
                refined.push(self.refined_of(&found, &refined));
            }
        }
        self.goals = asked;
        self.tries_all_pairs = true;
        let is_covered = found.last().is_some_and(|(rung, _)| is_near(rung, &goal));
        if !is_covered {
            found.push((goal, self.once()));
        }
        if refined.is_empty() || !is_covered && !is_within(&default, &goal) {
            refined.push(self.refined_of(&found, &refined));
        }
        let best = self.best_of(&found, &refined);
        let one = self.one_pivot(&best).or_else(|| {
            let ones: Vec<&Choice<'a>> = found.iter().filter_map(|(_, found)| found.one_pivot.as_ref()).collect();
            let reference = found[self.reference(&found)].1.one_pivot.as_ref().or(ones.last().copied())?;
            self.one_pivot(&self.cheapest_of(ones.clone(), reference))
        });
        (best, one)
    }

    /// The search whose choice the others must be as good as: at a rung no looser than the default the one that determines most,
    /// the loosest of equals.
    fn reference(&self, found: &[(Goal, Found<'a>)]) -> usize {
        let default = Settings::default().goal;
        let mut reference = 0;
        for (place, (rung, one)) in found.iter().enumerate() {
            let determined = self.reached(&one.choice).determined;
            if is_within(rung, &default) && determined >= self.reached(&found[reference].1.choice).determined {
                reference = place;
            }
        }
        reference
    }

    /// The cheapest part of all choices found by now.
    fn best_of(&self, found: &[(Goal, Found<'a>)], refined: &[Choice<'a>]) -> Choice<'a> {
        let ones = found.iter().filter_map(|(_, found)| found.one_pivot.as_ref());
        let choices = found.iter().map(|(_, found)| &found.choice).chain(ones).chain(refined);
        self.cheapest_of(choices.collect(), &found[self.reference(found)].1.choice)
    }

    /// The same made cheaper.
    fn refined_of(&mut self, found: &[(Goal, Found<'a>)], refined: &[Choice<'a>]) -> Choice<'a> {
        let best = self.best_of(found, refined);
        let demand = self.demand(&found[self.reference(found)].1.choice);
        self.refined(best, &demand)
    }

    /// The cheapest part of some choices that is as good as the reference, or reaches the goals.
    fn cheapest_of(&self, choices: Vec<&Choice<'a>>, reference: &Choice<'a>) -> Choice<'a> {
        let demand = self.demand(reference);
        let parts = choices.into_iter().filter_map(|choice| self.cheapest_part(choice, &demand));
        let with_cost = parts.map(|part| (self.reached(&part).cost, part));
        let least = with_cost.reduce(|best, part| if part.0 < best.0 - 1e-9 { part } else { best });
        least.map_or_else(|| reference.without_rest(), |(_, part)| part)
    }

    /// Fixed goals that are searched for beside the goal asked for, tightest first.
    fn rungs(&self) -> Vec<Goal> {
        let (goal, default) = (self.context.settings.goal, Settings::default().goal);
        let is_loose = is_within(&default, &goal);
        let rungs = self.context.settings.rungs.iter().filter(|&&rung| !is_loose || rung >= TIGHTEST_OF_DEFAULT);
        rungs.map(|&rung| scaled(&default, rung)).filter(|rung| is_within(rung, &goal)).collect()
    }
}

fn scaled(goal: &Goal, factor: f64) -> Goal {
    Goal { position_mm: goal.position_mm * factor, orientation_rad: goal.orientation_rad * factor, minutes: None }
}

/// True when a goal is no looser than another, rounding apart.
fn is_within(goal: &Goal, other: &Goal) -> bool {
    goal.position_mm <= other.position_mm * (1.0 + 1e-9) && goal.orientation_rad <= other.orientation_rad * (1.0 + 1e-9)
}

/// True when a search at a rung serves a goal: the rung is the loosest, or the goal is a little looser in both alike.
fn is_near(rung: &Goal, goal: &Goal) -> bool {
    let (positions, orientations) = (goal.position_mm / rung.position_mm, goal.orientation_rad / rung.orientation_rad);
    let loosest = RUNGS[RUNGS.len() - 1] * Settings::default().goal.position_mm;
    let is_alike = positions < ALIKE * orientations && orientations < ALIKE * positions;
    rung.position_mm >= loosest * (1.0 - 1e-9) || is_alike && positions.max(orientations) < NEAR
}
