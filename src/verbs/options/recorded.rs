//! The tests of a session that were recorded: fits are of these alone.

use fiveaxis::session::Session;

use crate::verbs::output::remark;

/// The session without tests that are planned and not recorded yet; says which they are.
pub fn recorded(session: Session) -> Session {
    let (session, planned) = session.recorded();
    if let Some(first) = planned.first() {
        let which = match planned.len() {
            1 => format!("test '{first}' has no recording: it is"),
            count => format!("{count} tests have no recording, '{first}' first: they are"),
        };
        remark(format_args!(
            "{which} left out here, and of what --save writes; the axes are taken as not having moved in between"
        ));
    }
    session
}
