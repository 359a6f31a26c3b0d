//! A pivot and a spindle ball that stand in each other's place: the spindle carries the one, the table the other.

use crate::chain::{Branch, Chain, LinkId};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, listed};
use crate::session::{Session, Test};

/// Tests whose spindle ball is carried by the workpiece's side and whose pivot by the tool's. Lengths do not tell: a bar measures both ways alike.
pub(super) fn exchanged(session: &Session) -> Option<DataFault> {
    let chain = Chain::of(&session.machine);
    let is_exchanged = |test: &&Test| {
        let [pivot, ball]: [Option<LinkId>; 2] = [&test.pivot, &test.spindle_ball].map(|ball| chain.link(&ball.link));
        let is_of_tool = pivot.is_some_and(|link| link.branch == Branch::Tool && link.depth > 0);
        is_of_tool && ball.is_some_and(|link| link.branch == Branch::Workpiece || link.depth == 0)
    };
    let names: Vec<String> = session.tests.iter().filter(is_exchanged).map(|test| test.name.clone()).collect();
    let first = session.tests.iter().find(is_exchanged)?;
    let says = format!(
        "in {} the spindle ball stands on {}, on the side of the workpiece, and the pivot on {}, which the tool's side carries: 'pivot' and \
         'spindle_ball' are exchanged; exchange them in the session",
        listed(&names),
        first.spindle_ball.link,
        first.pivot.link
    );
    Some(DataFault::seen(FaultKind::BallLink, "spindle-ball", names, says))
}
