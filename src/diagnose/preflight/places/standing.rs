//! Axes that stood elsewhere than the session says, by what the lengths say.

use super::ball_places::WORTH;
use super::misplaced::names;
use crate::chain::{Chain, Geometry};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{RECORDER, SESSION, listed};
use crate::diagnose::preflight::readings::figures::Linearised;
use crate::diagnose::preflight::struck_together::StruckTogether;
use crate::diagnose::preflight::suspicion::{Detail, RARELY, Suspicion};
use crate::diagnose::selection::shapes::judged_shape::PARAMETER_COST;
use crate::machine::AxisKind;
use crate::session::{Motion, Session, Test};
use crate::statistics::{Fitted, least_along};

/// Steps in which shifts of a standing axis are tried first, mm and deg.
const GRID_MM: f64 = 5.0;
const GRID_DEG: f64 = 4.5;

/// Rows of a test that tell where an axis stood.
const ROWS_OF_A_TEST: usize = 12;

/// Axes that stood elsewhere than stated, in the repeats of one test or wherever they stood alike.
pub(crate) fn standing_elsewhere(session: &Session) -> Vec<Suspicion> {
    let chain = Chain::of(&session.machine);
    let axes = 0..session.machine.axes.len();
    axes.flat_map(|axis| groups(session, axis).into_iter().map(move |tests| (axis, tests)))
        .flat_map(|(axis, tests)| stood_elsewhere(session, &chain, axis, &tests))
        .collect()
}

/// Where an axis stands in a test by the session, mm or rad; `None` where it moves, or where nothing was recorded.
fn standing(test: &Test, axis: usize) -> Option<f64> {
    let recording = test.recording.as_ref()?;
    test.positions[axis].filter(|_| !recording.axes.contains(&axis))
}

/// Tests in which an axis stands: the repeats of one, and all in which it stands alike.
pub(crate) fn groups(session: &Session, axis: usize) -> Vec<Vec<usize>> {
    let standing = |test: usize| standing(&session.tests[test], axis);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for first in 0..session.tests.len() {
        let Some(value) = standing(first) else { continue };
        let others = (0..session.tests.len()).filter(|&test| standing(test).is_some());
        let alike: Vec<usize> = others.clone().filter(|&test| standing(test) == Some(value)).collect();
        let repeats: Vec<usize> =
            others.filter(|&test| session.tests[first].is_repeat_of(&session.tests[test])).collect();
        for group in [repeats, alike] {
            if group.first() == Some(&first) && !groups.contains(&group) {
                groups.push(group);
            }
        }
    }
    groups
}

/// What the nominal machine leaves of some tests with an axis shifted, mm by mm or rad; `None` where they have no motion.
pub(crate) fn misfit_of_shift<'a>(
    session: &'a Session,
    chain: &'a Chain,
    axis: usize,
    tests: &[usize],
) -> Option<impl Fn(f64) -> f64 + Sync + 'a> {
    let geometry = Geometry::nominal(chain);
    let mut rows: Vec<(usize, Vec<f64>, f64)> = Vec::new();
    for &index in tests {
        let test = &session.tests[index];
        let motion = Motion::of(session, chain, test).ok()?;
        let lengths = &test.recording.as_ref()?.length_mm;
        for row in
            (0..lengths.len()).step_by((lengths.len() / ROWS_OF_A_TEST).max(1)).filter(|&row| lengths[row].is_finite())
        {
            rows.push((index, motion.row(row).to_vec(), lengths[row] - test.bar_error_mm));
        }
    }
    let links: Vec<_> = session.tests.iter().map(|test| test.links(chain).ok()).collect();
    Some(move |shift: f64| -> f64 {
        let one = |(index, at, length): &(usize, Vec<f64>, f64)| {
            let Some(links) = links[*index] else { return 0.0 };
            let mut at = at.clone();
            at[axis] += shift;
            let test = &session.tests[*index];
            (length - test.bar(&geometry, links, &at).norm()).powi(2)
        };
        (rows.iter().map(one).sum::<f64>() / rows.len().max(1) as f64).sqrt()
    })
}

/// Where the lengths put an axis: by the least misfit anywhere, and by the least nearby, for a circle is met twice.
fn stood_elsewhere(session: &Session, chain: &Chain, axis: usize, tests: &[usize]) -> Vec<Suspicion> {
    let Some(miss) = misfit_of_shift(session, chain, axis, tests) else { return Vec::new() };
    let step = match session.machine.axes[axis].kind {
        AxisKind::Linear => GRID_MM,
        AxisKind::Rotary => GRID_DEG.to_radians(),
    };
    let as_stated = miss(0.0);
    let [anywhere, nearby] = [step, NEARBY_SHARE_OF_GRID * step].map(|step| least_along(&miss, step));
    let is_other = (anywhere.at - nearby.at).abs() > NEARBY_SHARE_OF_GRID * step;
    [Some(nearby), Some(anywhere).filter(|_| is_other)]
        .into_iter()
        .flatten()
        .filter(|least| least.value < WORTH * as_stated)
        .filter_map(|least| stood_at(session, axis, tests, least.at))
        .collect()
}

/// Part of the grid in which a place counts as nearby.
const NEARBY_SHARE_OF_GRID: f64 = 0.02;

/// Travels are stated to so much, mm or rad.
const TRAVEL_TOLERANCE: f64 = 1e-3;

/// Distances and angles by which an axis is tried to have stood elsewhere, mm and deg; a finer search follows.
const LITTLE_MM: [f64; 4] = [-0.8, -0.1, 0.1, 0.8];
const LITTLE_DEG: [f64; 2] = [-0.5, 0.5];

/// Axes that stood a little elsewhere in groups of tests, among them these `runs`, slides also at the other sign: too little for the lengths
/// alone to tell.
pub(crate) fn a_little_elsewhere(session: &Session, worst: &[usize], runs: &[Vec<usize>]) -> Vec<Suspicion> {
    let machine = &session.machine;
    let mut list = Vec::new();
    for axis in 0..machine.axes.len() {
        let stands = |test: &usize| standing(&session.tests[*test], axis).is_some();
        let of_runs = runs.iter().filter(|run| run.iter().all(stands)).cloned();
        let groups = groups(session, axis).into_iter().chain(of_runs);
        for tests in groups.filter(|tests| tests.iter().any(|test| worst.contains(test))) {
            let stated = session.tests[tests[0]].positions[axis].unwrap_or(0.0);
            let shifts: Vec<f64> = match machine.axes[axis].kind {
                AxisKind::Linear => LITTLE_MM.into_iter().chain((stated != 0.0).then_some(-2.0 * stated)).collect(),
                AxisKind::Rotary => LITTLE_DEG.map(f64::to_radians).to_vec(),
            };
            list.extend(shifts.into_iter().filter_map(|shift| stood_at(session, axis, &tests, shift)));
        }
    }
    list
}

/// Axes that did not move in what was recorded in one piece, whose positions are those of the program: a machine lock, a sweep without its
/// start. Where slides follow, the bar keeps its length whether anything moves or not: of one run among others that tells nothing.
pub(in crate::diagnose::preflight) fn stood_still(session: &Session, groups: &StruckTogether) -> Vec<Suspicion> {
    let turns_alone = |test: &usize| session.tests[*test].recording.as_ref().is_some_and(|read| read.axes.len() == 1);
    let is_told = |group: &Vec<usize>| !groups.runs.contains(group) || group.iter().all(turns_alone);
    let of = |tests: &Vec<usize>| {
        let mut undone = session.clone();
        for &test in tests {
            let recording = undone.tests[test].recording.as_mut().filter(|recording| recording.time_s().is_some())?;
            for column in &mut recording.positions {
                let first = *column.first()?;
                column.fill(first);
            }
        }
        let says = format!(
            "no axis moved in {} by the lengths, whatever the positions say: a machine lock or a sweep that was not started; record the \
             tests again",
            listed(&names(session, tests))
        );
        Some(Suspicion {
            weight: RARELY,
            ..Suspicion::new(FaultKind::StandingAxis, RECORDER, names(session, tests), says, undone)
        })
    };
    groups.pieces().iter().filter(|group| is_told(group)).filter_map(of).collect()
}

/// Angles by which a column is tried to be off, deg; a finer search follows.
const OFF_DEG: [f64; 11] = [-90.0, -30.0, -12.0, -4.0, -1.5, 1.5, 4.0, 12.0, 30.0, 90.0, 180.0];

/// Columns of rotary axes that are off by one angle in some groups of tests.
pub(crate) fn columns_off(session: &Session, groups: &[Vec<usize>]) -> Vec<Suspicion> {
    let machine = &session.machine;
    let rotary = machine.axes_of(AxisKind::Rotary);
    let of = |axis: usize| {
        let moves = |&test: &usize| {
            session.tests[test].recording.as_ref().is_some_and(|recording| recording.axes.contains(&axis))
        };
        let every: Vec<usize> = (0..session.tests.len()).filter(moves).collect();
        let mut all: Vec<Vec<usize>> =
            groups.iter().filter(|group| group.iter().all(moves)).cloned().chain(std::iter::once(every)).collect();
        all.retain(|group| !group.is_empty());
        all.dedup();
        all.into_iter().flat_map(move |tests| {
            OFF_DEG
                .iter()
                .filter_map(move |deg| column_off(session, axis, &tests, deg.to_radians()))
                .collect::<Vec<_>>()
        })
    };
    rotary.flat_map(of).collect()
}

/// Distance by which derivatives by a linear axis are found, mm.
const SMALL_MM: f64 = 0.01;

/// Columns that are off by less are not told from errors of the slides themselves, mm.
const LEAST_MM: f64 = 0.02;

/// Columns of linear axes that are off by the distance that fits best, in some groups of tests.
pub(crate) fn slides_off(session: &Session, linearised: &Linearised, groups: &[Vec<usize>]) -> Vec<Suspicion> {
    let machine = &session.machine;
    let linear = machine.axes_of(AxisKind::Linear);
    let of = |axis: usize, tests: &Vec<usize>| {
        let off = |shift: f64| Some(column_off(session, axis, tests, shift)?.undone);
        let along = along(linearised, tests, SMALL_MM, off)?.value;
        let shift = by_secants(linearised, tests, along, off);
        let off = column_off(session, axis, tests, shift).filter(|_| shift.abs() > LEAST_MM)?;
        Some(Suspicion { log_figures: -PARAMETER_COST, is_found: false, ..off })
    };
    linear.flat_map(|axis| groups.iter().filter_map(move |tests| of(axis, tests))).collect()
}

/// Angle by which derivatives by a rotary axis are found, rad; and turns below which an axis is not told from errors of its own line, rad.
const SMALL_RAD: f64 = 1e-5;
const LEAST_RAD: f64 = 3e-4;

/// Axes that stood elsewhere, or counted from another zero, that are tried by what they gain, of each kind of mistake.
const MOST_FITTED: usize = 4;

/// An axis that is off by the figure that fits best.
struct Fitting {
    axis: usize,
    tests: Vec<usize>,
    shift: f64,
    /// What it takes off the squares, in those of the noise.
    gain: f64,
}

/// The figures that gain most, of axes that are off in some tests as `off` has them.
fn fitting(
    session: &Session,
    linearised: &Linearised,
    axes_and_tests: impl Iterator<Item = (usize, Vec<usize>)>,
    off: impl Fn(usize, &[usize], f64) -> Option<Session>,
) -> Vec<Fitting> {
    let fit = |(axis, tests): (usize, Vec<usize>)| {
        let (small, least) = match session.machine.axes[axis].kind {
            AxisKind::Linear => (SMALL_MM, LEAST_MM),
            AxisKind::Rotary => (SMALL_RAD, LEAST_RAD),
        };
        let size = along(linearised, &tests, small, |shift| off(axis, &tests, shift))?;
        (size.value.abs() > least).then(|| Fitting {
            axis,
            tests,
            shift: size.value,
            gain: (size.value / size.sigma).powi(2),
        })
    };
    let mut list: Vec<Fitting> = axes_and_tests.filter_map(fit).collect();
    list.sort_by(|one, other| other.gain.total_cmp(&one.gain));
    list.truncate(MOST_FITTED);
    for Fitting { axis, tests, shift, .. } in &mut list {
        *shift = by_secants(linearised, tests, *shift, |shift| off(*axis, tests, shift));
    }
    list
}

/// Times that a figure is fitted along its own secant, so that what its square does counts as well.
const SECANTS: usize = 2;

/// A figure of an axis that is `off`, as it fits best along what so much of it does.
fn along(linearised: &Linearised, tests: &[usize], by: f64, off: impl Fn(f64) -> Option<Session>) -> Option<Fitted> {
    linearised.fitted(&[linearised.figure_of(&off(by)?, tests, by)?])?.first().copied()
}

/// A figure that was fitted along its tangent, as it fits best along the way that it goes.
fn by_secants(linearised: &Linearised, tests: &[usize], mut shift: f64, off: impl Fn(f64) -> Option<Session>) -> f64 {
    for _ in 0..SECANTS {
        let fitted = along(linearised, tests, shift, &off).map(|size| size.value);
        shift = fitted.filter(|fitted| fitted.is_finite() && *fitted != 0.0).unwrap_or(shift);
    }
    shift
}

/// Axes that stood elsewhere by what fits best: in the repeats of a test, or wherever they stood alike.
pub(crate) fn stood_off(session: &Session, linearised: &Linearised) -> Vec<Suspicion> {
    let axes = 0..session.machine.axes.len();
    let stood = axes.flat_map(|axis| groups(session, axis).into_iter().map(move |tests| (axis, tests)));
    let off = |axis: usize, tests: &[usize], shift: f64| Some(stood_at(session, axis, tests, shift)?.undone);
    let list = fitting(session, linearised, stood, off);
    list.into_iter().filter_map(|Fitting { axis, tests, shift, .. }| stood_at(session, axis, &tests, shift)).collect()
}

/// A slide that is off by less from a test on is not told from a ball that slipped, mm: one that is knocked by more comes off its magnet.
const LEAST_TOUCHED_MM: f64 = 0.1;

/// Slides whose zero was touched off anew during the session: from one of its tests on they are off by what fits best, whether they
/// stand or move.
pub(crate) fn touched_off_anew(session: &Session, linearised: &Linearised) -> Vec<Suspicion> {
    let mut order: Vec<usize> = (0..session.tests.len()).collect();
    order.sort_by(|&one, &other| session.tests[one].started_at_s.total_cmp(&session.tests[other].started_at_s));
    let order = &order;
    let slides = session.machine.axes_of(AxisKind::Linear);
    let later = slides.flat_map(|axis| (1..order.len()).map(move |first| (axis, order[first..].to_vec())));
    let list =
        fitting(session, linearised, later, |axis, tests, shift| Some(counted_from(session, axis, tests, shift)));
    let told = |Fitting { axis, tests, shift: shift_mm, .. }: Fitting| {
        let name = &session.machine.axes[axis].name;
        let first = &session.tests[tests[0]].name;
        let says = format!(
            "{name} is off by about {:.3} mm from {first} on: its zero was touched off anew during the session; add {shift_mm:.3} to it from there on, \
             in 'positions' and in its columns, or make two sessions of it",
            -shift_mm
        );
        let undone = counted_from(session, axis, &tests, shift_mm);
        let found = Suspicion::new(FaultKind::StandingAxis, SESSION, names(session, &tests), says, undone);
        Suspicion {
            components: vec![name.clone()],
            detail: Detail::sizes(&[shift_mm], 0.01),
            log_figures: -PARAMETER_COST,
            weight: RARELY,
            ..found
        }
    };
    list.into_iter().filter(|fitting| fitting.shift.abs() > LEAST_TOUCHED_MM).map(told).collect()
}

/// The session with a slide counted from another zero in some tests, mm: where it stands, and where it moves.
fn counted_from(session: &Session, axis: usize, tests: &[usize], shift_mm: f64) -> Session {
    let mut undone = session.clone();
    for &test in tests {
        let test = &mut undone.tests[test];
        test.positions[axis] = test.positions[axis].map(|at| at + shift_mm);
        // where it stands there is no column
        let _ = move_column(test, axis, shift_mm);
    }
    undone
}

/// The session with the column of an axis moved by an angle or distance in some tests, rad or mm.
pub(crate) fn column_off(session: &Session, axis: usize, tests: &[usize], shift: f64) -> Option<Suspicion> {
    let mut undone = session.clone();
    for &test in tests {
        move_column(&mut undone.tests[test], axis, shift)?;
    }
    let (name, kind) = (&session.machine.axes[axis].name, session.machine.axes[axis].kind);
    let says = format!(
        "column {name} is off by about {:.2} {} in {}: the recording began late, or counts from another zero; add {:.2} to it",
        -kind.to_file_unit(shift),
        kind.position_unit(),
        listed(&names(session, tests)),
        kind.to_file_unit(shift)
    );
    let mut found = Suspicion::new(FaultKind::ColumnShifted, RECORDER, names(session, tests), says, undone);
    found.components = vec![name.clone()];
    found.detail = Detail::sizes(&[kind.to_file_unit(shift)], 0.01);
    (found.weight, found.is_found) = (RARELY, true);
    Some(found)
}

/// Moves the column of an axis in what was recorded of a test, rad or mm; `None` where it has none.
fn move_column(test: &mut Test, axis: usize, shift: f64) -> Option<()> {
    let recording = test.recording.as_mut()?;
    let column = recording.column_of(axis)?;
    recording.positions[column].iter_mut().for_each(|q| *q += shift);
    Some(())
}

/// A position as files write it: radians and back cost the last digits.
fn written(position: f64) -> f64 {
    (1e6 * position).round() / 1e6
}

/// How near to zero, or to the stated position with the other sign, an axis stood there, mm or deg; and the way over which any
/// other place becomes half as likely.
const AS_WRITTEN: f64 = 0.1;
const HALF_AS_LIKELY: f64 = 10.0;

/// The session with an axis standing elsewhere by so much in some tests, mm or rad.
pub(crate) fn stood_at(session: &Session, axis: usize, tests: &[usize], shift: f64) -> Option<Suspicion> {
    let (axis_name, kind) = (&session.machine.axes[axis].name, session.machine.axes[axis].kind);
    let stated = session.tests[*tests.first()?].positions[axis]?;
    // beyond its travel no axis stands
    let is_within =
        |(from, to): (f64, f64)| stated + shift > from - TRAVEL_TOLERANCE && stated + shift < to + TRAVEL_TOLERANCE;
    if !session.machine.axes[axis].range.is_none_or(is_within) {
        return None;
    }
    let mut undone = session.clone();
    for &test in tests {
        undone.tests[test].positions[axis] = session.tests[test].positions[axis].map(|at| at + shift);
    }
    let says = format!(
        "{axis_name} stood at about {:.2} {} by the lengths and not at {}; correct 'positions' in {}",
        kind.to_file_unit(stated + shift),
        kind.position_unit(),
        written(kind.to_file_unit(stated)),
        listed(&names(session, tests))
    );
    let mut found = Suspicion::new(FaultKind::StandingAxis, SESSION, names(session, tests), says, undone);
    (found.components, found.is_found) = (vec![axis_name.clone()], true);
    let (there, stated) = (kind.to_file_unit(stated + shift), kind.to_file_unit(stated));
    found.detail = Detail::sizes(&[there], 0.01);
    let is_usual = there.abs() < AS_WRITTEN || (there + stated).abs() < AS_WRITTEN;
    if !is_usual {
        // the nearer of two places that fit alike is the likelier one
        found.weight *= HALF_AS_LIKELY / (HALF_AS_LIKELY + (there - stated).abs());
    }
    Some(found)
}
