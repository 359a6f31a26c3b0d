//! The tests of a session that were recorded: fits are of these alone. What was done to their positions is said.

use std::collections::BTreeSet;

use fiveaxis::machine::AxisKind;
use fiveaxis::session::{Scatter, Session, Test};
use fiveaxis::units::UM_PER_MM;

use crate::verbs::output::remark;

/// The session without tests that are planned and not recorded yet; says which they are.
pub fn recorded(session: Session) -> Session {
    let (session, planned) = session.recorded();
    if session.tests.iter().all(|test| test.recording.is_none()) {
        let named: Vec<&String> = session.tests.iter().filter_map(|test| test.recording_file.as_ref()).collect();
        let files: BTreeSet<&String> = named.iter().copied().collect();
        match (named.first(), files.len()) {
            (None, _) => {}
            (Some(only), 1) => remark(format_args!("the recording '{only}' is not there")),
            (Some(first), files) => {
                remark(format_args!("no recording is there, neither '{first}' nor the other {}", files - 1));
            }
        }
    }
    if let Some(first) = planned.first() {
        let which = match planned.len() {
            1 => format!("test '{first}' has no recording: it is"),
            count => format!("{count} tests have no recording, '{first}' first: they are"),
        };
        remark(format_args!(
            "{which} left out here, and of what --save writes; the axes are taken as not having moved in between"
        ));
    }
    tell_scatter(&session);
    session
}

/// Says whose positions scatter without the readings following.
pub fn tell_scatter(session: &Session) {
    let of_test =
        |test: &'_ Test| Some((test.stated_name().to_string(), test.recording.as_ref().and_then(|read| read.scatter)?));
    let mut scattered: Vec<(String, Scatter)> = session.tests.iter().filter_map(of_test).collect();
    scattered.dedup_by(|(one, _), (other, _)| one == other);
    let Some((first, Scatter { axis, .. })) = scattered.first() else { return };
    let of_axis = || scattered.iter().map(|(_, scatter)| scatter).filter(|scatter| scatter.axis == *axis);
    let most = of_axis().map(|scatter| scatter.by).fold(0.0, f64::max);
    let others = match scattered.len() {
        1 => String::new(),
        count => format!(" and {} more", count - 1),
    };
    let axis = &session.machine.axes[*axis];
    let size = match axis.kind {
        AxisKind::Linear => format!("{:.1} µm", most * UM_PER_MM),
        AxisKind::Rotary => format!("{:.3}°", most.to_degrees()),
    };
    remark(format_args!(
        "test '{first}'{others}: positions of {} scatter by up to {size} rms and the readings do not follow, so they are read with noise; its even motion over a second is taken in their place",
        axis.name
    ));
}
