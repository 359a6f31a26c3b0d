//! Mistakes in sessions of points and poses: columns, units and senses that no chain explains, an instrument that was moved. Lengths have theirs in `mistakes`.

use nalgebra::{Matrix6, SMatrix, Vector3, Vector6};

use super::loaded::left_by_a_load;
use crate::chain::Chain;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, SESSION};
use crate::identify::{Fit, Options, identify};
use crate::machine::AxisKind;
use crate::readings::Kind;
use crate::session::{Session, sighted_misfit_mm};
use crate::statistics::rms;

/// Undoing a mistake brings the readings so many times nearer to the nominal chain: nominal dimensions are off by millimetres, a
/// wrong sense by the size of the machine.
const LEAST_RATIO: f64 = 5.0;
/// Readings this near to the nominal chain hold no mistake of this kind, mm.
const NEAR_NOMINAL_MM: f64 = 15.0;

/// The session with one mistake undone, and what it was.
type Undone = (&'static str, Vec<String>, String, Session);

/// A mistake in columns or senses that makes the readings fit the nominal chain once it is undone.
pub(crate) fn mistaken_columns(session: &Session) -> Option<DataFault> {
    let chain = Chain::of(&session.machine);
    let before = sighted_misfit_mm(session, &chain).filter(|misfit| *misfit > NEAR_NOMINAL_MM)?;
    let judged = undone(session).into_iter().filter_map(|(effect, components, says, undone)| {
        let after = sighted_misfit_mm(&undone, &Chain::of(&undone.machine))?;
        Some((after, effect, components, says))
    });
    let (after, effect, components, says) = judged.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (before > LEAST_RATIO * after).then(|| DataFault {
        components,
        before_um: 1e3 * before,
        after_um: 1e3 * after,
        ..DataFault::seen(effect, RECORDER, Vec::new(), says)
    })
}

/// Every mistake that is known, undone.
fn undone(session: &Session) -> Vec<Undone> {
    let mut list = Vec::new();
    let names = session.machine.axis_names();
    for (axis, name) in names.iter().enumerate() {
        let mut other = session.clone();
        other.machine.axes[axis].reversed ^= true;
        let says = format!(
            "{name} counts the other way: add 'reversed: true' to it in the machine file, or take it away there"
        );
        list.push(("axis-sign", vec![name.to_string()], says, other));
    }
    for (one, other) in pairs(names.len()) {
        if session.machine.axes[one].kind == session.machine.axes[other].kind {
            let says = format!("the columns of {} and {} are exchanged: correct the header", names[one], names[other]);
            let changed = with_positions(session, |axis, value| {
                (
                    if axis == one {
                        other
                    } else if axis == other {
                        one
                    } else {
                        axis
                    },
                    value,
                )
            });
            list.push(("swapped-columns", vec![names[one].to_string(), names[other].to_string()], says, changed));
        }
    }
    let rotary = |axis: usize| session.machine.axes[axis].kind == AxisKind::Rotary;
    let turned = with_positions(session, |axis, value| (axis, if rotary(axis) { value.to_degrees() } else { value }));
    list.push((
        "unit",
        vec!["positions".into()],
        "positions of rotary axes are in radians: convert them to degrees".into(),
        turned,
    ));
    for (unit, factor) in [("metres", 1e3), ("inches", 25.4)] {
        let says = format!("coordinates are in {unit}: convert the columns to mm");
        list.push(("unit", vec!["coordinates".into()], says, with_coordinates(session, |point| point * factor)));
    }
    // with the instrument's axes unknown every exchange of two columns looks like every other, and like a mirrored axis
    let says = "two of the columns x, y and z of the readings are exchanged, or one of the instrument's axes is mirrored: correct the header";
    let swapped = with_coordinates(session, |point| Vector3::new(point.y, point.x, point.z));
    list.push(("swapped-columns", vec!["coordinates".into()], says.into(), swapped));
    list
}

fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |one| (one + 1..count).map(move |other| (one, other)))
}

/// Positions changed: axis of a column and value to axis and value.
fn with_positions(session: &Session, change: impl Fn(usize, f64) -> (usize, f64)) -> Session {
    let mut changed = session.clone();
    for recording in changed.tests.iter_mut().filter_map(|test| test.recording.as_mut()) {
        for (axis, column) in recording.axes.iter_mut().zip(&mut recording.positions) {
            let of = *axis;
            column.iter_mut().for_each(|value| *value = change(of, *value).1);
            *axis = change(of, 0.0).0;
        }
    }
    changed
}

/// Coordinates changed, row by row.
fn with_coordinates(session: &Session, change: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Session {
    let mut changed = session.clone();
    let leads = |index: &usize| {
        let part = session.tests[*index].reading.part();
        part.is_some_and(|part| part.leads() && matches!(part.kind, Kind::Point | Kind::Pose))
    };
    for first in (0..session.tests.len()).filter(leads) {
        let rows = session.tests[first].rows();
        for row in 0..rows {
            let read = |k: usize| session.tests[first + k].recording.as_ref().map_or(f64::NAN, |r| r.length_mm[row]);
            let point = change(Vector3::new(read(0), read(1), read(2)));
            for k in 0..3 {
                if let Some(recording) = &mut changed.tests[first + k].recording {
                    recording.length_mm[row] = point[k];
                }
            }
        }
    }
    changed
}

/// Share of the residual's squares that is left at most when the instrument stands elsewhere from some row on: with the errors as
/// fitted, and with all fitted once more.
const MOST_LEFT: f64 = 0.7;
const MOST_LEFT_REFITTED: f64 = 0.5;
/// Rows on either side at least: twice the numbers of a place.
const LEAST_ROWS: usize = 12;

/// An instrument that was moved during a test: the residual is a shift and a turn of its frame before a row, and another after.
pub(crate) fn instrument_moved(session: &Session, fit: &Fit) -> Option<DataFault> {
    let leads = |index: &usize| {
        let part = session.tests[*index].reading.part();
        part.is_some_and(|part| part.leads() && matches!(part.kind, Kind::Point | Kind::Pose))
    };
    let moved = (0..session.tests.len()).filter(leads).filter_map(|first| {
        let (row, left) = change(session, fit, first)?;
        (left < MOST_LEFT).then_some((left, first, row))
    });
    let (left, first, row) = moved.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let refitted = identify(&with_second_frame(session, first, row), &Options::default()).ok()?;
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
    let of = test.reading.part().map_or(&test.name, |part| &part.of).clone();
    let says = format!(
        "the instrument of test '{of}' stands elsewhere from row {} on: give these rows a test of their own with instrument: {{link: {}, setup: second}}",
        row + 1,
        test.pivot.link
    );
    let before_um = 1e3 * all_mm(fit);
    Some(DataFault {
        before_um,
        after_um: before_um * left.sqrt(),
        ..DataFault::seen("instrument-moved", SESSION, vec![of], says)
    })
}

/// The session with the instrument of a test mounted anew from a row on.
fn with_second_frame(session: &Session, first: usize, row: usize) -> Session {
    let mut split = session.clone();
    let Some(numbers) = session.tests[first].reading.part().map(|part| part.kind.scalars().len()) else { return split };
    for index in first..first + numbers {
        let mut second = session.tests[index].clone();
        second.name.push_str(" from there");
        second.pivot.setup = Some("second".into());
        for (test, is_second) in [(&mut split.tests[index], false), (&mut second, true)] {
            let lengths = test.recording.iter_mut().flat_map(|recording| recording.length_mm.iter_mut().enumerate());
            lengths.filter(|(at, _)| (*at >= row) != is_second).for_each(|(_, value)| *value = f64::NAN);
        }
        split.tests.push(second);
    }
    split
}

/// The row from which another place of the instrument explains most, and the share of squares that is left then.
fn change(session: &Session, fit: &Fit, first: usize) -> Option<(usize, f64)> {
    let rows = session.tests[first].rows();
    let mut total = Sums::default();
    let all: Vec<(usize, Vector3<f64>, Vector3<f64>)> = (0..rows)
        .filter_map(|row| {
            let number = |k: usize| session.tests[first + k].recording.as_ref().map_or(f64::NAN, |r| r.length_mm[row]);
            let left = |k: usize| fit.tests[first + k].residual_mm[row];
            left(0)
                .is_finite()
                .then(|| (row, Vector3::new(number(0), number(1), number(2)), Vector3::new(left(0), left(1), left(2))))
        })
        .collect();
    if all.len() < 2 * LEAST_ROWS {
        return None;
    }
    let middle = all.iter().map(|(_, point, _)| point).sum::<Vector3<f64>>() / all.len() as f64;
    all.iter().for_each(|(_, point, left)| total.add(&(point - middle), left));
    let mut before = Sums::default();
    let mut best: Option<(usize, f64)> = None;
    for (count, (row, point, left)) in all.iter().enumerate() {
        if (LEAST_ROWS..=all.len() - LEAST_ROWS).contains(&count) {
            let after = total.less(&before);
            let share = 1.0 - (before.explained() + after.explained()) / total.squares.max(f64::MIN_POSITIVE);
            if best.is_none_or(|(_, least)| share < least) {
                best = Some((*row, share));
            }
        }
        before.add(&(point - middle), left);
    }
    best
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
        let mut columns = SMatrix::<f64, 3, 6>::zeros();
        columns.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        columns.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-point.cross_matrix() / LEVER));
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
        let held = self.matrix + Matrix6::identity() * 1e-9;
        held.cholesky().map_or(0.0, |factor| factor.solve(&self.right).dot(&self.right))
    }
}
