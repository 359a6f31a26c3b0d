//! Mistakes in the files before any physics: a sign, a name, a unit, an order, a time that does not belong. It repairs nothing.
//!
//! A session is refitted as if one mistake had been made, on few rows. A mistake is named when undoing it lowers the
//! misfit many times over, far below what any physics of the catalogue could do at that size of residual; what gains less is
//! held against physics (`mistake_or_effect`).

use crate::diagnose::cause::MOST_RIVALS;
use crate::diagnose::fault_kind::FaultKind;
use crate::statistics::{independent_share, median, noise_of_rows, rms};

use rayon::prelude::*;
use std::cell::OnceCell;
use std::collections::BTreeMap;

use super::axis_columns::from_other_end;
use super::contradictions::agrees_with_sweep;
use super::data_fault::{DataFault, RECORDER, Rival};
use super::doubts::exceeds;
use super::late_clock::shift_in_words;
use super::mistakes::{suspicions, worst_tests};
use super::nearer::{bring_nearer, first_position};
use super::places::axis_lines::fitted_lines;
use super::places::exchanged::repeats;
use super::places::misplaced::nearby;
use super::places::restated::restated;
use super::places::standing::column_off;
use super::quick_fit::{MOST_STRAIN, Refit, refit, refit_up_to};
use super::readings::scaled::{least_zero_mm, log_of_any_size, own_zero_mm};
use super::readings::steps::step_of_readings;
use super::suspicion::{Judged, Suspicion, Tried};
use crate::diagnose::model::decimate::{Sampled, few_rows};
use crate::session::{Path, Session, Test};
use crate::units::OtherUnit;

/// Undoing a mistake lowers the residual at least so many times: one that lies below so many noise floors needs no preflight.
const LEAST_RATIO: f64 = 1.6;

/// Undoing a mistake leaves at most so many noise floors, or lowers the residual so many times.
const NEAR_NOISE: f64 = 1.6;

const ENORMOUS_RATIO: f64 = 6.0;

/// Undoing a mistake lowers the residual at least so many times, or the readings with it undone are not searched for physics.
const LEAST_RATIO_FOR_A_SEARCH: f64 = 1.2;

/// What first steps of a fit leave with a mistake undone, over what is left as recorded, beyond which it is none.
const HOPELESS: f64 = 3.0;

/// Share of readings left out as outliers that is suspicious by itself.
const SUSPICIOUS_SHARE: f64 = 0.02;

/// What a fit leaves of a session, by which a mistake is looked for or not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Misfit {
    /// Rms residual and noise floor, µm.
    pub(crate) residual_um: f64,
    pub(crate) noise_um: f64,
    /// Share of readings left out as gross.
    pub(crate) left_out_share: f64,
    /// Largest offset of a ball or bar, in units of its spread.
    pub(crate) strain: f64,
}

impl Misfit {
    /// Of recordings that cannot be fitted.
    pub(crate) const BEYOND_ALL: Misfit =
        Misfit { residual_um: f64::INFINITY, noise_um: 0.0, left_out_share: 1.0, strain: f64::INFINITY };
}

/// A mistake, with the few rows of the session as they would be without it.
pub(crate) struct Mistake {
    pub(crate) fault: DataFault,
    pub(crate) undone: Session,
    /// Log prior against no mistake: the weight of its kind over that of all mistakes tried, less what fitted figures cost, plus
    /// n·ln(1/d) where undoing it divides n readings by 1/d.
    pub(crate) log_odds: f64,
    /// It leaves little more than noise, or gains enormously.
    pub(crate) is_plain: bool,
    /// A ball was put where the readings want it.
    pub(crate) is_found_place: bool,
    /// Figures were fitted to the readings, which take up much.
    has_figures: bool,
}

impl Mistake {
    /// Whether effects may explain what this mistake does: as it looks like one, has figures, gains no more than physics may, or
    /// others do as much, which happens where few tests let anything explain them.
    pub(crate) fn may_be_physics(&self) -> bool {
        let gains_little = self.fault.before_um < ENORMOUS_RATIO * self.fault.after_um;
        gains_little || self.has_figures || !self.fault.rivals.is_empty() || self.fault.looks_like_an_effect()
    }

    /// Whether undoing it leaves no more than something else does, µm, nearly.
    pub(crate) fn leaves_as_little(&self, left_um: f64) -> bool {
        self.fault.after_um < NEARLY_SAME_RATIO * left_um
    }
}

/// The mistakes of a session, looked for once however often it is asked.
pub(crate) struct Preflight<'s> {
    session: &'s Session,
    suspected: OnceCell<Vec<Suspected>>,
}

/// A mistake that is likely in a session, whatever its noise.
struct Suspected {
    best: Suspicion,
    rivals: Vec<Rival>,
    /// Misfit as recorded and undone, µm.
    before_um: f64,
    after_um: f64,
    /// Log odds before any reading.
    log_odds: f64,
}

impl<'s> Preflight<'s> {
    pub(crate) fn of(session: &'s Session) -> Preflight<'s> {
        Preflight { session, suspected: OnceCell::new() }
    }

    /// The mistakes that explain the session, if any does: the one that leaves least, and a file that does not belong to it where that
    /// leaves no more.
    pub(crate) fn mistakes(&self, misfit: Misfit) -> Vec<Mistake> {
        let Misfit { residual_um, noise_um, left_out_share, strain } = misfit;
        let session = self.session;
        let is_noise =
            residual_um < LEAST_RATIO_FOR_A_SEARCH * noise_um && !exceeds(residual_um, rows_repeat_to_um(session));
        // what lacks digits may have been cut to those it has, which is little beside noise and yet looks like an effect
        let has_all_digits = step_of_readings(session).is_none();
        if is_noise && has_all_digits && left_out_share < SUSPICIOUS_SHARE && strain < MOST_STRAIN {
            return Vec::new();
        }
        let suspected = self.suspected.get_or_init(|| suspected(session)).iter();
        suspected.filter_map(|suspected| suspected.mistake(noise_um)).collect()
    }
}

impl Suspected {
    /// As a mistake, where undoing it gains enough.
    fn mistake(&self, noise_um: f64) -> Option<Mistake> {
        let Suspected { best, rivals, before_um, after_um, log_odds } = self;
        let (before, after) = (*before_um, *after_um);
        let is_near_noise = after < NEAR_NOISE * noise_um;
        let is_plain = (before > LEAST_RATIO * after && is_near_noise) || before > ENORMOUS_RATIO * after;
        // the digits speak for a cut by themselves; how much it gains the likelihood says
        let is_shown = best.kind == FaultKind::ValuesRounded && before > after;
        (is_shown || before > LEAST_RATIO_FOR_A_SEARCH * after).then(|| {
            let is_found_place = best.kind == FaultKind::BallPlace && best.is_found;
            let (undone, has_figures) = (best.undone.clone(), best.log_figures != 0.0);
            let fault = DataFault { rivals: rivals.clone(), ..best.clone().fault(before, after) };
            let fault = fault.shared_evenly().less_what_it_leaves(noise_um);
            Mistake { fault, undone, log_odds: *log_odds, is_plain, is_found_place, has_figures }
        })
    }
}

/// The mistake that leaves least of a session, with those that leave as little, and a file of another session beside it.
fn suspected(session: &Session) -> Vec<Suspected> {
    let thinned = few_rows(session);
    let as_it_is = refit(&thinned, None).and_then(|first| refit(&thinned, Some(&first.values)));
    let Some(as_it_is) = as_it_is else { return Vec::new() };
    let misfit_um = |undone: &Session| refit(undone, Some(&as_it_is.values)).map(|refit| refit.misfit_um);
    let sampled = Sampled { few_rows: &thinned, all_rows: session };
    let mut suspicions = suspicions(sampled, &as_it_is);
    let worst = worst_tests(&as_it_is.residual_mm);
    suspicions.extend(restated(&thinned, &worst));
    suspicions.extend(nearby(&thinned));
    suspicions.extend(fitted_lines(&thinned, &as_it_is));
    suspicions.retain(|suspicion| !contradicts_a_sweep(session, suspicion));
    let tried = Tried::of(&suspicions);
    let mut judged: Vec<Judged> = suspicions
        .into_par_iter()
        .filter_map(|suspicion| {
            let refit = refit_up_to(&suspicion.undone, Some(&as_it_is.values), HOPELESS * as_it_is.misfit_um)?;
            let is_one = suspicion.kind != FaultKind::ReadingZero
                || own_zero_mm(&refit, &suspicion) > least_zero_mm(&thinned, &suspicion);
            is_one.then_some(Judged { left_um: suspicion.diminished * refit.misfit_um, suspicion })
        })
        .collect();
    bring_nearer(sampled, misfit_um, &mut judged);
    let rows = independent_readings(&thinned, &as_it_is, &judged);
    judged.sort_by(|a, b| a.weighed_um(rows).total_cmp(&b.weighed_um(rows)));
    let foreign = judged.extract_if(.., |one| one.suspicion.kind == FaultKind::ForeignFile).collect();
    let foreign = likeliest(foreign, rows).map(|(best, _)| best);
    let Some((best, others)) = likeliest(judged, rows) else { return Vec::new() };
    let best = widened(&thinned, misfit_um, best);
    let best = toggled(sampled, misfit_um, best);
    let with_odds = |Judged { left_um: after_um, suspicion: best }: Judged, alike: Vec<Judged>| {
        // which of them was made nothing tells: together they are as likely as all of them, on the same columns and tests once
        let guessed = |one: &Suspicion| (one.kind, one.components.clone(), one.tests.clone());
        let ways = std::iter::once(&best).chain(alike.iter().map(|one| &one.suspicion));
        let priors: BTreeMap<_, f64> = ways.rev().map(|one| (guessed(one), tried.log_prior(one).exp())).collect();
        let log_prior = priors.values().sum::<f64>().ln();
        let rivals = rivals(&best, alike.into_iter());
        let readings = readings(&best.undone);
        let figure = match best.kind {
            // a zero may lie anywhere in the stroke
            FaultKind::ReadingZero => refit(&best.undone, Some(&as_it_is.values))
                .map_or(0.0, |refit| log_of_any_size(own_zero_mm(&refit, &best))),
            // counted where it is held against physics
            FaultKind::BallPlace if best.is_found => 0.0,
            FaultKind::MountedAnew => 0.0,
            _ => best.log_cost(),
        };
        let log_odds = log_prior + figure - readings as f64 * best.diminished.ln();
        Suspected { best, rivals, before_um: as_it_is.misfit_um, after_um, log_odds }
    };
    let alike_um = (1.0 + SAME_MISFIT_SHARE) * best.weighed_um(rows);
    let alike: Vec<Judged> = others.into_iter().filter(|other| other.weighed_um(rows) < alike_um).collect();
    let best_um = best.weighed_um(rows);
    let foreign = foreign.filter(|foreign| foreign.weighed_um(rows) < NEARLY_SAME_RATIO * best_um);
    let is_far_better = foreign.as_ref().is_some_and(|foreign| FOREIGN_GAIN * foreign.weighed_um(rows) < best_um);
    let foreign = foreign.map(|foreign| with_odds(foreign, Vec::new()));
    let best = (!is_far_better).then(|| with_odds(best, alike));
    best.into_iter().chain(foreign).collect()
}

/// Readings of a session that count as independent, by what the mistake that leaves least leaves of them: noise that wanders is followed by
/// whatever has a figure in every run.
fn independent_readings(thinned: &Session, as_it_is: &Refit, judged: &[Judged]) -> f64 {
    let least = judged.iter().min_by(|one, other| one.left_um.total_cmp(&other.left_um));
    let refitted = least.and_then(|least| refit(&least.suspicion.undone, Some(&as_it_is.values)));
    let share = refitted.map_or(1.0, |refitted| independent_share(&refitted.residual_mm));
    share * readings(thinned) as f64
}

/// Rows of all recordings.
fn readings(session: &Session) -> usize {
    let recordings = session.tests.iter().filter_map(|test| test.recording.as_ref());
    recordings.map(|recording| recording.length_mm.len()).sum()
}

/// Noise of readings from row to row, µm: of the middle recording.
pub(crate) fn rows_repeat_to_um(session: &Session) -> f64 {
    let recordings = session.tests.iter().filter_map(|test| test.recording.as_ref());
    let noise_mm =
        recordings.filter(|recording| recording.is_run()).map(|recording| noise_of_rows(&recording.length_mm));
    median(noise_mm).map_or(f64::INFINITY, |noise_mm| 1e3 * noise_mm)
}

/// Whether a column would be off, or turned round, in a recording that lies where the session states its sweep.
fn contradicts_a_sweep(session: &Session, suspicion: &Suspicion) -> bool {
    let is_of_positions = [FaultKind::ColumnShifted, FaultKind::AngleReversed].contains(&suspicion.kind);
    let struck = session.tests.iter().filter(|test| suspicion.tests.contains(&test.name));
    let axis = suspicion.components.first().and_then(|name| session.machine.axis_index(name));
    let is_swept = |test: &Test| matches!(test.path, Some(Path::Sweep { axis: swept, .. }) if Some(swept) == axis);
    is_of_positions && struck.into_iter().any(|test| is_swept(test) && agrees_with_sweep(session, test))
}

/// A test with balls of its own follows nearly any mistake in its one recording: it must leave so many times less than these.
const FOREIGN_GAIN: f64 = 1.5;

/// Misfits by different rows and weights that differ by less, as a ratio, say the same.
const NEARLY_SAME_RATIO: f64 = 1.1;

/// Residuals that differ by less, as a share, say the same.
const SAME_MISFIT_SHARE: f64 = 0.02;

/// The mistake that leaves least, with the others: of those that leave the same, a column written from the wrong end,
/// which happens as files are put together, comes before a sign that is wrong in some recordings only, and what needs no fitted figure
/// before what does.
fn likeliest(mut judged: Vec<Judged>, rows: f64) -> Option<(Judged, Vec<Judged>)> {
    let first = judged.first()?;
    let is_partial_sign = first.suspicion.kind == FaultKind::AxisSign && !first.suspicion.tests.is_empty();
    let alike_um = (1.0 + SAME_MISFIT_SHARE) * first.weighed_um(rows);
    let is_alike = |one: &Judged| one.weighed_um(rows) < alike_um;
    let turned = judged.iter().position(|one| is_alike(one) && one.suspicion.kind == FaultKind::AngleReversed);
    let log_cost = |judged: &Judged| judged.suspicion.log_cost();
    let fewest_figures =
        judged.iter().take_while(|one| is_alike(one)).enumerate().max_by(|(place, one), (other, another)| {
            log_cost(one).total_cmp(&log_cost(another)).then(other.cmp(place))
        });
    let fewest_figures = fewest_figures.map_or(0, |(place, _)| place);
    let best = judged.remove(turned.filter(|_| is_partial_sign).unwrap_or(fewest_figures));
    Some((best, judged))
}

/// Rivals of a mistake, each kind on the same columns once, or once for each of several tests that have none in common.
fn rivals(best: &Suspicion, alike: impl Iterator<Item = Judged>) -> Vec<Rival> {
    let mut rivals: Vec<Suspicion> = Vec::new();
    for Judged { suspicion: other, .. } in alike {
        let says_as_much = |one: &Suspicion| {
            let has_common = one.tests.is_empty() || one.tests.iter().any(|test| other.tests.contains(test));
            (one.kind, &one.components) == (other.kind, &other.components) && (has_common || other.tests.is_empty())
        };
        if !says_as_much(best) && !rivals.iter().any(says_as_much) && rivals.len() < MOST_RIVALS {
            rivals.push(other);
        }
    }
    rivals.into_iter().map(|rival| rival.rival(0.0)).collect()
}

/// The mistake in a session whose recordings cannot be true as they stand; `None` when undoing none of those known makes them so.
pub fn implausible(session: &Session) -> Option<DataFault> {
    unit_of_lengths(session).or_else(|| {
        let mistakes = Preflight::of(session).mistakes(Misfit::BEYOND_ALL);
        mistakes.into_iter().next().map(|mistake| mistake.fault)
    })
}

/// Units in which lengths may have been written.
const LENGTH_UNITS: [OtherUnit; 4] =
    [OtherUnit::METRES, OtherUnit::INCHES, OtherUnit::CENTIMETRES, OtherUnit::MICROMETRES];

/// How far the middle of a recording may lie from the bar's length, as a share of it.
const NEAR_THE_BAR: f64 = 0.05;

/// Lengths in another unit than mm: every recording with a bar says the same factor.
fn unit_of_lengths(session: &Session) -> Option<DataFault> {
    let middles: Vec<(f64, f64)> = session
        .tests
        .iter()
        .filter_map(|test| {
            let lengths = test.recording.as_ref()?.length_mm.iter().copied();
            Some((median(lengths)?, test.bar_length_mm?))
        })
        .collect();
    let fits = |factor: f64| {
        !middles.is_empty() && middles.iter().all(|(middle, bar)| (middle * factor - bar).abs() < NEAR_THE_BAR * bar)
    };
    let OtherUnit { name: unit, size: factor } = LENGTH_UNITS.into_iter().find(|unit| fits(unit.size))?;
    let off_um = |factor: f64| 1e3 * rms(middles.iter().map(|(middle, bar)| middle * factor - bar));
    let says = format!("lengths are in {unit}: convert the column length_mm to mm");
    Some(DataFault {
        components: vec!["length".into()],
        before_um: off_um(1.0),
        after_um: off_um(factor),
        ..DataFault::seen(FaultKind::Unit, RECORDER, Vec::new(), says)
    })
}

/// A column that is off in some tests, with the other programs in which it is off by as much: those that leave less so.
fn widened(thinned: &Session, misfit_um: impl Fn(&Session) -> Option<f64> + Sync, mut best: Judged) -> Judged {
    let axis = best.suspicion.components.first().and_then(|name| thinned.machine.axis_index(name));
    let (Some(axis), FaultKind::ColumnShifted) = (axis, best.suspicion.kind) else { return best };
    let mut struck: Vec<usize> =
        (0..thinned.tests.len()).filter(|&test| best.suspicion.tests.contains(&thinned.tests[test].name)).collect();
    let Some(&first) = struck.first() else { return best };
    let at = |session: &Session| first_position(session, first, axis).unwrap_or(0.0);
    let shift = at(&best.suspicion.undone) - at(thinned);
    for other in 0..thinned.tests.len() {
        if struck.contains(&other) {
            continue;
        }
        let more: Vec<usize> = struck.iter().copied().chain(repeats(thinned, other)).collect();
        let wider = column_off(thinned, axis, &more, shift)
            .and_then(|wider| Some(Judged { left_um: misfit_um(&wider.undone)?, suspicion: wider }))
            .filter(|wider| wider.left_um < (1.0 - TOGGLE_GAIN) * best.left_um);
        if let Some(wider) = wider {
            (best, struck) = (wider, more);
        }
    }
    best
}

/// Share by which turning one recording more, or one less, must lower the residual.
const TOGGLE_GAIN: f64 = 0.02;

/// Reversed recordings found one by one: whichever of them turned, or turned back, leaves less is so.
pub(crate) fn toggled(sampled: Sampled<'_>, misfit_um: impl Fn(&Session) -> Option<f64>, mut judged: Judged) -> Judged {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let Judged { left_um, suspicion } = &mut judged;
    if suspicion.kind != FaultKind::AngleReversed {
        return judged;
    }
    let Some(axis) = session.machine.axes.iter().position(|axis| suspicion.components.contains(&axis.name)) else {
        return judged;
    };
    for _ in 0..2 {
        let before = *left_um;
        for (index, test) in session.tests.iter().enumerate() {
            let Some(turned) = test.recording.as_ref().and_then(|recording| from_other_end(recording, axis)) else {
                continue;
            };
            let mut undone = suspicion.undone.clone();
            undone.tests[index].recording = match suspicion.tests.contains(&test.name) {
                true => thinned.tests[index].recording.clone(),
                false => Some(turned),
            };
            if let Some(less) = misfit_um(&undone).filter(|less| *less < (1.0 - TOGGLE_GAIN) * *left_um) {
                *left_um = less;
                suspicion.undone = undone;
                match suspicion.tests.iter().position(|name| *name == test.name) {
                    Some(place) => drop(suspicion.tests.remove(place)),
                    None => suspicion.tests.push(test.name.clone()),
                }
            }
        }
        if *left_um >= before {
            break;
        }
    }
    judged
}

/// Residual that a ball which slipped may leave, µm rms: a cup that was knocked by more comes off.
const OF_PHYSICS_UM: f64 = 30.0;

impl DataFault {
    /// The same, less sure the more it leaves beside noise, µm: what is left may be another mistake, or belong to one that is not known.
    pub(crate) fn less_what_it_leaves(self, noise_um: f64) -> DataFault {
        let is_known = noise_um > 0.0 && self.after_um.is_finite();
        let whole = if is_known { (NEAR_NOISE * noise_um / self.after_um).min(1.0).sqrt() } else { 1.0 };
        self.or_effect(whole, None)
    }

    /// Whether an effect says of some tests what this mistake does: a clock that is late in them, a ball that slipped where a zero
    /// moved, an axis stood elsewhere or balls were mounted anew, or balls of a program that stand elsewhere, as lost motion or growth
    /// looks in the tests that alone show it.
    fn looks_like_an_effect(&self) -> bool {
        let is_of_some = [FaultKind::TimeShift, FaultKind::ReadingZero].contains(&self.kind) && !self.tests.is_empty();
        let is_of_a_place =
            [FaultKind::StandingAxis, FaultKind::ColumnShifted, FaultKind::MountedAnew].contains(&self.kind);
        let may_be_a_slip = is_of_a_place && self.before_um < OF_PHYSICS_UM;
        is_of_some || may_be_a_slip || self.kind == FaultKind::ForeignFile
    }

    /// Positions that are `seconds` too old in some tests (none named: all), with the residual as recorded and undone, µm.
    pub fn time_shift(seconds: f64, tests: Vec<String>, before_um: f64, after_um: f64) -> DataFault {
        let says = shift_in_words(seconds, &tests);
        DataFault {
            before_um,
            after_um,
            shift_ms: Some(1e3 * seconds),
            ..DataFault::seen(FaultKind::TimeShift, RECORDER, tests, says)
        }
    }
}
