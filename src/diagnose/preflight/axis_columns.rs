//! Columns of axes in another sense or unit, exchanged or from the wrong end: of one axis, of all that carry the workpiece, of some
//! recordings.

use super::contradictions::unit_instead;
use super::data_fault::{RECORDER, SESSION};
use super::places::axis_order::in_exchange;
use super::places::folded::without_sign;
use super::suspicion::{OFTEN, RARELY, SOMETIMES, Suspicion};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::{Sampled, keep_few_rows};
use crate::machine::{AxisKind, Directions};
use crate::session::{Recording, Session};

/// Columns of one axis in another sense or unit, in all tests or in some.
pub(super) fn of_an_axis(sampled: Sampled<'_>, axis: usize) -> Vec<Suspicion> {
    let session = sampled.few_rows;
    let (name, kind) = (session.machine.axes[axis].name.clone(), session.machine.axes[axis].kind);
    let found = |kind: FaultKind, undone: Session, says: String| {
        let found = Suspicion::new(kind, RECORDER, Vec::new(), says, undone);
        Suspicion { components: vec![name.clone()], weight: OFTEN, ..found }
    };
    let backwards = format!("{name} is counted backwards: turn the sign of column {name}, or set 'reversed: true'");
    let mut list = vec![found(FaultKind::AxisSign, scale_axis(session, axis, -1.0), backwards)];
    let (unit, due) = unit_instead(kind);
    let says = format!("{name} is in {}: convert the column to {due}", unit.name);
    // where it stands is the session's word, which may be in the unit of the column or in its own
    if session.tests.iter().any(|test| test.positions[axis].is_some_and(|value| value != 0.0)) {
        let too = format!("{says}, and the session's positions of {name} too");
        list.push(found(FaultKind::Unit, scale_axis(session, axis, unit.size), too));
    }
    list.push(found(FaultKind::Unit, scale_columns(session, axis, unit.size), says));
    if kind == AxisKind::Linear {
        return list;
    }
    list.extend(without_sign(sampled, axis));
    let alternate = [0, 1].map(|from| Struck::Alternate { from });
    let of_one_way = [true, false].map(|rising| Struck::Seen { rising });
    let mut told: Vec<Vec<String>> = Vec::new();
    for struck in of_one_way.into_iter().chain(alternate).chain([Struck::Every]) {
        for among in [Among::Alone, Among::Followed, Among::All] {
            let suspicion = reversed(sampled, axis, struck, among);
            list.extend(suspicion.filter(|suspicion| !told.contains(&suspicion.tests)).inspect(|suspicion| {
                told.push(suspicion.tests.clone());
            }));
        }
    }
    list
}

/// The axes that carry the workpiece, or all axes, with the other sense: the convention that the machine file states, or does not.
pub(super) fn senses_together(session: &Session) -> Vec<Suspicion> {
    let machine = &session.machine;
    let names = |axes: &[usize]| -> Vec<String> { axes.iter().map(|&axis| machine.axes[axis].name.clone()).collect() };
    let turned = |axes: &[usize]| {
        let mut undone = session.clone();
        axes.iter().for_each(|&axis| undone.machine.axes[axis].reversed ^= true);
        undone
    };
    let table = machine.table_axes();
    let every: Vec<usize> = (0..machine.axes.len()).collect();
    let stated = match machine.directions {
        Some(Directions::Iso841) => Directions::Carried,
        Some(Directions::Carried) | None => Directions::Iso841,
    };
    let of_table = format!(
        "{} go the other way, all that carry the workpiece: state 'directions: {stated}' in the machine file, if {}",
        names(&table).join(", "),
        stated.meaning()
    );
    let of_all = "all axes go the other way: turn the signs of their columns, or set 'reversed: true' for each in the machine file";
    let mut list = Vec::new();
    for (axes, says) in [(&table, of_table), (&every, of_all.to_string())] {
        // one axis alone stands on the list already
        if axes.len() > 1 && (axes == &table || table.len() < every.len()) {
            let mut found = Suspicion::new(FaultKind::AxisSign, SESSION, Vec::new(), says, turned(axes));
            (found.components, found.weight) = (names(axes), OFTEN);
            list.push(found);
        }
    }
    list
}

/// Signs and pairs of columns of some recordings that have the same ones.
pub(super) fn columns_of_some(session: &Session, tests: &[usize]) -> Vec<Suspicion> {
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
        let says = format!("{label} is counted backwards in {name}: turn the sign of column {label} there");
        let undone = alone(scale_axis(session, axis, -1.0));
        let found = Suspicion::new(FaultKind::AxisSign, RECORDER, names.clone(), says, undone);
        list.push(Suspicion { components: vec![label.clone()], ..found });
        for &other in &recording.axes[index + 1..] {
            if session.machine.axes[axis].kind == session.machine.axes[other].kind {
                let swap = swapped(session, axis, other);
                let says = format!("in {name} {}", swap.says);
                let undone = alone(swap.undone);
                list.push(Suspicion { says, tests: names.clone(), weight: SOMETIMES, undone, ..swap });
            }
        }
    }
    list
}

/// Columns of an axis and where the session says that it stands, times a factor.
fn scale_axis(session: &Session, axis: usize, factor: f64) -> Session {
    let mut undone = scale_columns(session, axis, factor);
    undone.tests.iter_mut().filter_map(|test| test.positions[axis].as_mut()).for_each(|value| *value *= factor);
    undone
}

/// Columns of an axis times a factor.
fn scale_columns(session: &Session, axis: usize, factor: f64) -> Session {
    let mut undone = session.clone();
    for recording in undone.tests.iter_mut().filter_map(|test| test.recording.as_mut()) {
        if let Some(column) = recording.column_of(axis) {
            recording.positions[column].iter_mut().for_each(|value| *value *= factor);
        }
    }
    undone
}

pub(super) fn swapped(session: &Session, a: usize, b: usize) -> Suspicion {
    let mut undone = session.clone();
    for test in &mut undone.tests {
        test.positions.swap(a, b);
        if let Some(recording) = &mut test.recording {
            recording.axes.iter_mut().for_each(|axis| *axis = in_exchange(*axis, a, b));
        }
    }
    let (one, two) = (session.machine.axes[a].name.clone(), session.machine.axes[b].name.clone());
    let says = format!("columns {one} and {two} are exchanged: swap their headers");
    let found = Suspicion::new(FaultKind::AxisSwap, RECORDER, Vec::new(), says, undone);
    Suspicion { components: vec![one, two], weight: OFTEN, ..found }
}

/// Recordings of an axis that may be written from the wrong end.
#[derive(Clone, Copy)]
enum Struck {
    /// Those that rise in the files, or fall.
    Seen { rising: bool },
    /// Every second one of the runs repeated in one setup, from the first or from the second on: there and back written alike.
    Alternate { from: usize },
    /// All: one program wrote them.
    Every,
}

/// Which recordings of an axis came out of one conversion: those of it alone, those in which other axes move too, or all.
#[derive(Clone, Copy)]
enum Among {
    Alone,
    Followed,
    All,
}

impl Among {
    fn has(self, recording: &Recording) -> bool {
        match self {
            Among::Alone => recording.axes.len() == 1,
            Among::Followed => recording.axes.len() > 1,
            Among::All => true,
        }
    }
}

/// A few rows of a recording in time with the column of an axis turned round; `None` where it has none.
pub(crate) fn from_other_end(recording: &Recording, axis: usize) -> Option<Recording> {
    let place = recording.swept(axis)?;
    let mut turned = recording.clone();
    turned.positions[place].reverse();
    keep_few_rows(&mut turned);
    Some(turned)
}

/// Sweeps of an axis, some of them turned round.
fn reversed(sampled: Sampled<'_>, axis: usize, struck: Struck, among: Among) -> Option<Suspicion> {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let mut order: Vec<usize> = (0..session.tests.len()).collect();
    order.sort_by(|&a, &b| session.tests[a].started_at_s.total_cmp(&session.tests[b].started_at_s));
    let mut undone = thinned.clone();
    let mut runs: Vec<(usize, usize)> = Vec::new();
    let mut tests = Vec::new();
    for index in order {
        let Some(recording) = &session.tests[index].recording else { continue };
        let Some(place) = recording.swept(axis).filter(|_| among.has(recording)) else { continue };
        let run = match runs.iter_mut().find(|(first, _)| session.tests[*first].is_repeat_of(&session.tests[index])) {
            Some((_, run)) => {
                *run += 1;
                *run
            }
            None => {
                runs.push((index, 0));
                0
            }
        };
        let column = &recording.positions[place];
        let turned = match struck {
            Struck::Seen { rising } => (column.last() > column.first()) == rising,
            Struck::Alternate { from } => run % 2 == from,
            Struck::Every => true,
        };
        if turned {
            undone.tests[index].recording = from_other_end(recording, axis);
            tests.push(session.tests[index].name.clone());
        }
    }
    let name = session.machine.axes[axis].name.clone();
    (!tests.is_empty()).then(|| {
        let says = format!("{name} of these recordings is written from the wrong end: reverse the column");
        let found = Suspicion::new(FaultKind::AngleReversed, RECORDER, tests, says, undone);
        Suspicion { components: vec![name], weight: RARELY, ..found }
    })
}
