//! How probable the cause of an accepted effect is among its rivals. It fits nothing.

use crate::diagnose::cause::{Cause, LEAST_PROBABILITY, MOST_RIVALS};
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::selection::naming::cause;
use crate::diagnose::selection::ranking::is_driven_by;
use crate::diagnose::selection::selected::{Candidate, SelectedEffect};
use crate::diagnose::selection::shapes::trajectory::has_first_order;
use crate::effects::CandidateFamily;
use crate::effects::{Signature, is_a};

/// A cause among those that the readings allow in its place.
pub(crate) struct Standing<'s> {
    pub(crate) probability: f64,
    /// Rivals worth naming with their probabilities, likeliest first.
    pub(crate) rivals: Vec<(Cause, f64)>,
    /// Other forms worth a look, those of the same cause among them, with their probabilities.
    pub(crate) forms: Vec<(&'s Candidate, f64)>,
}

/// A cause with the forms of it that were judged and their weights, the largest first.
struct Judged<'s> {
    cause: Cause,
    forms: Vec<(&'s Candidate, f64)>,
}

impl Judged<'_> {
    /// Weight of its best form.
    fn best(&self) -> f64 {
        self.forms.iter().map(|(_, weight)| *weight).fold(0.0, f64::max)
    }
}

/// Log odds beyond which nothing is left of the other.
const MOST_ODDS: f64 = 50.0;

/// Forms that are looked at beside the chosen one, at most.
const MOST_FORMS: usize = 8;

impl<'s> Standing<'s> {
    /// Of the cause that an effect was accepted for: rivals by their log odds, softened by what forms of the catalogue lack.
    ///
    /// A cause that can be written in many forms (in more or fewer components) is no likelier for it: each has the weight of its
    /// best form, shared by its forms.
    pub(crate) fn of(model: &LinearModel, families: &[CandidateFamily], lead: &'s SelectedEffect) -> Standing<'s> {
        let (machine, thresholds) = (model.context.machine(), &model.thresholds);
        let rank = |candidate: &Candidate| families[candidate.family].rank;
        let own_rank = rank(&lead.chosen);
        let rarity = |candidate: &Candidate| families[candidate.family].rarity;
        // what is customary in arms nobody counted
        let customary = if model.has_sweeps() { thresholds.customary } else { 1.0 };
        let own = Judged { cause: cause(machine, &lead.chosen, &[]), forms: vec![(&lead.chosen, 1.0)] };
        let mut causes = vec![own];
        for (rival, odds) in &lead.rivals {
            let cause = cause(machine, rival, &[]);
            let share = match is_load_or_bearing(&lead.chosen, rival) {
                true => thresholds.softening_of_arcs,
                false => thresholds.softening,
            };
            let is_undescribed = rival.is_free() && !lead.chosen.is_free();
            // forms are inexact; how rare a named cause is, and what size of it is plausible, is no matter of forms
            let rarer = if is_undescribed { 0.0 } else { rarity(rival) - rarity(&lead.chosen) };
            let beyond = rarer + rival.judgement.implausibility - lead.chosen.judgement.implausibility;
            let softened = (odds + beyond) / (1.0 + share * lead.ranked_odds.max(0.0)) - beyond;
            let is_rarer = rank(rival) > own_rank || is_driven_by(machine, rival, &lead.chosen);
            // a free curve may stand better than the name that is told; among names custom has chosen
            let (seen, custom) = match is_undescribed {
                true => (softened.min(MOST_ODDS).exp(), thresholds.undescribed),
                false => (softened.min(0.0).exp(), if is_rarer { customary } else { 1.0 }),
            };
            let is_known =
                |known: &&mut Judged| is_same(&known.cause, &cause) && is_driven_alike(known.forms[0].0, rival);
            match causes.iter_mut().find(is_known) {
                Some(known) => known.forms.push((rival, custom * seen)),
                None => causes.push(Judged { cause, forms: vec![(rival, custom * seen)] }),
            }
        }
        if !lead.chosen.is_free() {
            share_prior_of_free_curves(&mut causes);
        }
        let total: f64 = causes.iter().map(Judged::best).sum();
        let mut forms = Vec::new();
        for judged in &causes {
            let all: f64 = judged.forms.iter().map(|(_, weight)| weight).sum();
            let share = judged.best() / total / all.max(f64::MIN_POSITIVE);
            forms.extend(judged.forms.iter().map(|(form, weight)| (*form, share * weight)));
        }
        // the chosen form stands first
        let mut forms = forms.split_off(1);
        forms.retain(|(_, probability)| *probability >= LEAST_PROBABILITY);
        forms.sort_by(|a, b| b.1.total_cmp(&a.1));
        forms.truncate(MOST_FORMS);
        let probability = causes[0].best() / total;
        let mut rivals: Vec<(Cause, f64)> = causes
            .into_iter()
            .skip(1)
            .map(|judged| {
                let probability = judged.best() / total;
                (judged.cause, probability)
            })
            .collect();
        rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
        rivals.retain(|(_, probability)| *probability >= LEAST_PROBABILITY);
        rivals.truncate(MOST_RIVALS);
        Standing { probability, rivals, forms }
    }
}

/// What no form describes has one prior, however many free curves may stand for it: together they have the weight of the best one.
fn share_prior_of_free_curves(causes: &mut [Judged]) {
    let mut free: Vec<&mut Judged> = causes.iter_mut().filter(|judged| judged.forms[0].0.is_free()).collect();
    let all: f64 = free.iter().map(|judged| judged.best()).sum();
    let share = free.iter().map(|judged| judged.best()).fold(0.0, f64::max) / all.max(f64::MIN_POSITIVE);
    free.iter_mut().flat_map(|judged| &mut judged.forms).for_each(|(_, weight)| *weight *= share);
}

/// Whether two names mean one cause: the same effect at the same place, in some of the same components.
pub(super) fn is_same(one: &Cause, other: &Cause) -> bool {
    let shares = one.components.iter().any(|component| other.components.contains(component));
    one.effect == other.effect && one.place == other.place && (shares || one.components == other.components)
}

/// Whether the same axis drives both: play as one axis reverses is no play as another one does.
fn is_driven_alike(one: &Candidate, other: &Candidate) -> bool {
    one.effect.parameter("of") == other.effect.parameter("of")
}

/// Whether one of two candidates is the sag of a joint and the other its error motion over part of a turn.
fn is_load_or_bearing(one: &Candidate, other: &Candidate) -> bool {
    let is_arc =
        |candidate: &Candidate| is_a(&candidate.effect.kind, Signature::ErrorMotion) && !has_first_order(candidate);
    let is_sag = |candidate: &Candidate| is_a(&candidate.effect.kind, Signature::Sag);
    one.effect.place == other.effect.place && (is_arc(one) && is_sag(other) || is_sag(one) && is_arc(other))
}
