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
use crate::plan::reach::approach::{Approach, STANDS, crossings};
use crate::plan::reach::little_moves::{LittleMove, little_moves};
use crate::plan::reasons::forecast::forecasts;

impl<'a> Evaluation<'a> {
    /// Little moves of all axes that the tests move, from the park position of the first.
    fn little_moves(&mut self, tests: &[PlannedTest]) -> Vec<LittleMove> {
        let Some(first) = tests.first() else { return Vec::new() };
        let Ok(instrument) = Instrument::of(
            self.context.world,
            self.context.machine,
            self.context.bodies,
            self.context.kit,
            &first.test,
        ) else {
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
        let curve = self.trade_off(&choice);
        let order = few_changes(&choice);
        let errors = forecasts(self, &order);
        let tests = self.planned_tests(&order);
        let goal = &self.context.settings.goal;
        let goal_reached = errors.iter().all(|error| {
            let goal = if error.is_angle { goal.orientation_rad } else { goal.position_mm };
            error.determined && (error.sigma <= goal * 1.001 || error.sigma_relative <= goal * 1.001)
        });
        let parked: Vec<_> = tests.iter().map(|test| (test.test.name.as_str(), &test.approach)).collect();
        let advice = crossings(self.context.machine, &self.context.settings.avoid, &parked);
        Plan {
            little_moves: self.little_moves(&tests),
            tests,
            errors,
            minutes: curve.last().map_or(0.0, |point| point.minutes),
            pivot_setups: curve.last().map_or(0, |point| point.pivot_setups),
            curve,
            considered: self.context.all.list.len() + self.context.finer.count(),
            goal_reached,
            one_pivot: None,
            advice,
        }
    }

    /// What is known after the first test, after two, and so on in the order of choice, and what it takes.
    fn trade_off(&self, choice: &Choice) -> Vec<TradeOff> {
        let mut posterior = Posterior::before(&self.context.unknowns);
        let mut pivots = HashSet::new();
        let mut minutes = 0.0;
        let mut curve = Vec::new();
        for entry in choice.chosen.iter().map(|&k| &choice.entries[k]) {
            minutes += self.minutes(entry, &posterior);
            posterior.add(&entry.block);
            pivots.insert(entry.candidate.site);
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
                tests: curve.len() + 1,
                minutes,
                pivot_setups: pivots.len(),
                position_mm: worst(false),
                orientation_rad: worst(true),
            });
        }
        curve
    }

    /// The tests of a plan in an order, numbered from one; those that cannot be mounted or approached are left out.
    fn planned_tests(&mut self, order: &[&Entry]) -> Vec<PlannedTest> {
        let approaches = self.approaches(order);
        let mut names: HashMap<String, usize> = HashMap::new();
        let reached = order.iter().zip(approaches);
        let mut tests: Vec<PlannedTest> =
            reached.filter_map(|(entry, approach)| self.planned_test(entry, approach, &mut names)).collect();
        for (index, test) in tests.iter_mut().enumerate() {
            test.number = index + 1;
            test.test.marks = if self.context.settings.marks { marks(self, test) } else { None };
        }
        tests
    }

    /// A test as it is planned, without its number and marks; its name counts on from those that begin alike.
    fn planned_test(
        &mut self,
        entry: &Entry,
        approach: Option<Approach>,
        names: &mut HashMap<String, usize>,
    ) -> Option<PlannedTest> {
        let context = self.context;
        let candidate = entry.candidate;
        let (sweep, mut approach) = (self.measured(candidate, entry.sweep.as_ref()?)?, approach?);
        let mut base = base_name(context.machine, candidate);
        if entry.indexed_about.is_some() {
            base.push_str("-indexed");
        }
        let count = names.entry(base.clone()).or_default();
        *count += 1;
        let site = context.site(candidate.site);
        let mut test = self.test(candidate, format!("{base}-{count}"), (sweep.from_deg, sweep.to_deg));
        test.spindle_ball.indexed_about = entry.indexed_about;
        let instrument = Instrument::of(context.world, context.machine, context.bodies, context.kit, &test).ok()?;
        let run = candidate.rows(context.machine, sweep.from_deg, sweep.to_deg).0;
        test.approached = context.parking.give_senses(
            context.machine,
            &instrument.scene_without_bar(context.world),
            (&mut approach, &run),
            context.settings.margin_mm,
            &mut self.scratch,
        );
        Some(PlannedTest {
            number: 0,
            placing: Placing::of(context.machine, context.kit, &test, &context.settings.uncertainty),
            mounting: Mounting::of(context.machine, context.kit, &test, &instrument)?,
            test,
            axis: candidate.axis,
            rho_mm: candidate.solved.rho_mm,
            h_mm: candidate.solved.h_mm,
            way_radius_mm: candidate.way_radius_mm(),
            run,
            middle: candidate.pose((0.5 * (sweep.from_deg + sweep.to_deg)).to_radians()),
            minutes: self.run_minutes(entry),
            sweep,
            mount: context.bodies.mounts[site.mount].name.clone(),
            height_mm: site.height_mm,
            approach,
        })
    }
}

/// Chosen tests in an order with few changes of pivot, then spindle ball, then bar.
fn few_changes<'c, 'a>(choice: &'c Choice<'a>) -> Vec<&'c Entry<'a>> {
    let Choice { entries, chosen } = choice;
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
    order
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
