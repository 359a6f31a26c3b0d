//! Mistakes in columns and statements of points, poses and displacements, which no chain explains as they stand. Lengths have theirs in `mistakes`.
//!
//! With instruments and targets where they fit best, readings lie millimetres from the nominal chain. A wrong sense, unit, link or order of
//! columns puts them off by the size of the machine.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::chain::Chain;
use crate::diagnose::cause::MOST_RIVALS;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, Rival, SESSION};
use crate::identify::{Problem, residual_mm};
use crate::machine::AxisKind;
use crate::readings::{Kind, euler_xyz, quaternion, rotation, rotation_of_euler_xyz, rotation_of_quaternion};
use crate::session::{Recording, Session, Setups, Test, sighted_misfit};
use crate::statistics::{median, rms};
use crate::units::OtherUnit;

/// Undoing a mistake brings the readings so many times nearer to the nominal chain: nominal dimensions are off by millimetres, a
/// wrong sense by the size of the machine.
const LEAST_RATIO: f64 = 5.0;
/// Readings this near to the nominal chain hold no mistake of this kind, mm and rad: arms are built to millimetres and tenths of a degree.
const NEAR_NOMINAL_MM: f64 = 15.0;
const NEAR_NOMINAL_RAD: f64 = 0.05;
/// The same for a gauge, mm: it is used within its travel of some tenths.
const GAUGE_NEAR_NOMINAL_MM: f64 = 0.1;

/// Mistakes that leave up to so many times as much are as likely: nothing but nominal dimensions was compared.
const AS_LIKELY_UP_TO: f64 = 1.5;

/// Rows by which readings may stand beside those of other poses: a header lost, a pose left out, a table pasted beside another.
const MOST_ROWS_OFF: i64 = 3;

/// A mistake with the session as it would be without.
struct Undone {
    kind: FaultKind,
    place: &'static str,
    components: Vec<String>,
    says: String,
    session: Session,
}

/// What readings are compared by, over all of them: coordinates or rotations (mm or rad), or one gauge's displacements (mm).
type Measure = fn(&Session) -> Option<f64>;

/// A mistake in columns or statements that makes the readings fit the nominal chain once it is undone.
pub(crate) fn mistaken_columns(session: &Session) -> Option<DataFault> {
    best(session, points_mm, NEAR_NOMINAL_MM, 1e3, mistakes_of_points)
        .or_else(|| best(session, turns_rad, NEAR_NOMINAL_RAD, 1e3 * crate::readings::LEVER_MM, mistakes_of_rotations))
}

/// A gauge read with the other sign or in another unit. A fit turns the gauge round and leaves nothing of it: the stated direction tells.
pub(crate) fn mistaken_gauge(session: &Session) -> Option<DataFault> {
    best(session, gauges_mm, GAUGE_NEAR_NOMINAL_MM, 1e3, mistakes_of_gauges)
}

/// The mistake that leaves least by a measure, with those that leave as little.
fn best(
    session: &Session,
    measure: Measure,
    near: f64,
    to_um: f64,
    mistakes: fn(&Session) -> Vec<Undone>,
) -> Option<DataFault> {
    let before = measure(session).filter(|misfit| *misfit > near)?;
    let judged = mistakes(session).into_par_iter().filter_map(|one| Some((measure(&one.session)?, one)));
    let mut judged: Vec<(f64, Undone)> = judged.collect();
    judged.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut alike = judged.into_iter();
    let (after, best) = alike.next().filter(|(after, _)| before > LEAST_RATIO * after)?;
    let rivals = alike.take_while(|(other, _)| *other < AS_LIKELY_UP_TO * after).take(MOST_RIVALS).map(|(_, other)| {
        let Undone { kind, place, components, says, .. } = other;
        Rival { kind, place: place.to_string(), components, says, probability: 0.0 }
    });
    let fault = DataFault {
        components: best.components,
        before_um: to_um * before,
        after_um: to_um * after,
        rivals: rivals.collect(),
        ..DataFault::seen(best.kind, best.place, Vec::new(), best.says)
    };
    Some(fault.shared_evenly())
}

fn points_mm(session: &Session) -> Option<f64> {
    sighted_misfit(session, &Chain::of(&session.machine)).map(|misfit| misfit.point_mm)
}

fn turns_rad(session: &Session) -> Option<f64> {
    sighted_misfit(session, &Chain::of(&session.machine))?.turn_rad
}

/// The largest scatter of a gauge about the nominal chain, its zero wherever it fits best.
fn gauges_mm(session: &Session) -> Option<f64> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let problem = Problem::new(session, &chain, &setups, Vec::new()).ok()?;
    let residual_mm = residual_mm(&problem, &[]);
    let scatter = |test: usize| {
        let read = || residual_mm[test].iter().copied().filter(|value| value.is_finite());
        let zero = median(read())?;
        Some(rms(read().map(|value| value - zero)))
    };
    (0..session.tests.len()).filter(|&test| is_gauge(&session.tests[test])).filter_map(scatter).max_by(f64::total_cmp)
}

fn is_gauge(test: &Test) -> bool {
    test.reading.part().is_some_and(|part| part.kind == Kind::Displacement)
}

/// Every mistake of points and poses that coordinates tell, undone.
fn mistakes_of_points(session: &Session) -> Vec<Undone> {
    let mut list = senses(session);
    list.extend(exchanged(session));
    list.extend(units_of_positions(session));
    for OtherUnit { name: unit, size: factor } in [OtherUnit::METRES, OtherUnit::INCHES] {
        let undone = with_coordinates(session, |point| point * factor);
        list.push(of_coordinates(
            FaultKind::Unit,
            format!("coordinates are in {unit}: convert the columns to mm"),
            undone,
        ));
    }
    // with the instrument's axes unknown every exchange of two columns looks like every other, and like a mirrored axis
    let says = "two of the columns x, y and z of the readings are exchanged, or one of the instrument's axes is mirrored: correct the header";
    let swapped = with_coordinates(session, |point| Vector3::new(point.y, point.x, point.z));
    list.push(of_coordinates(FaultKind::SwappedColumns, says.into(), swapped));
    list.extend(other_links(session));
    list.extend(rows_off(session));
    list
}

fn of_coordinates(kind: FaultKind, says: String, session: Session) -> Undone {
    Undone { kind, place: RECORDER, components: vec!["coordinates".into()], says, session }
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
    };
    let mut list: Vec<Undone> = names.iter().enumerate().map(one).collect();
    let table = session.machine.table_axes();
    if table.len() > 1 {
        let components: Vec<String> = table.iter().map(|&axis| names[axis].to_string()).collect();
        let says = format!(
            "{} count the other way, all that carry the workpiece: state the other 'directions' (iso841 or carried) in the machine file",
            components.join(", ")
        );
        list.push(Undone { kind: FaultKind::AxisSign, place: SESSION, components, says, session: with(&table) });
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

/// A rotation as it would be, read in another form.
type Reread = fn(&Matrix3<f64>) -> Matrix3<f64>;

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
                });
            }
        }
    }
    list
}

/// Readings beside the positions of earlier or later rows.
fn rows_off(session: &Session) -> Vec<Undone> {
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
            components: vec!["coordinates".into()],
            says,
            session: undone,
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

/// Ways in which rotations are written by mistake: the column that shows their form (none for any), the fault, what to do, how they are
/// read anew.
const ROTATIONS: [(Option<&str>, FaultKind, &str, Reread); 6] = [
    (
        None,
        FaultKind::RotationForm,
        "rotations are those of the instrument in the target's axes: invert them (turn the signs of qx, qy and qz, or transpose the matrix)",
        Matrix3::transpose,
    ),
    (
        Some("qw"),
        FaultKind::RotationForm,
        "quaternions have their real part last: rename the columns to qx, qy, qz, qw",
        real_part_last,
    ),
    (Some("rx_deg"), FaultKind::Unit, "angles of the rotations are in radians: convert them to degrees", |read| {
        rotation_of_euler_xyz(euler_xyz(read).map(f64::to_degrees))
    }),
    (
        Some("rx_deg"),
        FaultKind::RotationForm,
        "angles of the rotations are about fixed axes, x first (Rz·Ry·Rx): state the quaternion",
        |read| about_fixed(euler_xyz(read)),
    ),
    (
        Some("rx_deg"),
        FaultKind::RotationForm,
        "angles of the rotations are about z, then y, then x (as A, B, C of a robot): rename them",
        |read| {
            let [about_z, about_y, about_x] = euler_xyz(read);
            about_fixed([about_x, about_y, about_z])
        },
    ),
    (
        Some("rx_deg"),
        FaultKind::RotationForm,
        "the three numbers of the rotations are a rotation vector: state the quaternion",
        |read| rotation(&Vector3::from(euler_xyz(read))),
    ),
];

fn real_part_last(read: &Matrix3<f64>) -> Matrix3<f64> {
    let [w, x, y, z] = quaternion(read);
    rotation_of_quaternion([z, w, x, y])
}

/// Every way in which rotations may have been written otherwise than the columns say, undone.
fn mistakes_of_rotations(session: &Session) -> Vec<Undone> {
    let columns = session.tests.iter().filter_map(|test| test.reading.part()).find(|part| part.kind == Kind::Pose);
    let has = |name: &str| columns.is_some_and(|part| part.columns.iter().any(|column| column == name));
    ROTATIONS
        .into_iter()
        .filter(|(column, ..)| column.is_none_or(has))
        .map(|(_, kind, says, way)| Undone {
            kind,
            place: RECORDER,
            components: vec!["rotations".into()],
            says: says.into(),
            session: with_rotations(session, way),
        })
        .collect()
}

/// Turns about fixed axes, x first: Rz·Ry·Rx.
fn about_fixed([x, y, z]: [f64; 3]) -> Matrix3<f64> {
    let about = |axis: Vector3<f64>, angle: f64| rotation(&(axis * angle));
    about(Vector3::z(), z) * about(Vector3::y(), y) * about(Vector3::x(), x)
}

/// Senses and units of displacements: of one gauge, undone.
fn mistakes_of_gauges(session: &Session) -> Vec<Undone> {
    let factors = [
        (-1.0, FaultKind::ReadingSign, "has the other sign: turn its direction, or the sign of the column"),
        (1e3, FaultKind::Unit, "is in metres: convert the column to mm"),
        (1e-3, FaultKind::Unit, "is in µm: convert the column to mm"),
        (OtherUnit::INCHES.size, FaultKind::Unit, "is in inches: convert the column to mm"),
    ];
    let mut gauges: Vec<&Test> = Vec::new();
    for test in session.tests.iter().filter(|test| is_gauge(test)) {
        if !gauges.iter().any(|gauge| gauge.pivot == test.pivot && gauge.stated_name() == test.stated_name()) {
            gauges.push(test);
        }
    }
    let every: Vec<String> = gauges.iter().map(|gauge| gauge.name.clone()).collect();
    let mut groups: Vec<Vec<String>> = every.iter().map(|name| vec![name.clone()]).collect();
    if every.len() > 1 {
        groups.push(every);
    }
    let of = |names: &Vec<String>| {
        let whom = match names.len() {
            1 => format!("the displacement of {}", names[0]),
            _ => "every displacement".to_string(),
        };
        factors.map(|(factor, kind, words)| {
            let mut undone = session.clone();
            for test in undone.tests.iter_mut().filter(|test| names.contains(&test.name)) {
                let lengths = test.recording.iter_mut().flat_map(|recording| &mut recording.length_mm);
                lengths.for_each(|value| *value *= factor);
            }
            let (components, says) = (vec!["displacement".to_string()], format!("{whom} {words}"));
            Undone { kind, place: RECORDER, components, says, session: undone }
        })
    };
    groups.iter().flat_map(of).collect()
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
    for first in (0..session.tests.len()).filter(|&test| session.tests[test].is_first_of_sighting()) {
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

/// Rotations changed, row by row.
fn with_rotations(session: &Session, change: Reread) -> Session {
    let mut changed = session.clone();
    for part in changed.tests.iter_mut().filter_map(|test| test.reading.part_mut()) {
        part.measured = Arc::new(part.measured.iter().map(change).collect());
    }
    changed
}
