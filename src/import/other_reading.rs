//! Marks that are in the readings at another sense, unit or clock than the capture's: what to say of readings named wrongly.

use super::capture::Capture;
use super::course::{Feeds, Pair};
use super::error::ImportError;
use super::marks::{Found, find};
use crate::session::{Marks, Session};
use crate::units::MM_PER_INCH;

/// What a capture's numbers may be instead.
struct OtherNumbers {
    /// Factor that the readings lack, and one that the times lack.
    readings: f64,
    times: f64,
    says: &'static str,
    cure: &'static str,
}

impl OtherNumbers {
    const fn readings(factor: f64, says: &'static str, cure: &'static str) -> OtherNumbers {
        OtherNumbers { readings: factor, times: 1.0, says, cure }
    }

    const fn times(factor: f64, says: &'static str, cure: &'static str) -> OtherNumbers {
        OtherNumbers { readings: 1.0, times: factor, says, cure }
    }
}

const OTHERS: [OtherNumbers; 10] = [
    OtherNumbers::readings(-1.0, "the readings have the other sense", "change the sign of the readings"),
    OtherNumbers::readings(
        1e3,
        "the readings are a thousand times too small, millimetres taken as µm or metres as millimetres",
        "name the readings by their unit, e.g. deviation_mm, or say --unit deviation-mm",
    ),
    OtherNumbers::readings(
        1e-3,
        "the readings are a thousand times too large, µm taken as millimetres",
        "name the readings by their unit, e.g. deviation_um, or say --unit deviation-um",
    ),
    OtherNumbers::readings(
        MM_PER_INCH,
        "the readings are in inches, or in thousandths of one where they are named µm",
        "multiply the readings by 25.4",
    ),
    OtherNumbers::readings(
        MM_PER_INCH * 1e-3,
        "the readings are in thousandths of an inch, or in millionths of one where they are named µm",
        "multiply the readings by 0.0254",
    ),
    OtherNumbers::readings(1.0 / MM_PER_INCH, "the readings are 25.4 times too large", "divide the readings by 25.4"),
    OtherNumbers::readings(10.0, "the readings are ten times too small", "multiply the readings by 10"),
    OtherNumbers::readings(0.1, "the readings are ten times too large", "divide the readings by 10"),
    OtherNumbers::times(
        1e-3,
        "the times are milliseconds and were taken as seconds",
        "state their unit, as time_ms in a table or unit=\"ms\" of the interval in XML, or say --rate",
    ),
    OtherNumbers::times(
        1e3,
        "the times are seconds and were taken as milliseconds",
        "state their unit, as time_s in a table or unit=\"s\" of the interval in XML, or say --rate",
    ),
];

/// Readings range over less than this where the bar is on, mm, and follow each other in steps between these, s.
const MOST_MM: f64 = 5.0;
const STEP_S: (f64, f64) = (1e-4, 2.0);

/// Forms of the marks of some tests.
pub(super) fn forms(session: &Session, among: &[Pair]) -> Vec<Marks> {
    let mut forms: Vec<Marks> = Vec::new();
    for marks in among.iter().filter_map(|pair| session.tests[pair.tests[0]].marks) {
        if forms.iter().all(|other| !alike(&marks, other)) {
            forms.push(marks);
        }
    }
    forms
}

/// True for marks of one form, whatever the gap and what was seen of them.
pub(super) fn alike(one: &Marks, other: &Marks) -> bool {
    *one == Marks { gap_s: one.gap_s, seen_mm: one.seen_mm, ..*other }
}

/// What the readings are, where all marks of a test's program are in them at another sense, unit or clock.
pub(super) fn other_reading(session: &Session, among: &[Pair], capture: &Capture, feeds: Feeds) -> Option<ImportError> {
    let forms = forms(session, among);
    let finite = || capture.reading_mm.iter().copied().filter(|reading| reading.is_finite());
    let range_mm = finite().fold(f64::MIN, f64::max) - finite().fold(f64::MAX, f64::min);
    let step_s = (capture.time_s.last()? - capture.time_s.first()?) / capture.time_s.len() as f64;
    // marks are in sight, the bar stays within its stroke, and the gauge reads as gauges do
    let may_be = |by: f64, time_by: f64| {
        let has_room = |marks: &Marks| by.abs() * range_mm > 0.5 * marks.move_mm.abs();
        forms.iter().any(has_room)
            && by.abs() * range_mm < MOST_MM
            && (STEP_S.0..STEP_S.1).contains(&(time_by * step_s))
    };
    OTHERS.iter().filter(|other| may_be(other.readings, other.times)).find_map(|other| {
        let OtherNumbers { readings: by, times: time_by, says: what, cure } = *other;
        let scaled = Capture {
            time_s: capture.time_s.iter().map(|time| time * time_by).collect(),
            reading_mm: capture.reading_mm.iter().map(|reading| reading * by).collect(),
        };
        let is_in_it = |marks: &Marks| matches!(find(&scaled, marks, feeds.range()), Found::All(_));
        forms.iter().any(is_in_it).then_some(ImportError::OtherReading { what, cure })
    })
}
