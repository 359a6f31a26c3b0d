//! Which few effects the evidence demands: a set is grown, then exchanged for better ones. No words, no proof.

use crate::statistics::NoiseModel;
use std::cell::Cell;
use std::sync::Arc;

use super::candidates::Family;
use super::joint_fit::{Model, Start, mean_square, rest_of};
use super::limits::{HALF, Limits, SWEEPS};
use super::pose_search::search_poses;
use super::selected::{Floors, Found, Grounds, Search, Ways};
use crate::diagnose::model::linear_model::Ground;
use crate::diagnose::model::whitened::Whitened;
use crate::diagnose::noise::noise_floor::noise_floor;
use crate::identify::Fit;

/// Searches a session.
pub fn search(grounds: &Grounds, floors: &Floors, families: &[Family]) -> Search {
    search_unless(grounds, floors, families, |_| false)
}

/// Searches a session once gross readings are gone; `cleaner` gives the fit without those that what is found, mm left, lets
/// see. `Err` is that fit: all is to be done again with it.
pub(crate) fn search_cleanly(
    grounds: &Grounds,
    floors: &Floors,
    families: &[Family],
    cleaner: impl Fn(&[Vec<f64>]) -> Option<Fit>,
) -> Result<Search, Fit> {
    let mut cleaned = None;
    let hides = |left_mm: &[Vec<f64>]| {
        cleaned = cleaner(left_mm);
        cleaned.is_some()
    };
    let search = search_unless(grounds, floors, families, hides);
    if cleaned.is_none() && grounds.fine.has_sweeps() && !search.found.is_empty() {
        cleaned = cleaner(&search.residual_mm);
    }
    cleaned.map_or(Ok(search), Err)
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
