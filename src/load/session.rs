//! Session files (YAML, see docs/formats.md) with their machine and recordings to a [`Session`].

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use nalgebra::Vector3;
use serde::Deserialize;

use super::document::{Document, Step};
use super::machine::load_machine_with_links;
use super::message::{LoadError, nearest};
use super::quantity::{finite, quantity};
use super::range::outside_range;
use super::recording::load_recording;
use super::text::{MAX_YAML_BYTES, read_limited};
use super::urdf::LinkChoice;
use crate::chain::Chain;
use crate::machine::{AxisKind, Machine};
use crate::session::{Ball, CirclePlane, Clock, Follow, Path as TestPath, Session, Spread, Test};
use crate::units::Measure;

/// Most tests of a session.
const MAX_TESTS: usize = 5000;
/// Most samples of a planned path.
const MAX_PATH_SAMPLES: f64 = 1e6;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SessionFile {
    name: Option<String>,
    machine: String,
    root_link: Option<String>,
    workpiece_link: Option<String>,
    tool_link: Option<String>,
    #[serde(default)]
    spread: BTreeMap<String, serde_yaml::Value>,
    tests: Vec<TestFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TestFile {
    name: String,
    recording: Option<String>,
    #[serde(default)]
    started_at: f64,
    bar_length: Option<f64>,
    bar_setup: Option<String>,
    bar_error: Option<serde_yaml::Value>,
    pivot: BallFile,
    spindle_ball: BallFile,
    #[serde(default)]
    positions: BTreeMap<String, f64>,
    feed: Option<f64>,
    overshoot: Option<f64>,
    sweep: Option<SweepFile>,
    circle: Option<CircleFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BallFile {
    link: String,
    at: [f64; 3],
    setup: Option<String>,
    spread: Option<serde_yaml::Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepFile {
    axis: String,
    from: f64,
    to: f64,
    step: Option<f64>,
    #[serde(default)]
    follow: FollowFile,
}

#[derive(Deserialize, Default, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum FollowFile {
    #[default]
    None,
    Radial,
    Tangential,
    Axial,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CircleFile {
    plane: String,
    radius: f64,
    from: f64,
    to: f64,
    step: Option<f64>,
}

/// True for a file that is written as a session and not as a machine: it names tests or a machine file.
pub fn names_tests(file: &Path) -> Result<bool, LoadError> {
    let text = read_limited(file, MAX_YAML_BYTES)?;
    if text.trim_start().starts_with('<') {
        return Ok(false);
    }
    let document = Document::parse(file, text)?;
    Ok(document.has("tests") || document.has("machine"))
}

/// Reads a session file with the machine and the recordings that it names.
pub fn load_session(file: &Path) -> Result<Session, LoadError> {
    let document = Document::parse(file, read_limited(file, MAX_YAML_BYTES)?)?;
    let raw: SessionFile = document.read()?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let links =
        LinkChoice { root: raw.root_link.clone(), workpiece: raw.workpiece_link.clone(), tool: raw.tool_link.clone() };
    let machine = load_machine_with_links(&folder.join(&raw.machine), &links)?;
    let chain = Chain::of(&machine);
    let spread = spread(&document, &raw.spread)?;
    if raw.tests.is_empty() || raw.tests.len() > MAX_TESTS {
        return Err(document
            .refuse(&[Step::Key("tests")], format!("{} tests; a session has 1 to {MAX_TESTS}", raw.tests.len())));
    }
    let reader = TestReader { document: &document, folder, machine: &machine, chain: &chain };
    let mut tests: Vec<Test> = Vec::with_capacity(raw.tests.len());
    for (index, test) in raw.tests.iter().enumerate() {
        let test = reader.test(index, test)?;
        if tests.iter().any(|other| other.name == test.name) {
            return Err(document.refuse(
                &[Step::Key("tests"), Step::Index(index), Step::Key("name")],
                format!("the name '{}' stands twice; each test has its own", test.name),
            ));
        }
        tests.push(test);
    }
    let name = raw
        .name
        .unwrap_or_else(|| file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default());
    Ok(Session { name, machine_file: raw.machine, machine, spread, tests })
}

fn spread(document: &Document, raw: &BTreeMap<String, serde_yaml::Value>) -> Result<Spread, LoadError> {
    let mut spread = Spread::default();
    for (key, value) in raw {
        let place = [Step::Key("spread"), Step::Key(key)];
        let target = match key.as_str() {
            "pivot" => &mut spread.pivot_mm,
            "spindle_ball" => &mut spread.spindle_ball_mm,
            "bar_length" => &mut spread.bar_length_mm,
            other => {
                let valid = ["pivot", "spindle_ball", "bar_length"];
                let hint = nearest(other, &valid).map(|name| format!("; did you mean '{name}'?")).unwrap_or_default();
                return Err(
                    document.refuse(&place, format!("unknown key '{other}'{hint} (allowed: {})", valid.join(", ")))
                );
            }
        };
        *target = positive_length(document, &place, value)?;
    }
    Ok(spread)
}

fn positive_length(document: &Document, place: &[Step], value: &serde_yaml::Value) -> Result<f64, LoadError> {
    let length = quantity(document, place, value, Measure::Length)?;
    if length > 0.0 && length <= 100.0 {
        Ok(length)
    } else {
        Err(document.refuse(place, "a spread is above zero and at most 100 mm"))
    }
}

/// What reading one test needs.
struct TestReader<'a> {
    document: &'a Document,
    folder: &'a Path,
    machine: &'a Machine,
    chain: &'a Chain,
}

impl TestReader<'_> {
    fn test(&self, index: usize, raw: &TestFile) -> Result<Test, LoadError> {
        let refuse = |key: &str, message: String| {
            self.document.refuse(
                &[Step::Key("tests"), Step::Index(index), Step::Key(key)],
                format!("test '{}': {message}", raw.name),
            )
        };
        for (key, value) in [
            ("started_at", Some(raw.started_at)),
            ("bar_length", raw.bar_length),
            ("feed", raw.feed),
            ("overshoot", raw.overshoot),
        ] {
            let sensible = value
                .is_none_or(|value| value.is_finite() && value.abs() < 1e9 && (key == "started_at" || value >= 0.0));
            if !sensible {
                return Err(refuse(key, format!("{key} is not a sensible number")));
            }
        }
        if raw.feed == Some(0.0) || raw.bar_length == Some(0.0) {
            return Err(refuse("feed", "bar_length and feed are above zero".into()));
        }
        let path = self.path(index, raw)?;
        let recording = match &raw.recording {
            Some(name) => self.recording(index, raw, name)?,
            None => None,
        };
        if let Some(recording) = &recording {
            let no_positions = matches!(recording.clock, Clock::Absent);
            if no_positions && path.is_none() {
                return Err(refuse(
                    "recording",
                    "the recording has only length_mm; say the arc with 'sweep: {axis: C, from: 0, to: 360}'".into(),
                ));
            }
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
            bar_error_mm: match &raw.bar_error {
                Some(value) => quantity(
                    self.document,
                    &[Step::Key("tests"), Step::Index(index), Step::Key("bar_error")],
                    value,
                    Measure::Length,
                )?,
                None => 0.0,
            },
            pivot: self.ball(index, "pivot", &raw.pivot)?,
            spindle_ball: self.ball(index, "spindle_ball", &raw.spindle_ball)?,
            positions: vec![None; self.machine.axes.len()],
            feed_mm_per_min: raw.feed,
            overshoot: raw.overshoot,
        };
        for (name, &value) in &raw.positions {
            let axis =
                self.axis(&[Step::Key("tests"), Step::Index(index), Step::Key("positions"), Step::Key(name)], name)?;
            test.positions[axis] = Some(self.position(index, axis, value)?);
        }
        self.every_axis_known(index, &test)?;
        Ok(test)
    }

    fn axis(&self, place: &[Step], name: &str) -> Result<usize, LoadError> {
        self.machine.axis_index(name).ok_or_else(|| {
            self.document.refuse(
                place,
                format!("the machine has no axis '{name}'; its axes are {}", self.machine.axis_names().join(" ")),
            )
        })
    }

    fn position(&self, index: usize, axis: usize, value: f64) -> Result<f64, LoadError> {
        let name = &self.machine.axes[axis].name;
        let place = [Step::Key("tests"), Step::Index(index), Step::Key("positions"), Step::Key(name)];
        let value = self.machine.axes[axis].kind.from_file_unit(finite(self.document, &place, value)?);
        match outside_range(self.machine, axis, value) {
            Some(message) => Err(self.document.refuse(&place, message)),
            None => Ok(value),
        }
    }

    fn ball(&self, index: usize, key: &str, raw: &BallFile) -> Result<Ball, LoadError> {
        let place = [Step::Key("tests"), Step::Index(index), Step::Key(key)];
        for value in raw.at {
            finite(self.document, &place, value)?;
        }
        if self.chain.link(&raw.link).is_none() {
            let known = self.chain.link_names();
            let hint = nearest(&raw.link, &known).map(|name| format!("; did you mean '{name}'?")).unwrap_or_default();
            return Err(self
                .document
                .refuse(&place, format!("no link is called '{}'{hint} (links: {})", raw.link, known.join(" "))));
        }
        Ok(Ball {
            link: raw.link.clone(),
            at: Vector3::from(raw.at),
            setup: raw.setup.clone(),
            spread_mm: raw.spread.as_ref().map(|value| positive_length(self.document, &place, value)).transpose()?,
        })
    }

    fn path(&self, index: usize, raw: &TestFile) -> Result<Option<TestPath>, LoadError> {
        let at = |key| [Step::Key("tests"), Step::Index(index), Step::Key(key)];
        match (&raw.sweep, &raw.circle) {
            (Some(_), Some(_)) => Err(self.document.refuse(&at("circle"), "both sweep and circle are given; keep one")),
            (None, None) => Ok(None),
            (Some(sweep), None) => {
                let axis = self.axis(&at("sweep"), &sweep.axis)?;
                let step = self.step(&at("sweep"), sweep.from, sweep.to, sweep.step)?;
                for end in [sweep.from, sweep.to] {
                    let value = self.machine.axes[axis].kind.from_file_unit(end);
                    if let Some(message) = outside_range(self.machine, axis, value) {
                        return Err(self.document.refuse(&at("sweep"), message));
                    }
                }
                let follow = match sweep.follow {
                    FollowFile::None => Follow::None,
                    FollowFile::Radial => Follow::Radial,
                    FollowFile::Tangential => Follow::Tangential,
                    FollowFile::Axial => Follow::Axial,
                };
                Ok(Some(TestPath::Sweep { axis, from: sweep.from, to: sweep.to, step, follow }))
            }
            (None, Some(circle)) => {
                let step = self.step(&at("circle"), circle.from, circle.to, circle.step)?;
                let plane = self.plane(&at("circle"), &circle.plane)?;
                if !(circle.radius.is_finite() && circle.radius > 0.0) {
                    return Err(self.document.refuse(&at("circle"), "radius is above zero, in mm"));
                }
                Ok(Some(TestPath::Circle { plane, radius_mm: circle.radius, from: circle.from, to: circle.to, step }))
            }
        }
    }

    fn step(&self, place: &[Step], from: f64, to: f64, step: Option<f64>) -> Result<f64, LoadError> {
        let step = step.unwrap_or(0.5).abs();
        for value in [from, to, step] {
            finite(self.document, place, value)?;
        }
        if step == 0.0 || from == to || ((to - from) / step).abs() > MAX_PATH_SAMPLES {
            return Err(self
                .document
                .refuse(place, "from and to differ, step is above zero and gives at most a million samples"));
        }
        Ok(step)
    }

    fn plane(&self, place: &[Step], plane: &str) -> Result<CirclePlane, LoadError> {
        let linear = |letter: Option<char>| {
            let axis = self.machine.axis_index(&letter?.to_string())?;
            (self.machine.axes[axis].kind == AxisKind::Linear).then_some(axis)
        };
        let mut letters = plane.chars();
        match (linear(letters.next()), linear(letters.next()), letters.next()) {
            (Some(first), Some(second), None) if first != second => Ok(CirclePlane { first, second }),
            _ => Err(self
                .document
                .refuse(place, format!("plane '{plane}' does not name two linear axes; write for example XY"))),
        }
    }

    fn recording(
        &self,
        index: usize,
        raw: &TestFile,
        name: &str,
    ) -> Result<Option<crate::session::Recording>, LoadError> {
        let refuse = |message: String| {
            self.document.refuse(&[Step::Key("tests"), Step::Index(index), Step::Key("recording")], message)
        };
        let relative = PathBuf::from(name);
        let stays_inside = relative.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !stays_inside || name.is_empty() {
            return Err(refuse(format!(
                "recording '{name}' leaves the session's folder; put the file beside the session"
            )));
        }
        let file = self.folder.join(&relative);
        if !file.exists() && (raw.sweep.is_some() || raw.circle.is_some()) {
            // a planned test names the file that its recording will have
            return Ok(None);
        }
        load_recording(&file, self.machine, raw.bar_length).map(Some)
    }

    fn every_axis_known(&self, index: usize, test: &Test) -> Result<(), LoadError> {
        let moved: Vec<usize> = match (&test.recording, &test.path) {
            (Some(recording), _) if !matches!(recording.clock, Clock::Absent) => recording.axes.clone(),
            (_, Some(TestPath::Sweep { axis, follow: Follow::None, .. })) => vec![*axis],
            (_, Some(TestPath::Sweep { axis, .. })) => {
                let linear = (0..self.machine.axes.len()).filter(|&k| self.machine.axes[k].kind == AxisKind::Linear);
                linear.chain([*axis]).collect()
            }
            (_, Some(TestPath::Circle { plane, .. })) => vec![plane.first, plane.second],
            (_, None) => Vec::new(),
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
