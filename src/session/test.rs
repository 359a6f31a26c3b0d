//! One test, and a session: tests on one machine in the order of their file. It holds what was done, not what it means.

use std::collections::{HashMap, HashSet};

use super::ball::{Ball, Spread, Zero};
use super::marks::Marks;
use super::path::Path;
use super::recording::Recording;
use crate::machine::Machine;
use crate::readings::{Kind, Reading};
use crate::statistics::step_of;

/// Way over which an axis that stands in a test came to its place, in the sense that the test states, mm or deg: three times the longest
/// over which lost motion is taken up.
pub const APPROACHED_OVER: f64 = 10.0;

/// One test: a bar between two balls while some axes move, or one number of what another instrument read of a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    pub name: String,
    /// Name of the recording's file, relative to the session file.
    pub recording_file: Option<String>,
    pub recording: Option<Recording>,
    /// Planned path, or the arc of a recording without positions.
    pub path: Option<Path>,
    /// Seconds since the session began at the recording's time 0.
    pub started_at_s: f64,
    /// Calibrated length of the bar, mm; `None` for an absolute length gauge.
    pub bar_length_mm: Option<f64>,
    /// Tag of a bar calibrated anew.
    pub bar_setup: Option<String>,
    /// How the bar's zero was set.
    pub zero: Zero,
    /// Known error of the reading: reading minus distance, mm.
    pub bar_error_mm: f64,
    pub pivot: Ball,
    pub spindle_ball: Ball,
    /// Positions of the axes that stand still, mm or rad, by axis index.
    pub positions: Vec<Option<f64>>,
    /// Speed of the moving ball, mm/min.
    pub feed_mm_per_min: Option<f64>,
    /// How far outside the arc the axes started, in the capture's direction, mm or deg.
    pub overshoot: Option<f64>,
    /// Marks that its program makes in the readings, if any.
    pub marks: Option<Marks>,
    /// The sense, −1 or 1 as commanded, in which axes that stand still came to their places, by axis index (ISO 230-2: direction of
    /// approach); none where it is not known.
    pub approached: Vec<Option<f64>>,
    /// What the rows hold: lengths, or one number of a point, a pose, a socket, a displacement.
    pub reading: Reading,
}

impl Test {
    /// First and last reading, s since the session began; `None` where its recording has no times.
    pub fn span_s(&self) -> Option<(f64, f64)> {
        let times = self.recording.as_ref()?.time_s()?;
        Some((self.started_at_s + times.first()?, self.started_at_s + times.last()?))
    }

    /// The step of which all its lengths, or all their deviations from the bar's length, are multiples, mm: from 0.001 on. Gauges
    /// read so where it is their last digit.
    pub fn last_digit_mm(&self) -> Option<f64> {
        let recording = self.recording.as_ref()?;
        let finite = || recording.length_mm.iter().copied().filter(|length| length.is_finite());
        finite().next()?;
        let of_deviations =
            self.bar_length_mm.and_then(|bar_mm| step_of(|| finite().map(move |length| length - bar_mm)));
        step_of(finite).into_iter().chain(of_deviations).reduce(f64::max)
    }

    /// Name as the session file has it: of a point or a pose, not of one of its numbers.
    pub fn stated_name(&self) -> &str {
        self.reading.part().map_or(&self.name, |part| &part.of)
    }

    /// Whether its readings are of a point or a pose.
    pub fn is_sighted(&self) -> bool {
        self.reading.part().is_some_and(|part| matches!(part.kind, Kind::Point | Kind::Pose))
    }

    /// Whether it is the first number of a point or a pose.
    pub fn is_first_of_sighting(&self) -> bool {
        self.is_sighted() && self.reading.part().is_some_and(|part| part.leads())
    }

    /// Whether it has the balls, bar, feed and standing axes of another one.
    pub fn is_repeat_of(&self, other: &Test) -> bool {
        self.pivot == other.pivot
            && self.spindle_ball == other.spindle_ball
            && self.bar_length_mm == other.bar_length_mm
            && self.positions == other.positions
            && self.feed_mm_per_min == other.feed_mm_per_min
    }

    /// Rows of the recording, or samples of the planned path.
    pub fn rows(&self) -> usize {
        match (&self.recording, &self.path) {
            (Some(recording), _) => recording.len(),
            (None, Some(path)) => path.sample_count(),
            (None, None) => 0,
        }
    }
}

/// Tests on one machine in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    pub name: String,
    /// File of the machine as the session names it.
    pub machine_file: String,
    pub machine: Machine,
    pub spread: Spread,
    pub tests: Vec<Test>,
}

impl Session {
    /// Whether any test was read by another instrument than a bar.
    pub fn has_parts(&self) -> bool {
        self.tests.iter().any(|test| test.reading.part().is_some())
    }

    /// Whether no test says when it ran: several that were recorded over time begin at 0, and at the same time.
    pub fn states_no_times(&self) -> bool {
        let timed = || self.tests.iter().filter_map(|test| Some((test, test.span_s()?)));
        // several instruments in one file were read at once
        let mut files = HashSet::new();
        let first_of_file =
            timed().filter(|(test, _)| test.recording_file.clone().is_none_or(|file| files.insert(file)));
        let mut spans: Vec<(f64, f64)> = first_of_file.map(|(_, span)| span).collect();
        spans.sort_by(|one, other| one.0.total_cmp(&other.0));
        // clocks that count on through a session say it
        let are_at_once = spans.windows(2).any(|pair| pair[1].0 < pair[0].1);
        are_at_once && timed().all(|(test, _)| test.started_at_s == 0.0)
    }

    /// The session without tests that have no recording, and the names of these; as it is where none has one.
    pub fn recorded(mut self) -> (Session, Vec<String>) {
        // known distances of sockets stand in no recording
        let is_planned = |test: &Test| test.recording.is_none() && !test.reading.is_gap();
        if self.tests.iter().all(|test| test.recording.is_none()) {
            return (self, Vec::new());
        }
        let planned = self.tests.iter().filter(|test| is_planned(test)).map(|test| test.stated_name().to_string());
        let mut planned: Vec<String> = planned.collect();
        planned.dedup();
        self.tests.retain(|test| !is_planned(test));
        (self, planned)
    }

    /// The session with its tests one after the other, in their order and without pauses; those of one file at once.
    pub fn one_after_the_other(mut self) -> Session {
        let mut ended_s = 0.0;
        let mut of_files: HashMap<String, f64> = HashMap::new();
        for test in &mut self.tests {
            let Some((begins_s, ends_s)) = test.span_s() else { continue };
            // several instruments were read into one file: at once
            let at_once = test.recording_file.as_ref().and_then(|file| of_files.get(file).copied());
            let later_s = at_once.unwrap_or_else(|| (ended_s - begins_s).max(-test.started_at_s));
            test.started_at_s += later_s;
            ended_s = ended_s.max(ends_s + later_s);
            of_files.extend(test.recording_file.clone().map(|file| (file, later_s)));
        }
        self
    }
}
