//! Mistakes in the files before any physics: a sign, a name, a unit, an order, a time that does not belong. It repairs nothing.
//!
//! A session is refitted as if one mistake had been made, on few rows. A mistake is named when undoing it lowers the
//! misfit many times over, far below what any physics of the catalogue could do at that size of residual.

use rayon::prelude::*;

use super::thin::{few_rows, keep_few_rows};
use crate::chain::Chain;
use crate::identify::{self, FreePrior, Problem, Weighting, minimise, normal_equations, robust_sigma};
use crate::machine::AxisKind;
use crate::session::{Clock, Recording, Session, Setups};

/// A mistake in the files.
#[derive(Debug, Clone, PartialEq)]
pub struct DataFault {
    /// `axis-sign`, `axis-swap`, `unit`, `angle-reversed` or `time-shift`.
    pub effect: &'static str,
    /// Axes or columns concerned.
    pub components: Vec<String>,
    /// Tests concerned; empty: all.
    pub tests: Vec<String>,
    /// In words, with what to do.
    pub says: String,
    /// Robust residual as recorded and with the mistake undone, µm.
    pub before_um: f64,
    pub after_um: f64,
    /// Shift in ms for `time-shift`.
    pub shift_ms: Option<f64>,
}

/// A way in which the files may be wrong.
struct Suspicion {
    effect: &'static str,
    components: Vec<String>,
    tests: Vec<String>,
    says: String,
    shift_ms: Option<f64>,
    undone: Session,
}

/// Undoing a mistake lowers the residual at least so many times.
const LEAST_RATIO: f64 = 1.6;
/// Residuals below this many noise floors need no preflight.
const SUSPICIOUS: f64 = 1.8;
/// Undoing a mistake leaves at most so many noise floors, or lowers the residual so many times.
const NEAR_NOISE: f64 = 1.6;
const ENORMOUS: f64 = 6.0;
/// A ball that the fit puts so many spreads from its stated place is suspicious by itself.
const SUSPICIOUS_STRAIN: f64 = 8.0;
/// Share of readings left out as outliers that is suspicious by itself.
const SUSPICIOUS_SHARE: f64 = 0.02;

/// The mistake that best explains a session, if one does.
///
/// `strain` is the largest offset of a ball or bar in the fit, in units of its spread.
pub fn preflight(
    session: &Session,
    residual_um: f64,
    noise_um: f64,
    left_out_share: f64,
    strain: f64,
) -> Option<DataFault> {
    if residual_um < SUSPICIOUS * noise_um && left_out_share < SUSPICIOUS_SHARE && strain < SUSPICIOUS_STRAIN {
        return None;
    }
    let thinned = few_rows(session);
    let as_it_is = refit(&thinned, None)?;
    let before = as_it_is.misfit_um;
    let misfit_um = |undone: &Session| refit(undone, Some(&as_it_is.values)).map(|refit| refit.misfit_um);
    let suspicions = suspicions(&thinned, session, &as_it_is.residual_mm);
    let mut judged: Vec<(f64, Suspicion)> = suspicions
        .into_par_iter()
        .filter_map(|suspicion| misfit_um(&suspicion.undone).map(|misfit| (misfit, suspicion)))
        .collect();
    judged.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = finer((&thinned, session), misfit_um, judged.into_iter().next()?);
    let (after, best) = toggled(&thinned, misfit_um, best);
    if std::env::var_os("FIVEAXIS_TRACE").is_some() {
        eprintln!("preflight: {before:.2} µm as it is, {after:.2} µm with '{}'", best.says);
    }
    // physics can also be imitated by a mistake: undoing a real one leaves little more than noise, or gains enormously
    let undone = (before > LEAST_RATIO * after && after < NEAR_NOISE * noise_um) || before > ENORMOUS * after;
    undone.then_some(DataFault {
        effect: best.effect,
        components: best.components,
        tests: best.tests,
        says: best.says,
        before_um: before,
        after_um: after,
        shift_ms: best.shift_ms,
    })
}

/// The mistake in a session whose recordings cannot be true as they stand; `None` when undoing none of those known makes them so.
pub fn implausible(session: &Session) -> Option<DataFault> {
    unit_of_lengths(session).or_else(|| preflight(session, f64::INFINITY, 0.0, 1.0, f64::INFINITY))
}

/// Units in which lengths may have been written, with their size in mm.
const LENGTH_UNITS: [(&str, f64); 4] = [("metres", 1e3), ("inches", 25.4), ("centimetres", 10.0), ("µm", 1e-3)];
/// How far the middle of a recording may lie from the bar's length, as a share of it.
const NEAR_THE_BAR: f64 = 0.05;

/// Lengths in another unit than mm: every recording with a bar says the same factor.
fn unit_of_lengths(session: &Session) -> Option<DataFault> {
    let middles: Vec<(f64, f64)> = session
        .tests
        .iter()
        .filter_map(|test| {
            let mut lengths: Vec<f64> =
                test.recording.as_ref()?.length_mm.iter().copied().filter(|length| length.is_finite()).collect();
            lengths.sort_by(f64::total_cmp);
            Some((*lengths.get(lengths.len() / 2)?, test.bar_length_mm?))
        })
        .collect();
    let fits = |factor: f64| {
        !middles.is_empty() && middles.iter().all(|(middle, bar)| (middle * factor - bar).abs() < NEAR_THE_BAR * bar)
    };
    let (unit, factor) = LENGTH_UNITS.into_iter().find(|(_, factor)| fits(*factor))?;
    let off_um = |factor: f64| 1e3 * identify::rms(middles.iter().map(|(middle, bar)| middle * factor - bar));
    Some(DataFault {
        effect: "unit",
        components: vec!["length".into()],
        tests: Vec::new(),
        says: format!("lengths are in {unit}: convert the column length_mm to mm"),
        before_um: off_um(1.0),
        after_um: off_um(factor),
        shift_ms: None,
    })
}

/// Shifts beside the best one of the grid, as factors.
const FINER: [f64; 8] = [0.9, 0.93, 0.96, 0.985, 1.015, 1.04, 1.07, 1.1];

/// A time shift brought nearer to its true size than the grid; other mistakes have no size.
fn finer(
    (thinned, session): (&Session, &Session),
    misfit_um: impl Fn(&Session) -> Option<f64> + Sync,
    (misfit, suspicion): (f64, Suspicion),
) -> (f64, Suspicion) {
    let Some(shift_ms) = suspicion.shift_ms else { return (misfit, suspicion) };
    let struck: Vec<usize> = (0..session.tests.len())
        .filter(|&test| suspicion.tests.is_empty() || suspicion.tests.contains(&session.tests[test].name))
        .collect();
    let near: Vec<(f64, Suspicion)> = FINER
        .par_iter()
        .filter_map(|factor| {
            let nearer = shifted((thinned, session), &struck, factor * shift_ms / 1e3);
            misfit_um(&nearer.undone).map(|misfit| (misfit, nearer))
        })
        .collect();
    near.into_iter().fold((misfit, suspicion), |best, next| if next.0 < best.0 { next } else { best })
}

/// Share by which turning one recording more, or one less, must lower the residual.
const TOGGLE_GAIN: f64 = 0.02;

/// Reversed recordings found one by one: whichever of them turned, or turned back, leaves less is so.
fn toggled(
    session: &Session,
    misfit_um: impl Fn(&Session) -> Option<f64>,
    (mut misfit, mut suspicion): (f64, Suspicion),
) -> (f64, Suspicion) {
    if suspicion.effect != "angle-reversed" {
        return (misfit, suspicion);
    }
    let Some(axis) = session.machine.axes.iter().position(|axis| suspicion.components.contains(&axis.name)) else {
        return (misfit, suspicion);
    };
    for _ in 0..2 {
        let before = misfit;
        for (index, test) in session.tests.iter().enumerate() {
            if test.recording.as_ref().is_none_or(|recording| recording.axes != [axis]) {
                continue;
            }
            let mut undone = suspicion.undone.clone();
            if let Some(recording) = &mut undone.tests[index].recording {
                recording.positions[0].reverse();
            }
            if let Some(less) = misfit_um(&undone).filter(|less| *less < (1.0 - TOGGLE_GAIN) * misfit) {
                misfit = less;
                suspicion.undone = undone;
                match suspicion.tests.iter().position(|name| *name == test.name) {
                    Some(place) => drop(suspicion.tests.remove(place)),
                    None => suspicion.tests.push(test.name.clone()),
                }
            }
        }
        if misfit >= before {
            break;
        }
    }
    (misfit, suspicion)
}

/// Residuals beyond so many robust sigmas count no more: single gross readings must not hide what a mistake does.
const CLIPPED: f64 = 15.0;

/// Offsets of balls and bars up to this are no matter of a mistake, mm: a bar may be stated ten spreads off its length.
const LEAST_SPREAD_MM: f64 = 0.02;
/// Refits at a narrower robust scale, at most.
const REFITS: usize = 6;
/// A robust scale that falls by less than this share has settled.
const SETTLED: f64 = 0.7;

/// Largest offset of a ball or bar from its stated place, in its spreads as stated.
pub fn strain(problem: &Problem, values: &[f64], widened: f64) -> f64 {
    let setups = problem.unknowns.iter().zip(values).filter(|(unknown, _)| unknown.quantity.is_setup());
    setups
        .map(|(unknown, value)| (value / (unknown.prior_sigma / widened).max(LEAST_SPREAD_MM)).abs())
        .fold(0.0, f64::max)
}

/// A robust fit on few rows.
struct Refit {
    /// Rms residual, µm; every reading counts, but none for more than so many sigmas.
    misfit_um: f64,
    values: Vec<f64>,
    residual_mm: Vec<Vec<f64>>,
}

/// Fits a session robustly: from the prior means, or from `near` where that lies nearer.
fn refit(session: &Session, near: Option<&[f64]>) -> Option<Refit> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let free = identify::default_free(&session.machine);
    let unknowns = identify::unknowns(session, &setups, &free, FreePrior::of(&session.machine));
    let problem = Problem::new(session, &chain, &setups, unknowns).ok()?;
    let means = problem.unknowns.iter().map(|unknown| unknown.prior_mean).collect();
    let starts = near.filter(|near| near.len() == problem.unknowns.len()).map(<[f64]>::to_vec);
    let (mut scale, mut values) = [means]
        .into_iter()
        .chain(starts)
        .map(|values| {
            let residual_mm = normal_equations(&problem, &values, &Weighting::Huber { scale_mm: 1.0 }).1;
            (scale_of(&residual_mm), values)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut residual_mm = Vec::new();
    for _ in 0..REFITS {
        let solution = minimise(&problem, &values, &Weighting::Huber { scale_mm: scale });
        (values, residual_mm) = (solution.values, solution.residual_mm);
        let next = scale_of(&residual_mm);
        let settled = next > SETTLED * scale;
        scale = next;
        if settled {
            break;
        }
    }
    let limit = CLIPPED * scale;
    let clipped =
        residual_mm.iter().flatten().filter(|value| value.is_finite()).map(|value| value.clamp(-limit, limit));
    // offsets of balls far beyond their spreads are a misfit as well
    let strained = 1.0 + (strain(&problem, &values, 1.0) / 6.0 - 1.0).max(0.0);
    Some(Refit { misfit_um: 1e3 * identify::rms(clipped) * strained, values, residual_mm })
}

/// Robust scale of residuals, mm.
fn scale_of(residual_mm: &[Vec<f64>]) -> f64 {
    robust_sigma(residual_mm.iter().flatten().copied()).max(1e-4)
}

/// All mistakes that are tried on the thinned session; shifts in time are made on all rows, whose arcs are nearly straight.
fn suspicions(session: &Session, whole: &Session, residual_mm: &[Vec<f64>]) -> Vec<Suspicion> {
    let mut list = Vec::new();
    let machine = &session.machine;
    let busy: Vec<usize> = (0..machine.axes.len())
        .filter(|&axis| {
            session.tests.iter().any(|test| test.recording.as_ref().is_some_and(|r| r.axes.contains(&axis)))
        })
        .collect();
    for &axis in &busy {
        let name = machine.axes[axis].name.clone();
        let mut scaled = |effect: &'static str, factor: f64, says: String| {
            let undone = scale_axis(session, axis, factor);
            list.push(Suspicion {
                effect,
                components: vec![name.clone()],
                tests: Vec::new(),
                says,
                shift_ms: None,
                undone,
            });
        };
        scaled(
            "axis-sign",
            -1.0,
            format!("{name} is counted backwards: turn the sign of column {name}, or set 'reversed: true'"),
        );
        match machine.axes[axis].kind {
            AxisKind::Linear => scaled("unit", 25.4, format!("{name} is in inches: convert the column to mm")),
            AxisKind::Rotary => scaled(
                "unit",
                180.0 / std::f64::consts::PI,
                format!("{name} is in radians: convert the column to degrees"),
            ),
        }
        if machine.axes[axis].kind == AxisKind::Rotary {
            let alternate = [0, 1].map(|from| Struck::Alternate { from });
            for struck in [Struck::Seen { rising: true }, Struck::Seen { rising: false }].into_iter().chain(alternate) {
                list.extend(reversed(session, axis, struck));
            }
        }
    }
    for (index, &a) in busy.iter().enumerate() {
        for &b in &busy[index + 1..] {
            if machine.axes[a].kind == machine.axes[b].kind {
                list.push(swapped(session, a, b));
            }
        }
    }
    for seconds in SHIFTS_S {
        let every: Vec<usize> = (0..session.tests.len()).collect();
        list.push(shifted((session, whole), &every, *seconds));
    }
    // one test alone: only the worst ones are worth the refits
    for test in worst_tests(residual_mm) {
        for seconds in SHIFTS_S {
            list.push(shifted((session, whole), &[test], *seconds));
        }
        list.extend(columns_of_some(session, &[test]));
    }
    // recordings with the same columns come out of one conversion
    let moving = |test: usize| session.tests[test].recording.as_ref().map(|recording| &recording.axes);
    for first in 0..session.tests.len() {
        let alike: Vec<usize> = (0..session.tests.len()).filter(|&test| moving(test) == moving(first)).collect();
        if alike[0] == first && (2..session.tests.len()).contains(&alike.len()) {
            list.extend(columns_of_some(session, &alike));
        }
    }
    list
}

/// Signs and pairs of columns of some recordings that have the same ones.
fn columns_of_some(session: &Session, tests: &[usize]) -> Vec<Suspicion> {
    let names: Vec<String> = tests.iter().map(|&test| session.tests[test].name.clone()).collect();
    let name = names.join(", ");
    let Some(recording) = tests.first().and_then(|&test| session.tests[test].recording.as_ref()) else {
        return Vec::new();
    };
    let alone = |undone: Session| {
        let mut session = session.clone();
        tests.iter().for_each(|&test| session.tests[test] = undone.tests[test].clone());
        session
    };
    let mut list = Vec::new();
    for (index, &axis) in recording.axes.iter().enumerate() {
        let label = &session.machine.axes[axis].name;
        list.push(Suspicion {
            effect: "axis-sign",
            components: vec![label.clone()],
            tests: names.clone(),
            says: format!("{label} is counted backwards in {name}: turn the sign of column {label} there"),
            shift_ms: None,
            undone: alone(scale_axis(session, axis, -1.0)),
        });
        for &other in &recording.axes[index + 1..] {
            if session.machine.axes[axis].kind == session.machine.axes[other].kind {
                let swap = swapped(session, axis, other);
                let says = format!("in {name} {}", swap.says);
                list.push(Suspicion { says, tests: names.clone(), undone: alone(swap.undone), ..swap });
            }
        }
    }
    list
}

/// Shifts tried, s.
const SHIFTS_S: &[f64] =
    &[-3.0, -2.4, -1.9, -1.5, -1.2, -0.95, -0.75, -0.6, -0.45, 0.45, 0.6, 0.75, 0.95, 1.2, 1.5, 1.9, 2.4, 3.0];
/// Single tests tried for a shift.
const WORST_TESTS: usize = 3;

/// Tests with the largest residual in a common fit.
fn worst_tests(residual_mm: &[Vec<f64>]) -> Vec<usize> {
    let mut order: Vec<(usize, f64)> =
        residual_mm.iter().map(|residual| identify::rms(residual.iter().copied())).enumerate().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    order.into_iter().take(WORST_TESTS).map(|(test, _)| test).collect()
}

fn scale_axis(session: &Session, axis: usize, factor: f64) -> Session {
    let mut undone = session.clone();
    for test in &mut undone.tests {
        if let Some(value) = &mut test.positions[axis] {
            *value *= factor;
        }
        if let Some(recording) = &mut test.recording
            && let Some(column) = recording.axes.iter().position(|&other| other == axis)
        {
            recording.positions[column].iter_mut().for_each(|value| *value *= factor);
        }
    }
    undone
}

fn swapped(session: &Session, a: usize, b: usize) -> Suspicion {
    let mut undone = session.clone();
    let other = |axis: usize| {
        if axis == a {
            b
        } else if axis == b {
            a
        } else {
            axis
        }
    };
    for test in &mut undone.tests {
        test.positions.swap(a, b);
        if let Some(recording) = &mut test.recording {
            recording.axes.iter_mut().for_each(|axis| *axis = other(*axis));
        }
    }
    let (one, two) = (session.machine.axes[a].name.clone(), session.machine.axes[b].name.clone());
    Suspicion {
        effect: "axis-swap",
        says: format!("columns {one} and {two} are exchanged: swap their headers"),
        components: vec![one, two],
        tests: Vec::new(),
        shift_ms: None,
        undone,
    }
}

/// Recordings of an axis that may be written from the wrong end.
#[derive(Clone, Copy)]
enum Struck {
    /// Those that rise in the files, or fall.
    Seen { rising: bool },
    /// Every second one of the runs repeated in one setup, from the first or from the second on: there and back written alike.
    Alternate { from: usize },
}

/// Single sweeps of an axis, some of them turned round.
fn reversed(session: &Session, axis: usize, struck: Struck) -> Option<Suspicion> {
    let mut order: Vec<usize> = (0..session.tests.len()).collect();
    order.sort_by(|&a, &b| session.tests[a].started_at_s.total_cmp(&session.tests[b].started_at_s));
    let mut undone = session.clone();
    let mut runs: Vec<(usize, usize)> = Vec::new();
    let mut tests = Vec::new();
    for index in order {
        let Some(recording) = &session.tests[index].recording else { continue };
        if recording.axes != [axis] || !matches!(recording.clock, Clock::TimeS(_)) {
            continue;
        }
        let run = match runs.iter_mut().find(|(first, _)| is_repeat(session, *first, index)) {
            Some((_, run)) => {
                *run += 1;
                *run
            }
            None => {
                runs.push((index, 0));
                0
            }
        };
        let column = &recording.positions[0];
        let turned = match struck {
            Struck::Seen { rising } => (column.last() > column.first()) == rising,
            Struck::Alternate { from } => run % 2 == from,
        };
        if turned && let Some(recording) = &mut undone.tests[index].recording {
            recording.positions[0].reverse();
            tests.push(session.tests[index].name.clone());
        }
    }
    let name = session.machine.axes[axis].name.clone();
    (!tests.is_empty()).then(|| Suspicion {
        effect: "angle-reversed",
        says: format!("{name} of these recordings is written from the wrong end: reverse the column"),
        components: vec![name],
        tests,
        shift_ms: None,
        undone,
    })
}

/// Two tests with the same balls, bar and standing axes.
fn is_repeat(session: &Session, one: usize, other: usize) -> bool {
    let (one, other) = (&session.tests[one], &session.tests[other]);
    one.pivot == other.pivot
        && one.spindle_ball == other.spindle_ball
        && one.bar_length_mm == other.bar_length_mm
        && one.positions == other.positions
        && one.feed_mm_per_min == other.feed_mm_per_min
}

/// Positions moved against the lengths by some seconds in some tests of the thinned session.
fn shifted((thinned, session): (&Session, &Session), tests: &[usize], seconds: f64) -> Suspicion {
    let mut undone = thinned.clone();
    for &test in tests {
        undone.tests[test].recording = session.tests[test].recording.clone();
        if let Some(recording) = &mut undone.tests[test].recording {
            shift(recording, seconds);
            keep_few_rows(recording);
        }
    }
    let names: Vec<String> = if tests.len() == session.tests.len() {
        Vec::new()
    } else {
        tests.iter().map(|&test| session.tests[test].name.clone()).collect()
    };
    Suspicion {
        effect: TIME_SHIFT,
        says: shift_in_words(seconds, &names),
        components: Vec::new(),
        tests: names,
        shift_ms: Some(1e3 * seconds),
        undone,
    }
}

const TIME_SHIFT: &str = "time-shift";

/// A shift of all tests (no names) or some.
fn shift_in_words(seconds: f64, names: &[String]) -> String {
    let which = if names.is_empty() { "all tests".to_string() } else { names.join(", ") };
    format!("lengths and positions are {seconds:.2} s apart in {which}: pair them by one clock")
}

impl DataFault {
    /// Whether lengths and positions of some tests only would be apart.
    pub fn is_shift_of_single_tests(&self) -> bool {
        self.effect == TIME_SHIFT && !self.tests.is_empty()
    }

    /// Positions that are `seconds` too old in some tests (none named: all), with the residual as recorded and undone, µm.
    pub fn time_shift(seconds: f64, tests: Vec<String>, before_um: f64, after_um: f64) -> DataFault {
        DataFault {
            effect: TIME_SHIFT,
            components: Vec::new(),
            says: shift_in_words(seconds, &tests),
            tests,
            before_um,
            after_um,
            shift_ms: Some(1e3 * seconds),
        }
    }
}

/// Positions as they are `seconds` later; rows beyond the recording lose their reading.
fn shift(recording: &mut Recording, seconds: f64) {
    let Clock::TimeS(time) = recording.clock.clone() else { return };
    let columns = recording.positions.clone();
    for row in 0..time.len() {
        let at = time[row] + seconds;
        let above = time.partition_point(|t| *t < at);
        if above == 0 || above == time.len() {
            recording.length_mm[row] = f64::NAN;
            continue;
        }
        for (column, from) in recording.positions.iter_mut().zip(&columns) {
            column[row] = between(&time, from, above, at);
        }
    }
}

/// Rows through which positions are read between rows: a chord across an arc of 100 mm is a µm short.
const THROUGH: usize = 4;

/// Position at a time between rows `above - 1` and `above`, by the polynomial through the nearest rows (Lagrange).
fn between(time: &[f64], position: &[f64], above: usize, at: f64) -> f64 {
    let first = above.saturating_sub(THROUGH / 2).min(time.len().saturating_sub(THROUGH));
    let rows = first..(first + THROUGH).min(time.len());
    let weight =
        |k: usize| -> f64 { rows.clone().filter(|&j| j != k).map(|j| (at - time[j]) / (time[k] - time[j])).product() };
    rows.clone().map(|k| weight(k) * position[k]).sum()
}
