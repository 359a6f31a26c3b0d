//! The tests of a session that were recorded: fits are of these alone. What was done to their positions is said.

use fiveaxis::session::Session;

use crate::verbs::output::remark;

/// The session without tests that are planned and not recorded yet; says which they are.
pub fn recorded(session: Session) -> Session {
    let (session, planned) = session.recorded();
    if session.tests.iter().all(|test| test.recording.is_none()) {
        let mut missing = session.tests.iter().filter_map(|test| test.recording_file.as_ref());
        match (missing.next(), missing.count()) {
            (None, _) => {}
            (Some(only), 0) => remark(format_args!("the recording '{only}' is not there")),
            (Some(first), others) => {
                remark(format_args!("no recording is there, neither '{first}' nor the other {others}"));
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
    let scattered: Vec<_> = session
        .tests
        .iter()
        .filter_map(|test| Some((test.stated_name(), test.recording.as_ref().and_then(|recording| recording.scatter)?)))
        .collect();
    let Some((first, scatter)) = scattered.first() else { return };
    let axis = &session.machine.axes[scatter.axis];
    let most = scattered.iter().map(|(_, scatter)| scatter.by).fold(0.0, f64::max);
    let others = match scattered.len() {
        1 => String::new(),
        count => format!(" and {} more", count - 1),
    };
    remark(format_args!(
        "test '{first}'{others}: positions of {} scatter by up to {:.2} {} rms and the readings do not follow, so they are read with noise; its even motion over a second is taken in their place",
        axis.name,
        axis.kind.to_file_unit(most),
        axis.kind.position_unit()
    ));
}
