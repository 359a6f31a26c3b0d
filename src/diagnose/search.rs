//! Which few effects the evidence demands: screen every family, refine the best, compare, accept, repeat. No words, no proof.

use std::cell::Cell;
use std::sync::Arc;

use super::choosing::{BALL_FORM, choose, compare, is_sensible, keep_diverse, simpler};
use super::demand::{adds_enough, is_below_the_bar, is_demanded, relieves};
use super::floor::{likely_noise, mean_noise_mm2, noise_floor, wandering};
use super::found::{Candidate, Floors, Found, Grounds, Search, Step, Ways};
use super::ground::Ground;
use super::library::Family;
use super::limits::{HALF, Limits, SWEEPS};
use super::model::{Model, Start, joined, mean_square, pooled_misfit, rest_of, without_trends};
use super::pose_search::search_poses;
use super::refining::refine_all;
use super::screening::screen;
use super::size::grows;
use super::stage::{Accepted, Stage};
use super::whitened::Whitened;
use crate::identify::NoiseModel;

/// Searches a session.
pub fn search(grounds: &Grounds, floors: &Floors, families: &[Family]) -> Search {
    search_unless(grounds, floors, families, |_| false)
}

/// Searches a session; the first set of effects stands where what it leaves, mm, is to be searched otherwise.
pub fn search_unless(
    grounds: &Grounds,
    floors: &Floors,
    families: &[Family],
    otherwise: impl FnOnce(&[Vec<f64>]) -> bool,
) -> Search {
    search_then(grounds, floors, families, SWEEPS, |ways, model| {
        if otherwise(&model.residual_mm) {
            return;
        }
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
        let leads = (0..leads.len()).filter(|&index| rest_of(leads, index).is_none()).map(|index| &leads[index].chosen);
        for lead in leads.take(LEADS) {
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
    let ways =
        Ways { grounds, families, floors, limits, whitened, steps: Cell::new(0), balls_are_round: Cell::new(false) };
    let mut model = Model::empty(&ways);
    let start = Start::of(&ways, &model);
    ways.grow(&mut model, None);
    revise(&ways, &mut model);
    model.finished(&ways, start)
}

/// Noise floors of both resolutions.
pub fn floors(grounds: &Grounds) -> Floors {
    [grounds.fine, grounds.coarse].map(|ground| noise_floor(ground, &ground.residual_mm))
}

/// Residual over noise floor from which other first steps are tried as well.
const POORLY_EXPLAINED: f64 = 1.3;

/// Other first steps that are tried.
const OTHER_STARTS: usize = 4;

/// Log odds, and at most the share of its gain, by which a ball out of round must stand better than a few of the machine's own
/// effects.
const BALLS_MUST_BE_BETTER: f64 = 60.0;
const BALLS_SHARE: f64 = 0.15;
/// The same beside effects that were taken instead.
const BALLS_ARE_GAUGES: f64 = 2.0;
const MOST_FOR_A_BALL: usize = 3;

/// Offsets from test to test, as shares of the rest of the noise, beside which growth must be worth telling; the larger one
/// where all of it is less than what is not known of the bar. Log odds from which it is, and beyond which there is no question.
const WANDERS: f64 = 0.7;
const WANDERS_FAR: f64 = 1.0;
const WORTH_TELLING: f64 = 6.0;
const BEYOND_A_ZERO: f64 = 300.0;

/// Log odds by which another set of effects must be better.
const BETTER_SET: f64 = 5.0;

/// The same for a set that begins with a free curve where the present one begins with a named form, at least and as a share
/// of what that one gains: between two orders of a turn lies more than neither.
const BETTER_FREE_SET: f64 = 60.0;
const FREE_SHARE: f64 = 0.03;

/// Log odds by which a form in one set of motions may stand worse than in another with a free curve beside it in the first.
const ONE_CAUSE: f64 = 20.0;

impl Ways<'_, '_, '_> {
    /// Whether other sets of effects may still be tried.
    fn goes_on(&self) -> bool {
        self.steps.get() < self.limits.steps
    }

    /// Adds effects as long as the evidence demands one; the first one may be given.
    fn grow(&self, model: &mut Model, mut first: Option<Candidate>) {
        let fine = self.grounds.fine;
        while model.found.len() < self.limits.effects {
            let Some(step) = self.next(model, first.take()) else { break };
            let within_mm2 = |residual_mm: &[Vec<f64>]| mean_square(fine, &without_trends(fine, residual_mm));
            let fall_within_mm2 = || within_mm2(&model.residual_mm) - within_mm2(&step.residual_mm);
            let standing = (step.found.fall_mm2, step.found.log_odds, model.pulls.shared_relief(&step.pulls));
            let (chosen, floor) = (&step.found.chosen, &self.floors[0]);
            let demanded = is_demanded(&self.limits, &model.found, chosen, standing, fall_within_mm2, floor);
            if !demanded || self.is_wander_of_the_zero(model, &step) {
                model.best_left = step.found.log_odds;
                break;
            }
            model.add(self, step);
        }
    }

    /// Whether a growth is not worth telling, the gauge's zero wandering from test to test more than the floor has it.
    fn is_wander_of_the_zero(&self, model: &Model, step: &Step) -> bool {
        let chosen = &step.found.chosen;
        if !grows(&chosen.effect) || step.found.log_odds > BEYOND_A_ZERO {
            return false;
        }
        let fine = self.grounds.fine;
        let cost = chosen.judgement.log_evidence - chosen.log_odds;
        let log_odds_beside = |share: f64| {
            let noise: Vec<NoiseModel> = step.noise.iter().map(|noise| wandering(noise, share)).collect();
            let stage = Stage::new(fine, &noise, &model.columns[0], &fine.kept);
            stage.judge(&chosen.columns, self.families[chosen.family].plausible).log_evidence - cost
        };
        log_odds_beside(WANDERS) < WORTH_TELLING
            || is_below_the_bar(fine, chosen) && log_odds_beside(WANDERS_FAR) < WORTH_TELLING
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
                candidates.retain(|candidate| !self.balls_are_round.get() || candidate.effect.kind != BALL_FORM);
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
        let stage = Stage::new(fine, &noise_left, &with_chosen, &fine.kept);
        let (residual_mm, pulls) = (stage.residual_mm(&with_chosen), stage.pulls());
        let noise = likely_noise(fine, &residual_mm, &noise_left, &self.floors[0]);
        let gain = 0.5 * (model.misfit(self) - pooled_misfit(fine, &noise, &residual_mm) - pulls.misfit());
        let log_odds = gain - (0.5 * chosen.judgement.chi2 - chosen.log_odds);
        trace(fine, families, model.found.len(), &candidates, index, (gain, log_odds), &noise);
        let fall_mm2 = mean_square(fine, &model.residual_mm) - mean_square(fine, &residual_mm);
        let lead = candidates[index].log_odds;
        let rivals = candidates.into_iter().enumerate().filter(|(k, _)| *k != index).map(|(_, rival)| {
            let odds = rival.log_odds - lead;
            (rival, odds)
        });
        let found = Found {
            rivals: rivals.collect(),
            chosen,
            log_odds,
            gain,
            ranked_odds: lead,
            beside_gain: gain,
            fall_mm2,
            form_withdrawn: false,
        };
        Some(Step { found, residual_mm, pulls, noise })
    }

    /// Replaces what a greedy search took too early: the first effect where much stays unexplained, then each beside the others.
    fn exchange(&self, model: &mut Model) {
        let floor_mm2 = mean_noise_mm2(&self.floors[0]);
        let left_mm2 = mean_square(self.grounds.fine, &model.residual_mm);
        if !model.found.is_empty() && left_mm2 > POORLY_EXPLAINED.powi(2) * floor_mm2 {
            self.start_otherwise(model);
        }
        let round_ball = self.round_balls(model);
        self.take_other_motions(model);
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
            if rest_of(&model.found, index).is_some() {
                continue;
            }
            let mut trial = model.without(self, index);
            let Some(step) = self.next(&trial, None) else { continue };
            let old = model.found[index].chosen.family;
            let mut rivals = step.found.rivals.clone();
            let ranked_odds = step.found.ranked_odds;
            // beside the same motion in fewer directions, one in more is a rival and no other set
            let is_simpler = simpler(
                self.grounds.fine.context.machine(),
                &[step.found.chosen.clone(), model.found[index].chosen.clone()],
                0,
            )
            .is_some();
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
        if let (Some(ball), Some(first)) = (round_ball, model.found.first_mut()) {
            first.rivals.push(ball);
        }
    }

    /// Takes the form of an effect in other motions where a free curve had to follow those: one cause rather than two.
    fn take_other_motions(&self, model: &mut Model) {
        let last = model.found.len().saturating_sub(1);
        let Some(whole) = rest_of(&model.found, last) else { return };
        let moves = |candidate: &Candidate, outlet| candidate.terms.iter().any(|term| term.outlet == outlet);
        let (lead, rest) = (&model.found[whole].chosen, &model.found[last].chosen);
        let is_error_motion = lead.effect.kind == "rotary-error-motion";
        if !is_error_motion || !self.goes_on() || rest.terms.iter().any(|term| moves(lead, term.outlet)) {
            return;
        }
        let is_same_form = |rival: &Candidate| {
            let is_alike = rival.effect.kind == lead.effect.kind && rival.effect.place == lead.effect.place;
            is_alike && rest.terms.iter().all(|term| moves(rival, term.outlet))
        };
        let rivals = model.found[whole].rivals.iter().map(|(rival, _)| rival);
        let Some(other) = rivals.clone().find(|rival| is_same_form(rival)).cloned() else { return };
        let mut trial = model.without(self, last).without(self, whole);
        if let Some(step) = self.next(&trial, Some(other)) {
            trial.add(self, step);
            self.grow(&mut trial, None);
            let trial = self.pruned(trial);
            self.replace(model, trial, -ONE_CAUSE);
        }
    }

    /// Tries other first effects.
    fn start_otherwise(&self, model: &mut Model) {
        let mut tried = vec![model.found[0].chosen.effect.kind.clone()];
        let rivals: Vec<Candidate> = model.found[0].rivals.iter().map(|(rival, _)| rival.clone()).collect();
        for rival in rivals {
            let kind = &rival.effect.kind;
            if !self.goes_on() || tried.len() > OTHER_STARTS || tried.contains(kind) || rival.is_free() {
                continue;
            }
            tried.push(kind.clone());
            let mut trial = Model::empty(self);
            self.grow(&mut trial, Some(rival));
            self.replace(model, trial, BETTER_SET);
        }
    }

    /// Takes what the machine does in place of a ball out of round, which has amplitudes for all of it: on circles of one bar
    /// the direction of the bar is the position of the slides.
    ///
    /// The ball that was left, with its log odds beside the machine's effects: nothing tells it from them.
    fn round_balls(&self, model: &mut Model) -> Option<(Candidate, f64)> {
        let first = model.found.first().filter(|first| first.chosen.effect.kind == BALL_FORM)?;
        let of_machine = |rival: &&Candidate| rival.effect.kind != BALL_FORM && !rival.is_event();
        let rivals: Vec<Candidate> = first.rivals.iter().map(|(rival, _)| rival).filter(of_machine).cloned().collect();
        let (ball, stands) = (first.chosen.clone(), model.standing(self));
        let better = BALLS_MUST_BE_BETTER.min(BALLS_SHARE * first.gain);
        let mut tried: Vec<String> = Vec::new();
        self.balls_are_round.set(true);
        for rival in rivals {
            if tried.len() < OTHER_STARTS && !tried.contains(&rival.effect.kind) {
                tried.push(rival.effect.kind.clone());
                let mut trial = Model::empty(self);
                self.grow(&mut trial, Some(rival));
                let are_few = (1..=MOST_FOR_A_BALL).contains(&trial.found.len());
                if are_few && self.replace(model, trial, -better) {
                    return Some((ball, (stands - model.standing(self)).min(0.0) - BALLS_ARE_GAUGES));
                }
            }
        }
        self.balls_are_round.set(false);
        None
    }

    /// The model without effects that add too little to what the others explain, whichever was taken first.
    fn pruned(&self, mut model: Model) -> Model {
        let fine = self.grounds.fine;
        let left = |columns: &[Accepted]| {
            let stage = Stage::on(self.whitened[0].clone(), columns);
            (mean_square(fine, &stage.residual_mm(columns)), stage.pulls())
        };
        let before_mm2 = left(&[]).0;
        while model.found.len() > 1 {
            let (all_mm2, all_pulls) = left(&model.columns[0]);
            let mut first = 0;
            let falls: Vec<(f64, f64, f64)> = model
                .found
                .iter()
                .map(|found| {
                    let own = first..first + found.chosen.columns.len();
                    first = own.end;
                    let others = (0..model.columns[0].len()).filter(|column| !own.contains(column));
                    let others: Vec<Accepted> = others.map(|column| model.columns[0][column].clone()).collect();
                    let (without_mm2, pulls) = left(&others);
                    (without_mm2 - all_mm2, before_mm2 - without_mm2, pulls.shared_relief(&all_pulls))
                })
                .collect();
            let adds_little = (0..falls.len())
                .filter(|&index| {
                    let place = model.found[index].chosen.effect.place;
                    // a free curve can stand for any form at its place: it is the one to go
                    let is_free = |k: usize| model.found[k].chosen.is_free();
                    let stands_for = |k: usize| is_free(k) && model.found[k].chosen.effect.place == place;
                    if !is_free(index) && (0..falls.len()).any(|k| k != index && stands_for(k)) {
                        return false;
                    }
                    let beside = (0..falls.len()).any(|k| k != index && model.found[k].chosen.effect.place == place);
                    let (fall_mm2, explained_mm2, relief) = falls[index];
                    !relieves(&model.found[index].chosen, relief)
                        && !adds_enough(&self.limits, beside, fall_mm2, explained_mm2, mean_noise_mm2(&self.floors[0]))
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
        let starts_free = |model: &Model| model.found.first().is_some_and(|first| first.chosen.is_free());
        // a free curve before a named form must stand far better, as where one effect is chosen
        let margin = if starts_free(&trial) && !starts_free(model) {
            BETTER_FREE_SET.max(model.found.first().map_or(0.0, |first| FREE_SHARE * first.gain))
        } else {
            margin
        };
        // a set that acts at more places must stand better by what each further one needs
        let places = |model: &Model| {
            let places = model.found.iter().map(|found| found.chosen.effect.place);
            places.collect::<std::collections::HashSet<_>>().len()
        };
        let further = places(&trial).saturating_sub(places(model).max(1));
        let margin = if margin < 0.0 { margin } else { margin.max(self.limits.accept_further * further as f64) };
        let is_better = other > now + margin;
        if is_better {
            *model = trial;
        }
        is_better
    }
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
