//! Sessions with one mistake of the files undone: a sign, two names, a unit, an order, a clock. Which mistake was made is for others to judge.

use super::data_fault::{RECORDER, SESSION};
use super::dwells::without_dwells;
use super::places::axis_order::{in_exchange, other_orders};
use super::places::exchanged;
use super::places::folded::without_sign;
use super::places::foreign::foreign;
use super::places::misplaced::on_any_link;
use super::places::standing::{columns_off, slides_off, stood_still};
use super::places::sweeps::other_arcs;
use super::quick_fit::Refit;
use super::readings::figures::Linearised;
use super::readings::order::out_of_order;
use super::readings::processed::own_zeros;
use super::readings::scaled::{scaled, scaled_by_any, zeroed};
use super::readings::taken_off::taken_off;
use super::readings::unsigned::unsigned;
use super::suspicion::{OFTEN, RARELY, SOMETIMES, Suspicion};
use crate::diagnose::model::decimate::keep_few_rows;
use crate::machine::{AxisKind, Directions};
use crate::session::{Clock, Recording, Session, Setups};
use crate::statistics::rms;

/// All mistakes that are tried on the thinned session; shifts in time are made on all rows, whose arcs are nearly straight.
pub(crate) fn suspicions(session: &Session, whole: &Session, as_it_is: &Refit) -> Vec<Suspicion> {
    let mut list = Vec::new();
    let worst = worst_tests(&as_it_is.residual_mm);
    let machine = &session.machine;
    let busy: Vec<usize> = (0..machine.axes.len())
        .filter(|&axis| {
            session.tests.iter().any(|test| test.recording.as_ref().is_some_and(|r| r.axes.contains(&axis)))
        })
        .collect();
    list.extend(busy.iter().flat_map(|&axis| of_an_axis((session, whole), axis)));
    list.extend(senses_together(session));
    for (index, &a) in busy.iter().enumerate() {
        for &b in &busy[index + 1..] {
            if machine.axes[a].kind == machine.axes[b].kind {
                list.push(swapped(session, a, b));
            }
        }
    }
    let every = [(0..session.tests.len()).collect::<Vec<usize>>()];
    // of tests alone only the worst ones are worth the refits
    let alone: Vec<Vec<usize>> = worst.iter().map(|&test| vec![test]).collect();
    for tests in &distinct([&every, &of_one_way(session, &every), &alone]) {
        list.extend(SHIFTS_S.iter().map(|seconds| shifted((session, whole), tests, *seconds)));
    }
    list.extend(alone.iter().flat_map(|test| columns_of_some(session, test)));
    list.extend(without_dwells(session, whole));
    list.extend(on_any_link(session));
    list.extend(exchanged::with_worst(session, &worst));
    let programs = worst_programs(session, &worst);
    list.extend(exchanged::programs(session, &programs));
    list.extend(other_arcs(session));
    list.extend(other_orders(session));
    let alike = alike(session);
    let of_one_way = of_one_way(session, &alike);
    // of one recording alone a shift in time says as much
    list.extend(columns_off(session, &distinct([&programs, &of_one_way])));
    let of_bars = of_bars(session);
    list.extend(scaled(session, &distinct([&programs, &alone, &alike, &of_bars])));
    // a gauge taken down between the directions has another zero in one of them
    list.extend(zeroed(session, &distinct([&programs, &alone, &alike])));
    list.extend(distinct([&alone, &programs]).iter().flat_map(|tests| foreign(session, tests)));
    list.extend(stood_still(session, &distinct([&alone, &programs])));
    list.extend(own_zeros(session, whole));
    if let Some(linearised) = Linearised::of(session, as_it_is) {
        list.extend(slides_off(session, &linearised, &distinct([&alone, &programs])));
        list.extend(scaled_by_any(session, &linearised, &distinct([&alone, &programs, &alike, &of_one_way, &of_bars])));
        list.extend(out_of_order((session, whole), &linearised, &worst, &programs));
        list.extend(taken_off((session, whole), &linearised));
        list.extend(unsigned((session, whole), &linearised));
    }
    list.extend(of_one_conversion(session));
    list
}

/// Groups of tests, each once.
fn distinct<const N: usize>(of: [&[Vec<usize>]; N]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for group in of.into_iter().flatten() {
        if !groups.contains(group) {
            groups.push(group.clone());
        }
    }
    groups
}

/// Of groups of tests, those whose first axis goes one way, where there are several but not all.
fn of_one_way(session: &Session, groups: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let rises = |test: &usize| {
        let recording = session.tests[*test].recording.as_ref();
        let column = recording.and_then(|recording| recording.positions.first());
        column.is_some_and(|column| column.last() > column.first())
    };
    let ways = groups.iter().flat_map(|tests| {
        let (rising, falling): (Vec<usize>, Vec<usize>) = tests.iter().copied().partition(rises);
        [rising, falling]
    });
    ways.filter(|way| (2..session.tests.len()).contains(&way.len())).collect()
}

/// Columns of one axis in another sense or unit, in all tests or in some.
fn of_an_axis((session, whole): (&Session, &Session), axis: usize) -> Vec<Suspicion> {
    let (name, kind) = (session.machine.axes[axis].name.clone(), session.machine.axes[axis].kind);
    let scaled = |effect: &'static str, factor: f64, says: String| Suspicion {
        effect,
        place: RECORDER.into(),
        components: vec![name.clone()],
        tests: Vec::new(),
        says,
        shift_ms: None,
        diminished: 1.0,
        log_figures: 0.0,
        is_found: false,
        weight: OFTEN,
        undone: scale_axis(session, axis, factor),
    };
    let backwards = format!("{name} is counted backwards: turn the sign of column {name}, or set 'reversed: true'");
    let mut list = vec![scaled("axis-sign", -1.0, backwards)];
    list.push(match kind {
        AxisKind::Linear => scaled("unit", 25.4, format!("{name} is in inches: convert the column to mm")),
        AxisKind::Rotary => {
            let says = format!("{name} is in radians: convert the column to degrees");
            scaled("unit", 180.0 / std::f64::consts::PI, says)
        }
    });
    if kind == AxisKind::Linear {
        return list;
    }
    list.extend(without_sign((session, whole), axis));
    let alternate = [0, 1].map(|from| Struck::Alternate { from });
    for struck in [Struck::Seen { rising: true }, Struck::Seen { rising: false }].into_iter().chain(alternate) {
        let mut told: Vec<Vec<String>> = Vec::new();
        for among in [Among::Alone, Among::Followed, Among::All] {
            let suspicion = reversed((session, whole), axis, struck, among);
            list.extend(suspicion.filter(|suspicion| !told.contains(&suspicion.tests)).inspect(|suspicion| {
                told.push(suspicion.tests.clone());
            }));
        }
    }
    list
}

/// The axes that carry the workpiece, or all axes, with the other sense: the convention that the machine file states, or does not.
fn senses_together(session: &Session) -> Vec<Suspicion> {
    let machine = &session.machine;
    let names = |axes: &[usize]| -> Vec<String> { axes.iter().map(|&axis| machine.axes[axis].name.clone()).collect() };
    let turned = |axes: &[usize]| {
        let mut undone = session.clone();
        axes.iter().for_each(|&axis| undone.machine.axes[axis].reversed ^= true);
        undone
    };
    let table: Vec<usize> = (0..machine.code.workpiece_side.len()).collect();
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
            let mut found = Suspicion::new("axis-sign", SESSION, Vec::new(), says, turned(axes));
            (found.components, found.weight) = (names(axes), OFTEN);
            list.push(found);
        }
    }
    list
}

/// Recordings with the same columns come out of one conversion.
fn of_one_conversion(session: &Session) -> Vec<Suspicion> {
    alike(session).iter().flat_map(|tests| columns_of_some(session, tests)).collect()
}

/// Tests with the same columns, where there are several but not all.
fn alike(session: &Session) -> Vec<Vec<usize>> {
    let moving = |test: usize| session.tests[test].recording.as_ref().map(|recording| &recording.axes);
    let with = |first: usize| -> Vec<usize> {
        (0..session.tests.len()).filter(|&test| moving(test) == moving(first)).collect()
    };
    let is_part = |tests: &Vec<usize>| (2..session.tests.len()).contains(&tests.len());
    (0..session.tests.len())
        .map(|first| (first, with(first)))
        .filter(|(first, tests)| tests[0] == *first && is_part(tests))
        .map(|(_, tests)| tests)
        .collect()
}

/// Tests with the same bar, where there are several but not all.
fn of_bars(session: &Session) -> Vec<Vec<usize>> {
    let bar_of = Setups::of(session).bar_of;
    let bars = 0..bar_of.iter().flatten().max().map_or(0, |last| last + 1);
    let with = |bar: usize| (0..bar_of.len()).filter(|&test| bar_of[test] == Some(bar)).collect::<Vec<usize>>();
    bars.map(with).filter(|tests| (2..session.tests.len()).contains(&tests.len())).collect()
}

/// The programs of the tests that fit worst: each with its other directions and repeats.
fn worst_programs(session: &Session, worst: &[usize]) -> Vec<Vec<usize>> {
    let mut programs: Vec<Vec<usize>> = Vec::new();
    for &test in worst {
        let repeats = exchanged::repeats(session, test);
        if !programs.contains(&repeats) {
            programs.push(repeats);
        }
    }
    programs
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
            place: RECORDER.into(),
            components: vec![label.clone()],
            tests: names.clone(),
            says: format!("{label} is counted backwards in {name}: turn the sign of column {label} there"),
            shift_ms: None,
            diminished: 1.0,
            log_figures: 0.0,
            is_found: false,
            weight: SOMETIMES,
            undone: alone(scale_axis(session, axis, -1.0)),
        });
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

/// Shifts tried, s.
const SHIFTS_S: &[f64] =
    &[-3.0, -2.4, -1.9, -1.5, -1.2, -0.95, -0.75, -0.6, -0.45, 0.45, 0.6, 0.75, 0.95, 1.2, 1.5, 1.9, 2.4, 3.0];

/// Single tests tried for a shift.
const WORST_TESTS: usize = 3;

/// Tests with the largest residual in a common fit.
pub(crate) fn worst_tests(residual_mm: &[Vec<f64>]) -> Vec<usize> {
    let mut order: Vec<(usize, f64)> =
        residual_mm.iter().map(|residual| rms(residual.iter().copied())).enumerate().collect();
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
            && let Some(column) = recording.column_of(axis)
        {
            recording.positions[column].iter_mut().for_each(|value| *value *= factor);
        }
    }
    undone
}

fn swapped(session: &Session, a: usize, b: usize) -> Suspicion {
    let mut undone = session.clone();
    for test in &mut undone.tests {
        test.positions.swap(a, b);
        if let Some(recording) = &mut test.recording {
            recording.axes.iter_mut().for_each(|axis| *axis = in_exchange(*axis, a, b));
        }
    }
    let (one, two) = (session.machine.axes[a].name.clone(), session.machine.axes[b].name.clone());
    Suspicion {
        effect: "axis-swap",
        place: RECORDER.into(),
        says: format!("columns {one} and {two} are exchanged: swap their headers"),
        components: vec![one, two],
        tests: Vec::new(),
        shift_ms: None,
        diminished: 1.0,
        log_figures: 0.0,
        is_found: false,
        weight: OFTEN,
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
fn reversed((thinned, session): (&Session, &Session), axis: usize, struck: Struck, among: Among) -> Option<Suspicion> {
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
        };
        if turned {
            undone.tests[index].recording = from_other_end(recording, axis);
            tests.push(session.tests[index].name.clone());
        }
    }
    let name = session.machine.axes[axis].name.clone();
    (!tests.is_empty()).then(|| Suspicion {
        effect: ANGLE_REVERSED,
        place: RECORDER.into(),
        says: format!("{name} of these recordings is written from the wrong end: reverse the column"),
        components: vec![name],
        tests,
        shift_ms: None,
        diminished: 1.0,
        log_figures: 0.0,
        is_found: false,
        weight: RARELY,
        undone,
    })
}

/// Positions moved against the lengths by some seconds in some tests of the thinned session.
pub(crate) fn shifted((thinned, session): (&Session, &Session), tests: &[usize], seconds: f64) -> Suspicion {
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
        place: RECORDER.into(),
        says: shift_in_words(seconds, &names),
        components: Vec::new(),
        tests: names,
        shift_ms: Some(1e3 * seconds),
        diminished: 1.0,
        log_figures: 0.0,
        is_found: true,
        weight: RARELY,
        undone,
    }
}

pub(crate) const TIME_SHIFT: &str = "time-shift";
pub(crate) const ANGLE_REVERSED: &str = "angle-reversed";

/// A shift of all tests (no names) or some.
pub(crate) fn shift_in_words(seconds: f64, names: &[String]) -> String {
    let which = if names.is_empty() { "all tests".to_string() } else { names.join(", ") };
    format!("lengths and positions are {seconds:.2} s apart in {which}: pair them by one clock")
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
