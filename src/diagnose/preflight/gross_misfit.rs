//! Which mistake explains a session that does not fit at all: wrong set-ups, files and columns judged by one likelihood. Smaller misfits are for `small_misfit`.
//!
//! Every mistake is undone and ranked by what the nominal machine then leaves; the best are refitted. With m the robust
//! misfit of a refit, `P ∝ w · m^(−ν)`: residuals of unknown size, ν of them independent, and w how usual the mistake is.

use crate::diagnose::cause::{LEAST_PROBABILITY, MOST_RIVALS};
use crate::diagnose::fault_kind::FaultKind;
use rayon::prelude::*;

use super::data_fault::{DataFault, SURE_OF_FAULT};
use super::doubts::exceeds;
use super::mistakes::suspicions;
use super::nearer::finer_place;
use super::places::axis_lines::other_lines;
use super::places::ball_places::{End, move_ball, placement};
use super::places::exchanged;
use super::places::misplaced::{misplaced, nearby};
use super::places::restated::other_directions;
use super::places::standing::standing_elsewhere;
use super::quick_fit::{MOST_STRAIN, Refit, nominal_mm, refit};
use super::small_misfit::{Misfit, Preflight, rows_repeat_to_um, toggled};
use super::suspicion::{Judged, OFTEN, Suspicion};
use crate::diagnose::model::decimate::{Sampled, few_rows};
use crate::identify::{FreePrior, Quantity};
use crate::session::{Session, Setups};

/// Mistakes that are refitted, beside the best of each kind.
const MOST_REFITTED: usize = 36;

/// Undoing a mistake lowers the misfit at least so many times: what is looked for here is enormous.
const LEAST_RATIO: f64 = 6.0;

/// Residual that is left once the mistake is undone, at most, as a share of the largest plausible location error: what a
/// working machine with faults of its own may leave.
const MOST_LEFT: f64 = 0.1;

/// Independent figures of a test: the offset of its trace, and one turn of it by sine and cosine.
const FIGURES_OF_A_TEST: f64 = 3.0;

/// Misfits below the resolution of a gauge say the same, µm.
const SAME_BELOW_UM: f64 = 0.1;

/// The mistake that best explains a session whose fit does not fit, or two where none does alone.
pub(crate) fn contest(session: &Session) -> Option<DataFault> {
    let contest = Contest::of(session)?;
    match contest.fault() {
        Some(fault) => Some(contest.with_another(fault, rows_repeat_to_um(session))),
        None => contest.two_at_once(),
    }
}

/// Mistakes that leave least alone, beside each of which another is looked for.
const FIRST_OF_TWO: usize = 3;

/// Mistakes undone one by one, the likeliest first.
struct Contest {
    /// Misfit as recorded, µm, and the largest offset of a ball or bar, in its spreads.
    before_um: f64,
    strain: f64,
    most_left_um: f64,
    judged: Vec<Settled>,
}

impl Contest {
    fn of(session: &Session) -> Option<Contest> {
        let thinned = few_rows(session);
        let sampled = Sampled { few_rows: &thinned, all_rows: session };
        let as_it_is = refit(&thinned, None)?;
        let mut judged: Vec<Settled> =
            ranked(sampled, &as_it_is).into_par_iter().filter_map(|(_, suspicion)| settled(suspicion)).collect();
        keep_each_place_once(&mut judged);
        turn_round(&mut judged, sampled);
        bring_standing_axes_nearer(&mut judged, &thinned);
        let freedom = FIGURES_OF_A_TEST * session.tests.len() as f64;
        let least = judged.iter().map(|one| one.left_um).fold(f64::INFINITY, f64::min).max(SAME_BELOW_UM);
        for one in &mut judged {
            one.weight *= (one.left_um.max(SAME_BELOW_UM) / least).powf(-freedom);
        }
        judged.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        let most_left_um = 1e3 * MOST_LEFT * FreePrior::of(&session.machine).length_mm;
        Some(Contest { before_um: as_it_is.misfit_um, strain: as_it_is.strain, most_left_um, judged })
    }

    /// Whether undoing the likeliest explains the session.
    fn is_explained(&self) -> bool {
        let Some(Settled { left_um, strain, .. }) = self.judged.first() else { return false };
        // what a fit takes up by balls far from their places is no larger residual, but no smaller mistake
        let is_released = self.strain > MOST_STRAIN && *strain < MOST_STRAIN && *left_um <= self.before_um;
        (self.before_um > LEAST_RATIO * left_um || is_released) && *left_um < self.most_left_um
    }

    /// The likeliest mistake with its rivals, where it explains the session.
    fn fault(&self) -> Option<DataFault> {
        let all: f64 = self.judged.iter().map(|one| one.weight).sum();
        let (best, others) = self.judged.split_first().filter(|_| self.is_explained())?;
        let share = |weight: f64| SURE_OF_FAULT * weight / all;
        let rivals = others
            .iter()
            .map(|other| (share(other.weight), &other.suspicion))
            .take_while(|(probability, _)| *probability > LEAST_PROBABILITY)
            .filter(|(_, other)| other.guess() != best.suspicion.guess())
            .take(MOST_RIVALS)
            .map(|(probability, other)| other.clone().rival(probability))
            .collect();
        let fault = best.suspicion.clone().fault(self.before_um, best.left_um);
        Some(DataFault { probability: share(best.weight), rivals, ..fault })
    }

    /// Two mistakes that explain the session together, where none does alone: of those that leave least alone, the one beside which another
    /// explains what is left, and leaves least.
    fn two_at_once(&self) -> Option<DataFault> {
        let both = self.judged.iter().take(FIRST_OF_TWO).filter_map(|first| {
            let second = Contest::of(&first.suspicion.undone)?.fault()?;
            (self.before_um > LEAST_RATIO * second.after_um).then_some((&first.suspicion, second))
        });
        let (first, second) = both.min_by(|(_, one), (_, other)| one.after_um.total_cmp(&other.after_um))?;
        Some(at_once(first.clone().fault(self.before_um, second.before_um), second))
    }

    /// The likeliest mistake with another one beside it, where it leaves more than readings repeat to and undoing the other lowers that as
    /// many times; else with a word that something is beside it.
    fn with_another(&self, fault: DataFault, repeats_um: f64) -> DataFault {
        let Some(best) = self.judged.first().filter(|best| exceeds(best.left_um, repeats_um)) else { return fault };
        let beside = Preflight::of(&best.suspicion.undone).mistakes(Misfit::BEYOND_ALL).into_iter();
        let second = beside.map(|mistake| mistake.fault).find(|other| other.before_um > LEAST_RATIO * other.after_um);
        match second {
            Some(second) => at_once(fault, second),
            None => {
                let says = format!(
                    "{}; that leaves {:.1} µm where readings repeat to {repeats_um:.1} µm: something else is beside it, so look again \
                     once it is mended",
                    fault.says, best.left_um
                );
                DataFault { says, ..fault }
            }
        }
    }
}

/// Two mistakes told as one.
fn at_once(first: DataFault, second: DataFault) -> DataFault {
    let is_of_all = first.tests.is_empty() || second.tests.is_empty();
    DataFault {
        says: format!("two mistakes at once: {}; and {}", first.says, second.says),
        components: [first.components, second.components].concat(),
        tests: if is_of_all { Vec::new() } else { [first.tests, second.tests].concat() },
        after_um: second.after_um,
        probability: first.probability * second.probability,
        rivals: first.rivals.into_iter().chain(second.rivals).take(MOST_RIVALS).collect(),
        ..first
    }
}

/// Mistakes by what the nominal machine leaves of the session without them: those that are worth a refit.
fn ranked(sampled: Sampled<'_>, as_it_is: &Refit) -> Vec<(f64, Suspicion)> {
    let thinned = sampled.few_rows;
    let mut list = misplaced(thinned);
    // a fit says where a ball is finer than nominal lengths do, unless it does not find there
    list.extend(nearby(thinned));
    list.extend(standing_elsewhere(thinned));
    list.extend(other_lines(thinned, as_it_is));
    list.extend(other_directions(thinned));
    list.extend(exchanged::by_nominal(thinned));
    list.extend(suspicions(sampled, as_it_is));
    let mut ranked: Vec<(f64, Suspicion)> = list
        .into_par_iter()
        .filter_map(|suspicion| nominal_mm(&suspicion.undone).map(|misfit| (suspicion.diminished * misfit, suspicion)))
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    // of mistakes that guess the same, sizes rounded, the one that leaves least is tried
    let mut guessed = std::collections::HashSet::new();
    ranked.retain(|(_, suspicion)| guessed.insert(suspicion.guess()));
    // nominal lengths tell places of one kind from each other, and little of one kind beside another: the best of each is refitted
    let (mut place, mut kinds) = (0, std::collections::HashSet::new());
    ranked.retain(|(_, suspicion)| {
        place += 1;
        let is_best_of_its_kind = kinds.insert((suspicion.kind, suspicion.components.clone()));
        place <= MOST_REFITTED || is_best_of_its_kind
    });
    ranked
}

/// Of mistakes that put one ball nearly alike, the one that leaves least; of those that leave nearly as little, one that a person makes at once.
fn keep_each_place_once(judged: &mut Vec<Settled>) {
    let rank = |one: &Settled| if one.suspicion.weight >= OFTEN { one.left_um / LEAST_GAIN } else { one.left_um };
    judged.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    let mut kept: Vec<Settled> = Vec::new();
    for one in judged.drain(..) {
        if !kept.iter().any(|other| other.suspicion.puts_a_ball_as(&one.suspicion)) {
            kept.push(one);
        }
    }
    *judged = kept;
}

/// Axes that stood elsewhere are brought nearer to where they did than the nominal machine tells: so many that leave least, where
/// that lowers what they leave so many times. What a fit takes up tells no place.
const STANDING_AXES_BROUGHT_NEARER: usize = 3;
const LEAST_GAIN: f64 = 1.1;

fn bring_standing_axes_nearer(judged: &mut [Settled], thinned: &Session) {
    let misfit_um = |undone: &Session| refit(undone, None).map(|refit| refit.misfit_um);
    let mut stood: Vec<usize> =
        (0..judged.len()).filter(|&k| judged[k].suspicion.kind == FaultKind::StandingAxis).collect();
    stood.sort_by(|&a, &b| judged[a].left_um.total_cmp(&judged[b].left_um));
    stood.truncate(STANDING_AXES_BROUGHT_NEARER);
    for k in stood {
        let left_um = judged[k].left_um;
        let nearer = finer_place(thinned, misfit_um, (left_um, &judged[k].suspicion));
        let nearer = nearer.filter(|nearer| LEAST_GAIN * nearer.left_um < left_um);
        if let Some(nearer) = nearer.and_then(|nearer| settled(nearer.suspicion)) {
            judged[k] = nearer;
        }
    }
}

/// Refits of a ball that was moved: the nominal machine puts it a tenth of a millimetre off.
const REFITS_OF_A_BALL: usize = 2;

/// Brings the best choice of recordings that are written from the wrong end, by axis, to where turning one more or one less
/// gains nothing.
fn turn_round(judged: &mut Vec<Settled>, sampled: Sampled<'_>) {
    let misfit_um = |undone: &Session| refit(undone, None).map(|refit| refit.misfit_um);
    for axis in &sampled.all_rows.machine.axes {
        let of_axis = |one: &Settled| {
            one.suspicion.kind == FaultKind::AngleReversed && one.suspicion.components == [&axis.name[..]]
        };
        let best = (0..judged.len())
            .filter(|&k| of_axis(&judged[k]))
            .min_by(|&a, &b| judged[a].left_um.total_cmp(&judged[b].left_um));
        if let Some(best) = best {
            let one = judged.swap_remove(best);
            let one = Judged { left_um: one.left_um, suspicion: one.suspicion };
            judged.extend(settled(toggled(sampled, misfit_um, one).suspicion));
        }
    }
}

/// A mistake with what undoing it leaves.
struct Settled {
    /// Misfit, µm.
    left_um: f64,
    /// Largest offset of a ball or bar, in its spreads.
    strain: f64,
    weight: f64,
    suspicion: Suspicion,
}

/// A mistake undone and refitted; a ball that was moved stands where the refit puts it.
fn settled(mut suspicion: Suspicion) -> Option<Settled> {
    let mut refitted = refit(&suspicion.undone, None)?;
    if [FaultKind::BallPlace, FaultKind::BarOther].contains(&suspicion.kind) {
        for _ in 0..REFITS_OF_A_BALL {
            move_balls(&mut suspicion, &refitted);
            refitted = refit(&suspicion.undone, None)?;
        }
    }
    let left_um = suspicion.diminished * refitted.misfit_um;
    Some(Settled { left_um, strain: refitted.strain, weight: suspicion.weight, suspicion })
}

/// Moves what the mistake concerns to where a refit puts it.
fn move_balls(suspicion: &mut Suspicion, refitted: &Refit) {
    let session = &suspicion.undone;
    let setups = Setups::of(session);
    let mut moved = session.clone();
    let concerns = |name: &String| suspicion.tests.is_empty() || suspicion.tests.contains(name);
    for (index, test) in moved.tests.iter_mut().enumerate().filter(|(_, test)| concerns(&test.name)) {
        for (end, of) in [(End::Pivot, &setups.pivot_of), (End::Spindle, &setups.spindle_ball_of)] {
            if suspicion.place == end.place() {
                move_ball(end.of_mut(test), &placement(refitted, end, of[index]));
            }
        }
        for (unknown, value) in refitted.unknowns.iter().zip(&refitted.values) {
            let own = matches!(unknown.quantity, Quantity::Bar { setup } if setups.bar_of[index] == Some(setup));
            if suspicion.kind == FaultKind::BarOther && own {
                test.bar_error_mm += value;
            }
        }
    }
    suspicion.undone = moved;
}
