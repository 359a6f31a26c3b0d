//! What is done before the first test: senses ticked off one by one, all runs gone through without the bar. It computes nothing.

use std::fmt::Write as _;

use super::sheet::Sheet;
use crate::nc::little_words;
use crate::report::wording::markup::escape;

const HOW: &str = "Nothing is mounted and the bar stays off. Turn the overrides of rapid and feed low and keep a hand on the feed \
hold. The program stops before and after each move: tick what you have seen.";

const THEN: &str = "Then it goes through the way, the run and the way back of every test at half the feed, with pivot and \
spindle cup mounted at its stops and the bar off.";

/// The list of senses and the programs of the dry run; nothing without programs.
pub(super) fn dry_run(out: &mut String, sheet: &Sheet) {
    let (Some(first), false) = (sheet.plan.tests.first(), sheet.dry_runs.is_empty()) else { return };
    let _ = write!(
        out,
        "<h2>Before the first test: dry run</h2><p>{}</p><p>{HOW}</p><table class=\"wide\">",
        escape(&sheet.dry_runs.join(", "))
    );
    let tool = sheet.bodies.tool_direction(sheet.machine);
    for little in &sheet.plan.little_moves {
        let words = little_words(sheet.machine, first, little, tool.as_ref());
        let _ = write!(out, "<tr><td><span class=\"tick\"></span> {}</td></tr>", escape(&words));
    }
    let _ = write!(out, "</table><p>{THEN}</p>");
}
