//! Which few effects the evidence demands: a set is grown, then exchanged for better ones. No words, no proof.

use crate::statistics::NoiseModel;
use std::cell::{Cell, OnceCell, RefCell};
use std::sync::Arc;

use super::joint_fit::{JointFit, mean_square, rest_of};
use super::limits::Limits;
use super::pose_search::search_poses;
use super::selected::{Floors, Resolutions, Search, SelectedEffect, SelectionContext};
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::whitened::WhitenedData;
use crate::diagnose::noise::noise_floor::noise_floor;
use crate::effects::CandidateFamily;
use crate::identify::Fit;

/// Searches a session.
pub fn search(resolutions: &Resolutions, floors: &Floors, families: &[CandidateFamily]) -> Search {
    search_unless(resolutions, floors, families, |_| false)
}

/// Searches a session once gross readings are gone; `cleaner` gives the fit without those that what is found, mm left, lets
/// see. `Err` is that fit: all is to be done again with it.
pub(crate) fn search_cleanly(
    resolutions: &Resolutions,
    floors: &Floors,
    families: &[CandidateFamily],
    cleaner: impl Fn(&[Vec<f64>]) -> Option<Fit>,
) -> Result<Search, Box<Fit>> {
    let mut cleaned = None;
    let hides = |left_mm: &[Vec<f64>]| {
        cleaned = cleaner(left_mm);
        cleaned.is_some()
    };
    let search = search_unless(resolutions, floors, families, hides);
    if cleaned.is_none() && resolutions.fine.has_sweeps() && !search.found.is_empty() {
        cleaned = cleaner(&search.residual_mm);
    }
    cleaned.map_or(Ok(search), |fit| Err(Box::new(fit)))
}

/// Searches a session; the first set of effects stands where what it leaves, mm, is to be searched otherwise.
pub fn search_unless(
    resolutions: &Resolutions,
    floors: &Floors,
    families: &[CandidateFamily],
    otherwise: impl FnOnce(&[Vec<f64>]) -> bool,
) -> Search {
    search_then(resolutions, floors, families, Limits::of_all(resolutions.fine.thresholds), |selection, joint| {
        if otherwise(&joint.residual_mm) {
            return;
        }
        selection.exchange(joint);
        *joint = selection.pruned(joint.clone());
        joint.weigh(selection);
        selection.hold_against_free_curves(joint);
    })
}

/// Searches a session beside effects that were found in other readings of it, with shapes as they were found there. They stay
/// where they are likelier than not, however little each of them adds.
pub(crate) fn search_from(
    resolutions: &Resolutions,
    floors: &Floors,
    families: &[CandidateFamily],
    found: &[SelectedEffect],
) -> Search {
    let here = |mut found: SelectedEffect| {
        found.chosen.columns = resolutions.fine.columns(&found.chosen.effect, &found.chosen.terms).ok()?;
        Some(found)
    };
    let limits = Limits::of_all(resolutions.fine.thresholds);
    search_then(resolutions, floors, families, limits, |selection, joint| {
        let found = found.iter().cloned().filter_map(here);
        let mut trial = JointFit::of(selection, found, &selection.floors[0]);
        selection.grow(&mut trial, None);
        if trial.standing(selection) > joint.standing(selection) {
            *joint = trial;
        }
    })
}

/// Starts from effects found on all readings, at most.
const LEADS: usize = 3;

/// Searches part of a session once more: from its own best effect, and from those found on all of it.
///
/// Which of the starts stands is for these readings alone to say; the further ones only spare the exchange of effects.
/// Families that were far from the best one at every step on all readings are left out.
pub fn search_part(
    resolutions: &Resolutions,
    floors: &Floors,
    families: &[CandidateFamily],
    (leads, contenders): (&[SelectedEffect], &[bool]),
) -> Search {
    let mut families = families.to_vec();
    let others = families.iter_mut().zip(contenders).filter(|(_, contends)| !**contends);
    others.for_each(|(family, _)| family.grid.clear());
    let families = &families;
    search_then(resolutions, floors, families, Limits::of_half(resolutions.fine.thresholds), |selection, joint| {
        let leads = (0..leads.len()).filter(|&index| rest_of(leads, index).is_none()).map(|index| &leads[index].chosen);
        for lead in leads.take(LEADS) {
            if !selection.goes_on() || joint.found.first().is_some_and(|first| first.chosen.family == lead.family) {
                continue;
            }
            let mut trial = JointFit::empty(selection);
            selection.grow_to_beat(joint.standing(selection), &mut trial, Some(lead.clone()));
            selection.replace(joint, trial, 0.0);
        }
    })
}

/// Grows a set of effects, best first, and lets `revise` look for better ones.
fn search_then(
    resolutions: &Resolutions,
    floors: &Floors,
    families: &[CandidateFamily],
    limits: Limits,
    revise: impl FnOnce(&SelectionContext, &mut JointFit),
) -> Search {
    if !resolutions.fine.has_sweeps() {
        return search_poses(resolutions.fine, families);
    }
    let whitened = |model, floor| Arc::new(WhitenedData::new(model, floor, &model.kept));
    let whitened = [whitened(resolutions.fine, &floors[0]), whitened(resolutions.coarse, &floors[1])];
    let selection = SelectionContext {
        resolutions,
        families,
        floors,
        limits,
        whitened,
        steps: Cell::new(0),
        balls_are_round: Cell::new(false),
        only_free: Cell::new(false),
        only_contenders: Cell::new(false),
        empty: OnceCell::new(),
        contenders: RefCell::new(vec![false; families.len()]),
    };
    let mut joint = JointFit::empty(&selection);
    let before_mm2 = mean_square(selection.resolutions.fine, &joint.residual_mm);
    selection.grow(&mut joint, None);
    revise(&selection, &mut joint);
    joint.finished(&selection, before_mm2)
}

/// Noise floors of both resolutions.
pub fn floors(resolutions: &Resolutions) -> Floors {
    [resolutions.fine, resolutions.coarse].map(|model| noise_floor(model, &model.residual_mm))
}

/// A search that was not made: nothing found.
pub fn nothing(model: &LinearModel, floor: &[NoiseModel]) -> Search {
    Search {
        noise_after: floor.to_vec(),
        floor: floor.to_vec(),
        found: Vec::new(),
        beside: Vec::new(),
        residual_before_mm2: mean_square(model, &model.residual_mm),
        residual_mm: model.residual_mm.clone(),
        other: None,
        contenders: Vec::new(),
        stated_misfit: 0.0,
    }
}
