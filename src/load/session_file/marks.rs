//! The marks of a test in a session file: moves along the bar before and after each direction, with their rests.

use super::test_file::TestFile;
use super::test_reader::TestReader;
use crate::load::checked_text::document::Step;
use crate::load::checked_text::message::LoadError;
use crate::session::Marks;
use crate::units::shown;

/// Shortest and longest move, mm: what a gauge surely shows, and the travel of long bars.
const MOVES_MM: [f64; 2] = [0.01, 10.0];
/// What a gauge may show of a move, mm.
const SEEN_MM: [f64; 2] = [0.0, 2.0 * MOVES_MM[1]];
/// Feeds of a move, mm/min.
const FEEDS: [f64; 2] = [0.1, 10_000.0];
/// Times at rest, s: what a control counts, and an hour.
const RESTS_S: [f64; 2] = [0.01, 3600.0];

impl TestReader<'_> {
    /// The marks of a test; `None` where its program makes none.
    pub(super) fn marks(&self, index: usize, raw: &TestFile) -> Result<Option<Marks>, LoadError> {
        let Some(marks) = &raw.marks else { return Ok(None) };
        let seen = marks.seen.unwrap_or_default().map(|seen_mm| ("seen", seen_mm.abs(), SEEN_MM, "mm"));
        let stated = [
            ("move", marks.move_mm.abs(), MOVES_MM, "mm, longer or shorter"),
            ("feed", marks.feed, FEEDS, "mm/min"),
            ("hold", marks.hold, RESTS_S, "s"),
            ("rest", marks.rest, RESTS_S, "s"),
            ("gap", marks.gap, RESTS_S, "s"),
        ];
        for (key, value, [least, most], unit) in stated.into_iter().chain(seen) {
            if !(least..=most).contains(&value) {
                return Err(self.document.refuse(
                    &[Step::Key("tests"), Step::Index(index), Step::Key("marks"), Step::Key(key)],
                    format!(
                        "test '{}': {key} {} of marks is not from {least} to {most} {unit}",
                        raw.name,
                        shown(value)
                    ),
                ));
            }
        }
        Ok(Some(Marks {
            move_mm: marks.move_mm,
            feed_mm_per_min: marks.feed,
            hold_s: marks.hold,
            rest_s: marks.rest,
            gap_s: marks.gap,
            seen_mm: marks.seen,
        }))
    }
}
