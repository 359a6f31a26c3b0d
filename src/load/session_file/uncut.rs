//! Recordings of marked tests without positions: whether they hold the arc alone, so that samples may be taken as uniform on it.

use super::test_reader::TestReader;
use crate::load::checked_text::document::Step;
use crate::load::checked_text::message::LoadError;
use crate::session::{Clock, Marks, Motion, Session, Spread, Test, times_beside_readings};
use crate::statistics::median;

/// Most that a recording may last longer or shorter than its arc: overrides and controls that slow down are within it.
const DURATION_OFF: f64 = 0.3;
/// Step of the search for marks, s.
const STEP_S: f64 = 0.05;
/// How long a level is looked at beside a mark, s, and how near to a move it is not.
const LEVEL_S: f64 = 0.3;
const NEAR_S: f64 = 0.05;
/// Share of a mark's move by which its height may be off, and by which a level may wander.
const HEIGHT_OFF: f64 = 0.2;
const LEVEL_WANDER: f64 = 0.15;
/// Readings without times are spread over the arc's own time, and over longer ones up to three times that, by such steps.
const STRETCHES: [f64; 9] = [1.0, 1.15, 1.3, 1.5, 1.75, 2.0, 2.3, 2.6, 3.0];

impl TestReader<'_> {
    /// Refuses a recording without positions that holds more, or less, than the arc of a test whose program makes marks.
    pub(super) fn only_the_arc(&self, index: usize, test: &Test) -> Result<(), LoadError> {
        let (Some(marks), Some(recording)) = (&test.marks, &test.recording) else { return Ok(()) };
        if !matches!(recording.clock, Clock::Absent) {
            return Ok(());
        }
        let refuse = |what: String| {
            self.document.refuse(
                &[Step::Key("tests"), Step::Index(index), Step::Key("recording")],
                format!(
                    "test '{}': {what}; nothing says where the axes stood, take the capture in one piece and type fiveaxis import CAPTURE.csv --session session.yaml --out imported",
                    test.name
                ),
            )
        };
        let Some(due_s) = self.arc_s(test).filter(|due_s| *due_s > 0.0) else { return Ok(()) };
        let times = recording.written_time_s();
        let lasts_s = times.as_ref().and_then(|time| Some(time.last()? - time.first()?));
        if let Some(lasts_s) = lasts_s.filter(|lasts_s| (lasts_s / due_s - 1.0).abs() > DURATION_OFF) {
            return Err(refuse(format!(
                "the recording lasts {lasts_s:.2} s and the arc takes {due_s:.2} s at the test's feed"
            )));
        }
        let even = |stretch: f64| {
            let step_s = stretch * due_s / (recording.len().max(2) - 1) as f64;
            (0..recording.len()).map(|row| step_s * row as f64).collect::<Vec<f64>>()
        };
        let shows = match &times {
            Some(time) => shows_a_mark(time, &recording.length_mm, marks),
            None => STRETCHES.iter().any(|&stretch| shows_a_mark(&even(stretch), &recording.length_mm, marks)),
        };
        match shows {
            true => Err(refuse(format!(
                "the readings show a mark of {} mm, so the recording holds more than the arc",
                marks.move_mm
            ))),
            false => Ok(()),
        }
    }

    /// Programmed time of a test's arc, s.
    fn arc_s(&self, test: &Test) -> Option<f64> {
        let planned = Test { recording: None, ..test.clone() };
        let session = Session {
            name: String::new(),
            machine_file: String::new(),
            machine: self.machine.clone(),
            spread: Spread::default(),
            tests: Vec::new(),
        };
        let motion = Motion::of(&session, self.chain, &planned).ok()?;
        motion.time_s?.last().copied()
    }
}

/// True where readings leave a level by a mark's move, stay, and come back to it.
fn shows_a_mark(time_s: &[f64], reading_mm: &[f64], marks: &Marks) -> bool {
    let (Some(first), Some(last)) = (time_s.first(), time_s.last()) else { return false };
    let level = |from_s: f64, to_s: f64| {
        let from = time_s.partition_point(|time| *time < from_s);
        let to = time_s.partition_point(|time| *time <= to_s).max(from);
        let values = || reading_mm[from..to].iter().copied().filter(|reading| reading.is_finite());
        let (low, high) = values().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
        let is_level = values().count() >= 2 && high - low < LEVEL_WANDER * marks.move_mm.abs();
        median(values()).filter(|_| is_level)
    };
    let (move_s, is_near) = (marks.move_s(), |mm: f64| (mm / marks.move_mm - 1.0).abs() < HEIGHT_OFF);
    let next_s = |from_s: f64| time_s.get(time_s.partition_point(|time| *time < from_s)).copied();
    times_beside_readings([*first, *last], STEP_S, [LEVEL_S, 0.0], next_s).any(|out_s| {
        let back_s = out_s + move_s + marks.hold_s;
        let Some(top) = level(out_s + move_s + NEAR_S, back_s - NEAR_S) else { return false };
        let is_low = |from_s: f64, to_s: f64| level(from_s, to_s).is_some_and(|foot| is_near(top - foot));
        is_low(out_s - LEVEL_S, out_s - NEAR_S) && is_low(back_s + move_s + NEAR_S, back_s + move_s + LEVEL_S)
    })
}
