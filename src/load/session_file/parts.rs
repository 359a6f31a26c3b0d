//! Tests of a session file whose readings are not lengths: one test for each number of a reading. Where instruments stand that no one stated is found in `instruments`.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use super::recordings::Read;
use super::test_file::{BallFile, FrameFile, TestFile};
use super::test_reader::TestReader;
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::message::{LoadError, did_you_mean};
use crate::load::checked_text::quantity::{finite, positive_length, quantity};
use crate::load::recording::{Wanted, says_where};
use crate::readings::{Kind, Part, Reading, Scalar, nearest_rotation, rotation_of_euler_xyz, rotation_of_quaternion};
use crate::session::{Ball, Test, UNKNOWN_MM, UNKNOWN_RAD};
use crate::units::Measure;

/// How far the length of a quaternion, or of a column of a rotation matrix, may be from 1: rounding to three decimals.
const NOT_UNIT: f64 = 2e-3;

/// The kind with this name; lengths where none is named.
pub(crate) fn kind_named(document: &Document, place: &[Step], name: Option<&str>) -> Result<Kind, LoadError> {
    let Some(name) = name else { return Ok(Kind::Length) };
    let names = Kind::ALL.map(Kind::name);
    Kind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
        let hint = did_you_mean(name, &names);
        document.refuse(place, format!("unknown readings '{name}'{hint} (allowed: {})", names.join(", ")))
    })
}

impl TestReader<'_> {
    /// Kind of a test and its columns.
    pub(crate) fn wanted(&self, index: usize, raw: &TestFile) -> Result<Wanted, LoadError> {
        let place = |key| [Step::Key("tests"), Step::Index(index), Step::Key(key)];
        let kind = match &raw.readings {
            None => self.kind,
            own => kind_named(self.document, &place("readings"), own.as_deref())?,
        };
        let known: Vec<&str> = kind.column_sets().iter().flat_map(|set| set.iter().copied()).collect();
        for usual in raw.columns.keys() {
            if !known.contains(&usual.as_str()) || kind == Kind::Length {
                let hint = did_you_mean(usual, &known);
                let allowed = if kind == Kind::Length { String::from("none") } else { known.join(", ") };
                return Err(self.document.refuse(
                    &place("columns"),
                    format!(
                        "test '{}': a {} has no column '{usual}'{hint} (allowed: {allowed})",
                        raw.name,
                        kind.name()
                    ),
                ));
            }
        }
        let renamed: Vec<(String, String)> = raw.columns.clone().into_iter().collect();
        for (k, (usual, own)) in renamed.iter().enumerate() {
            let holds_else = match renamed[..k].iter().find(|(_, other)| other == own) {
                Some((other, _)) => format!("'{other}' as well"),
                None if says_where(own, self.machine) => "what says when a row was read, or where an axis stood".into(),
                None => continue,
            };
            return Err(self.document.refuse(
                &place("columns"),
                format!("test '{}': column '{own}' of the file cannot hold {usual}, it holds {holds_else}; name the column of each", raw.name),
            ));
        }
        Ok(Wanted { kind, renamed })
    }

    /// The pivot or spindle ball of a test, or what stands in its place.
    pub(crate) fn side(&self, index: usize, raw: &TestFile, (kind, ball): (Kind, &str)) -> Result<Ball, LoadError> {
        let refuse = |message: String| self.document.refuse(&[Step::Key("tests"), Step::Index(index)], message);
        let is_pivot = ball == "pivot";
        let (own, instead) = match (kind, is_pivot) {
            (Kind::Length, _) => (ball, None),
            (Kind::SamePoint, true) => ("socket", raw.socket.as_ref()),
            (_, true) => ("instrument", raw.instrument.as_ref()),
            (_, false) => ("target", raw.target.as_ref()),
        };
        let strange = [
            ("pivot", raw.pivot.is_some(), kind == Kind::Length),
            ("spindle_ball", raw.spindle_ball.is_some(), kind == Kind::Length),
            ("instrument", raw.instrument.is_some(), !matches!(kind, Kind::Length | Kind::SamePoint)),
            ("socket", raw.socket.is_some(), kind == Kind::SamePoint),
            ("target", raw.target.is_some(), kind != Kind::Length),
        ];
        if let Some((key, ..)) = strange.iter().find(|(_, stated, due)| *stated && !due) {
            return Err(refuse(format!(
                "test '{}' is of readings '{}', which have no {key}; remove the key, or say 'readings' in the test",
                raw.name,
                kind.name()
            )));
        }
        let missing = || match kind {
            Kind::Length => refuse(format!("the key '{own}' is missing under tests[{index}]; add it")),
            _ => refuse(format!("test '{}': the key '{own}' is missing; add it, e.g. {own}: {{link: b}}", raw.name)),
        };
        if kind == Kind::Length {
            let stated = if is_pivot { &raw.pivot } else { &raw.spindle_ball };
            return self.ball(index, ball, stated.as_ref().ok_or_else(missing)?);
        }
        let frame = instead.ok_or_else(missing)?;
        let place = BallFile {
            link: frame.link.clone(),
            at: frame.at.unwrap_or_default(),
            // sockets are places of their own, found from the rows of their test
            setup: frame.setup.clone().or_else(|| (kind == Kind::SamePoint && is_pivot).then(|| raw.name.clone())),
            spread: frame.spread.clone(),
            indexed_about: None,
        };
        let ball = self.ball(index, own, &place)?;
        let at = frame.at.map_or(Vector3::repeat(f64::NAN), Vector3::from);
        Ok(Ball { at, spread_mm: ball.spread_mm.or(Some(UNKNOWN_MM)), ..ball })
    }

    /// One test for each number of the readings.
    pub(crate) fn parts(
        &self,
        index: usize,
        raw: &TestFile,
        (test, read): (Test, Option<Read>),
        wanted: &Wanted,
    ) -> Result<Vec<Test>, LoadError> {
        let kind = wanted.kind;
        let rows = test.rows();
        let mut numbers = vec![vec![f64::NAN; rows]; 3];
        let mut measured = Vec::new();
        // what a recording that is not there yet will have, where the session names it
        let mut columns = wanted.sets().next().filter(|_| !wanted.renamed.is_empty()).unwrap_or_default();
        let mut recording = test.recording.clone();
        if let (Some(read), Some(recording)) = (&read, &mut recording) {
            let names: Vec<&str> = recording.channels.iter().map(|(name, _)| name.as_str()).collect();
            columns = wanted.set_in(&names).unwrap_or_default();
            let taken =
                |name: &String| recording.channels.iter().find(|(own, _)| own == name).map(|(_, list)| list.clone());
            let lists: Vec<Vec<f64>> = columns.iter().filter_map(taken).collect();
            recording.channels.retain(|(name, _)| !columns.contains(name));
            match kind {
                Kind::SamePoint => numbers = vec![vec![0.0; rows]; 3],
                _ => lists.iter().take(3).enumerate().for_each(|(k, list)| numbers[k] = list.clone()),
            }
            measured = rotations(read, lists.get(3..).unwrap_or_default())?;
            if numbers.iter().flatten().all(|value| value.is_nan()) {
                return Err(LoadError::file(
                    &read.file,
                    format!("has no reading: every {} is empty", columns.join(" ")),
                ));
            }
        }
        let is_read: Vec<bool> = measured.iter().map(Option::is_some).collect();
        let measured = Arc::new(measured.into_iter().map(|read| read.unwrap_or_else(Matrix3::identity)).collect());
        let points =
            raw.instrument.as_ref().is_some_and(|frame| frame.direction.is_some() || frame.quaternion.is_some());
        if kind == Kind::Displacement && !points {
            let place = [Step::Key("tests"), Step::Index(index), Step::Key("instrument")];
            let says = "a displacement is read along a direction, and none is stated; write direction: [1, 0, 0] or as the gauge lies";
            return Err(self.document.refuse(&place, says));
        }
        let part = Part {
            kind,
            of: raw.name.clone(),
            scalar: Scalar::Coordinate(0),
            instrument_axes: self.axes(index, "instrument", raw.instrument.as_ref())?,
            target_axes: self.axes(index, "target", raw.target.as_ref())?,
            instrument_turn_rad: self.turn_spread(
                index,
                ("instrument", kind.instrument_turns()),
                raw.instrument.as_ref(),
            )?,
            target_turn_rad: self.turn_spread(index, ("target", kind.target_turns()), raw.target.as_ref())?,
            measured,
            noise_mm: None,
            columns: Arc::new(columns),
        };
        let of_scalar = |scalar: &Scalar| {
            let values = match *scalar {
                Scalar::Coordinate(k) => numbers[k].clone(),
                Scalar::Gap => vec![f64::NAN; rows],
                Scalar::Turn(_) => is_read.iter().map(|read| if *read { 0.0 } else { f64::NAN }).collect(),
            };
            let recording =
                recording.clone().map(|recording| crate::session::Recording { length_mm: values, ..recording });
            let name = match kind.scalars().len() {
                1 => raw.name.clone(),
                _ => format!("{} {}", raw.name, scalar.name()),
            };
            let reading = Reading::Part(Box::new(Part { scalar: *scalar, ..part.clone() }));
            Test { name, recording, reading, ..test.clone() }
        };
        Ok(kind.scalars().iter().map(of_scalar).collect())
    }

    /// Axes that a file states, R's directions otherwise.
    fn axes(&self, index: usize, key: &str, frame: Option<&FrameFile>) -> Result<Matrix3<f64>, LoadError> {
        let place = [Step::Key("tests"), Step::Index(index), Step::Key(key)];
        if let Some(direction) = frame.and_then(|frame| frame.direction) {
            for value in direction {
                finite(self.document, &place, value)?;
            }
            let along = Vector3::from(direction);
            if along.norm() < f64::MIN_POSITIVE.sqrt() {
                return Err(self.document.refuse(&place, "direction [0, 0, 0] points nowhere; write three numbers"));
            }
            let along = along.normalize();
            let beside = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
            return Ok(Matrix3::from_columns(&[along, beside, along.cross(&beside)]));
        }
        let Some(quaternion) = frame.and_then(|frame| frame.quaternion) else { return Ok(Matrix3::identity()) };
        let length = quaternion.iter().map(|value| value * value).sum::<f64>().sqrt();
        match (length - 1.0).abs() <= NOT_UNIT {
            true => Ok(rotation_of_quaternion(quaternion)),
            false => Err(self.document.refuse(
                &place,
                format!("the quaternion has length {length:.4}, due is 1; w stands first, then x y z"),
            )),
        }
    }

    /// How well axes are known: as stated, else hardly.
    fn turn_spread(
        &self,
        index: usize,
        (key, turns): (&str, bool),
        frame: Option<&FrameFile>,
    ) -> Result<Option<f64>, LoadError> {
        let stated = frame.and_then(|frame| frame.turn_spread.as_ref());
        let place = [Step::Key("tests"), Step::Index(index), Step::Key(key), Step::Key("turn_spread")];
        match (stated, turns) {
            (_, false) => Ok(None),
            (None, true) => Ok(Some(UNKNOWN_RAD)),
            (Some(value), true) => {
                let turn = quantity(self.document, &place, value, Measure::Angle)?;
                match turn > 0.0 {
                    true => Ok(Some(turn)),
                    false => Err(self.document.refuse(&place, "a spread is above zero")),
                }
            }
        }
    }
}

/// Two sockets whose distance is known.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SocketsFile {
    between: [String; 2],
    distance: f64,
    spread: Option<serde_yaml::Value>,
}

/// How well a distance of sockets is known when no one says it, mm: a fixture that was machined.
const SOCKETS_MM: f64 = 0.05;

/// The known distances of sockets as tests of one row each.
pub(crate) fn socket_distances(
    document: &Document,
    raw: &[SocketsFile],
    tests: &[Test],
    axes: usize,
) -> Result<Vec<Test>, LoadError> {
    let read = |(index, sockets): (usize, &SocketsFile)| {
        let place = [Step::Key("sockets"), Step::Index(index)];
        let socket = |name: &String| {
            let is_it = |test: &&Test| {
                let part = test.reading.part();
                part.is_some_and(|part| part.kind == Kind::SamePoint && part.of == *name && part.leads())
            };
            tests.iter().find(is_it).ok_or_else(|| {
                let message =
                    format!("no test of readings 'same_point' is called '{name}'; name the tests of two sockets");
                document.refuse(&place, message)
            })
        };
        let (one, other) = (socket(&sockets.between[0])?, socket(&sockets.between[1])?);
        if one.name == other.name {
            return Err(document.refuse(&place, "'between' names one socket twice; name the tests of two"));
        }
        if !(sockets.distance > 0.0 && sockets.distance < 1e5) {
            let message =
                format!("a distance of two sockets is above 0 and below 100000 mm, and not {}", sockets.distance);
            return Err(document.refuse(&place, message));
        }
        let is_same_pair = |earlier: &&SocketsFile| {
            earlier.between == sockets.between || earlier.between.iter().rev().eq(&sockets.between)
        };
        if let Some(earlier) = raw[..index].iter().find(is_same_pair) {
            let [one, other] = &sockets.between;
            let message =
                format!("the distance of {one} and {other} is stated twice, {} mm before; keep one", earlier.distance);
            return Err(document.refuse(&place, message));
        }
        let spread = sockets.spread.as_ref().map(|value| positive_length(document, &place, value)).transpose()?;
        let Some(part) = one.reading.part() else { return Ok(None) };
        let part = Part {
            of: format!("{} to {}", sockets.between[0], sockets.between[1]),
            scalar: Scalar::Gap,
            noise_mm: Some(spread.unwrap_or(SOCKETS_MM)),
            target_turn_rad: None,
            ..part.clone()
        };
        let recording = crate::session::Recording {
            clock: crate::session::Clock::Pose(vec![0.0]),
            axes: Vec::new(),
            positions: Vec::new(),
            length_mm: vec![sockets.distance],
            channels: Vec::new(),
            leading_texts: Arc::default(),
            leading_header: String::new(),
            column: Default::default(),
            scatter: None,
        };
        Ok(Some(Test {
            name: part.of.clone(),
            recording_file: None,
            recording: Some(recording),
            positions: vec![Some(0.0); axes],
            spindle_ball: other.pivot.clone(),
            reading: Reading::Part(Box::new(part)),
            ..one.clone()
        }))
    };
    let tests: Result<Vec<Option<Test>>, LoadError> = raw.iter().enumerate().map(read).collect();
    Ok(tests?.into_iter().flatten().collect())
}

/// Rotations row by row from their columns: quaternions, matrices or angles; `None` where one is empty.
fn rotations(read: &Read, lists: &[Vec<f64>]) -> Result<Vec<Option<Matrix3<f64>>>, LoadError> {
    let rows = read.recording.len();
    let row_of = |row: usize| lists.iter().map(|list| list[row]).collect::<Vec<f64>>();
    (0..rows)
        .map(|row| {
            let numbers = row_of(row);
            if numbers.is_empty() || numbers.iter().any(|value| value.is_nan()) {
                return Ok(None);
            }
            let refuse = |message: String| {
                let line = read.lines.get(row).map_or(row + 1, |&line| line as usize);
                Err(LoadError::line(&read.file, line, message))
            };
            match numbers[..] {
                [w, x, y, z] => {
                    let length = numbers.iter().map(|value| value * value).sum::<f64>().sqrt();
                    match (length - 1.0).abs() <= NOT_UNIT {
                        true => Ok(Some(rotation_of_quaternion([w, x, y, z]))),
                        false => refuse(format!(
                            "the quaternion ({w}, {x}, {y}, {z}) has length {length:.4}, due is 1; w stands first, correct the row or leave its cells empty"
                        )),
                    }
                }
                [x, y, z] => Ok(Some(rotation_of_euler_xyz([x, y, z].map(f64::to_radians)))),
                [_, _, _, _, _, _, _, _, _] => {
                    let matrix = Matrix3::from_row_slice(&numbers);
                    if matrix.determinant() < 0.0 {
                        return refuse(
                            "the rotation matrix is mirrored (determinant −1); rows are r00 r01 r02 and so on, a left-handed frame must be turned into a right-handed one".into(),
                        );
                    }
                    let off = (matrix.transpose() * matrix - Matrix3::identity()).amax();
                    match off <= NOT_UNIT {
                        true => Ok(Some(nearest_rotation(&matrix))),
                        false => refuse(format!(
                            "r00 to r22 are no rotation: its columns are off by {off:.4} from unit length or from right angles; correct the row or leave its cells empty"
                        )),
                    }
                }
                // no kind has a rotation of other columns
                _ => Ok(None),
            }
        })
        .collect()
}
