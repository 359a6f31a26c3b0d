//! Why a capture is not placed in time: what was found, and what to do.

use crate::effects::EffectError;
use crate::identify::FitError;
use crate::session::MotionError;

/// Why a capture is not placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ImportError {
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error("test '{test}' has no planned path; import places captures of planned sweeps and circles")]
    NoPath { test: String },
    #[error(
        "the session has no pair of neighbouring tests that run one path there and back, with one bar, at one feed and with the same balls; import needs the session that the plan wrote"
    )]
    NoPair,
    #[error("{readings} readings are too few to place; a capture has at least {due}")]
    TooFew { readings: usize, due: usize },
    #[error(
        "{percent:.0} % of the readings lie more than {stroke_mm} mm from the others: the bar was off or at its stop; record again"
    )]
    BarOff { percent: f64, stroke_mm: f64 },
    #[error(
        "the capture lasts {lasts_s:.1} s and the two directions of {test} move for {due_s:.1} s at least: it is cut off, or of another program"
    )]
    TooShort { test: String, lasts_s: f64, due_s: f64 },
    #[error(
        "the readings show no motion that a bar at rest would not show as well (log odds {odds:.1}): the bar stood still, or was off; record again"
    )]
    AtRest { odds: f64 },
    #[error(
        "the readings do not change: {percent:.0} % of them are {reading_um:.1} µm to the last digit, which no gauge in a running machine reads; look after \
         the gauge, its connection and the file, and record again"
    )]
    Unchanging { percent: f64, reading_um: f64 },
    #[error(
        "the capture begins {seconds:.1} s after the machine moved off: it is cut off at its start; start the recording before the program goes on"
    )]
    CutAtStart { seconds: f64 },
    #[error(
        "the capture ends {seconds:.1} s before the machine came to rest: it is cut off at its end; stop the recording after the last dwell"
    )]
    CutAtEnd { seconds: f64 },
    #[error(
        "no timing of {test} explains the readings: {left_um:.1} µm of {size_um:.1} µm are left, where the gauge's noise is {noise_um:.2} µm; it is another program's capture, or the bar slipped"
    )]
    Unexplained { test: String, left_um: f64, size_um: f64, noise_um: f64 },
    #[error(
        "two places in time explain the readings alike, {apart:.1}{unit} apart (log odds {odds:.1}); record again with a longer dwell"
    )]
    TwoPlaces { apart: f64, unit: &'static str, odds: f64 },
    #[error(
        "the readings tell the axis position to ± {sigma:.2}{unit} only, {limit}{unit} are asked for: the length hardly changes along this run"
    )]
    TooFlat { sigma: f64, limit: f64, unit: &'static str },
    #[error(
        "the readings fit {test} at {pace:.2} of its programmed feed: where an override or the control slowed the program, say --any-feed; else it is another program's capture"
    )]
    OtherFeed { test: String, pace: f64 },
    #[error(
        "{found} whole marks are in the readings, where {} 4: it is cut off, or of another program; record from before the first to after the last",
        program_makes(.test.as_deref())
    )]
    MarksMissing { test: Option<String>, found: usize },
    #[error(
        "{found} moves like marks are in the readings, where a program makes 4, and no four of them are told for certain: a run was broken off, or the bar was touched; trim the capture to its last start, just before {from_s:.1} s, or record again"
    )]
    ManyMarks { found: usize, from_s: f64 },
    #[error(
        "none of the 4 marks that {} is told in the readings: the machine stood still, ran another program, or comes to speed too slowly for marks to be told; if its program had no marks, take the tests' marks out of the session",
        program_makes(.test.as_deref())
    )]
    NoMarks { test: Option<String> },
    #[error("the marks of the session's programs are in the readings, but {what}: {cure}")]
    OtherReading { what: &'static str, cure: &'static str },
    #[error(
        "the marks leave {:.3} and {:.3} s for the two directions, and the run of {test} {}: it is another program's capture, or the control did not keep the feed (--any-feed)",
        .seen_s[0], .seen_s[1], .difference.words()
    )]
    OtherRuns { test: String, seen_s: [f64; 2], difference: RunsDiffer },
    #[error(
        "{seen_s:.2} s lie between the two directions' marks, and the program of {test} waits {due_s:.2} s, as no control does less: it is another program's capture; where the program was edited, state what it waited as gap of the test's marks"
    )]
    WaitsLess { test: String, seen_s: f64, due_s: f64 },
    #[error(
        "by their marks the two runs took times that differ by {longer_s:.3} s ± {sigma_s:.3} s, and the file has no times: rows of one of them are lost; let the gauge write times"
    )]
    RowsLost { longer_s: f64, sigma_s: f64 },
    #[error("the readings fit {test} only where {}: {cure}", .bound.words())]
    AtBound { test: String, bound: Bound, cure: &'static str },
    #[error(
        "the two runs took {:.2} and {:.2} s between their marks, {:.2} s apart at one pace of the marks: one of them was held, or its feed was changed on the way, and where is not told; record the test again in one go",
        .runs_s[0], .runs_s[1], .longer_s.abs()
    )]
    Stopped { runs_s: [f64; 2], longer_s: f64 },
    #[error(
        "the run of {test} was not even on its way: the readings speak for {} at {percent:.0} % of it, which puts positions off by {off:.1} {unit}; \
         record the test again in one go, at one feed",
        uneven(*.held_s, *.ratio)
    )]
    Uneven { test: String, percent: f64, held_s: f64, ratio: f64, off: f64, unit: &'static str },
    #[error(
        "the marks run at {pace:.2} of their programmed feed, and runs are sought from {:.2} to {:.2} of it: {cure}",
        .range[0], .range[1]
    )]
    FeedOfMarks { pace: f64, range: [f64; 2], cure: &'static str },
    #[error(
        "the readings are lengths of about {length_mm:.1} mm, and the bar of {test} has {bar_mm} mm: it is another bar, or its bar_length in the session is wrong"
    )]
    OtherBar { test: String, length_mm: f64, bar_mm: f64 },
    #[error("the readings fit another test of the session best: {test}")]
    OtherTest { test: String },
    #[error(
        "the capture may be that of {one} or of {other} (log odds {odds:.1}, {due:.1} are asked for): their readings are alike, and the wait between the directions is that of the one, or longer than that of the other; say which with --test {one} or --test {other}"
    )]
    TwoTests { one: String, other: String, odds: f64, due: f64 },
}

impl ImportError {
    /// True where other readings may be placed: the session and its tests are sound.
    pub(super) fn is_of_readings(&self) -> bool {
        use ImportError::{Fit, Motion, NoPair, NoPath};
        !matches!(self, Motion(_) | Fit(_) | NoPath { .. } | NoPair)
    }
}

/// What happened on the way of a run.
fn uneven(held_s: f64, ratio: f64) -> String {
    match held_s > 0.0 {
        true => format!("a hold of {held_s:.2} s"),
        false => format!("a feed that changed to {:.0} %", 100.0 * ratio),
    }
}

/// Whose marks they are: of a test that was asked for, or of any.
fn program_makes(test: Option<&str>) -> String {
    match test {
        Some(test) => format!("the program of {test} makes"),
        None => "a program of the session makes".into(),
    }
}

/// By what a run differs from that between marks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RunsDiffer {
    /// It takes so long as programmed, s.
    Takes { due_s: f64 },
    /// By the readings a direction (0 or 1) begins and ends so much later than the marks tell, s; one of them by more than is
    /// allowed.
    Lies { direction: usize, later_s: [f64; 2], most_s: f64 },
}

impl RunsDiffer {
    fn words(self) -> String {
        let by = |later_s: f64| format!("{:.3} s {}", later_s.abs(), if later_s < 0.0 { "before" } else { "after" });
        match self {
            RunsDiffer::Takes { due_s } => format!("takes {due_s:.3} s"),
            RunsDiffer::Lies { direction, later_s: [begin_s, end_s], most_s } => format!(
                "fits the readings only where its {} direction begins {} and ends {} the times that the marks tell, {most_s:.3} s being allowed",
                ["first", "second"][direction.min(1)],
                by(begin_s),
                by(end_s)
            ),
        }
    }
}

/// A number of a timing that lies where the search for it ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// Speed over the programmed feed, and from where to where it is sought.
    Pace { pace: f64, range: [f64; 2] },
    /// Time in which the run comes to speed, and the longest that is believed, s.
    Ramp { ramp_s: f64, most_s: f64 },
}

impl Bound {
    fn words(self) -> String {
        match self {
            Bound::Pace { pace, range: [slowest, fastest] } => {
                format!("its run took {pace:.2} of the programmed feed ({slowest:.2} to {fastest:.2} being sought)")
            }
            Bound::Ramp { ramp_s, most_s } => {
                format!("its run came to speed in {ramp_s:.1} s ({most_s:.1} s being the most that is believed)")
            }
        }
    }
}

impl From<EffectError> for ImportError {
    fn from(why: EffectError) -> ImportError {
        ImportError::Fit(FitError::Effect(why))
    }
}
