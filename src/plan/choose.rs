//! Which tests: the cheapest that reach a goal, or the best in a given time, checked for collisions as they come up. No files.
//!
//! Greedy by gain per minute with the gains kept from earlier rounds as upper bounds (information only shrinks as more is
//! known, and a shortened sweep only loses), then tests that are not needed are dropped. Gain is the fall of
//! Σ ln max(σᵢ², goalᵢ²) over the wanted errors.

use std::collections::{BTreeMap, BinaryHeap, HashMap, HashSet};

use super::approach::{Approach, Parking};
use super::candidates::{Avoid, Candidate, Candidates, candidates};
use super::information::{BLOCK_ROWS, Block, Knowledge, Nuisance, Uncertainty, Unknowns};
use super::method::{Method, MethodError, method_choice};
use super::reach::{ClearSweep, longest_sweep};
use super::run_in::RUN_IN;
use super::words::{ErrorForecast, forecasts};
use crate::bodies::{Bodies, Kit};
use crate::chain::{Chain, Geometry};
use crate::collision::{Instrument, NoWay, Scratch, World};
use crate::machine::Machine;
use crate::session::{Ball, Follow, Path, Test};

/// What a plan is to reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Standard deviation wanted of positions, mm.
    pub position_mm: f64,
    /// Standard deviation wanted of orientations, rad.
    pub orientation_rad: f64,
    /// Time allowed, min.
    pub minutes: Option<f64>,
}

/// Settings of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub goal: Goal,
    /// Least clearance of every sweep, mm.
    pub margin_mm: f64,
    pub avoid: Avoid,
    pub method: Option<Method>,
    pub uncertainty: Uncertainty,
    pub feed_mm_per_min: f64,
}

impl Default for Settings {
    fn default() -> Settings {
        let arcsec = std::f64::consts::PI / (180.0 * 3600.0);
        Settings {
            goal: Goal { position_mm: 4e-3, orientation_rad: 4.0 * arcsec, minutes: None },
            margin_mm: 5.0,
            avoid: Vec::new(),
            method: None,
            uncertainty: Uncertainty::default(),
            feed_mm_per_min: 500.0,
        }
    }
}

/// Minutes to mount and align a pivot.
const PIVOT_MIN: f64 = 8.0;
/// Minutes to change the spindle cup or fixture.
const SPINDLE_MIN: f64 = 4.0;
/// Minutes to change the bar's length and calibrate it.
const BAR_MIN: f64 = 3.0;
/// Minutes around each run: approach, trigger, retreat.
const RUN_MIN: f64 = 0.5;
/// Gain per minute below which a test is not worth running, when no goal is missed by it.
const LEAST_GAIN: f64 = 1e-2;
/// Groups of setups with one pivot and ball, members of each, and pairs checked when single tests bring nothing.
const PAIR_GROUPS: usize = 120;
const PAIR_MEMBERS: usize = 6;
const PAIR_CHECKS: usize = 1500;
/// Setups of one axis that may prove not clear before the rest is given up.
pub(super) const MAX_FAILURES: usize = 1500;
/// Most tests of a plan.
const MAX_TESTS: usize = 24;

/// One test of a plan, run in both directions.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedTest {
    /// The session test from lower to upper end.
    pub test: Test,
    pub axis: usize,
    /// Distance of the carried ball from the axis line, mm.
    pub rho_mm: f64,
    /// Distance of the still ball along the axis line from the foot of the other, mm.
    pub h_mm: f64,
    pub sweep: ClearSweep,
    /// Both directions, mounting apart, min.
    pub minutes: f64,
    /// Name of the mount.
    pub mount: String,
    /// Ball above the mount, mm.
    pub height_mm: f64,
    /// From park to the start of the run-in, without the bar.
    pub approach: Approach,
}

impl PlannedTest {
    /// The session tests: counter-clockwise (rising), then clockwise.
    pub fn both_ways(&self) -> [Test; 2] {
        let (from_deg, to_deg) = (self.sweep.from_deg, self.sweep.to_deg);
        [("ccw", from_deg, to_deg), ("cw", to_deg, from_deg)].map(|(way, from, to)| Test {
            name: format!("{}-{way}", self.test.name),
            path: Some(Path::Sweep { axis: self.axis, from, to, step: 0.5, follow: Follow::None }),
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
}

/// A candidate with what is known of it by now.
pub(super) struct Entry<'c> {
    pub candidate: &'c Candidate,
    pub block: Block,
    pub sweep: Option<ClearSweep>,
}

/// What evaluating candidates needs.
pub(super) struct Desk<'a> {
    pub machine: &'a Machine,
    pub bodies: &'a Bodies,
    pub kit: &'a Kit,
    pub settings: &'a Settings,
    pub geometry: Geometry<'a>,
    pub world: &'a World,
    pub unknowns: Unknowns,
    pub all: &'a Candidates,
    pub parking: Parking,
    pub scratch: Scratch,
    /// By axis: how often a pair ended or forbade a sweep.
    pub forbidden: BTreeMap<usize, HashMap<(String, String), usize>>,
    /// The same for the ways to the starts of sweeps that would be clear.
    pub blocked_ways: BTreeMap<usize, HashMap<(String, String), usize>>,
}

/// Plans the tests of a machine; `Err` when a method does not fit the machine.
pub fn plan(machine: &Machine, bodies: &Bodies, kit: &Kit, settings: &Settings) -> Result<Plan, PlanError> {
    let chain = Chain::of(machine);
    let world = World::new(&chain, bodies).map_err(PlanError::Bodies)?;
    let all = candidates(machine, bodies, kit, &settings.avoid, RUN_IN.to_radians());
    let mut desk = Desk {
        machine,
        bodies,
        kit,
        settings,
        geometry: Geometry::nominal(&chain),
        world: &world,
        unknowns: Unknowns::of(machine, settings.uncertainty),
        all: &all,
        parking: Parking::of(machine, bodies),
        scratch: Scratch::default(),
        forbidden: BTreeMap::new(),
        blocked_ways: BTreeMap::new(),
    };
    let (entries, chosen) = match settings.method {
        None => desk.greedy(),
        Some(method) => method_choice(&mut desk, method)?,
    };
    Ok(desk.finish(entries, chosen))
}

/// Why no plan was made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    #[error("{0}")]
    Bodies(String),
    #[error("{0}")]
    Method(#[from] MethodError),
}

/// Where the run-in of a sweep begins, rad.
fn run_in_start(machine: &Machine, axis: usize, from_deg: f64) -> f64 {
    let start = (from_deg - RUN_IN).to_radians();
    machine.axes[axis].range.map_or(start, |(low, high)| start.clamp(low, high))
}

/// Heap order: gain per minute, then the candidate's place in the list so that plans repeat.
#[derive(PartialEq)]
struct Bound(f64, usize, usize);

impl Eq for Bound {}
impl PartialOrd for Bound {
    fn partial_cmp(&self, other: &Bound) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Bound {
    fn cmp(&self, other: &Bound) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(scatter(other.1).cmp(&scatter(self.1)))
    }
}

/// Breaks ties apart: neighbours in the list tend to fail for the same reason.
fn scatter(index: usize) -> (u64, usize) {
    ((index as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15), index)
}

impl<'a> Desk<'a> {
    /// A candidate's information over its sweep.
    pub fn entry(&self, candidate: &'a Candidate, sweep: Option<ClearSweep>) -> Entry<'a> {
        let (from, to) = match &sweep {
            Some(clear) => (clear.from_deg.to_radians(), clear.to_deg.to_radians()),
            None => (candidate.from, candidate.to),
        };
        let site = &self.all.sites[candidate.site];
        let place = &self.all.places[candidate.place];
        let link = &self.bodies.mounts[site.mount].link;
        let poses: Vec<Vec<f64>> = (0..BLOCK_ROWS)
            .map(|k| {
                let mut q = candidate.solved.positions.clone();
                // middles of equal parts: no angle counts twice in a full turn
                q[candidate.axis] = from + (to - from) * (k as f64 + 0.5) / BLOCK_ROWS as f64;
                q
            })
            .collect();
        let (pivot, spindle) = ((site.link, link.as_str(), &site.at), (place.link, &place.at));
        let block = self.unknowns.block(&self.geometry, pivot, spindle, candidate.bar_mm, &poses, to - from);
        Entry { candidate, block, sweep }
    }

    /// The session test of a candidate.
    pub fn test(&self, candidate: &Candidate, name: String, (from, to): (f64, f64)) -> Test {
        let site = &self.all.sites[candidate.site];
        let place = &self.all.places[candidate.place];
        let ball = |link: &str, at| Ball { link: link.into(), at, setup: None, spread_mm: None };
        let spindle_link = self.bodies.spindle.as_ref().map_or("t", |spindle| spindle.link.as_str());
        let positions = candidate.solved.positions.iter().enumerate();
        Test {
            name,
            recording_file: None,
            recording: None,
            path: Some(Path::Sweep { axis: candidate.axis, from, to, step: 0.5, follow: Follow::None }),
            started_at_s: 0.0,
            bar_length_mm: Some(candidate.bar_mm),
            bar_setup: None,
            bar_error_mm: 0.0,
            pivot: ball(&self.bodies.mounts[site.mount].link, site.at),
            spindle_ball: ball(spindle_link, place.at),
            positions: positions.map(|(axis, &q)| (axis != candidate.axis).then_some(q)).collect(),
            feed_mm_per_min: Some(self.settings.feed_mm_per_min),
            overshoot: Some(RUN_IN),
        }
    }

    /// The way from a park position to the start of a sweep's run-in.
    fn approach(&mut self, candidate: &Candidate, sweep: &ClearSweep, park: usize) -> Option<Result<Approach, NoWay>> {
        let test = self.test(candidate, String::new(), (sweep.from_deg, sweep.to_deg));
        let instrument = Instrument::of(self.world, self.bodies, self.kit, &test).ok()?;
        let scene = instrument.scene_without_bar(self.world);
        let mut start = candidate.solved.positions.clone();
        start[candidate.axis] = run_in_start(self.machine, candidate.axis, sweep.from_deg);
        Some(self.parking.approach(park, &scene, &start, self.settings.margin_mm, &mut self.scratch))
    }

    /// The longest clear sweep of a candidate to whose start there is a clear way; remembers what stood in the way.
    pub fn clear(&mut self, candidate: &'a Candidate) -> Option<ClearSweep> {
        let arc = (candidate.from.to_degrees(), candidate.to.to_degrees());
        let test = self.test(candidate, String::new(), arc);
        let instrument = Instrument::of(self.world, self.bodies, self.kit, &test).ok()?;
        let scene = instrument.scene(self.world);
        let arc = (candidate.from, candidate.to);
        let positions = &candidate.solved.positions;
        let found = longest_sweep(&scene, candidate.axis, positions, arc, self.settings.margin_mm, &mut self.scratch);
        let (pairs, pair) = match found {
            Ok(sweep) => match self.no_way(candidate, &sweep) {
                None => return Some(sweep),
                Some(pair) => (&mut self.blocked_ways, pair),
            },
            Err(pair) => (&mut self.forbidden, pair),
        };
        *pairs.entry(candidate.axis).or_default().entry(pair).or_default() += 1;
        None
    }

    /// What stands in every way from every park position to the start of a sweep; `None` when one is clear.
    fn no_way(&mut self, candidate: &Candidate, sweep: &ClearSweep) -> Option<(String, String)> {
        let mut first = None;
        for park in 0..self.parking.count() {
            match self.approach(candidate, sweep, park)? {
                Ok(_) => return None,
                Err(no_way) => first = first.or(Some(no_way.hit.pair)),
            }
        }
        first
    }

    /// Minutes that a test adds to what is mounted already.
    fn cost(&self, entry: &Entry, mounted: &Knowledge) -> f64 {
        let mounting: f64 = entry
            .block
            .uses()
            .filter(|nuisance| !mounted.knows(nuisance))
            .map(|nuisance| match nuisance {
                Nuisance::Pivot(..) => PIVOT_MIN,
                Nuisance::SpindleBall(_) => SPINDLE_MIN,
                Nuisance::Bar(_) => BAR_MIN,
                Nuisance::Stand(_) => 0.0,
            })
            .sum();
        mounting + self.run_minutes(entry)
    }

    /// Both directions of a test, min.
    pub fn run_minutes(&self, entry: &Entry) -> f64 {
        let arc = entry
            .sweep
            .as_ref()
            .map_or(entry.candidate.to - entry.candidate.from, |sweep| (sweep.to_deg - sweep.from_deg).to_radians());
        let way = (arc + 2.0 * RUN_IN.to_radians()) * entry.candidate.solved.rho_mm;
        2.0 * (way / self.settings.feed_mm_per_min + RUN_MIN)
    }

    /// Σ ln max(σ², goal²).
    fn worth(&self, variances: &[f64]) -> f64 {
        let goal = &self.settings.goal;
        variances
            .iter()
            .zip(&self.unknowns.errors)
            .map(|(&variance, &(_, component, _))| {
                let goal: f64 = if component >= 3 { goal.orientation_rad } else { goal.position_mm };
                // with time to spend there is no "good enough"
                let floor = if self.settings.goal.minutes.is_some() { 0.1 * goal } else { goal };
                variance.max(floor * floor).ln()
            })
            .sum()
    }

    /// Chooses tests one by one; returns all candidates looked at and the indices chosen in order.
    fn greedy(&mut self) -> (Vec<Entry<'a>>, Vec<usize>) {
        let list: &'a [Candidate] = &self.all.list;
        let mut entries: Vec<Entry> = list.iter().map(|candidate| self.entry(candidate, None)).collect();
        let mut knowledge = Knowledge::before_with_loose_pivots(&self.unknowns);
        let mut gains = vec![f64::MAX; entries.len()];
        let mut heap: BinaryHeap<Bound> = (0..entries.len()).map(|k| Bound(f64::MAX, k, 0)).collect();
        let mut failures: BTreeMap<usize, usize> = BTreeMap::new();
        let mut chosen: Vec<usize> = Vec::new();
        let mut dead: HashSet<usize> = HashSet::new();
        let mut minutes = 0.0;
        let (mut round, mut worth) = (1, self.worth(&knowledge.variances()));
        while let Some(Bound(_, k, seen)) = heap.pop() {
            if dead.contains(&k) || chosen.len() >= MAX_TESTS {
                continue;
            }
            let cost = self.cost(&entries[k], &knowledge);
            if self.settings.goal.minutes.is_some_and(|budget| minutes + cost > budget) {
                continue;
            }
            if seen < round {
                gains[k] = worth - self.worth(&knowledge.variances_with(&entries[k].block));
                heap.push(Bound(gains[k] / cost, k, round));
                continue;
            }
            if gains[k] / cost <= LEAST_GAIN {
                // one test alone brings nothing; two from one pivot may
                let pair = self.best_pair(&mut entries, &knowledge, worth, &dead, minutes);
                let Some(pair) = pair.filter(|_| chosen.len() + 2 <= MAX_TESTS) else { break };
                for k in pair {
                    minutes += self.cost(&entries[k], &knowledge);
                    knowledge.add(&entries[k].block);
                    chosen.push(k);
                    dead.insert(k);
                }
                worth = self.worth(&knowledge.variances());
                round += 1;
                gains.fill(f64::MAX);
                heap = (0..entries.len()).filter(|k| !dead.contains(k)).map(|k| Bound(f64::MAX, k, 0)).collect();
                continue;
            }
            if entries[k].sweep.is_none() {
                let axis = entries[k].candidate.axis;
                if failures.get(&axis).is_some_and(|&count| count >= MAX_FAILURES) {
                    dead.insert(k);
                    continue;
                }
                match self.clear(entries[k].candidate) {
                    Some(sweep) => {
                        entries[k] = self.entry(entries[k].candidate, Some(sweep));
                        heap.push(Bound(f64::MAX, k, 0));
                    }
                    None => {
                        dead.insert(k);
                        *failures.entry(axis).or_default() += 1;
                    }
                }
                continue;
            }
            knowledge.add(&entries[k].block);
            minutes += cost;
            chosen.push(k);
            dead.insert(k);
            worth = self.worth(&knowledge.variances());
            round += 1;
            // gains only fall, but costs fall too when a setup is mounted: bounds anew
            heap = (0..entries.len())
                .filter(|k| !dead.contains(k))
                .map(|k| Bound(gains[k] / self.cost(&entries[k], &knowledge), k, 0))
                .collect();
        }
        if self.settings.goal.minutes.is_none() {
            self.drop_needless(&entries, &mut chosen);
        }
        (entries, chosen)
    }

    /// The pair of clear tests from one pivot and one spindle ball with the greatest gain per minute, if any has one.
    fn best_pair(
        &mut self,
        entries: &mut [Entry<'a>],
        knowledge: &Knowledge,
        worth: f64,
        dead: &HashSet<usize>,
        minutes: f64,
    ) -> Option<[usize; 2]> {
        let mut groups: BTreeMap<(usize, usize, usize), Vec<usize>> = BTreeMap::new();
        for (k, entry) in entries.iter().enumerate().filter(|(k, _)| !dead.contains(k)) {
            let c = entry.candidate;
            groups.entry((c.axis, c.site, c.place)).or_default().push(k);
        }
        let mut pairs: Vec<(f64, [usize; 2])> = Vec::new();
        for axis in groups.keys().map(|key| key.0).collect::<std::collections::BTreeSet<_>>() {
            let mine: Vec<&Vec<usize>> =
                groups.iter().filter(|(key, group)| key.0 == axis && group.len() > 1).map(|(_, group)| group).collect();
            let stride = mine.len().div_ceil(PAIR_GROUPS).max(1);
            for group in mine.iter().step_by(stride) {
                let reach = group.len().div_ceil(PAIR_MEMBERS).max(1);
                let members: Vec<usize> = group.iter().step_by(reach).copied().collect();
                for (place, &one) in members.iter().enumerate() {
                    let mut with_one = knowledge.clone();
                    with_one.add(&entries[one].block);
                    let first_cost = self.cost(&entries[one], knowledge);
                    for &other in &members[place + 1..] {
                        let cost = first_cost + self.cost(&entries[other], &with_one);
                        let gain = worth - self.worth(&with_one.variances_with(&entries[other].block));
                        let fits = self.settings.goal.minutes.is_none_or(|budget| minutes + cost <= budget);
                        if fits && gain / cost > LEAST_GAIN {
                            pairs.push((gain / cost, [one, other]));
                        }
                    }
                }
            }
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut refused: HashSet<usize> = HashSet::new();
        for (bound, pair) in pairs.into_iter().take(PAIR_CHECKS) {
            if pair.iter().any(|k| refused.contains(k)) {
                continue;
            }
            let mut both = true;
            for k in pair {
                if both && entries[k].sweep.is_none() {
                    match self.clear(entries[k].candidate) {
                        Some(sweep) => entries[k] = self.entry(entries[k].candidate, Some(sweep)),
                        None => {
                            refused.insert(k);
                            both = false;
                        }
                    }
                }
            }
            if !both {
                continue;
            }
            // shortened sweeps tell less: half of what was promised is still worth taking
            let mut with_one = knowledge.clone();
            with_one.add(&entries[pair[0]].block);
            let cost = self.cost(&entries[pair[0]], knowledge) + self.cost(&entries[pair[1]], &with_one);
            let gain = worth - self.worth(&with_one.variances_with(&entries[pair[1]].block));
            if gain / cost > LEAST_GAIN.max(0.5 * bound) {
                return Some(pair);
            }
        }
        None
    }

    /// Drops tests without which the wanted errors are as good, dearest first.
    fn drop_needless(&self, entries: &[Entry], chosen: &mut Vec<usize>) {
        let worth_of = |set: &[usize]| {
            let mut knowledge = Knowledge::before_with_loose_pivots(&self.unknowns);
            set.iter().for_each(|&k| knowledge.add(&entries[k].block));
            self.worth(&knowledge.variances())
        };
        let full = worth_of(chosen);
        let mut place = 0;
        while place < chosen.len() {
            let mut without = chosen.clone();
            without.remove(place);
            // a thousandth of a factor e in one error
            if worth_of(&without) <= full + 1e-3 {
                *chosen = without;
            } else {
                place += 1;
            }
        }
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
    fn finish(&mut self, entries: Vec<Entry<'a>>, chosen: Vec<usize>) -> Plan {
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
            (site, place, (candidate.bar_mm * 1e3) as i64, candidate.axis)
        });
        let blocks: Vec<&Block> = order.iter().map(|entry| &entry.block).collect();
        let errors = forecasts(self, &blocks);
        let approaches = self.approaches(&order);
        let mut names: HashMap<String, usize> = HashMap::new();
        let tests = order
            .iter()
            .zip(approaches)
            .filter_map(|(entry, approach)| {
                let (sweep, approach) = (entry.sweep.clone()?, approach?);
                let candidate = entry.candidate;
                let base = format!("{}-{}", self.machine.axes[candidate.axis].name.to_lowercase(), candidate.bar_mm);
                let count = names.entry(base.clone()).or_default();
                *count += 1;
                let name = format!("{base}-{count}");
                let site = &self.all.sites[candidate.site];
                Some(PlannedTest {
                    test: self.test(candidate, name, (sweep.from_deg, sweep.to_deg)),
                    axis: candidate.axis,
                    rho_mm: candidate.solved.rho_mm,
                    h_mm: candidate.solved.h_mm,
                    minutes: self.run_minutes(entry),
                    sweep,
                    mount: self.bodies.mounts[site.mount].name.clone(),
                    height_mm: site.height_mm,
                    approach,
                })
            })
            .collect();
        let pivots: HashSet<usize> = order.iter().map(|entry| entry.candidate.site).collect();
        let goal = &self.settings.goal;
        let goal_reached = errors.iter().all(|error| {
            let goal = if error.is_angle { goal.orientation_rad } else { goal.position_mm };
            error.determined && (error.sigma <= goal * 1.001 || error.sigma_relative <= goal * 1.001)
        });
        Plan {
            tests,
            errors,
            minutes,
            pivot_setups: pivots.len(),
            curve,
            considered: self.all.list.len(),
            goal_reached,
        }
    }
}
