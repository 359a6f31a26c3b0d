//! Which few effects the evidence demands: a set is grown, then exchanged for better ones. No words, no proof.

use std::cell::Cell;
use std::sync::Arc;

use super::floor::noise_floor;
use super::found::{Floors, Found, Grounds, Search, Ways};
use super::ground::Ground;
use super::library::Family;
use super::limits::{HALF, Limits, SWEEPS};
use super::model::{Model, Start, mean_square, rest_of};
use super::pose_search::search_poses;
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
