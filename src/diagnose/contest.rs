//! Which mistake explains a session that does not fit at all: wrong set-ups, files and columns judged by one likelihood. Smaller misfits are for `preflight`.
//!
//! Every mistake is undone and ranked by what the nominal machine then leaves; the best are refitted. With m the robust
//! misfit of a refit, `P ∝ w · m^(−ν)`: residuals of unknown size, ν of them independent, and w how usual the mistake is.

use rayon::prelude::*;

use super::data_fault::{DataFault, Rival, SURE_OF_FAULT};
use super::exchanged;
use super::misplaced::{AXIS_LINE, BALL_PLACE, misplaced};
use super::mistakes::{Suspicion, suspicions};
use super::naming::{LEAST_PROBABILITY, MOST_RIVALS};
use super::refit::{Refit, refit, robust_rms_mm};
use super::thin::few_rows;
use crate::chain::Chain;
use crate::identify::{self, FreePrior, Problem, Quantity, Weighting, normal_equations};
use crate::session::{Session, Setups};

/// Mistakes that are refitted.
const MOST_REFITTED: usize = 36;

/// Undoing a mistake lowers the misfit at least so many times: what is looked for here is enormous.
const LEAST_RATIO: f64 = 6.0;

/// Residual that is left once the mistake is undone, at most, as a share of the largest plausible location error: what a
/// working machine with faults of its own may leave.
const MOST_LEFT: f64 = 0.1;

/// Independent figures of a test: the offset of its trace, and one turn of it by sine and cosine.
const FIGURES_OF_A_TEST: f64 = 3.0;

/// Misfits below this say the same, µm: two explanations that leave less than a good machine does are both right.
const SAME_BELOW_UM: f64 = 1.0;

/// The mistake that best explains a session whose fit does not fit.
pub(super) fn contest(session: &Session) -> Option<DataFault> {
    let thinned = few_rows(session);
    let as_it_is = refit(&thinned, None)?;
    let before = as_it_is.misfit_um;
    let mut list = misplaced(&thinned, &as_it_is.values);
    list.extend(exchanged::by_nominal(&thinned));
    list.extend(suspicions(&thinned, session, &as_it_is.residual_mm));
    let mut told = std::collections::HashSet::new();
    list.retain(|suspicion| told.insert(suspicion.says.clone()));
    let mut ranked: Vec<(f64, Suspicion)> = list
        .into_par_iter()
        .filter_map(|suspicion| nominal_mm(&suspicion.undone).map(|misfit| (misfit, suspicion)))
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.truncate(MOST_REFITTED);
    let mut judged: Vec<(f64, f64, Suspicion)> = ranked
        .into_par_iter()
        .filter_map(|(_, suspicion)| settled(suspicion).map(|(left, suspicion)| (left, suspicion.weight, suspicion)))
        .collect();
    let freedom = FIGURES_OF_A_TEST * session.tests.len() as f64;
    let least = judged.iter().map(|(left, ..)| *left).fold(f64::INFINITY, f64::min).max(SAME_BELOW_UM);
    for (left, weight, _) in &mut judged {
        *weight *= (left.max(SAME_BELOW_UM) / least).powf(-freedom);
    }
    let all: f64 = judged.iter().map(|(_, weight, _)| weight).sum();
    judged.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut judged = judged.into_iter();
    let (after, weight, best) = judged.next()?;
    let most_left_um = 1e3 * MOST_LEFT * FreePrior::of(&session.machine).length_mm;
    if !(before > LEAST_RATIO * after && after < most_left_um) {
        return None;
    }
    let share = |weight: f64| SURE_OF_FAULT * weight / all;
    let rivals = judged
        .map(|(_, weight, other)| (share(weight), other))
        .take_while(|(probability, _)| *probability > LEAST_PROBABILITY)
        .filter(|(_, other)| other.says != best.says)
        .take(MOST_RIVALS)
        .map(|(probability, other)| Rival {
            effect: other.effect,
            place: other.place,
            components: other.components,
            says: other.says,
            probability,
        });
    Some(DataFault {
        components: best.components,
        before_um: before,
        after_um: after,
        shift_ms: best.shift_ms,
        probability: share(weight),
        rivals: rivals.collect(),
        ..DataFault::seen(best.effect, &best.place, best.tests, best.says)
    })
}

/// Robust residual of a session by its nominal machine, mm.
fn nominal_mm(session: &Session) -> Option<f64> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let problem = Problem::new(session, &chain, &setups, Vec::new()).ok()?;
    let residual_mm = normal_equations(&problem, &[], &Weighting::Huber { scale_mm: 1.0 }).1;
    Some(robust_rms_mm(&residual_mm))
}

/// Refits of a ball that was moved: the nominal machine puts it a tenth of a millimetre off.
const SETTLING: usize = 2;

/// A mistake undone and refitted, µm left; a ball that was moved stands where the refit puts it.
fn settled(mut suspicion: Suspicion) -> Option<(f64, Suspicion)> {
    let mut refitted = refit(&suspicion.undone, None)?;
    if [BALL_PLACE, "bar-other", "standing-axis", AXIS_LINE].contains(&suspicion.effect) {
        for _ in 0..SETTLING {
            move_balls(&mut suspicion, &refitted);
            refitted = refit(&suspicion.undone, None)?;
        }
    }
    Some((refitted.misfit_um, suspicion))
}

/// Moves what the mistake concerns to where a refit puts it.
fn move_balls(suspicion: &mut Suspicion, refitted: &Refit) {
    let session = &suspicion.undone;
    let setups = Setups::of(session);
    let free = identify::default_free(&session.machine);
    let unknowns = identify::unknowns(session, &setups, &free, FreePrior::of(&session.machine));
    let mut moved = session.clone();
    let concerns = |name: &String| suspicion.tests.is_empty() || suspicion.tests.contains(name);
    for (unknown, value) in unknowns.iter().zip(&refitted.values) {
        for (index, test) in moved.tests.iter_mut().enumerate().filter(|(_, test)| concerns(&test.name)) {
            match unknown.quantity {
                Quantity::Pivot { setup, coordinate }
                    if suspicion.place == "pivot" && setups.pivot_of[index] == setup =>
                {
                    test.pivot.at[coordinate] += value;
                }
                Quantity::SpindleBall { setup, coordinate }
                    if suspicion.place == "spindle-ball" && setups.spindle_ball_of[index] == setup =>
                {
                    let sign = test.spindle_ball.sign(coordinate);
                    test.spindle_ball.at[coordinate] += sign * value;
                }
                Quantity::Bar { setup } if suspicion.place == "bar" && setups.bar_of[index] == Some(setup) => {
                    test.bar_error_mm += value;
                }
                _ => {}
            }
        }
    }
    suspicion.undone = moved;
}
