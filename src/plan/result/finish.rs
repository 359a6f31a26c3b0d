//! The finish of a plan: its tests in an order with few changes, forecasts and trade-off curve. It chooses nothing.

use std::collections::{HashMap, HashSet};

use super::marks::marks;
use super::mounting::Mounting;
use super::placing::Placing;
use super::plan_result::{Plan, PlannedTest, TradeOff};
use crate::collision::Instrument;
use crate::machine::Machine;
use crate::plan::context::choice::{Choice, Entry};
use crate::plan::context::evaluation::Evaluation;
use crate::plan::information::posterior::Posterior;
use crate::plan::places::candidate::Candidate;
use crate::plan::places::drive::Drive;
use crate::plan::reach::approach::{Approach, crossings};
use crate::plan::reach::little_moves::{LittleMove, little_moves};
use crate::plan::reasons::forecast::forecasts;

/// Axes that stand within this of one place are not moved, mm or rad.
const STANDS: f64 = 1e-6;

impl<'a> Evaluation<'a> {
    /// Little moves of all axes that the tests move, from the park position of the first.
    fn little_moves(&mut self, tests: &[PlannedTest]) -> Vec<LittleMove> {
        let Some(first) = tests.first() else { return Vec::new() };
        let Ok(instrument) = Instrument::of(self.context.world, self.context.bodies, self.context.kit, &first.test)
        else {
            return Vec::new();
        };
        let park = &first.approach.park;
        let moves = |axis: usize| {
            tests.iter().any(|test| {
                let corners = test.approach.corners();
                test.run.iter().chain(&corners).any(|row| (row[axis] - park[axis]).abs() > STANDS)
            })
        };
        let axes: Vec<usize> = first.approach.park_order.iter().copied().filter(|&axis| moves(axis)).collect();
        let scene = instrument.scene_without_bar(self.context.world);
        little_moves(self.context.machine, &scene, park, &axes, self.context.settings.margin_mm, &mut self.scratch)
    }

    /// Ways to the tests: from one park position for all where there is such a one, else each from its own.
    fn approaches(&mut self, order: &[&Entry]) -> Vec<Option<Approach>> {
        let mut best: Vec<Option<Approach>> = vec![None; order.len()];
        for park in 0..self.context.parking.count() {
            let found: Vec<Option<Approach>> =
                order.iter().map(|entry| self.approach(entry.candidate, entry.sweep.as_ref()?, park)?.ok()).collect();
            if found.iter().all(Option::is_some) {
                return found;
            }
            for (best, found) in best.iter_mut().zip(found) {
                *best = best.take().or(found);
            }
        }
        best
    }

    /// The plan of the chosen tests in an order with few changes of pivot, then spindle ball, then bar.
    pub(crate) fn finish(&mut self, choice: Choice<'a>) -> Plan {
        let Choice { entries, chosen } = choice;
        let mut curve = Vec::new();
        let mut posterior = Posterior::before(&self.context.unknowns);
        let mut minutes = 0.0;
        for (count, &k) in chosen.iter().enumerate() {
            minutes += self.cost(&entries[k], &posterior);
            posterior.add(&entries[k].block);
            let pivots: HashSet<usize> = chosen[..=count].iter().map(|&k| entries[k].candidate.site).collect();
            let worst = |angle: bool| {
                posterior
                    .variances()
                    .iter()
                    .zip(&self.context.unknowns.errors)
                    .filter(|(_, (_, component, _))| (*component >= 3) == angle)
                    .map(|(variance, _)| variance.sqrt())
                    .fold(0.0, f64::max)
            };
            curve.push(TradeOff {
                tests: count + 1,
                minutes,
                pivot_setups: pivots.len(),
                position_mm: worst(false),
                orientation_rad: worst(true),
            });
        }
        let mut order: Vec<&Entry> = chosen.iter().map(|&k| &entries[k]).collect();
        let rank = |value: usize, of: &dyn Fn(&Candidate) -> usize| {
            chosen.iter().position(|&k| of(entries[k].candidate) == value).unwrap_or(usize::MAX)
        };
        order.sort_by_key(|entry| {
            let candidate = entry.candidate;
            let site = rank(candidate.site, &|c| c.site);
            let place = rank(candidate.place, &|c| c.place);
            // a run with the spindle indexed comes right after the same run without
            let same = chosen.iter().position(|&k| std::ptr::eq(entries[k].candidate, candidate));
            (site, place, (candidate.bar_mm * 1e3) as i64, candidate.axis, same, entry.indexed_about)
        });
        let errors = forecasts(self, &order);
        let approaches = self.approaches(&order);
        let mut names: HashMap<String, usize> = HashMap::new();
        let mut tests: Vec<PlannedTest> = order
            .iter()
            .zip(approaches)
            .filter_map(|(entry, approach)| {
                let (sweep, approach) = (self.measured(entry.candidate, entry.sweep.as_ref()?)?, approach?);
                let candidate = entry.candidate;
                let mut base = base_name(self.context.machine, candidate);
                if entry.indexed_about.is_some() {
                    base.push_str("-indexed");
                }
                let count = names.entry(base.clone()).or_default();
                *count += 1;
                let name = format!("{base}-{count}");
                let site = self.context.site(candidate.site);
                let mut test = self.test(candidate, name, (sweep.from_deg, sweep.to_deg));
                test.spindle_ball.indexed_about = entry.indexed_about;
                let instrument =
                    Instrument::of(self.context.world, self.context.bodies, self.context.kit, &test).ok()?;
                let mounting = Mounting::of(self.context.bodies, self.context.kit, &test, &instrument)?;
                Some(PlannedTest {
                    number: 0,
                    placing: Placing::of(
                        self.context.machine,
                        self.context.kit,
                        &test,
                        &self.context.settings.uncertainty,
                    ),
                    test,
                    axis: candidate.axis,
                    rho_mm: candidate.solved.rho_mm,
                    h_mm: candidate.solved.h_mm,
                    way_radius_mm: candidate.way_radius_mm(),
                    run: candidate.rows(self.context.machine, sweep.from_deg, sweep.to_deg).0,
                    middle: candidate.pose((0.5 * (sweep.from_deg + sweep.to_deg)).to_radians()),
                    minutes: self.run_minutes(entry),
                    sweep,
                    mount: self.context.bodies.mounts[site.mount].name.clone(),
                    height_mm: site.height_mm,
                    approach,
                    mounting,
                })
            })
            .collect();
        for (index, test) in tests.iter_mut().enumerate() {
            test.number = index + 1;
            test.test.marks = if self.context.settings.marks { marks(self, test) } else { None };
        }
        let pivots: HashSet<usize> = order.iter().map(|entry| entry.candidate.site).collect();
        let goal = &self.context.settings.goal;
        let goal_reached = errors.iter().all(|error| {
            let goal = if error.is_angle { goal.orientation_rad } else { goal.position_mm };
            error.determined && (error.sigma <= goal * 1.001 || error.sigma_relative <= goal * 1.001)
        });
        let parked: Vec<_> = tests.iter().map(|test| (test.test.name.as_str(), &test.approach)).collect();
        let advice = crossings(self.context.machine, &self.context.settings.avoid, &parked);
        let little_moves = self.little_moves(&tests);
        Plan {
            little_moves,
            tests,
            errors,
            minutes,
            pivot_setups: pivots.len(),
            curve,
            considered: self.context.all.list.len() + self.context.finer.count(),
            goal_reached,
            one_pivot: None,
            advice,
        }
    }
}

/// What a test's name begins with: `c-100`, `c-tangential-100`, `zx-100`.
fn base_name(machine: &Machine, candidate: &Candidate) -> String {
    let name = |axis: usize| machine.axes[axis].name.to_lowercase();
    let what = match &candidate.drive {
        Drive::Turn => name(candidate.axis),
        Drive::Follow(follow, _) => format!("{}-{}", name(candidate.axis), follow.name()),
        Drive::Circle(plane, _) => format!("{}{}", name(plane.first), name(plane.second)),
    };
    format!("{what}-{}", candidate.bar_mm)
}
