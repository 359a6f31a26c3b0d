//! One test of a session file with its recording: balls, bar and axes that stand still. Paths are read in `test_path`.

use super::recordings::Read;
use super::test_file::TestFile;
use super::test_reader::TestReader;
use crate::load::checked_text::document::Step;
use crate::load::checked_text::limits::TEST_NAME;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::quantity::{LARGEST, quantity};
use crate::load::recording::Wanted;
use crate::readings::{Kind, Reading};
use crate::session::{Clock, Test, Zero};
use crate::units::{Measure, shown};

/// Smallest bar length, mm, and feed, mm/min.
const SMALLEST: f64 = 1e-3;

/// True for names that can be a file's: a simulation writes its recordings under them.
fn names_a_file(name: &str) -> bool {
    !name.contains(['/', '\\']) && !name.trim_matches(['.', ' ']).is_empty() && name.len() <= TEST_NAME.most
}

impl TestReader<'_> {
    /// Reads the test with this index: one for lengths, one for each number of other readings.
    pub(crate) fn tests(&self, index: usize, raw: &TestFile) -> Result<Vec<Test>, LoadError> {
        let wanted = self.wanted(index, raw)?;
        if wanted.kind != Kind::Length {
            // keys of another kind explain columns that are missing
            self.side(index, raw, (wanted.kind, "pivot"))?;
            self.side(index, raw, (wanted.kind, "spindle_ball"))?;
        }
        let (test, read) = self.test(index, raw, &wanted)?;
        match wanted.kind {
            Kind::Length => Ok(vec![test]),
            _ => self.parts(index, raw, (test, read), &wanted),
        }
    }

    /// Reads what a test has whatever its kind.
    fn test(&self, index: usize, raw: &TestFile, wanted: &Wanted) -> Result<(Test, Option<Read>), LoadError> {
        let refuse = |key: &str, message: String| {
            self.document.refuse(
                &[Step::Key("tests"), Step::Index(index), Step::Key(key)],
                format!("test '{}': {message}", raw.name),
            )
        };
        self.plain_values(index, raw)?;
        let zero = self.zero(index, raw)?;
        let path = self.path(index, raw)?;
        let recording = match &raw.recording {
            Some(name) => self.recordings.recording(index, raw, name, (self.machine, wanted))?,
            None => None,
        };
        let (read, recording) = match (recording, wanted.kind) {
            (Some(read), Kind::Length) => (None, Some(read.recording)),
            (Some(read), _) => (Some(read), None),
            (None, _) => (None, None),
        };
        let recording = recording.or_else(|| read.as_ref().map(|read| read.recording.clone()));
        if let Some(recording) = &recording {
            let no_positions = matches!(recording.clock, Clock::Absent);
            if no_positions && path.is_none() {
                return Err(refuse(
                    "recording",
                    "the recording has no column of positions such as A_deg; add it, or say the arc of samples uniform in angle with 'sweep: {axis: C, from: 0, to: 360}'"
                        .into(),
                ));
            }
        }
        if let Some(recording) = recording.as_ref().filter(|recording| matches!(recording.clock, Clock::Absent))
            && recording.len() < 2
        {
            return Err(refuse(
                "recording",
                "the recording has one row and no column of positions; one length lies nowhere on an arc, add the column".into(),
            ));
        }
        if recording.is_none() && path.is_none() {
            return Err(refuse("name", "has neither a recording nor a sweep or circle; add one".into()));
        }
        let mut test = Test {
            name: raw.name.clone(),
            recording_file: raw.recording.clone(),
            recording,
            path,
            started_at_s: raw.started_at,
            bar_length_mm: raw.bar_length,
            bar_setup: raw.bar_setup.clone(),
            zero,
            bar_error_mm: match &raw.bar_error {
                Some(value) => quantity(
                    self.document,
                    &[Step::Key("tests"), Step::Index(index), Step::Key("bar_error")],
                    value,
                    Measure::Length,
                )?,
                None => 0.0,
            },
            pivot: self.side(index, raw, (wanted.kind, "pivot"))?,
            spindle_ball: self.side(index, raw, (wanted.kind, "spindle_ball"))?,
            positions: vec![None; self.machine.axes.len()],
            feed_mm_per_min: raw.feed,
            overshoot: raw.overshoot,
            marks: self.marks(index, raw)?,
            approached: self.approached(index, raw)?,
            reading: Reading::Length,
        };
        for (name, &value) in &raw.positions {
            let axis =
                self.axis(&[Step::Key("tests"), Step::Index(index), Step::Key("positions"), Step::Key(name)], name)?;
            test.positions[axis] = Some(self.position(index, axis, value)?);
        }
        self.every_axis_known(index, &test)?;
        self.only_the_arc(index, &test)?;
        Ok((test, read))
    }

    /// The senses in which standing axes came to their places, by axis.
    fn approached(&self, index: usize, raw: &TestFile) -> Result<Vec<Option<f64>>, LoadError> {
        let mut senses = vec![None; self.machine.axes.len()];
        for (name, &sense) in &raw.approached {
            let place = [Step::Key("tests"), Step::Index(index), Step::Key("approached"), Step::Key(name)];
            let axis = self.axis(&place, name)?;
            if sense.abs() != 1.0 {
                let says = format!(
                    "test '{}': approached says {} of {}; 1 where it came to its place in the positive sense, -1 in the negative",
                    raw.name,
                    shown(sense),
                    self.machine.axes[axis].name
                );
                return Err(self.document.refuse(&place, says));
            }
            senses[axis] = Some(sense);
        }
        Ok(senses)
    }

    /// Refuses a name that is no file's and numbers that no test has.
    fn plain_values(&self, index: usize, raw: &TestFile) -> Result<(), LoadError> {
        let refuse = |key: &str, message: String| {
            self.document.refuse(
                &[Step::Key("tests"), Step::Index(index), Step::Key(key)],
                format!("test '{}': {message}", raw.name),
            )
        };
        if !names_a_file(&raw.name) {
            return Err(refuse(
                "name",
                "recordings are named after their tests; a name is 1 to 200 characters without / and \\".into(),
            ));
        }
        for (key, value, least, unit) in [
            ("started_at", Some(raw.started_at), -LARGEST, "s"),
            ("bar_length", raw.bar_length, SMALLEST, "mm"),
            ("feed", raw.feed, SMALLEST, "mm/min"),
            ("overshoot", raw.overshoot, 0.0, "mm or deg"),
        ] {
            if let Some(value) = value.filter(|value| !(least..=LARGEST).contains(value)) {
                return Err(refuse(
                    key,
                    format!("{key} {} is not a number from {least} to {LARGEST} {unit}", shown(value)),
                ));
            }
        }
        Ok(())
    }

    fn zero(&self, index: usize, raw: &TestFile) -> Result<Zero, LoadError> {
        let refuse = |message: String| {
            let place = [Step::Key("tests"), Step::Index(index), Step::Key("zero")];
            self.document.refuse(&place, format!("test '{}': {message}", raw.name))
        };
        match (raw.zero.as_deref(), raw.bar_length) {
            (None | Some("calibrated"), _) => Ok(Zero::Calibrated),
            (Some("free"), Some(_)) => Ok(Zero::Free),
            (Some("free"), None) => Err(refuse(
                "a free zero is an offset of a bar's readings, and no bar_length names the bar; add its length to the nearest mm".into(),
            )),
            (Some(other), _) => {
                Err(refuse(format!("zero '{other}' is not understood; write free (set by hand) or calibrated")))
            }
        }
    }

    fn every_axis_known(&self, index: usize, test: &Test) -> Result<(), LoadError> {
        let moved: Vec<usize> = match (&test.recording, &test.path) {
            (Some(recording), _) if !matches!(recording.clock, Clock::Absent) => recording.axes.clone(),
            (_, path) => path.as_ref().map_or(Vec::new(), |path| path.moving_axes(self.machine)),
        };
        for (axis, entry) in self.machine.axes.iter().enumerate() {
            if test.positions[axis].is_none() && !moved.contains(&axis) {
                return Err(self.document.refuse(
                    &[Step::Key("tests"), Step::Index(index), Step::Key("positions")],
                    format!(
                        "test '{}': axis {} has neither a column in the recording nor a place in positions; add it, e.g. {}: 0",
                        test.name, entry.name, entry.name
                    ),
                ));
            }
        }
        Ok(())
    }
}
