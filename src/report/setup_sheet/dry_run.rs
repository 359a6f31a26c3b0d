//! What is done before the first test: senses ticked off one by one, all runs gone through without the bar. It computes nothing.

use std::fmt::Write as _;

use super::sheet::Sheet;
use crate::nc::little_words;
use crate::report::wording::markup::escape;

const HOW: &str = "The bar stays off all the way. Turn the overrides of rapid and feed low and keep a hand on the feed hold. \
First the senses, before anything is mounted. The program stops before and after each move: tick what you have seen.";

const THEN: &str = "Then the tests, one after the other. The program stops before each: mount its pivot and spindle cup, no bar. \
It goes through the way, the run at half the feed, and the way back.";

/// The list of senses and the programs of the dry run; nothing without programs.
pub(super) fn dry_run(out: &mut String, sheet: &Sheet) {
    let (Some(first), false) = (sheet.plan.tests.first(), sheet.dry_runs.is_empty()) else { return };
    let _ = write!(
        out,
        "<h2>Before the first test: dry run</h2><p>{}</p><p>{HOW}</p><table class=\"wide\">",
        escape(&sheet.dry_runs.join(", "))
    );
    for little in &sheet.plan.little_moves {
        let words = little_words(sheet.machine, first, little);
        let _ = write!(out, "<tr><td><span class=\"tick\"></span> {}</td></tr>", escape(&words));
    }
    let _ = write!(out, "</table><p>{THEN}</p>");
}
