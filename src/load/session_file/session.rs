//! Session files (YAML, see docs/formats.md) with their machine and recordings to a [`Session`].

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::parts::{SocketsFile, kind_named, socket_distances};
use super::recordings::RecordingReader;
use super::test_file::TestFile;
use super::test_reader::TestReader;
use crate::chain::Chain;
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::limits::{SESSION_ROWS, SETUPS, TESTS, YAML_BYTES};
use crate::load::checked_text::message::{LoadError, did_you_mean};
use crate::load::checked_text::quantity::positive_length;
use crate::load::checked_text::text::read_limited;
use crate::load::machine_file::machine::{is_urdf, load_machine_with_links};
use crate::load::rows::Rows;
use crate::load::urdf::LinkChoice;
use crate::session::{Session, Setups, Spread, Test, even_out, locate_instruments};

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
    readings: Option<String>,
    #[serde(default)]
    sockets: Vec<SocketsFile>,
    tests: Vec<TestFile>,
}

/// True for a file that is written as a session and not as a machine: it names tests or a machine file.
pub fn names_tests(file: &Path) -> Result<bool, LoadError> {
    let text = read_limited(file, YAML_BYTES)?;
    if is_urdf(file, &text) {
        return Ok(false);
    }
    let document = Document::parse(file, text)?;
    Ok(document.has("tests") || document.has("machine"))
}

/// Reads a session file with the machine and the recordings that it names.
pub fn load_session(file: &Path) -> Result<Session, LoadError> {
    load_session_with(file, Rows::Plausible)
}

/// Reads a session file; with [`Rows::AsRecorded`] recordings that cannot be true are read as well.
pub fn load_session_with(file: &Path, rows: Rows) -> Result<Session, LoadError> {
    let document = Document::parse(file, read_limited(file, YAML_BYTES)?)?;
    let raw: SessionFile = document.read()?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let links =
        LinkChoice { root: raw.root_link.clone(), workpiece: raw.workpiece_link.clone(), tool: raw.tool_link.clone() };
    let machine = load_machine_with_links(&folder.join(&raw.machine), &links)?;
    let chain = Chain::of(&machine);
    let spread = spread(&document, &raw.spread)?;
    if raw.tests.is_empty() || raw.tests.len() > TESTS.most {
        return Err(document
            .refuse(&[Step::Key("tests")], format!("{} tests; a session has 1 to {}", raw.tests.len(), TESTS.most)));
    }
    let recordings = RecordingReader::new(&document, folder, &raw.tests, rows);
    let kind = kind_named(&document, &[Step::Key("readings")], raw.readings.as_deref())?;
    let reader = TestReader { document: &document, kind, recordings, machine: &machine, chain: &chain };
    let mut session_rows = 0;
    let mut tests: Vec<Test> = Vec::with_capacity(raw.tests.len());
    for (index, test) in raw.tests.iter().enumerate() {
        let read = reader.tests(index, test)?;
        session_rows += read.iter().map(Test::rows).sum::<usize>();
        if let Some(message) = SESSION_ROWS.exceeded(session_rows) {
            return Err(document.refuse(&[Step::Key("tests"), Step::Index(index)], message));
        }
        if let Some(test) = read.iter().find(|test| tests.iter().any(|other| other.name == test.name)) {
            return Err(document.refuse(
                &[Step::Key("tests"), Step::Index(index), Step::Key("name")],
                format!("the name '{}' stands twice; each test has its own", test.name),
            ));
        }
        tests.extend(read);
    }
    even_out(&mut tests, &machine);
    let name = raw
        .name
        .unwrap_or_else(|| file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default());
    let mut session = Session { name, machine_file: raw.machine, machine, spread, tests };
    locate_instruments(&mut session, &chain).map_err(|(name, message)| {
        let place = raw.tests.iter().position(|test| test.name == name).unwrap_or(0);
        document.refuse(&[Step::Key("tests"), Step::Index(place)], format!("test '{name}': {message}"))
    })?;
    refuse_indexed_vector(&document, &session)?;
    let known = socket_distances(&document, &raw.sockets, &session.tests, session.machine.axes.len())?;
    session.tests.extend(known);
    let setups = Setups::of(&session);
    match SETUPS.exceeded(setups.pivots.len() + setups.spindle_balls.len() + setups.bars.len()) {
        Some(message) => Err(document.refuse(&[Step::Key("tests")], message)),
        None => Ok(session),
    }
}

/// A pivot length that is not known turns with no index of the spindle, as a ball's own error does: one unknown cannot be both.
fn refuse_indexed_vector(document: &Document, session: &Session) -> Result<(), LoadError> {
    let place = [Step::Key("spread"), Step::Key("pivot_length")];
    if session.spread.pivot_length_mm == 0.0 {
        return Ok(());
    }
    if session.machine.spindle_axis().is_none() {
        return Err(document.refuse(
            &place,
            format!(
                "no rotary axis of {} carries the spindle, so it has no pivot length; leave the key out",
                session.machine.code
            ),
        ));
    }
    match session.tests.iter().find(|test| test.spindle_ball.indexed_about.is_some()) {
        None => Ok(()),
        Some(test) => Err(document.refuse(
            &place,
            format!(
                "test '{}' has the spindle indexed, which the pivot length does not follow; leave one of the two out",
                test.name
            ),
        )),
    }
}

fn spread(document: &Document, raw: &BTreeMap<String, serde_yaml::Value>) -> Result<Spread, LoadError> {
    let mut spread = Spread::default();
    for (key, value) in raw {
        let place = [Step::Key("spread"), Step::Key(key)];
        let target = match key.as_str() {
            "pivot" => &mut spread.pivot_mm,
            "spindle_ball" => &mut spread.spindle_ball_mm,
            "bar_length" => &mut spread.bar_length_mm,
            "pivot_length" => &mut spread.pivot_length_mm,
            other => {
                let valid = ["pivot", "spindle_ball", "bar_length", "pivot_length"];
                let hint = did_you_mean(other, &valid);
                return Err(
                    document.refuse(&place, format!("unknown key '{other}'{hint} (allowed: {})", valid.join(", ")))
                );
            }
        };
        *target = positive_length(document, &place, value)?;
    }
    Ok(spread)
}
