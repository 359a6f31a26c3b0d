//! An instrument that was moved while points and poses were read. Mistakes in their columns stand in `readings::columns`.

use nalgebra::{Matrix6, SMatrix, SVector, Vector3, Vector6};

use super::loaded::left_by_a_load;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, SESSION};
use crate::identify::{Fit, Options, identify};
use crate::session::{Session, Setups};
use crate::statistics::{rms, robust_sigma};

/// Share of the residual's squares that is left at most when the instrument stands elsewhere from some row on: with the errors as
/// fitted, and with all fitted once more.
const MOST_LEFT: f64 = 0.7;
const MOST_LEFT_REFITTED: f64 = 0.5;
/// Rows on either side at least: twice the numbers of a place.
const LEAST_ROWS: usize = 12;

/// Residuals below this are rounding, mm.
const ROUNDING_MM: f64 = 1e-6;

/// Tag of an instrument's second place.
const SECOND: &str = "second";

/// An instrument that was moved during a session: the residual is a shift and a turn of its frame before a row, and another after.
pub(crate) fn instrument_moved(session: &Session, options: &Options, fit: &Fit) -> Option<DataFault> {
    let moved = visits(session, fit).into_iter().filter_map(|visits| {
        let (at, left) = change(&visits)?;
        (left < MOST_LEFT && left < left_by_drift(&visits)).then_some((left, visits, at))
    });
    let (left, visits, at) = moved.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let (first, row) = (visits[at].test, visits[at].row);
    let later: Vec<usize> = visits[at..].iter().map(|visit| visit.test).filter(|&test| test != first).collect();
    let begins_there = !visits[..at].iter().any(|visit| visit.test == first);
    let split = with_second_frame(session, (first, row), &later);
    let refitted = identify(&split, options).ok()?;
    // rows after the move may have been left out as outliers
    let all_mm =
        |fit: &Fit| rms(fit.tests.iter().flat_map(|test| &test.residual_mm).copied().filter(|v| v.is_finite()));
    let refitted_left = (all_mm(&refitted) / all_mm(fit)).powi(2);
    if refitted_left > MOST_LEFT_REFITTED {
        return None;
    }
    // one load that leaves no more says it with fewer numbers
    if left_by_a_load(session, fit).is_some_and(|left_by_load| left_by_load <= refitted_left) {
        return None;
    }
    let left = left.min(refitted_left);
    let test = &session.tests[first];
    let of = test.stated_name().to_string();
    let second = format!("instrument: {{link: {}, setup: second}}", test.pivot.link);
    let mut says = match begins_there {
        true => format!("the instrument of test '{of}' stands elsewhere than before: give that test {second}"),
        false => format!(
            "the instrument of test '{of}' stands elsewhere from row {} on: give these rows a test of their own with {second}",
            row + 1
        ),
    };
    if !later.is_empty() {
        says.push_str("; the tests after it have the same second setup");
    }
    let before_um = 1e3 * all_mm(fit);
    let fault = DataFault {
        before_um,
        after_um: before_um * left.sqrt(),
        ..DataFault::seen(FaultKind::InstrumentMoved, SESSION, vec![of], says)
    };
    Some(fault.or_effect(evenness(&split, &refitted), None))
}

/// What is left on either side of a move may differ by so many times: poses are others there.
const EITHER_SIDE: f64 = 2.0;

/// How evenly a fit leaves its residual before a move and after it, one where both sides are alike: another mistake leaves far more on its own
/// side.
fn evenness(split: &Session, refitted: &Fit) -> f64 {
    let is_second = |test: &usize| split.tests[*test].pivot.setup.as_deref() == Some(SECOND);
    let (after, before): (Vec<usize>, Vec<usize>) = (0..split.tests.len()).partition(is_second);
    let left_mm = |tests: Vec<usize>| {
        robust_sigma(
            tests.iter().flat_map(|&test| &refitted.tests[test].residual_mm).copied().filter(|left| left.is_finite()),
        )
    };
    let (before, after) = (left_mm(before), left_mm(after));
    (EITHER_SIDE * before.min(after) / before.max(after)).min(1.0)
}

/// A pose that an instrument saw: first number of its test, row, time as a share of all, point and what is left of it, mm.
struct Visit {
    test: usize,
    row: usize,
    at: f64,
    point: Vector3<f64>,
    left: Vector3<f64>,
}

/// What each instrument saw, in the order of the session, points from their middle; none of one that saw too little.
fn visits(session: &Session, fit: &Fit) -> Vec<Vec<Visit>> {
    let instrument_of = Setups::of(session).pivot_of;
    let firsts = (0..session.tests.len()).filter(|&test| session.tests[test].is_first_of_sighting());
    let mut order: Vec<usize> = firsts.collect();
    order.sort_by(|&a, &b| session.tests[a].started_at_s.total_cmp(&session.tests[b].started_at_s));
    let mut by_instrument: Vec<(usize, Vec<Visit>)> = Vec::new();
    for test in order {
        let number = |k: usize, row: usize| session.tests[test + k].recording.as_ref().map(|r| r.length_mm[row]);
        let seen = (0..session.tests[test].rows()).filter_map(|row| {
            let left = [0, 1, 2].map(|k| fit.tests[test + k].residual_mm[row]);
            let point = [0, 1, 2].map(|k| number(k, row).unwrap_or(f64::NAN));
            let (left, point) = (Vector3::from(left), Vector3::from(point));
            left.iter().all(|value| value.is_finite()).then_some(Visit { test, row, at: 0.0, point, left })
        });
        match by_instrument.iter_mut().find(|(instrument, _)| *instrument == instrument_of[test]) {
            Some((_, visits)) => visits.extend(seen),
            None => by_instrument.push((instrument_of[test], seen.collect())),
        }
    }
    let visits = by_instrument.into_iter().map(|(_, visits)| visits);
    let is_much = |visits: &Vec<Visit>| {
        visits.len() >= 2 * LEAST_ROWS && rms(visits.iter().flat_map(|visit| visit.left.iter().copied())) > ROUNDING_MM
    };
    let from_middle = |mut visits: Vec<Visit>| {
        let count = visits.len() as f64;
        let middle = visits.iter().map(|visit| visit.point).sum::<Vector3<f64>>() / count;
        visits.iter_mut().enumerate().for_each(|(k, visit)| {
            visit.point -= middle;
            visit.at = k as f64 / count;
        });
        visits
    };
    visits.filter(is_much).map(from_middle).collect()
}

/// The session with the instrument mounted anew from a row of a test on, and in later tests.
fn with_second_frame(session: &Session, (first, row): (usize, usize), later: &[usize]) -> Session {
    let mut split = session.clone();
    let numbers = |test: usize| session.tests[test].reading.part().map_or(0, |part| part.kind.scalars().len());
    for &test in later {
        let of_test = &mut split.tests[test..test + numbers(test)];
        of_test.iter_mut().for_each(|test| test.pivot.setup = Some(SECOND.into()));
    }
    for index in first..first + numbers(first) {
        let mut second = session.tests[index].clone();
        second.name.push_str(" from there");
        second.pivot.setup = Some(SECOND.into());
        for (test, is_second) in [(&mut split.tests[index], false), (&mut second, true)] {
            let lengths = test.recording.iter_mut().flat_map(|recording| recording.length_mm.iter_mut().enumerate());
            lengths.filter(|(at, _)| (*at >= row) != is_second).for_each(|(_, value)| *value = f64::NAN);
        }
        split.tests.push(second);
    }
    split
}

/// The visit from which another place of the instrument explains most, and the share of squares that is left then.
fn change(visits: &[Visit]) -> Option<(usize, f64)> {
    let mut total = Sums::default();
    visits.iter().for_each(|visit| total.add(&visit.point, &visit.left));
    let mut before = Sums::default();
    let mut best: Option<(usize, f64)> = None;
    for (count, visit) in visits.iter().enumerate() {
        if (LEAST_ROWS..=visits.len() - LEAST_ROWS).contains(&count) {
            let after = total.less(&before);
            let share = 1.0 - (before.explained() + after.explained()) / total.squares.max(f64::MIN_POSITIVE);
            if best.is_none_or(|(_, least)| share < least) {
                best = Some((count, share));
            }
        }
        before.add(&visit.point, &visit.left);
    }
    best
}

/// Shares of the session in which a place settles.
const SETTLES_IN: [f64; 4] = [0.1, 0.25, 0.5, 1.0];

/// Share of squares that is left by a frame that drifts, as much of it as it wants, evenly or settling: growth and creep look like that, and
/// a move does not.
fn left_by_drift(visits: &[Visit]) -> f64 {
    let squares: f64 = visits.iter().map(|visit| visit.left.norm_squared()).sum();
    let shapes = std::iter::once(None).chain(SETTLES_IN.map(Some));
    let left = shapes.map(|settles| {
        let (mut matrix, mut right) = (SMatrix::<f64, 12, 12>::zeros(), SVector::<f64, 12>::zeros());
        for visit in visits {
            let grown = settles.map_or(visit.at, |settles| 1.0 - (-visit.at / settles).exp());
            let still = frame_columns(&visit.point);
            let mut columns = SMatrix::<f64, 3, 12>::zeros();
            columns.fixed_view_mut::<3, 6>(0, 0).copy_from(&still);
            columns.fixed_view_mut::<3, 6>(0, 6).copy_from(&(still * grown));
            matrix += columns.transpose() * columns;
            right += columns.transpose() * visit.left;
        }
        let held = matrix + SMatrix::<f64, 12, 12>::identity() * HELD;
        1.0 - held.cholesky().map_or(0.0, |factor| factor.solve(&right).dot(&right)) / squares
    });
    left.fold(1.0, f64::min)
}

/// What holds directions that the points do not tell.
const HELD: f64 = 1e-9;

/// A shift and a small turn of a frame at a point.
fn frame_columns(point: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    let mut columns = SMatrix::<f64, 3, 6>::zeros();
    columns.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
    columns.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-point.cross_matrix() / LEVER));
    columns
}

/// Normal equations of a shift and a small turn: `left = t + w × point`.
#[derive(Clone, Copy, Default)]
struct Sums {
    matrix: Matrix6<f64>,
    right: Vector6<f64>,
    squares: f64,
}

/// Turns count at this lever, mm, so that shifts and turns are of like size.
const LEVER: f64 = 1e3;

impl Sums {
    fn add(&mut self, point: &Vector3<f64>, left: &Vector3<f64>) {
        let columns = frame_columns(point);
        self.matrix += columns.transpose() * columns;
        self.right += columns.transpose() * left;
        self.squares += left.norm_squared();
    }

    fn less(&self, other: &Sums) -> Sums {
        Sums {
            matrix: self.matrix - other.matrix,
            right: self.right - other.right,
            squares: self.squares - other.squares,
        }
    }

    /// Squares that shift and turn take.
    fn explained(&self) -> f64 {
        let held = self.matrix + Matrix6::identity() * HELD;
        held.cholesky().map_or(0.0, |factor| factor.solve(&self.right).dot(&self.right))
    }
}
