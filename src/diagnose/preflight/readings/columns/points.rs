//! Senses, units, order and links of points and poses that coordinates tell, undone. Which mistake was made is for others to judge.

use nalgebra::Vector3;

use super::undone::{AS_READ, COORDINATES, Undone};
use crate::chain::Chain;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{RECORDER, SESSION};
use crate::machine::AxisKind;
use crate::session::{Recording, Session, Test, sighted_misfits};
use crate::units::OtherUnit;

/// Rows by which readings may stand beside those of other poses: a header lost, a pose left out, a table pasted beside another.
const MOST_ROWS_OFF: i64 = 3;

/// Largest distance of a test's points from the nominal chain at the size at which they were read, mm; `None` without points.
pub(super) fn points_mm(session: &Session, scale_of: &dyn Fn(&Test) -> f64) -> Option<f64> {
    let misfits = sighted_misfits(session, &Chain::of(&session.machine)).into_iter();
    misfits.map(|misfit| misfit.point_mm / scale_of(&session.tests[misfit.first])).reduce(f64::max)
}

/// Every mistake of points and poses that coordinates tell, undone.
pub(super) fn mistakes_of_points(session: &Session) -> Vec<Undone> {
    let mut list = senses(session);
    list.extend(exchanged(session));
    list.extend(units_of_positions(session));
    list.extend(columns_off(session));
    let exchanged = |of: Option<&str>, says: String| {
        let undone = with_coordinates(session, of, |point| Vector3::new(point.y, point.x, point.z));
        of_coordinates(FaultKind::SwappedColumns, says, undone)
    };
    list.extend(in_units(session, None));
    list.push(exchanged(None, EXCHANGED.into()));
    for name in sightings_if_several(session) {
        list.extend(in_units(session, Some(name)));
        list.push(exchanged(Some(name), format!("in {name} {EXCHANGED}")));
    }
    list.extend(other_links(session));
    list.extend(rows_off(session));
    list
}

/// With the instrument's axes unknown every exchange of two columns looks like every other, and like a mirrored axis.
pub(super) const EXCHANGED: &str = "two of the columns x, y and z of the readings are exchanged, or one of the instrument's axes is mirrored: correct the header";

/// Names of the tests of points and poses, where there is more than one.
pub(super) fn sightings_if_several(session: &Session) -> Vec<&str> {
    let firsts = session.tests.iter().filter(|test| test.is_first_of_sighting());
    let names: Vec<&str> = firsts.map(Test::stated_name).collect();
    if names.len() > 1 { names } else { Vec::new() }
}

/// Coordinates in another unit: of the test of that name, or of all.
pub(super) fn in_units<'s>(session: &'s Session, of: Option<&'s str>) -> impl Iterator<Item = Undone> + 's {
    let in_unit = move |OtherUnit { name: unit, size: factor }: OtherUnit| {
        let undone = with_coordinates(session, of, |point| point * factor);
        let whose = of.map_or_else(String::new, |name| format!(" of {name}"));
        let says = format!("coordinates{whose} are in {unit}: convert the columns to mm");
        let scale = (factor, of.map(|name| vec![name.to_string()]));
        Undone { scale, ..of_coordinates(FaultKind::Unit, says, undone) }
    };
    [OtherUnit::METRES, OtherUnit::INCHES, OtherUnit::MICROMETRES].into_iter().map(in_unit)
}

fn of_coordinates(kind: FaultKind, says: String, session: Session) -> Undone {
    Undone { kind, place: RECORDER, components: vec![COORDINATES.into()], says, session, scale: AS_READ }
}

/// Axes that count the other way: one, or all that carry the workpiece, as another convention has them.
fn senses(session: &Session) -> Vec<Undone> {
    let names = session.machine.axis_names();
    let with = |axes: &[usize]| {
        let mut other = session.clone();
        axes.iter().for_each(|&axis| other.machine.axes[axis].reversed ^= true);
        other
    };
    let one = |(axis, name): (usize, &&str)| Undone {
        kind: FaultKind::AxisSign,
        place: RECORDER,
        components: vec![name.to_string()],
        says: format!(
            "{name} counts the other way: add 'reversed: true' to it in the machine file, or take it away there"
        ),
        session: with(&[axis]),
        scale: AS_READ,
    };
    let mut list: Vec<Undone> = names.iter().enumerate().map(one).collect();
    let table = session.machine.table_axes();
    if table.len() > 1 {
        let components: Vec<String> = table.iter().map(|&axis| names[axis].to_string()).collect();
        let says = format!(
            "{} count the other way, all that carry the workpiece: state the other 'directions' (iso841 or carried) in the machine file",
            components.join(", ")
        );
        list.push(Undone {
            kind: FaultKind::AxisSign,
            place: SESSION,
            components,
            says,
            session: with(&table),
            scale: AS_READ,
        });
    }
    list
}

/// Columns of two axes of one kind exchanged.
fn exchanged(session: &Session) -> Vec<Undone> {
    let names = session.machine.axis_names();
    let pairs = (0..names.len()).flat_map(|one| (one + 1..names.len()).map(move |other| (one, other)));
    let alike = pairs.filter(|&(one, other)| session.machine.axes[one].kind == session.machine.axes[other].kind);
    let of = |(one, other): (usize, usize)| Undone {
        kind: FaultKind::SwappedColumns,
        place: RECORDER,
        components: vec![names[one].to_string(), names[other].to_string()],
        says: format!("the columns of {} and {} are exchanged: correct the header", names[one], names[other]),
        session: with_positions(session, |axis, value| {
            let other = if axis == one {
                other
            } else if axis == other {
                one
            } else {
                axis
            };
            (other, value)
        }),
        scale: AS_READ,
    };
    alike.map(of).collect()
}

/// Positions in another unit: of all axes of a kind, or of one.
fn units_of_positions(session: &Session) -> Vec<Undone> {
    let machine = &session.machine;
    let units = [
        (AxisKind::Rotary, OtherUnit::RADIANS),
        (AxisKind::Linear, OtherUnit::METRES),
        (AxisKind::Linear, OtherUnit::INCHES),
    ];
    let of_unit = |(kind, OtherUnit { name: unit, size: factor }): (AxisKind, OtherUnit)| {
        let (word, due) = match kind {
            AxisKind::Rotary => ("rotary", "degrees"),
            AxisKind::Linear => ("linear", "mm"),
        };
        let axes: Vec<usize> = (0..machine.axes.len()).filter(|&axis| machine.axes[axis].kind == kind).collect();
        let with = |struck: &[usize]| {
            with_positions(session, |axis, value| (axis, if struck.contains(&axis) { value * factor } else { value }))
        };
        let undone = |components: String, says: String, session: Session| Undone {
            kind: FaultKind::Unit,
            place: RECORDER,
            components: vec![components],
            says,
            session,
            scale: AS_READ,
        };
        let all = format!("positions of {word} axes are in {unit}: convert them to {due}");
        let mut list = vec![undone("positions".into(), all, with(&axes))];
        list.extend(axes.iter().filter(|_| axes.len() > 1).map(|&axis| {
            let name = &machine.axes[axis].name;
            undone(name.clone(), format!("{name} is in {unit}: convert the column to {due}"), with(&[axis]))
        }));
        list
    };
    units.into_iter().flat_map(of_unit).collect()
}

/// Where a test states the link of one of its ends.
type LinkOf = fn(&mut Test) -> &mut String;

/// Angles from which the zero of a rotary axis is off in another program, deg.
const OTHER_ZEROS_DEG: [f64; 3] = [90.0, -90.0, 180.0];

/// Columns of rotary axes that count from another zero.
fn columns_off(session: &Session) -> Vec<Undone> {
    let machine = &session.machine;
    let of = |axis: usize, by_deg: f64| {
        let name = &machine.axes[axis].name;
        Undone {
            kind: FaultKind::ColumnShifted,
            place: RECORDER,
            components: vec![name.clone()],
            says: format!("{name} stands {by_deg:+.0}° from where its column says: add {by_deg:.0} to the column"),
            session: with_positions(session, |own, value| {
                (own, if own == axis { value + by_deg.to_radians() } else { value })
            }),
            scale: AS_READ,
        }
    };
    machine.axes_of(AxisKind::Rotary).flat_map(|axis| OTHER_ZEROS_DEG.map(|by_deg| of(axis, by_deg))).collect()
}

/// Instruments and targets on another link than stated.
fn other_links(session: &Session) -> Vec<Undone> {
    let chain = Chain::of(&session.machine);
    let ends: [(&'static str, LinkOf); 2] =
        [("target", |test| &mut test.spindle_ball.link), ("instrument", |test| &mut test.pivot.link)];
    let mut list = Vec::new();
    for (end, link_of) in ends {
        let mut stated: Vec<String> = Vec::new();
        for test in session.tests.iter().filter(|test| test.is_sighted()) {
            let link = link_of(&mut test.clone()).clone();
            if !stated.contains(&link) {
                stated.push(link);
            }
        }
        for link in &stated {
            for other in
                chain.link_names().into_iter().filter(|other| other != link && chain.link(other) != chain.link(link))
            {
                let mut undone = session.clone();
                for test in undone.tests.iter_mut().filter(|test| test.is_sighted()) {
                    let own = link_of(test);
                    if own == link {
                        *own = other.to_string();
                    }
                }
                list.push(Undone {
                    kind: FaultKind::BallLink,
                    place: end,
                    components: vec![link.clone()],
                    says: format!("the {end} on {link} stands on {other}: correct its link in the session"),
                    session: undone,
                    scale: AS_READ,
                });
            }
        }
    }
    list
}

/// Readings beside the positions of earlier or later rows.
pub(super) fn rows_off(session: &Session) -> Vec<Undone> {
    let offs = (1..=MOST_ROWS_OFF).flat_map(|rows| [rows, -rows]);
    let of = |off: i64| {
        let mut undone = session.clone();
        for test in undone.tests.iter_mut().filter(|test| test.is_sighted()) {
            test.recording.iter_mut().for_each(|recording| moved_against_readings(recording, off));
        }
        let (rows, side) = (off.abs(), if off > 0 { "earlier" } else { "later" });
        let count = if rows == 1 { "one row".to_string() } else { format!("{rows} rows") };
        let says = format!(
            "readings stand {count} {side} than the positions of their poses: move the columns of one against those of the other"
        );
        Undone {
            kind: FaultKind::ReadingsOrder,
            place: RECORDER,
            components: vec![COORDINATES.into()],
            says,
            session: undone,
            scale: AS_READ,
        }
    };
    offs.map(of).collect()
}

/// Puts beside every reading the positions that stand so many rows later; rows without are not read.
fn moved_against_readings(recording: &mut Recording, off: i64) {
    let count = recording.len() as i64;
    for column in &mut recording.positions {
        let stated = column.clone();
        for (row, value) in column.iter_mut().enumerate() {
            *value = stated[(row as i64 + off).clamp(0, count - 1) as usize];
        }
    }
    for (row, length) in recording.length_mm.iter_mut().enumerate() {
        if !(0..count).contains(&(row as i64 + off)) {
            *length = f64::NAN;
        }
    }
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

/// Coordinates changed, row by row: of the test of that name, or of all.
pub(super) fn with_coordinates(
    session: &Session,
    of: Option<&str>,
    change: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> Session {
    let mut changed = session.clone();
    let is_changed = |test: &Test| test.is_first_of_sighting() && of.is_none_or(|name| name == test.stated_name());
    for first in (0..session.tests.len()).filter(|&test| is_changed(&session.tests[test])) {
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
