//! A finished plan: its tests in an order with few changes, forecasts and trade-off curve. It chooses nothing.

use std::collections::{HashMap, HashSet};

use super::approach::{Approach, crossings};
use super::candidates::Candidate;
use super::choose::{Choice, Desk, Entry};
use super::course::Drive;
use super::knowledge::Knowledge;
use super::little_moves::{LittleMove, little_moves};
use super::mounting::Mounting;
use super::placing::Placing;
use super::reach::ClearSweep;
use super::words::{ErrorForecast, forecasts};
use crate::collision::Instrument;
use crate::machine::Machine;
use crate::session::{Follow, Path, Test};

/// One test of a plan, run in both directions.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedTest {
    /// Place in the order of the plan, from 1.
    pub number: usize,
    /// The session test from lower to upper end.
    pub test: Test,
    /// The axis that turns; on a circle the linear axis that carries the cosine.
    pub axis: usize,
    /// Distance of the carried ball from the axis line, mm.
    pub rho_mm: f64,
    /// Distance of the still ball along the axis line from the foot of the other, mm.
    pub h_mm: f64,
    /// Radius on which one ball goes round as seen from the other, mm; of the carried ball about the axis where the bar keeps
    /// its direction.
    pub way_radius_mm: f64,
    pub sweep: ClearSweep,
    /// Both directions, mounting apart, min.
    pub minutes: f64,
    /// Name of the mount.
    pub mount: String,
    /// Ball above the mount, mm.
    pub height_mm: f64,
    /// Positions of all axes along the rising direction, run-in and run-out included, mm and rad.
    pub run: Vec<Vec<f64>>,
    /// The same in the middle of the arc.
    pub middle: Vec<f64>,
    /// From park to the start of the run-in, without the bar.
    pub approach: Approach,
    /// Parts of the kit that are mounted.
    pub mounting: Mounting,
    /// How the pivot's place is found.
    pub placing: Placing,
}

impl PlannedTest {
    /// True when more than one axis moves.
    pub fn is_coupled(&self) -> bool {
        !matches!(self.test.path, Some(Path::Sweep { follow: Follow::None, .. }))
    }

    /// The session tests: counter-clockwise (rising), then clockwise.
    pub fn both_ways(&self) -> [Test; 2] {
        let (from_deg, to_deg) = (self.sweep.from_deg, self.sweep.to_deg);
        [("ccw", from_deg, to_deg), ("cw", to_deg, from_deg)].map(|(way, from, to)| Test {
            name: format!("{}-{way}", self.test.name),
            path: self.test.path.as_ref().map(|path| path.between(from, to)),
            ..self.test.clone()
        })
    }
}

/// A point of the trade-off curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TradeOff {
    pub tests: usize,
    pub minutes: f64,
    pub pivot_setups: usize,
    /// Worst standard deviations of positions, mm, and orientations, rad.
    pub position_mm: f64,
    pub orientation_rad: f64,
}

/// The best plan whose tests all use one pivot setup.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnePivot {
    /// Errors determined.
    pub determined: usize,
    pub minutes: f64,
}

/// A test plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub tests: Vec<PlannedTest>,
    pub errors: Vec<ErrorForecast>,
    pub minutes: f64,
    pub pivot_setups: usize,
    pub curve: Vec<TradeOff>,
    /// Candidates that were reachable.
    pub considered: usize,
    /// Goals reached, absolute or relative to the spindle ball.
    pub goal_reached: bool,
    /// What tests from one pivot setup alone reach; `None` when a method or a limit on pivots was asked for, or without any test.
    pub one_pivot: Option<OnePivot>,
    /// Avoided regions that lie between park positions; what would bring errors below the goal that the linear axes keep above
    /// it, in words with the figures.
    pub advice: Vec<String>,
    /// Little moves from the park position of the first test that show the sense of the axes that the plan moves.
    pub little_moves: Vec<LittleMove>,
}

/// Axes that stand within this of one place are not moved, mm or rad.
const STANDS: f64 = 1e-6;

impl<'a> Desk<'a> {
    /// Little moves of all axes that the tests move, from the park position of the first.
    fn little_moves(&mut self, tests: &[PlannedTest]) -> Vec<LittleMove> {
        let Some(first) = tests.first() else { return Vec::new() };
        let Ok(instrument) = Instrument::of(self.world, self.bodies, self.kit, &first.test) else { return Vec::new() };
        let park = &first.approach.park;
        let moves = |axis: usize| {
            tests.iter().any(|test| {
                let corners = test.approach.corners();
                test.run.iter().chain(&corners).any(|row| (row[axis] - park[axis]).abs() > STANDS)
            })
        };
        let axes: Vec<usize> = first.approach.park_order.iter().copied().filter(|&axis| moves(axis)).collect();
        let scene = instrument.scene_without_bar(self.world);
        little_moves(self.machine, &scene, park, &axes, self.settings.margin_mm, &mut self.scratch)
    }

    /// Ways to the tests: from one park position for all where there is such a one, else each from its own.
    fn approaches(&mut self, order: &[&Entry]) -> Vec<Option<Approach>> {
        let mut best: Vec<Option<Approach>> = vec![None; order.len()];
        for park in 0..self.parking.count() {
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
    pub(super) fn finish(&mut self, choice: Choice<'a>) -> Plan {
        let Choice { entries, chosen } = choice;
        let mut curve = Vec::new();
        let mut knowledge = Knowledge::before(&self.unknowns);
        let mut minutes = 0.0;
        for (count, &k) in chosen.iter().enumerate() {
            minutes += self.cost(&entries[k], &knowledge);
            knowledge.add(&entries[k].block);
            let pivots: HashSet<usize> = chosen[..=count].iter().map(|&k| entries[k].candidate.site).collect();
            let worst = |angle: bool| {
                knowledge
                    .variances()
                    .iter()
                    .zip(&self.unknowns.errors)
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
                let mut base = base_name(self.machine, candidate);
                if entry.indexed_about.is_some() {
                    base.push_str("-indexed");
                }
                let count = names.entry(base.clone()).or_default();
                *count += 1;
                let name = format!("{base}-{count}");
                let site = self.site(candidate.site);
                let mut test = self.test(candidate, name, (sweep.from_deg, sweep.to_deg));
                test.spindle_ball.indexed_about = entry.indexed_about;
                let instrument = Instrument::of(self.world, self.bodies, self.kit, &test).ok()?;
                let mounting = Mounting::of(self.bodies, self.kit, &test, &instrument)?;
                Some(PlannedTest {
                    number: 0,
                    placing: Placing::of(self.machine, self.kit, &test, &self.settings.uncertainty),
                    test,
                    axis: candidate.axis,
                    rho_mm: candidate.solved.rho_mm,
                    h_mm: candidate.solved.h_mm,
                    way_radius_mm: candidate.way_radius_mm(),
                    run: candidate.rows(self.machine, sweep.from_deg, sweep.to_deg).0,
                    middle: candidate.pose((0.5 * (sweep.from_deg + sweep.to_deg)).to_radians()),
                    minutes: self.run_minutes(entry),
                    sweep,
                    mount: self.bodies.mounts[site.mount].name.clone(),
                    height_mm: site.height_mm,
                    approach,
                    mounting,
                })
            })
            .collect();
        for (index, test) in tests.iter_mut().enumerate() {
            test.number = index + 1;
            test.test.marks = if self.settings.marks { self.marks(test) } else { None };
        }
        let pivots: HashSet<usize> = order.iter().map(|entry| entry.candidate.site).collect();
        let goal = &self.settings.goal;
        let goal_reached = errors.iter().all(|error| {
            let goal = if error.is_angle { goal.orientation_rad } else { goal.position_mm };
            error.determined && (error.sigma <= goal * 1.001 || error.sigma_relative <= goal * 1.001)
        });
        let parked: Vec<_> = tests.iter().map(|test| (test.test.name.as_str(), &test.approach)).collect();
        let advice = crossings(self.machine, &self.settings.avoid, &parked);
        let little_moves = self.little_moves(&tests);
        Plan {
            little_moves,
            tests,
            errors,
            minutes,
            pivot_setups: pivots.len(),
            curve,
            considered: self.all.list.len() + self.finer.count(),
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
