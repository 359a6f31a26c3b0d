//! Rotations that were written in another form than the columns say, undone. Which form it was is for others to judge.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::undone::{AS_READ, Undone};
use crate::chain::Chain;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::RECORDER;
use crate::readings::{Kind, euler_xyz, quaternion, rotation, rotation_of_euler_xyz, rotation_of_quaternion};
use crate::session::{Session, Test, sighted_misfits};

/// A rotation as it would be, read in another form.
type Reread = fn(&Matrix3<f64>) -> Matrix3<f64>;

/// Angle between the rotations and the nominal chain, rad; `None` without rotations.
pub(super) fn turns_rad(session: &Session, _scale_of: &dyn Fn(&Test) -> f64) -> Option<f64> {
    sighted_misfits(session, &Chain::of(&session.machine))
        .into_iter()
        .filter_map(|misfit| misfit.turn_rad)
        .reduce(f64::max)
}

/// A way in which rotations are written by mistake.
struct OtherForm {
    /// The column that shows their form; `None` for any.
    column: Option<&'static str>,
    kind: FaultKind,
    says: &'static str,
    reread: Reread,
}

impl OtherForm {
    const fn new(column: Option<&'static str>, kind: FaultKind, says: &'static str, reread: Reread) -> OtherForm {
        OtherForm { column, kind, says, reread }
    }
}

const OTHER_FORMS: [OtherForm; 6] = [
    OtherForm::new(
        None,
        FaultKind::RotationForm,
        "rotations are those of the instrument in the target's axes: invert them (turn the signs of qx, qy and qz, or transpose the matrix)",
        Matrix3::transpose,
    ),
    OtherForm::new(
        Some("qw"),
        FaultKind::RotationForm,
        "quaternions have their real part last: rename the columns to qx, qy, qz, qw",
        real_part_last,
    ),
    OtherForm::new(
        Some("rx_deg"),
        FaultKind::Unit,
        "angles of the rotations are in radians: convert them to degrees",
        |read| rotation_of_euler_xyz(euler_xyz(read).map(f64::to_degrees)),
    ),
    OtherForm::new(
        Some("rx_deg"),
        FaultKind::RotationForm,
        "angles of the rotations are about fixed axes, x first (Rz·Ry·Rx): state the quaternion",
        |read| about_fixed(euler_xyz(read)),
    ),
    OtherForm::new(
        Some("rx_deg"),
        FaultKind::RotationForm,
        "angles of the rotations are about z, then y, then x (as A, B, C of a robot): rename them",
        |read| {
            let [about_z, about_y, about_x] = euler_xyz(read);
            about_fixed([about_x, about_y, about_z])
        },
    ),
    OtherForm::new(
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
pub(super) fn mistakes_of_rotations(session: &Session) -> Vec<Undone> {
    let columns = session.tests.iter().filter_map(|test| test.reading.part()).find(|part| part.kind == Kind::Pose);
    let has = |name: &str| columns.is_some_and(|part| part.columns.iter().any(|column| column == name));
    OTHER_FORMS
        .into_iter()
        .filter(|form| form.column.is_none_or(has))
        .map(|form| Undone {
            scale: AS_READ,
            kind: form.kind,
            place: RECORDER,
            components: vec!["rotations".into()],
            says: form.says.into(),
            session: with_rotations(session, form.reread),
        })
        .collect()
}

/// Turns about fixed axes, x first: Rz·Ry·Rx.
fn about_fixed([x, y, z]: [f64; 3]) -> Matrix3<f64> {
    let about = |axis: Vector3<f64>, angle: f64| rotation(&(axis * angle));
    about(Vector3::z(), z) * about(Vector3::y(), y) * about(Vector3::x(), x)
}

/// Rotations changed, row by row.
fn with_rotations(session: &Session, change: Reread) -> Session {
    let mut changed = session.clone();
    for part in changed.tests.iter_mut().filter_map(|test| test.reading.part_mut()) {
        part.measured = Arc::new(part.measured.iter().map(change).collect());
    }
    changed
}
