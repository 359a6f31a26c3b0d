//! Which few effects the evidence demands: screen every family, refine the best, compare, accept, repeat. No words, no proof.

use std::cell::Cell;
use std::collections::HashSet;
use std::sync::Arc;

use rayon::prelude::*;

use super::cells::Cells;
use super::floor::{likely_noise, mean_noise_mm2, noise_floor};
use super::ground::{Column, Ground, Term};
use super::library::Family;
use super::pose_search::search_poses;
use super::refining::refine_all;
use super::screening::screen;
use super::stage::{Accepted, Judgement, Stage};
use super::whitened::Whitened;
use crate::identify::{NoiseModel, Quantity, misfit};
use crate::machine::Effect;

/// A candidate with its best shape.
#[derive(Debug, Clone)]
pub struct Candidate {
    pub family: usize,
    pub effect: Effect,
    pub terms: Vec<Term>,
    pub columns: Vec<Column>,
    pub judgement: Judgement,
    /// Log evidence with the cost of the shape grid taken off.
    pub log_odds: f64,
}

impl Candidate {
    /// Its columns as they join the model.
    pub fn accepted(&self) -> impl Iterator<Item = Accepted> + '_ {
        self.columns.iter().map(|column| Accepted { column: column.clone(), prior: self.judgement.tau.max(1.0) })
    }
}

/// An accepted effect with its rivals.
#[derive(Debug, Clone)]
pub struct Found {
    pub chosen: Candidate,
    /// Other candidates at the same stage, best first, with their log odds relative to the chosen one (below zero).
    pub rivals: Vec<(Candidate, f64)>,
    /// Gain in log likelihood with the noise fitted before and after, less the cost of shapes and amplitudes.
    pub log_odds: f64,
    /// The gain alone.
    pub gain: f64,
    /// Log odds of the chosen candidate at the step that ranked the rivals, on the scale of theirs.
    pub ranked_odds: f64,
    /// The gain beside all other effects of the model: how far they can stand for it.
    pub beside_gain: f64,
    /// Fall of the mean square residual, mm².
    pub fall_mm2: f64,
}

/// Result of a search.
pub struct Search {
    pub floor: Vec<NoiseModel>,
    pub noise_before: Vec<NoiseModel>,
    pub noise_after: Vec<NoiseModel>,
    pub found: Vec<Found>,
    /// Residuals with what was found in the fit, mm.
    pub residual_mm: Vec<Vec<f64>>,
    /// Log odds of the best candidate that was not accepted.
    pub best_left: f64,
    /// Mean square of the residual before anything was found, mm².
    pub residual_before_mm2: f64,
}

/// The same session at two resolutions: all rows for what is fast, averaged rows for what is slow.
pub struct Grounds<'g, 'a> {
    pub fine: &'g Ground<'a>,
    pub coarse: &'g Ground<'a>,
    /// Shapes over the averaged rows.
    pub cells: &'g Cells<'g>,
}

/// When a search stops.
struct Limits {
    /// Log odds above which an effect is accepted, and those that a further one at another place needs: what is left of
    /// an inexact form must not pass for it.
    accept: f64,
    accept_further: f64,
    /// Log odds above which a first effect that acts once is accepted: no other reading can confirm it.
    accept_event: f64,
    /// Most effects of one session.
    effects: usize,
    /// Share of what was explained before that a further effect elsewhere must explain.
    share_elsewhere: f64,
    /// Rms that a further effect elsewhere must take off the residual, in noise floors.
    rms_elsewhere: f64,
    /// Steps after which no other set of effects is tried: readings that no form fits would go on for minutes.
    steps: usize,
}

/// Sweeps: few causes beside one that dominates; what an inexact form leaves must not pass for physics.
const SWEEPS: Limits = Limits {
    accept: 15.0,
    accept_further: 30.0,
    accept_event: 24.0,
    effects: 6,
    share_elsewhere: 0.015,
    rms_elsewhere: 0.3,
    steps: 26,
};
/// The same over half of the readings, which show half as much, give or take their noise.
const HALF: Limits = Limits { accept: 4.0, accept_further: 15.0, accept_event: 8.0, steps: 10, ..SWEEPS };

/// Families refined at each stage.
const REFINED: usize = 12;
/// A free curve is preferred to a form of the catalogue only when it explains so much more.
const FREE_CURVE_MARGIN: f64 = 1.3;

/// Searches a session.
pub fn search(grounds: &Grounds, floors: &Floors, families: &[Family]) -> Search {
    search_then(grounds, floors, families, SWEEPS, |ways, model| {
        ways.exchange(model);
        *model = ways.pruned(model.clone());
        model.weigh(ways);
    })
}

/// Starts from effects found on all readings, at most.
const LEADS: usize = 3;

/// Searches part of a session once more: from its own best effect, and from those found on all of it.
///
/// Which of the starts stands is for these readings alone to say; the further ones only spare the exchange of effects.
pub fn search_part(grounds: &Grounds, floors: &Floors, families: &[Family], leads: &[Found]) -> Search {
    search_then(grounds, floors, families, HALF, |ways, model| {
        for lead in leads.iter().take(LEADS).map(|found| &found.chosen) {
            if !ways.goes_on() || model.found.first().is_some_and(|first| first.chosen.family == lead.family) {
                continue;
            }
            let mut trial = Model::empty(ways);
            ways.grow(&mut trial, Some(lead.clone()));
            ways.replace(model, trial, 0.0);
        }
    })
}

/// Grows a set of effects, best first, and lets `revise` look for better ones.
fn search_then(
    grounds: &Grounds,
    floors: &Floors,
    families: &[Family],
    limits: Limits,
    revise: impl FnOnce(&Ways, &mut Model),
) -> Search {
    if !grounds.fine.has_sweeps() {
        return search_poses(grounds.fine, families);
    }
    let whitened = |ground, floor| Arc::new(Whitened::new(ground, floor, &ground.kept));
    let whitened = [whitened(grounds.fine, &floors[0]), whitened(grounds.coarse, &floors[1])];
    let ways = Ways { grounds, families, floors, limits, whitened, steps: Cell::new(0) };
    let mut model = Model::empty(&ways);
    let start = Start::of(&ways, &model);
    ways.grow(&mut model, None);
    revise(&ways, &mut model);
    model.finished(&ways, start)
}

/// How a session stood before the search.
struct Start {
    noise: Vec<NoiseModel>,
    residual_mm2: f64,
}

impl Start {
    fn of(ways: &Ways, model: &Model) -> Start {
        Start { noise: model.noise.clone(), residual_mm2: mean_square(ways.grounds.fine, &model.residual_mm) }
    }
}

/// Noise by test, on all rows and on averaged ones.
pub type Floors = [Vec<NoiseModel>; 2];

/// Noise floors of both resolutions.
pub fn floors(grounds: &Grounds) -> Floors {
    [grounds.fine, grounds.coarse].map(|ground| noise_floor(ground, &ground.residual_mm))
}

/// What a search has found so far.
#[derive(Clone)]
struct Model {
    /// Accepted columns on all rows and on averaged ones.
    columns: [Vec<Accepted>; 2],
    found: Vec<Found>,
    residual_mm: Vec<Vec<f64>>,
    noise: Vec<NoiseModel>,
    best_left: f64,
}

impl Model {
    fn empty(ways: &Ways) -> Model {
        let fine = ways.grounds.fine;
        let residual_mm = Stage::new(fine, &ways.floors[0], &[], &fine.kept).residual_mm(&[]);
        let noise = likely_noise(fine, &residual_mm, &ways.floors[0], &ways.floors[0]);
        Model { columns: [Vec::new(), Vec::new()], found: Vec::new(), residual_mm, noise, best_left: f64::NEG_INFINITY }
    }

    /// The same without one of its effects, fitted anew.
    fn without(&self, ways: &Ways, left_out: usize) -> Model {
        let mut model = Model::empty(ways);
        let others = self.found.iter().enumerate().filter(|(index, _)| *index != left_out);
        others.for_each(|(_, found)| model.take(ways, found.clone()));
        let fine = ways.grounds.fine;
        let stage = Stage::new(fine, &self.noise, &model.columns[0], &fine.kept);
        model.residual_mm = stage.residual_mm(&model.columns[0]);
        model.noise = likely_noise(fine, &model.residual_mm, &self.noise, &ways.floors[0]);
        model
    }

    /// Works out what each effect adds beside all others.
    fn weigh(&mut self, ways: &Ways) {
        if self.found.len() < 2 {
            return;
        }
        let misfit = |model: &Model| pooled_misfit(ways.grounds.fine, &model.noise, &model.residual_mm);
        let whole = misfit(self);
        for index in 0..self.found.len() {
            let gain = 0.5 * (misfit(&self.without(ways, index)) - whole);
            if std::env::var_os("FIVEAXIS_TRACE").is_some() {
                eprintln!("{} beside the others: {gain:.1}", self.found[index].chosen.effect.kind);
            }
            self.found[index].beside_gain = gain;
        }
    }

    /// The result of a search that ends with this model.
    fn finished(self, ways: &Ways, start: Start) -> Search {
        Search {
            residual_before_mm2: start.residual_mm2,
            noise_before: start.noise,
            noise_after: self.noise,
            found: self.found,
            residual_mm: self.residual_mm,
            best_left: self.best_left,
            floor: ways.floors[0].clone(),
        }
    }

    /// Adds what a step found, with what it leaves.
    fn add(&mut self, ways: &Ways, step: Step) {
        self.take(ways, step.found);
        self.residual_mm = step.residual_mm;
        self.noise = step.noise;
    }

    /// Adds the columns of an effect.
    fn take(&mut self, ways: &Ways, found: Found) {
        let chosen = &found.chosen;
        let coarse = ways.grounds.coarse.columns(&chosen.effect, &chosen.terms).unwrap_or_default();
        let prior = chosen.judgement.tau.max(1.0);
        self.columns[1].extend(coarse.into_iter().map(|column| Accepted { column, prior }));
        self.columns[0].extend(chosen.accepted());
        self.found.push(found);
    }

    /// Log likelihood with its own noise, less what shapes and amplitudes cost.
    fn standing(&self, ways: &Ways) -> f64 {
        let cost: f64 = self.found.iter().map(|found| found.gain - found.log_odds).sum();
        -0.5 * pooled_misfit(ways.grounds.fine, &self.noise, &self.residual_mm) - cost
    }
}

/// Residual over noise floor from which other first steps are tried as well.
const POORLY_EXPLAINED: f64 = 1.3;
/// Other first steps that are tried.
const OTHER_STARTS: usize = 4;
/// Log odds by which another set of effects must be better.
const BETTER_SET: f64 = 5.0;
/// The same for a set that begins with a free curve where the present one begins with a named form.
const BETTER_FREE_SET: f64 = 60.0;

/// A session with all that may be in it.
struct Ways<'w, 'g, 'a> {
    grounds: &'w Grounds<'g, 'a>,
    families: &'w [Family],
    floors: &'w Floors,
    limits: Limits,
    /// All rows and averaged ones under their noise floors.
    whitened: [Arc<Whitened<'g, 'a>>; 2],
    /// Steps made so far.
    steps: Cell<usize>,
}

impl Ways<'_, '_, '_> {
    /// Whether other sets of effects may still be tried.
    fn goes_on(&self) -> bool {
        self.steps.get() < self.limits.steps
    }

    /// Adds effects as long as the evidence demands one; the first one may be given.
    fn grow(&self, model: &mut Model, mut first: Option<Candidate>) {
        while model.found.len() < self.limits.effects {
            let Some(step) = self.next(model, first.take()) else { break };
            let standing = (step.found.fall_mm2, step.found.log_odds);
            let demanded = is_demanded(&self.limits, &model.found, &step.found.chosen, standing, &self.floors[0]);
            if !demanded || is_gauge_wander(self.grounds.fine, &step.found.chosen) {
                model.best_left = step.found.log_odds;
                break;
            }
            model.add(self, step);
        }
    }

    /// The next effect beside those of a model; `given` stands for the choice when it is stated.
    fn next(&self, model: &Model, given: Option<Candidate>) -> Option<Step> {
        self.steps.set(self.steps.get() + 1);
        let fine = self.grounds.fine;
        let families = self.families;
        let candidates = match given {
            Some(given) => vec![given],
            None => {
                let [fine, coarse] = &self.whitened;
                let stages = [Stage::on(fine.clone(), &model.columns[0]), Stage::on(coarse.clone(), &model.columns[1])];
                let mut candidates = screen(&stages, families, self.grounds.cells);
                candidates.retain(|candidate| is_sensible(candidate, stages[0].misfit));
                keep_diverse(&mut candidates, families);
                refine_all(&stages, families, candidates)
            }
        };
        let best = candidates.first()?;
        // the noise that the best candidate leaves is the one to compare under
        let with_best = joined(&model.columns[0], best);
        let left = Stage::on(self.whitened[0].clone(), &with_best).residual_mm(&with_best);
        let noise_left = likely_noise(fine, &left, &self.floors[0], &self.floors[0]);
        let stage = Stage::new(fine, &noise_left, &model.columns[0], &fine.kept);
        let candidates = compare(&stage, families, candidates);
        let index = choose(&candidates, families, fine);
        let chosen = candidates[index].clone();
        let with_chosen = joined(&model.columns[0], &chosen);
        let residual_mm = Stage::new(fine, &noise_left, &with_chosen, &fine.kept).residual_mm(&with_chosen);
        let noise = likely_noise(fine, &residual_mm, &noise_left, &self.floors[0]);
        let gain =
            0.5 * (pooled_misfit(fine, &model.noise, &model.residual_mm) - pooled_misfit(fine, &noise, &residual_mm));
        let log_odds = gain - (0.5 * chosen.judgement.chi2 - chosen.log_odds);
        trace(fine, families, model.found.len(), &candidates, index, (gain, log_odds), &noise);
        let fall_mm2 = mean_square(fine, &model.residual_mm) - mean_square(fine, &residual_mm);
        let lead = candidates[index].log_odds;
        let rivals = candidates.into_iter().enumerate().filter(|(k, _)| *k != index).map(|(_, rival)| {
            let odds = rival.log_odds - lead;
            (rival, odds)
        });
        let found =
            Found { rivals: rivals.collect(), chosen, log_odds, gain, ranked_odds: lead, beside_gain: gain, fall_mm2 };
        Some(Step { found, residual_mm, noise })
    }

    /// Replaces what a greedy search took too early: the first effect where much stays unexplained, then each beside the others.
    fn exchange(&self, model: &mut Model) {
        let floor_mm2 = mean_noise_mm2(&self.floors[0]);
        let left_mm2 = mean_square(self.grounds.fine, &model.residual_mm);
        if !model.found.is_empty() && left_mm2 > POORLY_EXPLAINED.powi(2) * floor_mm2 {
            self.start_otherwise(model);
        }
        for index in (0..model.found.len()).rev() {
            // a model that was replaced may be shorter
            if index >= model.found.len() {
                continue;
            }
            // an effect that was given has no rivals yet
            let has_rivals = !model.found[index].rivals.is_empty();
            if has_rivals && (model.found.len() == 1 || !self.goes_on()) {
                continue;
            }
            // a free curve at the place of an effect found before it is the rest of that one's form
            let place = model.found[index].chosen.effect.place;
            let is_rest = model.found[index].chosen.effect.kind == "unknown"
                && model.found[..index].iter().any(|other| other.chosen.effect.place == place);
            if is_rest {
                continue;
            }
            let mut trial = model.without(self, index);
            let Some(step) = self.next(&trial, None) else { continue };
            let old = model.found[index].chosen.family;
            let mut rivals = step.found.rivals.clone();
            let ranked_odds = step.found.ranked_odds;
            // beside the same motion in fewer directions, one in more is a rival and no other set
            let is_simpler = simpler(&[step.found.chosen.clone(), model.found[index].chosen.clone()], 0).is_some();
            if step.found.chosen.family != old && !is_simpler {
                rivals.insert(0, (step.found.chosen.clone(), 0.0));
                trial.add(self, step);
                self.grow(&mut trial, None);
                if self.replace(model, trial, BETTER_SET) {
                    continue;
                }
            }
            // beside the others the rivals are fewer than when it was taken
            rivals.retain(|(rival, _)| rival.family != old);
            model.found[index].rivals = rivals;
            model.found[index].ranked_odds = ranked_odds;
        }
    }

    /// Tries other first effects.
    fn start_otherwise(&self, model: &mut Model) {
        let mut tried = vec![model.found[0].chosen.effect.kind.clone()];
        let rivals: Vec<Candidate> = model.found[0].rivals.iter().map(|(rival, _)| rival.clone()).collect();
        for rival in rivals {
            let kind = &rival.effect.kind;
            if !self.goes_on() || tried.len() > OTHER_STARTS || tried.contains(kind) || kind == "unknown" {
                continue;
            }
            tried.push(kind.clone());
            let mut trial = Model::empty(self);
            self.grow(&mut trial, Some(rival));
            self.replace(model, trial, BETTER_SET);
        }
    }

    /// The model without effects that add too little to what the others explain, whichever was taken first.
    fn pruned(&self, mut model: Model) -> Model {
        let fine = self.grounds.fine;
        let left_mm2 = |columns: &[Accepted]| {
            let left = Stage::on(self.whitened[0].clone(), columns).residual_mm(columns);
            mean_square(fine, &left)
        };
        let before_mm2 = left_mm2(&[]);
        while model.found.len() > 1 {
            let all_mm2 = left_mm2(&model.columns[0]);
            let mut first = 0;
            let falls: Vec<(f64, f64)> = model
                .found
                .iter()
                .map(|found| {
                    let own = first..first + found.chosen.columns.len();
                    first = own.end;
                    let others = (0..model.columns[0].len()).filter(|column| !own.contains(column));
                    let others: Vec<Accepted> = others.map(|column| model.columns[0][column].clone()).collect();
                    let without_mm2 = left_mm2(&others);
                    (without_mm2 - all_mm2, before_mm2 - without_mm2)
                })
                .collect();
            let adds_little = (0..falls.len())
                .filter(|&index| {
                    let place = model.found[index].chosen.effect.place;
                    // a free curve can stand for any form at its place: it is the one to go
                    let is_free = |k: usize| self.families[model.found[k].chosen.family].kind == "unknown";
                    let stands_for = |k: usize| is_free(k) && model.found[k].chosen.effect.place == place;
                    if !is_free(index) && (0..falls.len()).any(|k| k != index && stands_for(k)) {
                        return false;
                    }
                    let beside = (0..falls.len()).any(|k| k != index && model.found[k].chosen.effect.place == place);
                    let (fall_mm2, explained_mm2) = falls[index];
                    !adds_enough(&self.limits, beside, fall_mm2, explained_mm2, mean_noise_mm2(&self.floors[0]))
                })
                .min_by(|&a, &b| falls[a].0.total_cmp(&falls[b].0));
            let Some(index) = adds_little else { break };
            model = model.without(self, index);
        }
        model
    }

    /// Takes a trial when it stands better by some log odds; whether it did.
    fn replace(&self, model: &mut Model, trial: Model, margin: f64) -> bool {
        let trial = if trial.standing(self) > model.standing(self) { self.pruned(trial) } else { trial };
        let (now, other) = (model.standing(self), trial.standing(self));
        if std::env::var_os("FIVEAXIS_TRACE").is_some() {
            let names = |model: &Model| -> Vec<String> {
                model.found.iter().map(|found| found.chosen.effect.kind.clone()).collect()
            };
            eprintln!("exchange: {now:.1} {:?} or {other:.1} {:?}", names(model), names(&trial));
        }
        let starts_free =
            |model: &Model| model.found.first().is_some_and(|first| first.chosen.effect.kind == "unknown");
        // a free curve before a named form must stand far better, as where one effect is chosen
        let margin = if starts_free(&trial) && !starts_free(model) { BETTER_FREE_SET } else { margin };
        let is_better = other > now + margin;
        if is_better {
            *model = trial;
        }
        is_better
    }
}

/// One step of a search: what it finds and what is left then.
struct Step {
    found: Found,
    residual_mm: Vec<Vec<f64>>,
    noise: Vec<NoiseModel>,
}

/// A search that was not made: nothing found.
pub fn nothing(ground: &Ground, floor: &[NoiseModel]) -> Search {
    Search {
        noise_before: floor.to_vec(),
        noise_after: floor.to_vec(),
        floor: floor.to_vec(),
        found: Vec::new(),
        residual_before_mm2: mean_square(ground, &ground.residual_mm),
        residual_mm: ground.residual_mm.clone(),
        best_left: f64::NEG_INFINITY,
    }
}

/// Share of the mean square that all effects found before explain which a further one at the same place must explain.
const LEAST_SHARE: f64 = 0.002;
/// Rms that the first effect must take off the residual, in noise floors.
const LEAST_RMS: f64 = 0.18;
/// The same for an event: somewhere in a session noise looks like a jump.
const LEAST_EVENT_RMS: f64 = 0.25;

/// Whether the evidence demands a candidate beside what was found.
fn is_demanded(
    limits: &Limits,
    found: &[Found],
    chosen: &Candidate,
    (fall_mm2, log_odds): (f64, f64),
    floor: &[NoiseModel],
) -> bool {
    let noise_mm2 = mean_noise_mm2(floor);
    let in_noise = |share: f64| fall_mm2 > share * share * noise_mm2;
    if found.is_empty() {
        let is_event = chosen.effect.kind.ends_with("-slip");
        let (odds, rms) = match is_event {
            true => (limits.accept_event, LEAST_EVENT_RMS),
            false => (limits.accept, LEAST_RMS),
        };
        return log_odds > odds && in_noise(rms);
    }
    let explained: f64 = found.iter().map(|found| found.fall_mm2).sum();
    let same_place = found.iter().any(|other| other.chosen.effect.place == chosen.effect.place);
    log_odds > if same_place { limits.accept } else { limits.accept_further }
        && adds_enough(limits, same_place, fall_mm2, explained, noise_mm2)
}

/// Whether an effect takes enough off the mean square beside what the others explain.
fn adds_enough(limits: &Limits, same_place: bool, fall_mm2: f64, explained_mm2: f64, noise_mm2: f64) -> bool {
    match same_place {
        true => fall_mm2 > LEAST_SHARE * explained_mm2,
        false => {
            fall_mm2 > limits.share_elsewhere * explained_mm2 && fall_mm2 > limits.rms_elsewhere.powi(2) * noise_mm2
        }
    }
}

/// Growth of the bar below its own uncertainty: a gauge's zero wanders as far in a session.
fn is_gauge_wander(ground: &Ground, chosen: &Candidate) -> bool {
    if chosen.effect.kind != "bar-length" || chosen.effect.parameter("bar").is_some() {
        return false;
    }
    let uncertain_mm = ground
        .problem
        .unknowns
        .iter()
        .filter(|unknown| matches!(unknown.quantity, Quantity::Bar { .. }))
        .map(|unknown| unknown.prior_sigma)
        .fold(0.0, f64::max);
    let mut ends = (f64::MAX, f64::MIN);
    for test in 0..ground.tests() {
        for row in (0..ground.kept[test].len()).filter(|&row| ground.kept[test][row]) {
            let columns = chosen.columns.iter().zip(&chosen.judgement.amplitudes);
            let grown: f64 =
                columns.map(|(column, size)| size * column.by_test[test].get(row).copied().unwrap_or(0.0)).sum();
            ends = (ends.0.min(grown), ends.1.max(grown));
        }
    }
    ends.1 - ends.0 < uncertain_mm
}

/// Mean square of the rows that take part, mm².
pub(super) fn mean_square(ground: &Ground, residual_mm: &[Vec<f64>]) -> f64 {
    let kept = residual_mm
        .iter()
        .zip(&ground.kept)
        .flat_map(|(residual, kept)| residual.iter().zip(kept).filter(|(_, kept)| **kept));
    crate::identify::rms(kept.map(|(value, _)| *value)).powi(2)
}

/// Prints the standing of the best candidates when the variable FIVEAXIS_TRACE is set: for work on the search itself.
pub(super) fn trace(
    ground: &Ground,
    families: &[Family],
    stage: usize,
    candidates: &[Candidate],
    index: usize,
    (gain, log_odds): (f64, f64),
    noise: &[NoiseModel],
) {
    if std::env::var_os("FIVEAXIS_TRACE").is_none() {
        return;
    }
    let machine = ground.context.machine();
    eprintln!("stage {stage}: gain {gain:.1} log odds {log_odds:.1} chosen {index}; noise {:?}", noise.first());
    for candidate in candidates.iter().take(8) {
        let outlets: Vec<String> =
            families[candidate.family].outlets.iter().map(|outlet| outlet.name(machine)).collect();
        let effect = &candidate.effect;
        eprintln!(
            "   {:9.1} chi2 {:9.1} {} {} {} {:?}",
            candidate.log_odds,
            candidate.judgement.chi2,
            effect.kind,
            effect.place.name(machine),
            outlets.join(" "),
            effect.parameters
        );
    }
}

/// Shortest shift between lengths and positions of a single test, ms: a mistake of pairing is no matter of milliseconds.
const SHORTEST_SHIFT_MS: f64 = 200.0;
const LONGEST_SHIFT_MS: f64 = 5000.0;

/// Share of the misfit that a wrong pairing of one test must explain: the files are wrong, or the machine is.
const SHIFT_SHARE: f64 = 0.5;

/// Whether a candidate's size is one that it can have.
fn is_sensible(candidate: &Candidate, misfit: f64) -> bool {
    let shift_ms = candidate.judgement.amplitudes.iter().fold(0.0f64, |largest, size| largest.max(size.abs()));
    let explains = candidate.judgement.chi2 > SHIFT_SHARE * misfit;
    !super::is_shift_of_one_test(&candidate.effect)
        || (explains && (SHORTEST_SHIFT_MS..LONGEST_SHIFT_MS).contains(&shift_ms))
}

/// Free curves that are refined beside the named ones.
const REFINED_FREE: usize = 3;
/// Candidates of one kind that are refined: on a coarse grid a jump may stand behind many ways to grow.
const REFINED_ALIKE: usize = 8;

/// Keeps the best candidates, but not only free curves or only one kind.
pub(super) fn keep_diverse(candidates: &mut Vec<Candidate>, families: &[Family]) {
    let mut kept: Vec<&'static str> = Vec::new();
    candidates.retain(|candidate| {
        let kind = families[candidate.family].kind;
        let alike = kept.iter().filter(|other| **other == kind).count();
        let named = kept.iter().filter(|other| **other != "unknown").count();
        let keep = if kind == "unknown" { alike < REFINED_FREE } else { alike < REFINED_ALIKE && named < REFINED };
        if keep {
            kept.push(kind);
        }
        keep
    });
}

/// Judges refined candidates under one noise, on all rows.
fn compare(stage: &Stage, families: &[Family], mut candidates: Vec<Candidate>) -> Vec<Candidate> {
    candidates.par_iter_mut().for_each(|candidate| {
        let cost = candidate.judgement.log_evidence - candidate.log_odds;
        candidate.judgement = stage.judge(&candidate.columns, families[candidate.family].plausible);
        candidate.log_odds = candidate.judgement.log_evidence - cost;
    });
    candidates.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
    candidates
}

/// Log odds within which candidates count as equal, so that the customary name decides.
const TIE: f64 = 3.0;
/// The same as a share of the best one's log odds: forms are never exact.
const TIE_SHARE: f64 = 0.002;
const FREE_TIE: f64 = 10.0;

/// The candidate to accept: the best named one, unless a free curve explains far more; customary names win ties.
pub(super) fn choose(candidates: &[Candidate], families: &[Family], ground: &Ground) -> usize {
    let is_free = |candidate: &Candidate| families[candidate.family].kind == "unknown";
    let best_named = candidates.iter().position(|candidate| !is_free(candidate));
    let best = match best_named {
        Some(named) if is_free(&candidates[0]) => {
            let far_more = candidates[0].judgement.chi2 > FREE_CURVE_MARGIN * candidates[named].judgement.chi2 + 30.0;
            if far_more { 0 } else { named }
        }
        _ => 0,
    };
    let best = simpler(candidates, best).unwrap_or(best);
    // a free curve over an axis that only follows another one says the same as one over that axis
    let share = TIE_SHARE * candidates[best].log_odds.max(0.0);
    let tie = if is_free(&candidates[best]) { FREE_TIE } else { TIE.max(share) };
    let near = |candidate: &Candidate| {
        candidates[best].log_odds - candidate.log_odds < tie && is_free(candidate) == is_free(&candidates[best])
    };
    (0..candidates.len())
        .filter(|&k| k == best || near(&candidates[k]))
        .min_by_key(|&k| (families[candidates[k].family].customary_rank(ground), k != best))
        .unwrap_or(best)
}

/// Share of what a vibration in all directions explains with which one direction alone is the likelier cause: a phase that
/// wanders is no other direction.
const ONE_DIRECTION: f64 = 0.93;
/// The same for error motions: what lies between the orders is no other motion.
const FEWER_MOTIONS: f64 = 0.99;

/// A candidate of the best one's kind that explains nearly as much in half as many directions or fewer.
fn simpler(candidates: &[Candidate], best: usize) -> Option<usize> {
    let Candidate { effect, terms, judgement, .. } = &candidates[best];
    let share = match effect.kind.as_str() {
        "vibration" => ONE_DIRECTION,
        "rotary-error-motion" => FEWER_MOTIONS,
        _ => return None,
    };
    candidates.iter().position(|other| {
        other.effect.kind == effect.kind
            && (other.effect.place == effect.place || effect.kind == "vibration")
            && 2 * directions(&other.terms) <= directions(terms)
            && other.judgement.chi2 > share * judgement.chi2
    })
}

fn directions(terms: &[Term]) -> usize {
    terms.iter().map(|term| term.outlet).collect::<HashSet<_>>().len()
}

fn pooled_misfit(ground: &Ground, noise: &[NoiseModel], residual_mm: &[Vec<f64>]) -> f64 {
    let mut alike: Vec<(NoiseModel, Vec<Vec<f64>>)> = Vec::new();
    for test in 0..ground.tests() {
        let rows = residual_mm[test].iter().zip(&ground.kept[test]);
        let masked: Vec<f64> = rows.map(|(r, kept)| if *kept { *r } else { f64::NAN }).collect();
        match alike.iter_mut().find(|(model, _)| *model == noise[test]) {
            Some((_, traces)) => traces.push(masked),
            None => alike.push((noise[test], vec![masked])),
        }
    }
    alike.iter().map(|(noise, traces)| misfit(noise, traces)).sum()
}

pub(super) fn joined(model: &[Accepted], candidate: &Candidate) -> Vec<Accepted> {
    model.iter().cloned().chain(candidate.accepted()).collect()
}
